"""Step the covariances, square roots and means of linear filters whose gain changes with time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .small_matrices import factor, product, put, solve_both, solve_upper, symmetrise, triangle, turn

__all__ = ["Schedule", "Target", "joseph_steps", "mean_steps", "root_steps"]


class Target(NamedTuple):
    """End a schedule early when every entry of P[k|k−1] is within `near` of `goal`; test every `look` steps, never if 0."""

    goal: np.ndarray
    near: np.ndarray
    look: int


class Schedule(NamedTuple):
    """Arrays for the results of each step: P[k|k−1], P[k|k], S[k] and the gain M[k]."""

    priors: np.ndarray
    posteriors: np.ndarray
    S: np.ndarray
    gains: np.ndarray


def joseph_steps(A, C, Q, R, P, seen, target, out):
    """Fill the schedule `out` by Joseph's form, starting from P = P[0|−1].

    Return the number of steps done, or −1 − k if S[k] is not positive definite. P is overwritten with the covariance
    of the next step, so a second call continues. `seen` (steps, p) is true where a measurement arrives; without rows
    all arrive.
    """
    priors, posteriors, S, gains = out.priors, out.posteriors, out.S, out.gains
    steps, n, p = len(priors), len(A), len(C)
    AT, CT, keepT = np.empty((n, n)), np.empty((n, p)), np.empty((n, n))
    turn(A, AT)
    turn(C, CT)
    across, MT, MR = np.empty((n, p)), np.empty((p, n)), np.empty((n, p))
    heard, L, keep, X, Y = np.empty((p, p)), np.empty((p, p)), np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    for k in range(steps):
        put(P, priors[k])
        product(P, CT, False, across)
        product(C, across, False, heard)
        symmetrise(heard, R, heard)
        put(heard, S[k])
        turn(across, MT)
        if seen.shape[0]:
            for i in range(p):
                if not seen[k, i]:
                    for j in range(p):
                        heard[i, j] = heard[j, i] = 0.0
                    heard[i, i] = 1.0
                    for j in range(n):
                        MT[i, j] = 0.0
        if not factor(heard, L):
            return -1 - k
        solve_both(L, MT)
        M = gains[k]
        turn(MT, M)
        product(M, C, False, keep)
        for i in range(n):
            for j in range(n):
                keep[i, j] = -keep[i, j]
            keep[i, i] += 1.0
        product(keep, P, False, X)
        product(M, R, False, MR)
        product(MR, MT, True, P)
        turn(keep, keepT)
        product(X, keepT, True, Y)
        symmetrise(Y, P, P)
        put(P, posteriors[k])
        if target.look > 0 and k % target.look == 0 and there(priors[k], target.goal, target.near):
            return k + 1
        product(A, P, False, X)
        product(X, AT, True, Y)
        symmetrise(Y, Q, P)
    return steps


def root_steps(A, C, Q_root, R, R_root, U, seen, target, out):
    """Do the same as `joseph_steps` with square roots: U Uᵀ = P[0|−1].

    Q_root (n×n) and R_root (p×p) are roots of Q and R. U is overwritten with the root of the next step.
    """
    priors, posteriors, S, gains = out.priors, out.posteriors, out.S, out.gains
    steps, n, p = len(priors), len(A), len(C)
    heard, CU = np.empty(p, dtype=np.bool_), np.empty((p, n))
    UT, CUT = np.empty((n, n)), np.empty((n, p))
    wide, tall, v, w = np.empty((p + n, p + n)), np.empty((2 * n, n)), np.empty(2 * n + p), np.empty(n + p)
    S_root, K, AU = np.empty((p, p)), np.empty((p, n)), np.empty((n, n))
    for k in range(steps):
        turn(U, UT)
        product(U, UT, False, priors[k])
        product(C, U, False, CU)
        turn(CU, CUT)
        product(CU, CUT, False, S[k])
        for i in range(p):
            for j in range(p):
                S[k, i, j] += R[i, j]
        for i in range(p):
            heard[i] = not seen.shape[0] or seen[k, i]
        count = stacked(R_root, CU, U, heard, wide)
        triangle(wide, count + n, v, w)
        for i in range(count):
            if not abs(wide[i, i]) > 0.0:
                return -1 - k
            for j in range(i, count):
                S_root[j, i] = wide[i, j]
            for j in range(n):
                K[i, j] = wide[i, count + j]
        solve_upper(S_root[:count, :count], K[:count])
        at = 0
        for i in range(p):
            for j in range(n):
                gains[k, j, i] = K[at, j] if heard[i] else 0.0
            at += heard[i]
        if count:
            for i in range(n):
                for j in range(n):
                    U[i, j] = wide[count + j, count + i] if j <= i else 0.0
        turn(U, UT)
        product(U, UT, False, posteriors[k])
        if target.look > 0 and k % target.look == 0 and there(priors[k], target.goal, target.near):
            return k + 1
        product(A, U, False, AU)
        for i in range(n):  # the transpose of [A U Q^½]
            for j in range(n):
                tall[j, i] = AU[i, j]
                tall[n + j, i] = Q_root[i, j]
        triangle(tall, n, v, w)
        for i in range(n):
            for j in range(n):
                U[i, j] = tall[j, i] if j <= i else 0.0
    return steps


def stacked(R_root, CU, U, heard, wide):
    """Write the transpose of [R^½ C U; 0 U] to `wide`, only with measurements that arrive; return their number."""
    p, n = CU.shape
    count = 0
    for i in range(p):
        if heard[i]:
            for j in range(p):
                wide[j, count] = R_root[i, j]
            for j in range(n):
                wide[p + j, count] = CU[i, j]
            count += 1
    for i in range(n):
        for j in range(p):
            wide[j, count + i] = 0.0
        for j in range(n):
            wide[p + j, count + i] = U[i, j]
    return count


def mean_steps(A, C, gains, x, known, push, predicted, filtered, nu):
    """Step the means with given gains: ν = y − C x̂, then x̂ + M ν, then A x̂ + B u. Return the number of steps.

    `known` (steps, p) is y − D u, NaN where no measurement arrived; `push` (steps, n) is B u, or has no rows.
    x is overwritten with the predicted mean of the next step.
    """
    steps, n, p = len(known), len(A), len(C)
    heard, after = np.empty(p), np.empty(n)
    for k in range(steps):
        for j in range(n):
            predicted[k, j] = x[j]
        for i in range(p):
            a = known[k, i]
            for j in range(n):
                a -= C[i, j] * x[j]
            nu[k, i] = a
            heard[i] = 0.0 if np.isnan(a) else a
        for i in range(n):
            a = x[i]
            for j in range(p):
                a += gains[k, i, j] * heard[j]
            after[i] = filtered[k, i] = a
        for i in range(n):
            a = push[k, i] if push.shape[0] else 0.0
            for j in range(n):
                a += A[i, j] * after[j]
            x[i] = a
    return steps


def there(P, goal, near):
    """Return whether every entry of P is within `near` of that of `goal`."""
    for i in range(len(P)):
        for j in range(len(P)):
            if not abs(P[i, j] - goal[i, j]) <= near[i, j]:
                return False
    return True
