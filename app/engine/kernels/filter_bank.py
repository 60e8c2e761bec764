"""Step nonlinear runs with three filters: linearised, extended and unscented.

Lanes: 0 the estimate of the second filter, 1 the true state, 2 … 2n + 2 the points of the third, then the n slopes of lane 0.
"""

from __future__ import annotations

import numpy as np

from .small_matrices import factor, product, put, solve_both, symmetrise, turn
from .tape import flow_lanes, run_lanes

__all__ = ["filter_bank_steps"]

GIVE_UP_LIMIT = 1e12  # as in filters.many_runs


def filter_bank_steps(rates, output, f0, A, B, h0, C, D, rest, held, Q, R, weights, gain, limit,
                  known, jumps, v, w, start, start_P, plan, step, X, priors, P_one, P, points, lost, x, y, u, means, posterior_one,
                  posteriors, nu, S_one, S, M_one, M):
    """Take all N runs over the samples of `known`; how many are done, fewer where the plain way has to judge.

    Tapes f (x, u → ẋ) and h (x, u → y); the expansion f₀ + A (x − rest) + B (u − held), h₀ + C (x − rest) + D (u − held); Q (3, n, n),
    R (3, p, p) by filter; weights (3, 2n + 1): of means, of covariances, and √(n + λ) first; u = known − gain x̂ clipped to ±limit, x̂ of
    filter plan[0], −1: none; jumps (k, n) of the true state; plan = (by, parts of a step, samples followed by a step, points: 0 drawn
    anew, 1 carried on, 2 carried on from the second sample), `step` the length of a part.
    Before each sample: X true states, priors (k + 1, 3, n, N), P_one of the first filter, P (k + 1, 2, N, n, n) of the others, points
    (k + 1, N, n, 2n + 1) or few, lost (k + 1, 3, N). At each: x, y, u, means (k, 3, n, N), posteriors, nu (k, 3, p, N), S and gains M.
    """
    n, N, m, p = X.shape[1], X.shape[2], known.shape[1], len(C)
    count, plain = 2 * n + 1, 2 * n + 3
    by, parts, moves, carried = plan[0], plan[1], plan[2], plan[3]
    lanes, first = plain + n, n + m
    T = np.empty((first + max(len(rates.steps), len(output.steps)), lanes))
    Y, K, total, Z = np.empty((n, lanes)), np.empty((n, lanes)), np.empty((n, lanes)), np.empty((p, lanes))
    CT, across, acrossT, H, HT = np.empty((n, p)), np.empty((n, p)), np.empty((p, n)), np.empty((p, n)), np.empty((n, p))
    heard, L, F, FT, G1, G2 = np.empty((p, p)), np.empty((n, n)), np.empty((n, n)), np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    shared, middle, seen = np.empty((n, n)), np.empty(n), np.empty(p)
    turn(C, CT)
    for k in range(len(known)):
        product(P_one[k], CT, False, across)
        product(C, across, False, S_one[k])
        symmetrise(S_one[k], R[0], S_one[k])
        if not gained(S_one[k], across, heard, acrossT, M_one[k]):
            return k
        joseph_form(P_one[k], C, R[0], M_one[k], posterior_one[k])
        for run in range(N):
            # --- what is measured, and what each of them expects
            for i in range(n):
                T[i, 0] = priors[k, 1, i, run]
                x[k, i, run] = T[i, 1] = X[k, i, run] + jumps[k, i]
            straight(T, plain)
            if carried == 0 or (carried == 2 and k == 0):
                if not factor(P[k, 1, run], L):
                    return k
                drawn(priors[k, 2], run, L, weights[2, 0], T)
            else:
                for i in range(n):
                    for l in range(count):
                        T[i, 2 + l] = points[k, run, i, l]
            for j in range(m):
                for l in range(lanes):
                    T[n + j, l] = known[k, j] if l < plain else 0.0
            run_lanes(output.steps, output.numbers, first, T, plain)
            for i in range(p):
                for l in range(lanes):
                    Z[i, l] = T[output.ends[i], l]
                y[k, i, run] = Z[i, 1] + v[k, i, run]
                if not abs(y[k, i, run]) < np.inf:
                    return k
                for l in range(n):
                    H[i, l] = HT[l, i] = Z[i, plain + l]
            # --- expanded once
            for i in range(p):
                a = h0[i]
                for j in range(n):
                    a += C[i, j] * (priors[k, 0, j, run] - rest[j])
                for j in range(m):
                    a += D[i, j] * (known[k, j] - held[j])
                nu[k, 0, i, run] = y[k, i, run] - a
            # --- along its estimate
            product(P[k, 0, run], HT, False, across)
            product(H, across, False, S[k, 0, run])
            symmetrise(S[k, 0, run], R[1], S[k, 0, run])
            if not gained(S[k, 0, run], across, heard, acrossT, M[k, 0, run]):
                return k
            joseph_form(P[k, 0, run], H, R[1], M[k, 0, run], posteriors[k, 0, run])
            # --- by sigma points
            centre(Z, weights, seen)
            spread(Z, weights, R[2], S[k, 1, run])
            for i in range(n):
                for j in range(p):
                    a = 0.0
                    for l in range(count):
                        a += (T[i, 2 + l] - priors[k, 2, i, run]) * weights[1, l] * Z[j, 2 + l]
                    across[i, j] = a
            if not gained(S[k, 1, run], across, heard, acrossT, M[k, 1, run]):
                return k
            told(P[k, 1, run], S[k, 1, run], M[k, 1, run], posteriors[k, 1, run])
            for i in range(p):
                nu[k, 1, i, run], nu[k, 2, i, run] = y[k, i, run] - Z[i, 0], y[k, i, run] - seen[i]
            # --- their estimates, and who is given up
            for f in range(3):
                bad = lost[k, f, run]
                for i in range(n):
                    a = priors[k, f, i, run]
                    for j in range(p):
                        a += (M_one[k, i, j] if f == 0 else M[k, f - 1, run, i, j]) * nu[k, f, j, run]
                    means[k, f, i, run] = a
                    d = posterior_one[k, i, i] if f == 0 else posteriors[k, f - 1, run, i, i]
                    if not (abs(a) < GIVE_UP_LIMIT and d > 0.0 and d < GIVE_UP_LIMIT):
                        bad = True
                lost[k + 1, f, run] = bad
                if bad:
                    for i in range(n):
                        means[k, f, i, run] = start[i, run]
                    if f > 0:
                        put(start_P[run], posteriors[k, f - 1, run])
            for j in range(m):
                a = known[k, j]
                if by >= 0:
                    for i in range(n):
                        a -= gain[j, i] * means[k, by, i, run]
                    a = min(max(a, -limit[j]), limit[j])
                u[k, j, run] = a
            if k >= moves:
                continue
            # --- a step on
            for i in range(n):
                Y[i, 0], Y[i, 1] = means[k, 1, i, run], x[k, i, run]
            straight(Y, plain)
            if not factor(posteriors[k, 1, run], L):
                return k
            drawn(means[k, 2], run, L, weights[2, 0], Y)
            for j in range(m):
                for l in range(lanes):
                    T[n + j, l] = u[k, j, run] if l < plain else 0.0
            flow_lanes(rates, first, T, plain, step, parts, Y, K, total)
            for i in range(n):
                X[k + 1, i, run] = Y[i, 1] + w[k, i, run]
                if not abs(X[k + 1, i, run]) < GIVE_UP_LIMIT:
                    return k
                priors[k + 1, 1, i, run] = Y[i, 0]
                for l in range(n):
                    F[i, l] = FT[l, i] = Y[i, plain + l]
            product(F, posteriors[k, 0, run], False, G1)
            product(G1, FT, True, G2)
            symmetrise(G2, Q[1], P[k + 1, 0, run])
            if carried > 0:
                for i in range(n):
                    for l in range(count):
                        points[k + 1, run, i, l] = Y[i, 2 + l]
            centre(Y, weights, middle)
            spread(Y, weights, Q[2], P[k + 1, 1, run])
            for i in range(n):
                priors[k + 1, 2, i, run] = middle[i]
                a = f0[i]
                for j in range(n):
                    a += A[i, j] * (means[k, 0, j, run] - rest[j])
                for j in range(m):
                    a += B[i, j] * (u[k, j, run] - held[j])
                priors[k + 1, 0, i, run] = a
        if k < moves:  # all runs share the covariance of the first
            put(start_P[0] if lost[k + 1, 0, 0] else posterior_one[k], shared)
            turn(A, FT)
            product(A, shared, False, G1)
            product(G1, FT, True, G2)
            symmetrise(G2, Q[0], P_one[k + 1])
    return len(known)


def straight(X, plain):
    """Slopes of the states by themselves in the lanes from `plain` on."""
    n = X.shape[1] - plain
    for i in range(n):
        for l in range(n):
            X[i, plain + l] = 1.0 if i == l else 0.0


def drawn(means, run, L, reach, X):
    """Sigma points about a column of means (n, N) in the lanes from 2 on: ± reach times the columns of L, lower."""
    n = len(means)
    for i in range(n):
        a = means[i, run]
        X[i, 2] = a
        for j in range(n):
            b = reach * L[i, j] if j <= i else 0.0
            X[i, 3 + j], X[i, 3 + n + j] = a + b, a - b


def centre(X, weights, middle):
    """The weighted means (rows,) of the points of X (rows, lanes), which are then counted from there."""
    for i in range(len(X)):
        a, first = 0.0, X[i, 2]
        for l in range(weights.shape[1]):
            a += weights[0, l] * (X[i, 2 + l] - first)
        middle[i] = a + first
        for l in range(weights.shape[1]):
            X[i, 2 + l] -= middle[i]


def spread(X, weights, plus, out):
    """out (rows, rows) = the weighted sum of the squares of centred points, and a symmetric `plus`."""
    for i in range(len(X)):
        for j in range(i + 1):
            a = 0.0
            for l in range(weights.shape[1]):
                a += weights[1, l] * X[i, 2 + l] * X[j, 2 + l]
            out[i, j] = out[j, i] = a + plus[i, j]


def gained(S, across, L, turned, M):
    """M = across S⁻¹ (n, p); False where S is not positive definite. L (p, p) and turned (p, n) are room to work in."""
    if len(S) == 1:
        for i in range(len(M)):
            M[i, 0] = across[i, 0] / S[0, 0]
        return True
    if not factor(S, L):
        return False
    turn(across, turned)
    solve_both(L, turned)
    turn(turned, M)
    return True


def joseph_form(P, H, R, M, out):
    """out = (I − M H) P (I − M H)ᵀ + M R Mᵀ."""
    n, p = M.shape
    keep, turned, X, Y = np.empty((n, n)), np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    MR, MT = np.empty((n, p)), np.empty((p, n))
    product(M, H, False, keep)
    for i in range(n):
        for j in range(n):
            keep[i, j] = -keep[i, j]
        keep[i, i] += 1.0
    product(keep, P, False, X)
    product(M, R, False, MR)
    turn(M, MT)
    product(MR, MT, True, out)
    turn(keep, turned)
    product(X, turned, True, Y)
    symmetrise(Y, out, out)


def told(P, S, M, out):
    """out = P − M S Mᵀ."""
    n, p = M.shape
    MS, MT = np.empty((n, p)), np.empty((p, n))
    product(M, S, False, MS)
    turn(M, MT)
    product(MS, MT, True, out)
    for i in range(n):
        for j in range(i + 1):
            out[i, j] = out[j, i] = P[i, j] - out[i, j]
