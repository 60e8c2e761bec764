"""Compute a starting gain for any plant, and move a few of its poles alone.

A hand that drags two poles of thirty must not pay for placing all thirty, which with one input may be beyond double
precision. So the start is a Riccati gain, and only what was dragged is placed, within its own invariant subspace.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import schur
from scipy.optimize import linear_sum_assignment

from ..structure.decomposition import reachable_subspace
from ..systems.arrays import frozen
from ..systems.balance import natural_scale, plain_scale
from ..systems.errors import EngineError, PoleError
from ..systems.gates.argument_checks import POLES, POSITIVE, matrix, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.pole_sets import Poles
from ..systems.records import record
from .optimal import dlqr, lqr
from .placement import place

__all__ = ["StartingGain", "in_natural_units", "shift_observer", "shift_poles", "starting_feedback", "starting_observer", "typical_rate"]

TOLERANCES = (None, 1e-7, 1e-4, 1e-2)  # of the staircase: what cannot be steered at one is left alone at the next


@record()
class StartingGain:
    """A gain (K m×n or L n×p), the poles it gives (n,), and which of them no gain moves.

    `moved` and `bolted` together are `poles`; each sorted by (real, imag).
    """

    gain: np.ndarray
    moved: Poles
    bolted: Poles

    @property
    def poles(self) -> Poles:
        """All of them, sorted."""
        return np.sort_complex(np.concatenate([self.moved, self.bolted]))


@takes(plant=PLANT)
def typical_rate(plant: Plant) -> float:
    """The lower median of the speeds |λ| (|log λ|/dt if sampled) of the modes that move, in rad/s; 1 if none does."""
    with np.errstate(divide="ignore"):
        speeds = np.abs(np.log(plant.poles[np.abs(plant.poles) > 1e-9]) / plant.dt) if plant.dt else np.abs(plant.poles)
    speeds = np.sort(speeds[speeds > 1e-7 * max(float(speeds.max(initial=0.0)), 1e-300)])
    return float(speeds[(len(speeds) - 1) // 2]) if speeds.size else 1.0 if not plant.dt else 0.1 / plant.dt


@takes(plant=PLANT)
def in_natural_units(plant: Plant) -> Plant:
    """The plant with balanced states, and inputs and outputs as strong as the typical rate (as one where it is sampled).

    Poles, hidden modes and ranks stay; distances to being hidden no longer depend, but for a factor of a
    few, on the units that a file came in.
    """
    scale, size = natural_scale(plant.A, plant.B, plant.C), 1.0 if plant.dt else typical_rate(plant)
    B, C = plant.B / scale[:, None], plant.C * scale
    wide, tall = np.linalg.norm(B, axis=0), np.linalg.norm(C, axis=1)[:, None]
    return Plant(plant.A * scale / scale[:, None], size * B / np.where(wide > 0, wide, 1.0), size * C / np.where(tall > 0, tall, 1.0),
                 np.zeros((plant.p, plant.m)), plant.dt, name=plant.name)


@takes(plant=PLANT, eager=POSITIVE)
def starting_feedback(plant: Plant, *, eager: float = 1.0) -> StartingGain:
    """K (m×n) of the regulator with Q = eager·I, R = I once units and the typical rate are divided out.

    What no input reaches keeps its poles (`bolted`), stable or not; if even the rest defeats the Riccati equation, K is
    zero. Every plant has such a gain. Raises EngineError for an `eager` that is not positive.
    """
    scale, rate = natural_scale(plant.A, plant.B), typical_rate(plant)
    A, B = plant.A * scale / scale[:, None], plant.B / scale[:, None]
    size = np.linalg.norm(B, axis=0)
    B = B / np.where(size > 0, size, 1.0)
    for rtol in TOLERANCES:
        T, r = reachable_subspace(A, B, rtol=rtol)
        seen, rest = T[:, :r], T[:, r:]
        bolted = np.linalg.eigvals(rest.T @ A @ rest).astype(complex) if r < plant.n else np.empty(0, dtype=complex)
        if r == 0:
            return _start(plant, np.zeros((plant.m, plant.n)), bolted)
        try:
            K = _regulated(seen.T @ A @ seen, seen.T @ B, rate, plant.dt, eager)
        except EngineError:
            continue
        unit = np.where(size > 0, (1.0 if plant.dt else rate) / np.where(size > 0, size, 1.0), 0.0)
        return _start(plant, unit[:, None] * (K @ seen.T) / scale, bolted)
    return _start(plant, np.zeros((plant.m, plant.n)), plant.poles)


@takes(plant=PLANT, eager=POSITIVE)
def starting_observer(plant: Plant, *, eager: float = 25.0) -> StartingGain:
    """L (n×p), by duality; `eager` makes the observer quicker than the controller."""
    dual = starting_feedback(plant.dual(), eager=eager)
    return StartingGain(frozen(dual.gain.T), dual.moved, dual.bolted)


def _regulated(A: np.ndarray, B: np.ndarray, rate: float, dt: float, eager: float) -> np.ndarray:
    """K for unit columns of B. In continuous time K is in units of the rate."""
    Q, R = eager * np.eye(len(A)), np.eye(B.shape[1])
    if not dt:
        return lqr(A / rate, B, Q, R).gain
    step = float(np.clip(rate * dt, 1e-4, 1.0))  # as if the cost were an integral, sampled
    return step * dlqr(A, step * B, step * Q, step * R).gain


def _start(plant: Plant, K: np.ndarray, bolted: np.ndarray) -> StartingGain:
    """The gain with the poles that it gives in the plant's own coordinates, those nearest to the bolted ones apart."""
    poles = np.linalg.eigvals(plant.A - plant.B @ K).astype(complex)
    _, fixed = linear_sum_assignment(np.abs(bolted[:, None] - poles[None, :]))
    return StartingGain(frozen(K), frozen(np.sort_complex(np.delete(poles, fixed))), frozen(np.sort_complex(bolted)))


@takes(A=matrix("n n"), B=matrix("n m"), K=matrix("m n"), before=POLES, after=POLES)
def shift_poles(A: np.ndarray, B: np.ndarray, K: np.ndarray, before: Sequence[complex], after: Sequence[complex]) -> np.ndarray:
    """K (m×n) plus what moves the poles `before` of A − BK to `after`; all other poles and their eigenvectors stay.

    With Yᵀ(A − BK) = Λ Yᵀ over the left invariant subspace of `before`, K + F Yᵀ with F = place(Λ, YᵀB, after).
    A n×n, B n×m. Poles in both lists stay where they are. Raises PoleError as `place` does.
    """
    old, new = _changed(before, after)
    if not len(new):
        return K
    scale = plain_scale(A)
    closed = (A - B @ K) * scale / scale[:, None]
    values = np.linalg.eigvals(closed).astype(complex)
    if len(old) > len(values):
        raise PoleError("This plant has {count} poles; {count2} cannot be moved; ask for fewer.",
                        count=len(values), count2=len(old))
    _, chosen = linear_sum_assignment(np.abs(old[:, None] - values[None, :]))
    inside, outside = values[chosen], np.delete(values, chosen)

    def selected(re: float, im: float) -> bool:
        z = complex(re, im)
        return bool(np.abs(inside - z).min() <= (np.abs(outside - z).min() if outside.size else np.inf))

    form, Z, count = schur(closed.T, output="real", sort=selected)  # pyright: ignore[reportAssignmentType]
    if count != len(new):
        raise PoleError("These poles lie too close to others of the loop to be moved by themselves; move them one "
                        "by one.")
    Y = Z[:, :count]
    F = place(form[:count, :count].T, Y.T @ (B / scale[:, None]), new, sizes=np.ones(count)).gain
    return K + (F @ Y.T) / scale


@takes(A=matrix("n n"), C=matrix("p n"), L=matrix("n p"), before=POLES, after=POLES)
def shift_observer(A: np.ndarray, C: np.ndarray, L: np.ndarray, before: Sequence[complex], after: Sequence[complex]) -> np.ndarray:
    """L (n×p) plus what moves the poles `before` of A − LC to `after`: `shift_poles` of the dual."""
    return shift_poles(A.T, C.T, L.T, before, after).T


def _changed(before: Sequence[complex], after: Sequence[complex]) -> tuple[np.ndarray, np.ndarray]:
    """The two lists without what they share."""
    old, new = list(np.asarray(before, dtype=complex)), []
    typical = 1e-12 * float(np.abs(old).max(initial=0.0))
    for pole in np.asarray(after, dtype=complex):
        same = next((i for i, p in enumerate(old) if abs(p - pole) <= 1e-9 * abs(pole) + typical), None)
        if same is None:
            new.append(pole)
        else:
            old.pop(same)
    if len(old) != len(new):
        raise PoleError("Give as many poles as stand on the board: {count}, not {count2}.",
                        count=len(before), count2=len(after))
    return np.array(old, dtype=complex), np.array(new, dtype=complex)
