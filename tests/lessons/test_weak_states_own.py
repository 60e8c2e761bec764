"""Lesson 12 on a person's own plant: Hankel values, bounds and what must stay, against Gramians solved by SciPy."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

from observer_lab.course.knobs import KnobError
from observer_lab.engine import Plant
from observer_lab.lessons import LESSONS
from observer_lab.plants.own_plant import canonical_text, read_plant_file

LESSON = LESSONS["weak-states"]
CELLS = 120


def rod(cells: int = CELLS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Heat along a rod: a heater at one end, a thermometer in the middle and one at the far end."""
    A = np.diag(np.full(cells, -2.0)) + np.diag(np.ones(cells - 1), 1) + np.diag(np.ones(cells - 1), -1)
    B, C = np.zeros((cells, 1)), np.zeros((2, cells))
    B[0], C[0, cells // 2], C[1, -1] = 1.0, 1.0, 1.0
    return cells * A, cells * B, C


def hankel(A: np.ndarray, B: np.ndarray, C: np.ndarray) -> np.ndarray:
    """The roots of the eigenvalues of Wc Wo, largest first."""
    reached, seen = solve_continuous_lyapunov(A, -B @ B.T), solve_continuous_lyapunov(A.T, -C.T @ C)
    return np.sort(np.sqrt(np.maximum(np.real(np.linalg.eigvals(reached @ seen)), 0)))[::-1]


def test_a_rod_of_120_cells_keeps_its_hankel_values_and_both_bounds_hold() -> None:
    A, B, C = rod()
    text = read_plant_file("rod.json", json.dumps({"A": A.tolist(), "B": B.tolist(), "C": C.tolist()}).encode())
    lesson = LESSON.fit(text)
    exact, outcome = hankel(A, B, C), lesson.compute(lesson.start())
    found = outcome.study.system.hankel
    assert len(found) < CELLS and np.allclose(found, exact[:len(found)], rtol=0, atol=1e-7 * exact[0])
    read = 2 * exact[len(found):].sum() + 1e-6 * exact[0]  # what reading the file has cut
    for order in range(1, len(found) + 1):
        outcome = lesson.compute(lesson.apply(lesson.start(), {"order": order}))
        model, f = outcome.study.cut.model, outcome.study.system.frequencies[::10]
        gap = max(np.linalg.norm(C @ np.linalg.solve(2j * np.pi * w * np.eye(CELLS) - A, B)
                                 - model.C @ np.linalg.solve(2j * np.pi * w * np.eye(order) - model.A, model.B), 2) for w in f)
        assert gap <= outcome.metrics["bound"] + read
        assert all(check.holds for check in outcome.checks)


def test_the_order_at_the_start_is_the_least_that_errs_by_a_hundredth() -> None:
    A, B, C = rod(20)
    lesson = LESSON.fit(canonical_text(Plant(A, B, C)))
    values, start = hankel(A, B, C), int(lesson.start()["order"])
    tail = [2 * values[r:].sum() for r in range(len(values) + 1)]
    assert tail[start] <= 0.01 * values[0] < tail[start - 1]


@pytest.mark.parametrize("unstable", [1, 2])
def test_unstable_states_always_stay(unstable: int) -> None:
    rng = np.random.default_rng(unstable)
    T = rng.standard_normal((6, 6))
    A = T @ np.diag([*np.linspace(0.2, 0.5, unstable), *np.linspace(-1, -4, 6 - unstable)]) @ np.linalg.inv(T)
    lesson = LESSON.fit(canonical_text(Plant(A, rng.standard_normal((6, 2)), rng.standard_normal((1, 6)))))
    order = lesson.knob("order")
    assert order.low == unstable
    least = lesson.compute(lesson.apply(lesson.start(), {"order": unstable}))
    assert np.allclose(np.sort(least.poles["model"].real), np.linspace(0.2, 0.5, unstable), rtol=1e-6)
    assert least.metrics["unstable"] == unstable and len(least.study.system.hankel) == 6 - unstable
    assert all(check.holds for check in least.checks)


def test_what_takes_no_part_is_said_and_what_cannot_be_cut_is_refused() -> None:
    hidden = LESSON.fit(canonical_text(Plant(np.diag([-1.0, -2.0, -3.0]), [[1], [1], [0]], [[1, 1, 1]])))
    assert hidden.knob("order").high == 2
    said = hidden.compute(hidden.apply(hidden.start(), {"order": 2})).words.value("en")
    assert "2 of 3" in said and "take part" in said
    with pytest.raises(KnobError, match="no stable state"):
        LESSON.fit(canonical_text(Plant(np.diag([1.0, 2.0]), [[1], [1]], [[1, 1]])))


def test_ranks_change_with_the_unit_of_time_and_hankel_values_do_not() -> None:
    A, B, C = rod(12)
    lesson = LESSON.fit(canonical_text(Plant(A, B, C)))
    slow, fast = (lesson.compute(lesson.apply(lesson.start(), {"clock": clock, "tolerance": 1e-6})) for clock in (1.0, 1 / 24))
    assert fast.metrics["rank_observability"] > slow.metrics["rank_observability"]
    assert fast.metrics["sigma1"] == slow.metrics["sigma1"]
