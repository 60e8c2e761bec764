"""Run example 1 with an unstable mode more: what the paper assumes, what fails without it, and T = 0."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import block_diag, expm

from observer_lab.course.figures.records import Curve, LineFigure, TableFigure
from observer_lab.course.lesson import Design
from observer_lab.engine import Plant, controllability, functional_observer, observability, place
from observer_lab.engine.observers import existence
from observer_lab.plants.duan import EXAMPLE_1
from observer_lab.text import Text, format_number, text

from .knobs import ASSUMED, STATIC, STATIC_FIT, UNREACHED, UNSEEN

MODE_RAD_S = 0.3  # rad/s: the eigenvalue of the mode that is added, which grows
CONTROLLER_POLES, OBSERVER_POLES = (-1.0, -1.5, -3.5), (-2.0, -3.0)  # rad/s
OUTPUT_GAIN = 2.0  # M of the output feedback whose K is M C
X0 = (1.0, 1.0, 0.3)
HORIZON, DT = 8.0, 0.01
V_RATE_RAD_S, V_AMPLITUDE = 5.0, 4.0  # of v = −4 sin(5t + π/2) = −4 cos 5t
EDGE = 20.0  # values beyond are drawn at the edge
ASSUMED_TAB = text("Assumptions")


@dataclass(frozen=True, eq=False)
class Assumed:
    """One case: its plant, the K that is wanted, the observer's F, T, L, N, M. Then its run and the error of the input.

    x (n_t, 3), e_u (n_t,) = û + K x; `loop` are the eigenvalues of plant and observer together.
    """

    plant: Plant
    K: np.ndarray
    F: np.ndarray
    T: np.ndarray
    L: np.ndarray
    N: np.ndarray
    M: np.ndarray
    t: np.ndarray
    x: np.ndarray
    e_u: np.ndarray
    loop: np.ndarray


def plant_with_mode(reached: bool, seen: bool) -> Plant:
    """Example 1 beside ẋ₃ = 0.3 x₃ + b u, y = x₂ + c x₃; b and c are 1, or 0 where the mode is not reached or not seen."""
    inner = EXAMPLE_1.plant
    return Plant(block_diag(inner.A, [[MODE_RAD_S]]), np.vstack([inner.B, [[float(reached)]]]), np.hstack([inner.C, [[float(seen)]]]))


@lru_cache(maxsize=8)
def assumed_run(case: str) -> Assumed:
    """The case of the knob; every start is x(0) = (1, 1, 0.3), z(0) = 0."""
    plant = plant_with_mode(case != UNREACHED, case != UNSEEN)
    K = place(plant.A, plant_with_mode(True, True).B, CONTROLLER_POLES).gain
    if case == UNREACHED:
        inner = EXAMPLE_1.plant
        K = np.hstack([place(inner.A, inner.B, CONTROLLER_POLES[1:]).gain, K[:, 2:]])
    if case in (STATIC, STATIC_FIT):
        M = K @ np.linalg.pinv(plant.C) if case == STATIC else np.array([[OUTPUT_GAIN]])
        K = K if case == STATIC else M @ plant.C
        return _run(plant, K, *(np.zeros(shape) for shape in ((0, 0), (0, 3), (0, 1), (1, 0))), M)
    if case == UNSEEN:  # the best that can be done: an observer of what is seen
        inner = functional_observer(EXAMPLE_1.plant, K[:, :2], 1, poles=OBSERVER_POLES[:1])
        return _run(plant, K, inner.F, np.hstack([inner.T, [[0.0]]]), inner.L, inner.N, inner.M)
    found = functional_observer(plant, K, 2, poles=OBSERVER_POLES)
    return _run(plant, K, found.F, found.T, found.L, found.N, found.M)


def _run(plant: Plant, K: np.ndarray, F: np.ndarray, T: np.ndarray, L: np.ndarray, N: np.ndarray, M: np.ndarray) -> Assumed:
    """ẋ = Ax + Bu, ż = Fz + Ly + TBu, u = v − (Nz + My), with v as two more states: exact at every sample."""
    A, B, C, q = plant.A, plant.B, plant.C, len(F)
    loop = np.block([[A - B @ M @ C, -B @ N], [L @ C - T @ B @ M @ C, F - T @ B @ N]])
    v = np.vstack([B, T @ B]) @ [[1.0, 0.0]]
    turning = np.array([[0.0, V_RATE_RAD_S], [-V_RATE_RAD_S, 0.0]])
    step = expm(DT * np.block([[loop, v], [np.zeros((2, 3 + q)), turning]]))
    states = np.empty((round(HORIZON / DT) + 1, len(step)))
    states[0] = [*X0, *np.zeros(q), -V_AMPLITUDE, 0.0]
    for k in range(len(states) - 1):
        states[k + 1] = step @ states[k]
    x, z = states[:, :3], states[:, 3:3 + q]
    return Assumed(plant, K, F, T, L, N, M, DT * np.arange(len(states)), x, (x @ (K - M @ C).T - z @ N.T)[:, 0], np.linalg.eigvals(loop))


def assumed_figures(design: Design) -> tuple[LineFigure, LineFigure, TableFigure]:
    """The error of the input, the mode, and the conditions order by order."""
    name = design["assumed"]
    case = assumed_run(name)
    return _error(case, dict(ASSUMED)[name]), _mode(case, name), _conditions(case)


def _error(case: Assumed, label: Text) -> LineFigure:
    late, peak = float(np.abs(case.e_u[-len(case.t) // 4:]).max()), float(np.abs(case.e_u).max())
    said = (text("K is a multiple of C: the reading alone gives the input, with no error at any time.") if peak < 1e-9 else
            text("In the last quarter of this run the error is at most {late:.2g}.", late=late))
    return LineFigure("assumed_error", text("error of the input: {label}", label=label), case.t,
                      (Curve(text("error"), np.clip(case.e_u, -EDGE, EDGE), "error"),), "e_u", caption=said, tab=ASSUMED_TAB,
                      window=(-6.0, 6.0))


def _mode(case: Assumed, name: str) -> LineFigure:
    pole = float(case.loop.real.max())
    said = (text("The rightmost pole of the loop is {pole:.3g}: the loop is stable.", pole=pole) if pole < 0 else
            text("The rightmost pole of the loop is {pole:.3g}: the loop is unstable, because no input reaches the mode.", pole=pole)
            if name == UNREACHED else
            text("The rightmost pole of the loop is {pole:.3g}: the loop is unstable, because no reading contains the mode.", pole=pole))
    return LineFigure("assumed_mode", text("the added mode x₃"), case.t, (Curve(text("mode x₃"), np.clip(case.x[:, 2], -EDGE, EDGE)),),
                      "x₃", caption=said, tab=ASSUMED_TAB, window=(-5.0, 5.0))


def _conditions(case: Assumed) -> TableFigure:
    """Ranks, and the share of K that each order misses; of a plant that hides a mode at least what lies on that mode."""
    plant, reach, sight = case.plant, controllability(case.plant), observability(case.plant)
    rows: list[tuple[Text | str, str, Text]] = [
        (text("input reaches"), f"{reach.rank} / 3", text("every mode") if reach.rank == 3 else text("not the added mode")),
        (text("sensor sees"), f"{sight.rank} / 3", text("every mode") if sight.rank == 3 else text("not the added mode"))]
    for order in range(3):
        missed = _missed(plant, case.K, order)
        rows.append((text("T = 0, no state") if order == 0 else text("order {order}", order=order),
                     "0 %" if missed < 1e-9 else f"{format_number(100 * missed, '.3g')} %",
                     text("an observer exists") if missed < 1e-9 else text("no observer with these poles")))
    return TableFigure("assumed", text("the assumptions, and the share of K that is missed"),
                       (text("condition"), text("rank, or K missed by"), text("what it says")), tuple(rows), tab=ASSUMED_TAB,
                       caption=text("Observer poles −2 and −3. The added mode has the eigenvalue 0.3."))


def _missed(plant: Plant, K: np.ndarray, order: int) -> float:
    """The share of K outside the rows of T and C; of an unseen mode no row of T sees anything."""
    if observability(plant).rank < 3:
        inner = EXAMPLE_1.plant
        seen = existence(inner, K[:, :2], OBSERVER_POLES[:order]).missed * float(np.linalg.norm(K[:, :2]))
        return float(np.hypot(seen, K[0, 2]) / np.linalg.norm(K))
    return float(existence(plant, K, OBSERVER_POLES[:order]).missed)

