"""State a Riccati problem, bring it to balanced states and unit weights, evaluate its residual."""

from __future__ import annotations

import math

import numpy as np

from ..systems.balance import weighed_scale
from ..systems.fixed_point import fixed, product
from ..systems.records import record

__all__ = ["Equation", "RiccatiProblem", "in_balanced_units", "norm", "unit_scale"]

WIDEST = 1000  # bits of a factor of the cost
BITS = 320


@record()
class RiccatiProblem:
    """The data of min ∫ xᵀQx + 2xᵀNu + uᵀRu (or the sum, in discrete time) along ẋ = Ax + Bu."""

    A: np.ndarray
    B: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    N: np.ndarray


def norm(M: np.ndarray) -> float:
    """Frobenius norm."""
    entries = M.ravel(order="K")
    return math.sqrt(entries.dot(entries))


def in_balanced_units(problem: RiccatiProblem) -> tuple[RiccatiProblem, np.ndarray, np.ndarray]:
    """The same problem in balanced states and in inputs of like weight, with the scales of both, powers of two.

    What pins the scales beside A are how strongly an input of unit cost drives a state, and what a state costs.
    """
    A, B, Q, R, N = problem.A, problem.B, problem.Q, problem.R, problem.N
    weights = R.diagonal()
    inputs = 2.0 ** -np.round(np.log2(np.where(weights > 0, weights, 1.0)) / 2)
    driven = np.sqrt(np.square(B * inputs).sum(axis=1))[:, None]
    x = weighed_scale(A, driven, np.sqrt(np.maximum(np.diag(Q), 0.0))[None])
    if (x == 1).all() and (inputs == 1).all():
        return problem, x, inputs
    return RiccatiProblem(A * x / x[:, None], B * inputs / x[:, None], Q * x * x[:, None], R * inputs * inputs[:, None],
                          N * inputs * x[:, None]), x, inputs


def unit_scale(problem: RiccatiProblem) -> tuple[RiccatiProblem, float, float]:
    """The same problem with Q, R and BR⁻¹Bᵀ of comparable size, and the factors of S and K that lead back.

    The cost is divided by c and the input by b, powers of two near c = √(‖Q‖‖R‖)/‖B‖ and b² = c/‖R‖: no rounding, and
    a common factor of Q and R falls out of the gain.
    """
    A, B, Q, R, N = problem.A, problem.B, problem.Q, problem.R, problem.N
    q, r, b = map(norm, (Q, R, B))
    half_r = 2 * round(math.log2(r if r > 0 else q if q > 0 else 1.0) / 2)  # an even power, so that its root is exact too
    ratio = math.log2(q) - half_r if q > 0 else 0.0
    log_b = min(250, max(-250, round(ratio / 4 - (math.log2(b) if b > 0 else 0.0) / 2)))
    input_scale, cost = 2.0**log_b, 2.0 ** min(WIDEST, max(-WIDEST, half_r + 2 * log_b))
    # û = u / input_scale turns B into input_scale·B, uᵀRu/cost into ûᵀ(R·input_scale²/cost)û
    scaled = RiccatiProblem(A, B * input_scale, Q / cost, R / 2.0**half_r, N * (input_scale / cost))
    return scaled, cost, input_scale


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
