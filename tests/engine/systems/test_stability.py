"""Stability is judged in one place: every call that asks says the same, and a fast block takes no digits from a slow one."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import observer_lab.engine
from observer_lab.engine import EngineError, Plant, closed_loop, loop_margins, noisy_loop
from observer_lab.engine.filters import error_parts
from observer_lab.engine.structure import (
    balanced_truncation,
    controllability,
    gramians,
    hankel_singular_values,
    observability,
    split_stable,
)
from observer_lab.engine.systems import is_stable, stability, stable_poles

EXACT_SCALES = 2.0 ** np.arange(-12, 13)


def _says_stable(plant: Plant) -> dict[str, bool]:
    """What each call of the engine says of one plant without a controller."""
    n, none = plant.n, np.zeros((plant.n, plant.p))

    def runs(call, *arguments):
        try:
            call(*arguments)
        except EngineError as problem:
            assert "table" in str(problem) or "settle" in str(problem), problem  # stable, unstable
            return False
        return True

    blind = Plant(plant.A, plant.B, np.zeros((1, n)), None, plant.dt)
    no_input = Plant(plant.A, np.zeros((n, 1)), plant.C, None, plant.dt)
    return {
        "gramians": runs(gramians, plant), "hankel": runs(hankel_singular_values, plant),
        "split": split_stable(plant).stable.n == n, "truncation": balanced_truncation(plant, n - 1).kept == 0,
        "noisy_loop": noisy_loop(plant, None, np.eye(n), 1.0).stable,
        "detectable": observability(blind).detectable, "stabilizable": controllability(no_input).stabilizable,
        "closed_loop": closed_loop(plant, np.zeros((plant.m, n)), none).stable,
        "loop_margins": loop_margins(plant, np.zeros((plant.m, plant.p))).stable,
        "error_parts": runs(error_parts, plant, none, np.eye(n), 1.0, 1.0),
        "is_stable": is_stable(plant.A, dt=plant.dt), "stable_poles": bool(stable_poles(plant.A, dt=plant.dt)[1].all()),
    }


def _cascade(rng: np.random.Generator, poles: np.ndarray, down: bool) -> np.ndarray:
    """A triangular matrix with these poles, entries beside them of any size, states in any order and in any units."""
    n = len(poles)
    A = np.diag(poles) + np.triu(rng.standard_normal((n, n)) * 10.0 ** rng.uniform(-3, 3, (n, n)), 1)
    A = A.T if down else A
    order, units = rng.permutation(n), rng.choice(EXACT_SCALES, n)
    return (A * units / units[:, None])[np.ix_(order, order)]


@settings(max_examples=60, derandomize=True, database=None)
@given(st.integers(0, 10_000), st.integers(2, 5), st.booleans(), st.booleans(), st.integers(-9, 9))
def test_a_triangular_cascade_is_as_stable_as_its_diagonal_says(seed: int, n: int, down: bool, grows: bool, time: int) -> None:
    rng = np.random.default_rng(seed)
    poles = -10.0 ** rng.uniform(-4, 6, n)
    if grows:
        poles[rng.integers(n)] *= -1
    A = _cascade(rng, poles, down) * 10.0**time
    assert is_stable(A) is not grows
    assert int(np.count_nonzero(~stable_poles(A)[1])) == int(grows)


@pytest.mark.parametrize("grows", [False, True])
@pytest.mark.parametrize("A", [[[-1e-3, 1, 0], [0, -1, 1], [0, 0, -1e6]], [[-1e-3, 0, 0], [1, -1, 0], [0, 1, -1e6]]])
def test_every_call_calls_the_slow_cascade_what_it_is(A: list[list[float]], grows: bool) -> None:
    A = np.array(A)
    A[0, 0] *= -1 if grows else 1
    said = _says_stable(Plant(A, [[0], [0], [1]] if A[0, 1] else [[1], [0], [0]], [[1, 0, 0]] if A[0, 1] else [[0, 0, 1]]))
    assert set(said.values()) == {not grows}, said


@settings(max_examples=15, derandomize=True, database=None)
@given(st.integers(0, 10_000), st.sampled_from([0.0, 0.1]), st.floats(1e-8, 0.2), st.sampled_from([-1, 1]))
def test_every_call_says_the_same_of_a_random_plant(seed: int, dt: float, away: float, side: int) -> None:
    rng, shift = np.random.default_rng(seed), side * away
    A = rng.standard_normal((4, 4))
    poles = np.linalg.eigvals(A)
    A = A * ((1 + shift) / np.abs(poles).max()) if dt else A - (poles.real.max() - shift) * np.eye(4)
    said = _says_stable(Plant(A, rng.standard_normal((4, 2)), rng.standard_normal((2, 4)), None, dt))
    assert set(said.values()) == {shift < 0}, said


@settings(max_examples=40, derandomize=True, database=None)
@given(st.integers(0, 10_000), st.integers(2, 6))
def test_a_pole_on_the_edge_to_rounding_is_not_stable(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    Q = np.linalg.qr(rng.standard_normal((n, n)))[0]
    assert not is_stable(Q @ np.diag([0.0, *-rng.uniform(0.1, 9, n - 1)]) @ Q.T)
    assert not is_stable(Q, dt=1.0)


def test_poles_of_many_sizes_in_one_companion_matrix_are_told() -> None:
    coefficients = np.poly([-1e-3, -1.0, -1e3, -1e6])
    companion = np.vstack([-coefficients[1:], np.eye(3, 4)])
    assert is_stable(companion) and is_stable(companion.T)


def test_no_other_module_of_the_engine_compares_poles_with_the_edge() -> None:
    """A comparison `poles.real < 0` or `abs(poles) < 1` outside the module of stability would be a second judgement."""
    second = re.compile(r"(poles?\.real|real\(poles?\)|abs\(poles?\))[^=\n]{0,9}(<|>=?) ?[01]\b(?!\.|e)")
    room = Path(observer_lab.engine.__file__).parent
    found = {str(path.relative_to(room)) for path in room.rglob("*.py") for line in path.read_text(encoding="utf-8").splitlines()
             if second.search(line) and '"""' not in line and ">>>" not in line}
    assert found <= {"systems/stability.py", "systems/sampling.py"}, found  # the second: poles of a logarithm


def test_eigenvectors_of_any_condition_are_judged_without_a_warning() -> None:
    """The condition of these eigenvectors has a square beyond the range of doubles."""
    assert stability.is_stable(np.array([[-1e-70, 1e100], [0.0, -2e-70]]))
    assert not stability.is_stable(np.array([[-1e-70, 1e100], [0.0, 2e-70]]))
