"""State a Riccati problem, and bring it to balanced states and to weights of unit scale."""

from __future__ import annotations

import math

import numpy as np

from ..systems.balance import weighed_scale
from ..systems.records import record

__all__ = ["RiccatiProblem", "in_balanced_units", "norm", "unit_scale"]

WIDEST = 1000  # bits of a factor of the cost


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
