"""Run algorithm RLO on the two carts: poles in a rectangle, directions known.

The last entry of each row of T is 1, as remark 3 allows. Then J is least where L takes no reading of the tachometer, whatever the
poles are, and the search is left with the poles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from observer_lab.course.lesson import Design
from observer_lab.engine import functional_observer
from observer_lab.engine.observers import Attempt, FunctionalObserver, Norm, RobustObserver
from observer_lab.engine.observers.directions import seen_rows
from observer_lab.plants.two_carts import CARTS, directions, row

from .criterion import criterion_4
from .knobs import NORMS
from .study import weighted

POLE_OF_ONE_STATE = float(CARTS.K[0, 2] / CARTS.K[0, 3])  # s = k₃/k₄: there, and only there, one state is enough
GRID, ROUNDS, SHRINK = 61, 12, 0.2  # points along each side, how often the grid is drawn closer, and how much
Box = tuple[tuple[float, float], tuple[float, float]]


def best_in_rectangle(design: Design, name: str, worst_condition: float) -> Iterator[tuple[float, RobustObserver | None]]:
    """RLO in a norm, in steps: the part done, and at the end the observer of the lowest possible order with the least J."""
    design = design.with_values(norm=name)
    low, high, tall = design["region_low"], design["region_high"], design["region_tall"]
    if low <= POLE_OF_ONE_STATE <= high:
        one = _observer(design, (complex(POLE_OF_ONE_STATE),), NORMS[name])
        yield 1.0, RobustObserver(one, one.J, (Attempt(1, 0, True, one.output_residual, one.J),), 1)
        return
    attempts = [Attempt(1, 0, False, min(_missed(low), _missed(high)), np.inf)]
    best: FunctionalObserver | None = None
    shapes: list[tuple[int, Box]] = [(0, ((low, high), (low, high)))]
    if tall > 0:
        shapes.append((1, ((low, high), (0.0, tall))))
    for pairs, box in shapes:
        x, y, J = _least(box, lambda x, y, pairs=pairs: _value(design, x, y, pairs, worst_condition))
        poles = (complex(x, -y), complex(x, y)) if pairs else (complex(x), complex(y))
        found = _observer(design, poles, NORMS[name]) if np.isfinite(J) else None
        attempts.append(Attempt(2, pairs, found is not None, 0.0 if found is None else found.output_residual, J))
        if found is not None and (best is None or found.J < best.J):
            best = found
        yield 0.5, None
    assert best is not None
    yield 1.0, RobustObserver(best, best.J, tuple(attempts), len(shapes) * ROUNDS * GRID * GRID)


def _observer(design: Design, poles: tuple[complex, ...], norm: Norm) -> FunctionalObserver:
    return functional_observer(CARTS.plant, CARTS.K, len(poles), poles=poles, directions=directions(poles), wrong=weighted(design),
                               norm=norm)


def _missed(s: float) -> float:
    """The share of K that one state with this pole misses: (k₃, k₄) against (s, 1), since the sensors give the other two states."""
    k3, k4 = CARTS.K[0, 2:]
    return float(abs(k3 - s * k4) / np.hypot(s, 1) / np.linalg.norm(CARTS.K))


def _value(design: Design, x: np.ndarray, y: np.ndarray, pairs: int, worst_condition: float) -> np.ndarray:
    """J over two real poles or over (Re, Im) of a pair, infinite where [T; C] is conditioned worse than allowed."""
    s1, s2 = (x + 1j * y, x - 1j * y) if pairs else (x, y)
    first, second = (np.moveaxis(row(s), 0, -1) for s in _full(s1, s2))
    seen, scale = seen_rows(CARTS.plant.A, CARTS.plant.C)
    T = np.stack([first.real, first.imag if pairs else second.real], axis=-2) * scale
    T = T / np.maximum(np.linalg.norm(T, axis=-1, keepdims=True), 1e-300)
    rows = np.concatenate([T, np.broadcast_to(seen, (*T.shape[:-2], *seen.shape))], axis=-2)
    values = np.linalg.svd(rows, compute_uv=False)
    fits = values[..., 0] <= worst_condition * values[..., -1]
    return np.where(fits, criterion_4(s1, s2, design).sum(axis=0), np.inf)


def _full(*poles: np.ndarray) -> tuple[np.ndarray, ...]:
    return tuple(np.asarray(s, dtype=complex) for s in poles)


def _least(box: Box, value: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> tuple[float, float, float]:
    """(x, y, value) of the least value in a box, by a grid that is drawn closer around its least point."""
    (left, right), (bottom, top) = box
    at, half = (0.5 * (left + right), 0.5 * (bottom + top)), (0.5 * (right - left), 0.5 * (top - bottom))
    best = (*at, np.inf)
    for _ in range(ROUNDS):
        xs = np.linspace(max(left, at[0] - half[0]), min(right, at[0] + half[0]), GRID)
        ys = np.linspace(max(bottom, at[1] - half[1]), min(top, at[1] + half[1]), GRID)
        x, y = np.meshgrid(xs, ys)
        values = value(x, y)
        k = np.unravel_index(int(np.argmin(values)), values.shape)
        if values[k] < best[2]:
            best = float(x[k]), float(y[k]), float(values[k])
        at, half = best[:2], (SHRINK * half[0], SHRINK * half[1])
    return best
