"""Evaluate the residual of a Riccati equation for the given doubles."""

from __future__ import annotations

import numpy as np

from ..systems.fixed_point import fixed, product
from ..systems.records import record
from .riccati_problem import RiccatiProblem, in_balanced_units, unit_scale

__all__ = ["Equation"]

BITS = 320


@record()
class Equation:
    """A Riccati equation with what it was solved for; `noise` = (G, W) where Q is G W Gᵀ, of which Q has the rounded value."""

    problem: RiccatiProblem
    solution: np.ndarray
    sampled: bool
    noise: tuple[np.ndarray, np.ndarray] | None = None

    def residual(self) -> float:
        """Frobenius norm of AᵀS + SA + Q − KᵀRK, or of AᵀSA − S + Q − KᵀWK with W = R + BᵀSB, relative to the sum of
        those of its terms, in balanced states.

        With RK or WK in place of BᵀS + Nᵀ or BᵀSA + Nᵀ, d what is left of it: the last term is KᵀWK + Kᵀd + dᵀK + dᵀW⁻¹d.
        """
        own, states, _ = in_balanced_units(self.problem)
        unit, cost, _ = unit_scale(own)
        scaled = self.solution * states * states[:, None] / cost
        A, B, R, N, S = (fixed(M, BITS) for M in (unit.A, unit.B, unit.R, unit.N, scaled))
        Q = fixed(unit.Q, BITS) if self.noise is None else self._power(states, cost)
        SB, SA = product(S, B, BITS), product(S, A, BITS)
        weight, right = R, SB.T + N.T
        terms = [SA, SA.T, Q]
        if self.sampled:
            weight, right = R + product(B.T, SB, BITS), product(SB.T, A, BITS) + N.T
            terms = [product(A.T, SA, BITS), -S, Q]
        near = np.linalg.solve(_doubles(weight), _doubles(right))
        K = fixed(near, BITS)
        WK = product(weight, K, BITS)
        d = right - WK
        Kd, rest = product(K.T, d, BITS), _doubles(d)
        quadratic = product(K.T, WK, BITS) + Kd + Kd.T + fixed(rest.T @ np.linalg.solve(_doubles(weight), rest), BITS)
        size = sum(float(np.linalg.norm(_doubles(term))) for term in (*terms, quadratic))
        return float(np.linalg.norm(_doubles(sum(terms[1:], terms[0]) - quadratic))) / size if size > 0 else 0.0

    def _power(self, states: np.ndarray, cost: float) -> np.ndarray:
        """G W Gᵀ in balanced states, nothing rounded."""
        G, W = self.noise if self.noise is not None else (np.zeros((0, 0)), np.zeros((0, 0)))
        spread = 2.0 ** np.round(np.log2(np.where(np.diag(W) > 0, np.sqrt(np.diag(W)), 1.0)))
        root = 2.0 ** np.round(np.log2(cost) / 2)
        wide = fixed(G * spread * states[:, None] / root, BITS)
        return product(product(wide, fixed(W / spread / spread[:, None] * (root * root / cost), BITS), BITS), wide.T, BITS)


def _doubles(M: np.ndarray) -> np.ndarray:
    return (M / (1 << BITS)).astype(float)
