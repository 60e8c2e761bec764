"""Reduce a plant with many states to what a lesson takes, by balanced truncation with its H∞ bound."""

from __future__ import annotations

import numpy as np
from scipy.linalg import matrix_balance, schur, solve_sylvester

from ..systems.errors import EngineError
from ..systems.gates.argument_checks import count, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.lyapunov import settled_factors
from ..systems.plant import Plant
from .notes import note

__all__ = ["NEGLIGIBLE", "reduced_to"]

NEGLIGIBLE = 1e-3  # of the largest Hankel value: states beyond that change nothing that a lesson shows
EDGE = 1e-12  # of the fastest pole: as near to the edge of stability as this a pole counts as not stable
ROUNDING = 1e-7  # of the largest Hankel value: how well a small one is known from Gramians


@takes(plant=PLANT, most=count(1, 200))
def reduced_to(plant: Plant, most: int) -> Plant:
    """The plant itself where it has at most `most` states; else cut to the least order whose bound 2 Σσ is below a thousandth of σ₁,
    at most `most`.

    The states on and beyond the edge of stability stay. `Plant.notes` says the orders, the bound on ‖G − G_r‖_∞ and σ₁.
    Unlike `balanced_truncation` it certifies no rounding, and so takes seconds less at 200 states.
    Raises EngineError where more than `most` states are not stable, or the Gramians are lost in rounding.
    Source: Glover, "All optimal Hankel-norm approximations" (1984), theorem 9.6; Enns (1984) for the bound.

    >>> reduced_to(Plant(-np.diag(np.arange(1.0, 41)), np.ones((40, 1)), np.ones((1, 40))), 30).n < 30
    True
    """
    if plant.n <= most:
        return plant
    blocks, right, left = _split(plant)
    stable, k = blocks[0], len(blocks[0])
    kept = plant.n - k
    if kept > most:
        raise EngineError("The plant has {n} states, and {kept} of them are not stable; at most {most} can be kept.", n=plant.n, kept=kept,
                          most=most)
    sigma, T, L = _balanced(stable, left[:k] @ plant.B, plant.C @ right[:, :k], plant.dt)
    largest = float(sigma.max(initial=0.0))
    r = min(_needed(sigma), most - kept, int(np.count_nonzero(sigma > ROUNDING * largest)))
    T = np.hstack([right[:, :k] @ T[:, :r], right[:, k:]])
    L = np.vstack([L[:r] @ left[:k], left[k:]])
    bound = float(2 * sigma[r:].sum() + 2 * (k - r) * ROUNDING * largest)
    A, B, C = L @ plant.A @ T, L @ plant.B, plant.C @ T
    if not all(np.isfinite(M).all() for M in (A, B, C)):
        raise EngineError("This plant cannot be reduced: its Gramians are lost in rounding; choose units in which its states are alike.")
    said = note("reduced", before=plant.n, after=len(A), bound=bound, largest=largest)
    units = tuple(pair for pair in plant.units if pair[0] in (*plant.input_names, *plant.output_names))
    return Plant(A, B, C, plant.D, plant.dt, (), plant.input_names, plant.output_names, units, plant.name, (*plant.notes, said))


def _split(plant: Plant) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray, np.ndarray]:
    """(A_stable, A_rest), T and T⁻¹ of x = T (z_s, z_u): an ordered Schur form of the balanced A, and one Sylvester equation."""
    n = plant.n
    _, scales = matrix_balance(plant.A, permute=False, separate=True)
    scale = scales[0]
    A = plant.A * scale / scale[:, None]
    size = float(np.abs(plant.poles).max(initial=0.0))

    def inside(re: float, im: float) -> bool:
        return abs(complex(re, im)) < 1 - EDGE if plant.dt else re < -EDGE * size

    S, Q, k = schur(A, output="real", sort=inside)  # type: ignore[misc]
    X = solve_sylvester(S[:k, :k], -S[k:, k:], -S[:k, k:]) if 0 < k < n else np.zeros((k, n - k))
    corner = np.zeros((n - k, k))
    T = scale[:, None] * (Q @ np.block([[np.eye(k), X], [corner, np.eye(n - k)]]))
    left = np.block([[np.eye(k), -X], [corner, np.eye(n - k)]]) @ Q.T / scale
    return (S[:k, :k], S[k:, k:]), T, left


def _balanced(A: np.ndarray, B: np.ndarray, C: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Hankel values of a stable plant, and the columns and rows of its balancing transformation; both of rank k at most."""
    Rc, Ro = settled_factors(A, B, C, dt)
    U, sigma, Vt = np.linalg.svd(Ro.T @ Rc)
    root = np.sqrt(np.maximum(sigma, np.finfo(float).tiny))
    return sigma, Rc @ Vt.T / root, (Ro @ U / root).T


def _needed(sigma: np.ndarray) -> int:
    """The least order whose tail 2 Σσ is negligible beside the largest."""
    tails = 2 * np.concatenate([np.cumsum(sigma[::-1])[::-1], [0.0]])
    return int(np.argmax(tails <= NEGLIGIBLE * sigma.max(initial=0.0)))
