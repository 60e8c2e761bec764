"""Write the routine of a recursive Kalman filter: Joseph's form, missing readings, a gate on NIS."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import chdtri

from ..text import text
from .routine import Routine, table

__all__ = ["gate_limits", "kalman_routine"]

RULE = text("The filter is recursive: it computes its covariance at every step, by Joseph's form.")

PREDICTED = """
for i in range(n):
    xhat[i] = xnext[i]
"""
INNOVATION = """
count = 0.0
for i in range(p):
    s = y[i]
    for j in range(n):
        s = s - C[i * n + j] * xhat[j]
    for j in range(m):
        s = s - D[i * m + j] * u[j]
    seen[i] = 1.0
    v[i] = s
    if y[i] != y[i]:
        seen[i] = 0.0
        v[i] = 0.0
    count = count + seen[i]
    for j in range(n):
        s = 0.0
        for k in range(n):
            s = s + C[i * n + k] * P[k * n + j]
        CP[i * n + j] = s * seen[i]
"""
SPREAD = """
for i in range(p):
    for j in range(p):
        s = R[i * p + j]
        for k in range(n):
            s = s + CP[i * n + k] * C[j * n + k]
        S[i * p + j] = s * (seen[i] * seen[j])
        if i == j and seen[i] == 0.0:
            S[i * p + j] = 1.0
for i in range(p):
    for j in range(i + 1):
        s = S[i * p + j]
        for k in range(j):
            s = s - F[i * p + k] * F[j * p + k]
        if i == j:
            F[i * p + i] = sqrt(s)
        else:
            F[i * p + j] = s / F[j * p + j]
nis[0] = 0.0
for i in range(p):
    s = v[i]
    for k in range(i):
        s = s - F[i * p + k] * w[k]
    w[i] = s / F[i * p + i]
    nis[0] = nis[0] + w[i] * w[i]
for j in range(n):
    for i in range(p):
        s = CP[i * n + j]
        for k in range(i):
            s = s - F[i * p + k] * w[k]
        w[i] = s / F[i * p + i]
    for i in range(p):
        s = w[p - 1 - i]
        for k in range(i):
            s = s - F[(p - 1 - k) * p + (p - 1 - i)] * M[j * p + (p - 1 - k)]
        M[j * p + (p - 1 - i)] = s / F[(p - 1 - i) * p + (p - 1 - i)]
"""
GATE = """
for i in range(p):
    if count == limits[2 * i] and nis[0] > limits[2 * i + 1]:
        rejected[0] = rejected[0] + 1.0
        for j in range(p):
            seen[j] = 0.0
            for k in range(n):
                M[k * p + j] = 0.0
"""
CORRECTION = """
for i in range(n):
    s = xhat[i]
    for j in range(p):
        s = s + M[i * p + j] * v[j]
    xhat[i] = s
for i in range(n):
    for j in range(n):
        s = 0.0
        if i == j:
            s = 1.0
        for k in range(p):
            s = s - M[i * p + k] * C[k * n + j]
        N[i * n + j] = s
for i in range(n):
    for j in range(n):
        s = 0.0
        for k in range(n):
            s = s + N[i * n + k] * P[k * n + j]
        W[i * n + j] = s
for i in range(n):
    for j in range(p):
        s = 0.0
        for k in range(p):
            s = s + M[i * p + k] * R[k * p + j]
        MR[i * p + j] = s
for i in range(n):
    for j in range(i + 1):
        s = 0.0
        for k in range(n):
            s = s + W[i * n + k] * N[j * n + k]
        for k in range(p):
            s = s + MR[i * p + k] * M[j * p + k]
        P[i * n + j] = s
        P[j * n + i] = s
"""
FEEDBACK = """
for i in range(m):
    s = r[i]
    for j in range(n):
        s = s - K[i * n + j] * xhat[j]
    u[i] = s
"""
CLIP = """
for i in range(m):
    if u[i] < u_min[i]:
        u[i] = u_min[i]
    if u[i] > u_max[i]:
        u[i] = u_max[i]
"""
FORWARD = """
for i in range(n):
    s = 0.0
    for j in range(n):
        s = s + A[i * n + j] * xhat[j]
    for j in range(m):
        s = s + B[i * m + j] * u[j]
    xnext[i] = s
"""
SPREADING = """
for i in range(n):
    for j in range(n):
        s = 0.0
        for k in range(n):
            s = s + A[i * n + k] * P[k * n + j]
        W[i * n + j] = s
for i in range(n):
    for j in range(i + 1):
        s = Q[i * n + j]
        for k in range(n):
            s = s + W[i * n + k] * A[j * n + k]
        P[i * n + j] = s
        P[j * n + i] = s
"""


def gate_limits(p: int, share: float) -> np.ndarray:
    """The largest NIS of 1, 2 … p readings that pass a gate which lets this share of good ones through, (p, 2) with the count before."""
    return np.array([[k, chdtri(k, 1 - share)] for k in range(1, p + 1)], dtype=float)


def kalman_routine(A: np.ndarray, B: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray, start: tuple[np.ndarray, np.ndarray],
                   period: float, names: tuple[Sequence[str], Sequence[str], Sequence[str]], *, D: np.ndarray | None = None,
                   gate: float | None = None, K: np.ndarray | None = None, limits: tuple[np.ndarray, np.ndarray] | None = None) -> Routine:
    """The filter of x⁺ = A x + B u + w, y = C x + D u + v from its belief `start` before the first reading; `names` of x, u and y.

    A reading that is NaN did not arrive. Readings together more surprising than the `gate` lets through are not used. With K the step
    computes u = r − K x̂ from the corrected estimate, for D = 0.
    """
    n, m, p = len(A), B.shape[1], len(C)
    direct = D is not None and bool(np.any(D)) and K is None
    innovation = INNOVATION if direct else INNOVATION.replace("    for j in range(m):\n        s = s - D[i * m + j] * u[j]\n", "")
    constants = [table("A", A, "model: x+ = A x + B u + w, y = C x + D u + v"), table("B", B), table("C", C),
                 *([table("D", D)] if direct else []), table("Q", Q, "covariance of w"), table("R", R, "covariance of v")]
    states = [table("xnext", start[0], "prediction of the next sample's state"), table("P", start[1], "its covariance")]
    scratch = {"xhat": n, "v": p, "seen": p, "CP": p * n, "S": p * p, "F": p * p, "w": p, "M": n * p, "N": n * n, "W": n * n, "MR": n * p,
               "nis": 1}
    parts, watched = [PREDICTED, innovation, SPREAD], ["xhat", "nis"]
    if gate is not None:
        constants.append(table("limits", gate_limits(p, gate), "number of readings, largest NIS that passes"))
        states.append(table("rejected", [0.0], "samples that the gate has refused"))
        parts.append(GATE)
        watched.append("rejected")
    parts.append(CORRECTION)
    if K is not None:
        constants.append(table("K", K, "feedback: u = r - K xhat"))
        states.append(table("r", np.zeros(m), "command"))
        parts.append(FEEDBACK)
        watched.append("u")
        if limits is not None:
            constants += [table("u_min", limits[0], "limits of u"), table("u_max", limits[1])]
            parts.append(CLIP)
    source = "".join([*parts, FORWARD, SPREADING]).strip() + "\n"
    return Routine("recursive Kalman filter", period, {"n": n, "m": m, "p": p}, tuple(constants), tuple(states), scratch, source,
                   tuple(names[2]), tuple(names[1]), tuple(names[0]), K is not None, tuple(watched), RULE)
