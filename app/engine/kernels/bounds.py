"""Compute Jacobians, the Cramér–Rao bound and normalised squared errors along nonlinear runs."""

from __future__ import annotations

import numpy as np

from .filter_bank import gained, joseph_form, straight
from .small_matrices import factor, product, symmetrise, turn
from .tape import flow_lanes, run_lanes

__all__ = ["bound_steps", "slope_steps", "square_steps"]


def slope_steps(f, h, step, parts, x, u, F, H):
    """Compute the Jacobians of a nonlinear model at each state of a run; return the number of states done.

    The tape f holds the right side of dx/dt = f(x, u), the tape h that of y = h(x). For each of the k states x (k, n)
    and inputs u (k, m), write to F (k, n, n) the Jacobian of the state after `step`, integrated in `parts` parts,
    and to H (k, p, n) the Jacobian of h.
    """
    n, m, p = x.shape[1], u.shape[1], H.shape[1]
    first, lanes = n + m, 1 + n
    T = np.empty((first + max(len(f.steps), len(h.steps)), lanes))
    Y, K, total = np.empty((n, lanes)), np.empty((n, lanes)), np.empty((n, lanes))
    for k in range(len(x)):
        for j in range(m):
            for l in range(lanes):
                T[n + j, l] = u[k, j] if l == 0 else 0.0
        for i in range(n):
            Y[i, 0] = T[i, 0] = x[k, i]
        straight(T, 1)
        straight(Y, 1)
        run_lanes(h.steps, h.numbers, first, T, 1)
        for i in range(p):
            for l in range(n):
                H[k, i, l] = T[h.ends[i], 1 + l]
        flow_lanes(f, first, T, 1, step, parts, Y, K, total)
        for i in range(n):
            for l in range(n):
                F[k, i, l] = Y[i, 1 + l]
    return len(x)


def bound_steps(P, F, Q, varying, told, out):
    """Compute the Cramér–Rao bound at every sample, out (k + 1, n, n); return the number of samples done.

    Each step corrects the bound by the readings, P⁺ = (P⁻¹ + CᵀC)⁻¹, and predicts it, F P⁺ Fᵀ + Q. A row of C is a reading
    of x with noise variance 1. `told` (k + 1, n, n) holds the C of the readings at each sample. `varying` (k, n, n) holds the C
    that stands for the spread of F[k] over the runs. It ends early where rounding has made a covariance indefinite.
    """
    n = len(P)
    one, after, X, Y, FT = np.empty((n, n)), np.empty((n, n)), np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    for i in range(n):
        for j in range(n):
            one[i, j] = 1.0 if i == j else 0.0
    if not corrected(P, told[0], one, out[0]):
        return 0
    for k in range(len(F)):
        if not corrected(out[k], varying[k], one, after):
            return k + 1
        turn(F[k], FT)
        product(F[k], after, False, X)
        product(X, FT, True, Y)
        symmetrise(Y, Q, after)
        if not corrected(after, told[k + 1], one, out[k + 1]):
            return k + 1
    return len(out)


def corrected(P, C, one, out):
    """Write (P⁻¹ + CᵀC)⁻¹ for C (n, n) to `out`; return False if rounding has made P indefinite. `one` is the identity."""
    n = len(P)
    CT, across, S = np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    L, turned, M = np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    turn(C, CT)
    product(P, CT, False, across)
    product(C, across, False, S)
    symmetrise(S, one, S)
    if not gained(S, across, L, turned, M):
        return False
    joseph_form(P, C, one, M, out)
    return True


def square_steps(e, P, out):
    """Write eᵀ P⁻¹ e for errors e (k, n) and covariances P (k, n, n) to `out` (k,); return the number of samples done.

    Each state is divided by its standard deviation first. It ends early at the first P that is not positive definite.
    """
    n = e.shape[1]
    deviation, R, L, half = np.empty(n), np.empty((n, n)), np.empty((n, n)), np.empty(n)
    for k in range(len(e)):
        for i in range(n):
            if not P[k, i, i] > 0.0:
                return k
            deviation[i] = np.sqrt(P[k, i, i])
        for i in range(n):
            for j in range(i + 1):
                R[i, j] = P[k, i, j] / (deviation[i] * deviation[j])
        if not factor(R, L):
            return k
        total = 0.0
        for i in range(n):
            a = e[k, i] / deviation[i]
            for j in range(i):
                a -= L[i, j] * half[j]
            half[i] = a / L[i, i]
            total += half[i] * half[i]
        out[k] = total
    return len(e)
