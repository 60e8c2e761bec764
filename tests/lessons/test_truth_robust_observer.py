"""What J tells and what it does not: the worst case, and a factor W that only renames states; by scipy alone."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy import linalg

from observer_lab.lessons.robust_observer.lesson import LESSON
from observer_lab.plants.duan import EXAMPLE_2


def shown(pair: tuple[float, float]) -> dict[str, float]:
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"example": "2", "norm": "2", "pair": pair}))
    return {name: float(outcome.metrics[name]) for name in ("J", "worst_gain")}


def own(poles: tuple[float, float]) -> dict[str, np.ndarray]:
    """The observer by its equations: t = g C adj(sI − A), l = −det(sI − A), with g = 1; then N, M."""
    A, C, K = EXAMPLE_2.plant.A, EXAMPLE_2.plant.C, EXAMPLE_2.K
    c = np.poly(A)
    T = np.vstack([C @ ((s**2 + c[1] * s + c[2]) * np.eye(3) + (s + c[1]) * A + A @ A) for s in poles])
    L = np.array([[-np.polyval(c, s)] for s in poles])
    N, M = np.split(K @ np.linalg.inv(np.vstack([T, C])), [2], axis=1)
    return {"F": np.diag(poles), "T": T, "L": L, "N": N, "M": M}


def test_the_worst_gain_does_not_follow_the_criterion() -> None:
    """As the step says: J grows from 8.83 to 2445, and the worst of the eight sign patterns falls from 0.036 to 0.034."""
    near, far = shown((-1, -2)), shown((-10, -12))
    assert near["J"] == pytest.approx(8.83, abs=0.005) and far["J"] == pytest.approx(2445, abs=0.5)
    assert round(near["worst_gain"], 3) == 0.036 and round(far["worst_gain"], 3) == 0.034


@pytest.mark.parametrize("poles", [(-1.0, -2.0), (-10.0, -12.0)])
def test_the_worst_gain_is_that_of_the_loops_over_a_fine_grid(poles: tuple[float, float]) -> None:
    o, P, w = own(poles), EXAMPLE_2.plant, EXAMPLE_2.wrong
    d = LESSON.apply(LESSON.start(), {"example": "2"})
    sizes, worst = (d["b1"], d["b2"], d["d"]), 0.0
    for signs in product((-1, 1), repeat=3):
        a, c = np.abs(sizes[:2]) * signs[:2], abs(sizes[2]) * signs[2]
        At, Ct = P.A + np.tensordot(a, w.A, 1), P.C + c * w.C[0]
        U = np.hstack([-o["M"] @ Ct, -o["N"]])  # û = −(N z + M y)
        loop = np.block([[At, np.zeros((3, 2))], [o["L"] @ Ct, o["F"]]]) + np.vstack([P.B, o["T"] @ P.B]) @ U
        drive, error = np.vstack([P.B, o["T"] @ P.B]), U + np.hstack([EXAMPLE_2.K, np.zeros((1, 2))])
        worst = max(worst, *(abs((error @ linalg.solve(2j * np.pi * f * np.eye(5) - loop, drive))[0, 0])
                             for f in np.geomspace(1e-3, 20, 1500)))
    assert shown(poles)["worst_gain"] == pytest.approx(worst, rel=2e-3)


def test_with_w_free_the_criterion_falls_to_what_m_alone_costs() -> None:
    """T → WT, L → WL, N → NW⁻¹ leaves û; the terms of T and L vanish with W."""
    o, w = own((-1.0, -2.0)), EXAMPLE_2.wrong
    def J(scale: float) -> float:
        return float(sum(np.linalg.norm(scale * o["T"] @ Ai, 2) for Ai in w.A) + sum(np.linalg.norm(scale * o["L"] @ Ci, 2) +
                     np.linalg.norm(o["M"] @ Ci, 2) for Ci in w.C))
    alone = float(sum(np.linalg.norm(o["M"] @ Ci, 2) for Ci in w.C))
    plain = LESSON.compute(LESSON.apply(LESSON.start(), {"example": "2", "norm": "2", "pair": (-1, -2), "w12": 0.0}))
    assert J(1.0) == pytest.approx(plain.metrics["J"], rel=1e-6)
    values = [J(10.0**-k) for k in range(9)]
    assert np.all(np.diff(values) < 0) and values[-1] == pytest.approx(alone, rel=1e-5)


def test_orders_are_compared_with_their_poles_said() -> None:
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"example": "2"}))
    ranks: Any = next(f for f in LESSON.figures(outcome) if f.id == "ranks")
    assert [str(row[1]) for row in ranks.rows] == ["–", "−4", "−4, −2.5", "−4, −2.5, −6"]
