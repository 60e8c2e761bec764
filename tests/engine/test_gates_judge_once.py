"""A gate judges once: no gated function refuses what its gate has refused already."""

from __future__ import annotations

import ast
import inspect

import numpy as np
import pytest
from gate_cover import covered, findings, parts_of
from public_calls import ROOMS

from observer_lab.engine import EngineError, ShapeError
from observer_lab.engine.systems.gates.argument_checks import matrix, number, takes


@pytest.mark.slow
@pytest.mark.parametrize("rooms", [ROOMS[part::4] for part in range(4)], ids=" ".join)
def test_no_condition_of_a_gated_function_is_one_that_its_gate_covers(rooms: tuple[str, ...]) -> None:
    assert list(findings(tuple(f"{room}." for room in rooms))) == [], "take the check away: its gate in @takes has made it"


@takes(A=matrix("n n"), B=matrix("n m"), share=number(0, 1), level=number())
def judges_twice(A: np.ndarray, B: np.ndarray, share: float, level: float) -> None:
    """A function with two checks that its gate has made, and three that it has not."""
    n = len(A)
    if B.shape[0] != n or not 0 <= share < level:
        raise ShapeError("{name}", name="B")
    if share == 1 or not np.any(A):
        raise EngineError("{name}", name="share")


def test_the_rule_sees_what_is_judged_twice_and_lets_the_rest_pass() -> None:
    right = {"A": np.eye(2), "B": np.ones((2, 1)), "share": 0.5, "level": 0.7}
    gates = inspect.getattr_static(judges_twice, "taken").gates
    assert list(covered(judges_twice, gates, right)) == ["B.shape[0] != n", "not 0 <= share"]


def test_a_condition_is_read_part_by_part() -> None:
    condition = ast.parse("a or not (b and 0 < c <= d)", mode="eval").body
    assert [ast.unparse(part) for part in parts_of(condition)] == ["a", "not b", "not 0 < c", "not c <= d"]
