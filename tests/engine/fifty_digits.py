"""What is true of the doubles that are given, in fifty digits: mpmath, no code of ours."""

from __future__ import annotations

import mpmath
import numpy as np
from mpmath import mp
from scipy.optimize import linear_sum_assignment

from observer_lab.engine import Plant
from observer_lab.engine.structure import Observability

DIGITS = 60


def matrix(M: np.ndarray) -> mpmath.matrix:
    return mp.matrix(np.asarray(M).tolist()) if M.size else mp.matrix(*M.shape)


def eigenvalues(A: np.ndarray, B: np.ndarray, K: np.ndarray) -> list[mpmath.mpc]:
    """eig(A − BK)."""
    with mp.workdps(DIGITS):
        return list(mp.eig(matrix(A) - matrix(B) * matrix(K), left=False, right=False))


def away_from(points: np.ndarray, true: list[mpmath.mpc]) -> float:
    """Largest distance of two matched sets."""
    with mp.workdps(DIGITS):
        away = np.array([[float(abs(mp.mpc(complex(a)) - z)) for z in true] for a in points])
    rows, columns = linear_sum_assignment(away)
    return float(away[rows, columns].max())


def riccati_residual(A: np.ndarray, B: np.ndarray, Q: np.ndarray | tuple[np.ndarray, np.ndarray], R: np.ndarray, S: np.ndarray,
                       sampled: bool = False) -> float:
    """Norm of the Riccati residual relative to the sum of the norms of its terms; Q may be (G, W), which is G W Gᵀ."""
    with mp.workdps(DIGITS):
        a, b, r, s = (matrix(M) for M in (A, B, R, S))
        q = matrix(Q[0]) * matrix(Q[1]) * matrix(Q[0]).T if isinstance(Q, tuple) else matrix(Q)
        if sampled:
            weight = r + b.T * s * b
            K = mp.inverse(weight) * (b.T * s * a)
            terms = [a.T * s * a, -s, q, -(K.T * weight * K)]
        else:
            K = mp.inverse(r) * (b.T * s)
            terms = [a.T * s, s * a, q, -(K.T * r * K)]
        whole = terms[0] + terms[1] + terms[2] + terms[3]
        return float(mp.mnorm(whole, "f") / sum(mp.mnorm(t, "f") for t in terms))


def gramian(A: np.ndarray, G: np.ndarray) -> mpmath.matrix:
    """A P + P Aᵀ + G Gᵀ = 0 by doubling of the Cayley transform."""
    a, g = matrix(A), matrix(G)
    one = mp.eye(len(A))
    speed = mp.mpf(float(np.sqrt(np.prod(np.sort(np.abs(np.linalg.eigvals(A)))[[0, -1]]))))
    inverse = mp.inverse(speed * one - a)
    step, P = inverse * (speed * one + a), 2 * speed * inverse * g * g.T * inverse.T
    for _ in range(60):
        more = step * P * step.T
        P, step = P + more, step * step
        if mp.mnorm(more, "f") <= mp.mpf(10) ** (-DIGITS + 10) * mp.mnorm(P, "f"):
            break
    return P


def variances(A: np.ndarray, G: np.ndarray) -> np.ndarray:
    """Diagonal of the solution of A P + P Aᵀ + G Gᵀ = 0."""
    with mp.workdps(DIGITS):
        P = gramian(A, G)
        return np.array([float(P[i, i]) for i in range(len(A))])


def sampled_variances(A: np.ndarray, G: np.ndarray) -> np.ndarray:
    """Diagonal of the solution of A P Aᵀ − P + G Gᵀ = 0."""
    with mp.workdps(2 * DIGITS):
        power, P = matrix(A), matrix(G) * matrix(G).T
        for _ in range(60):
            more = power * P * power.T
            P, power = P + more, power * power
            if mp.mnorm(more, "f") <= mp.mpf(10) ** -30 * mp.mnorm(P, "f"):
                break
        return np.array([float(P[i, i]) for i in range(len(A))])


def hankel_values(plant: Plant) -> list[float]:
    """Largest first."""
    with mp.workdps(DIGITS + 40):
        product = gramian(plant.A, plant.B) * gramian(plant.A.T, plant.C.T)
        return sorted((float(mp.sqrt(abs(v))) for v in mp.eig(product, left=False, right=False)), reverse=True)


def _at(plant: Plant, omega: float) -> mpmath.matrix:
    pencil = mp.mpc(0, float(omega)) * mp.eye(plant.n) - matrix(plant.A)
    B, columns = matrix(plant.B), []
    for j in range(plant.m):
        columns.append(matrix(plant.C) * mp.lu_solve(pencil, B[:, j]) if plant.n > 1 else matrix(plant.C) * B[:, j] / pencil[0, 0])
    return mp.matrix([[columns[j][i] + mp.mpf(float(plant.D[i, j])) for j in range(plant.m)] for i in range(plant.p)])


def response(plant: Plant, omega: np.ndarray) -> np.ndarray:
    with mp.workdps(DIGITS):
        rows = [_at(plant, float(w)) for w in omega]
        return np.array([[[complex(H[i, j]) for j in range(plant.m)] for i in range(plant.p)] for H in rows])


def difference_on_grid(one: Plant, other: Plant) -> float:
    """The largest singular value of the difference of two responses, on a grid of frequencies."""
    speeds = np.abs(one.poles)
    with mp.workdps(DIGITS):
        top = 0.0
        for w in [0.0, *np.geomspace(0.1 * speeds.min(), 10 * speeds.max(), 9)]:
            second = _at(other, w) if other.n else matrix(np.asarray(other.D))
            gap = _at(one, w) - second
            value = np.array([[complex(gap[i, j]) for j in range(gap.cols)] for i in range(gap.rows)])
            top = max(top, float(np.linalg.norm(value, 2)))
        return top


def distance_to_hidden(plant: Plant, found: Observability) -> list[float]:
    """σ_min [A − λI; C] at the true eigenvalue next to each mode's pole."""
    with mp.workdps(DIGITS):
        true = mp.eig(matrix(plant.A), left=False, right=False)
        away = np.array([[float(abs(mp.mpc(mode.pole) - z)) for z in true] for mode in found.modes])
        order = linear_sum_assignment(away)[1]
        out = []
        for k in order:
            a, c, n = matrix(plant.A), matrix(plant.C), plant.n
            whole = mp.matrix(n + plant.p, n)
            for j in range(n):
                for i in range(n):
                    whole[i, j] = a[i, j] - (true[k] if i == j else 0)
                for i in range(plant.p):
                    whole[n + i, j] = c[i, j]
            out.append(float(min(mp.svd_c(whole, compute_uv=False))))
        return out


def roots(polynomial: np.ndarray) -> np.ndarray:
    with mp.workdps(DIGITS):
        found = mp.polyroots([mp.mpf(float(c)) for c in polynomial[::-1]], maxsteps=500, extraprec=400, asc=True)
        return np.array([complex(z) for z in found])


def union_gap(loop: object, plant: Plant, K: np.ndarray, L: np.ndarray) -> float:
    """How far the poles of the loop as it is stored lie from those of its two parts, relative to the largest."""
    with mp.workdps(DIGITS):
        parts = [*eigenvalues(plant.A, plant.B, K), *eigenvalues(plant.A, L, plant.C)]
        whole = list(mp.eig(matrix(loop.A_xxhat), left=False, right=False))  # type: ignore[attr-defined]
        away = np.array([[float(abs(a - z)) for z in whole] for a in parts])
        rows, columns = linear_sum_assignment(away)
        return float(away[rows, columns].max()) / max(float(abs(z)) for z in parts)
