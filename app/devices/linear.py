"""Write the routine of an observer with states of its own, and sample such an observer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..engine.systems import step_matrices
from ..text import Text, text
from .routine import Routine, table
from .sampling import DeviceError

__all__ = ["HELD_READINGS", "linear_routine", "sampled_observer"]

HELD_READINGS = text("The observer is sampled exactly, with readings and inputs held for {ts:.3g} s; its poles become exp(s T).")
NOT_STABLE = text("The observer has a pole that is not stable, so its error would not decay on a device; move the pole.")

READINGS = """
for i in range(p):
    if y[i] == y[i]:
        held[i] = y[i]
for i in range(q):
    z[i] = znext[i]
"""
ESTIMATE = """
for i in range(g):
    s = 0.0
    for j in range(q):
        s = s + N[i * q + j] * z[j]
    for j in range(p):
        s = s + M[i * p + j] * held[j]
    xhat[i] = s
"""
FEEDBACK = """
for i in range(m):
    u[i] = r[i] - xhat[i]
"""
DIRECT = """
for i in range(g):
    s = xhat[i]
    for j in range(m):
        s = s + E[i * m + j] * u[j]
    xhat[i] = s
"""
STEP = """
for i in range(q):
    s = 0.0
    for j in range(q):
        s = s + F[i * q + j] * z[j]
    for j in range(p):
        s = s + L[i * p + j] * held[j]
    for j in range(m):
        s = s + H[i * m + j] * u[j]
{bilinear}    znext[i] = s
"""
BILINEAR = """    for k in range(m):
        for j in range(p):
            s = s + U[i * (m * p) + k * p + j] * (u[k] * held[j])
"""


def sampled_observer(F: np.ndarray, inputs: Sequence[np.ndarray], ts: float) -> tuple[np.ndarray, ...]:
    """exp(F T) and the held form of each input matrix. Raises DeviceError where F is not stable."""
    if np.linalg.eigvals(F).real.max(initial=-np.inf) >= 0:
        raise DeviceError(NOT_STABLE)
    Phi, Phi1 = step_matrices(F, ts)
    return (Phi, *(Phi1 @ each for each in inputs))


def linear_routine(kind: str, period: float, matrices: dict[str, np.ndarray], start: Sequence[float] | np.ndarray,
                   names: tuple[Sequence[str], Sequence[str], Sequence[str]], rule: Text, *, drives: bool = False,
                   r: Sequence[float] | np.ndarray | None = None) -> Routine:
    """z⁺ = F z + L y + H u and the estimate N z + M y + E u, with `matrices` F, L, H, N, M, and E and U where there are such.

    U = [U₁ … U_m] adds Σ uⱼ Uⱼ y to z⁺. A missing reading counts as the last one. With `drives` u = r − estimate.
    `names`: of the estimates, of the inputs, of the readings.
    """
    F, L, H, N, M = (matrices[name] for name in ("F", "L", "H", "N", "M"))
    q, p, m, g = len(F), L.shape[1], H.shape[1], len(N)
    E, U = matrices.get("E"), matrices.get("U")
    constants = [table("F", F, "z+ = F z + L y + H u"), table("L", L), table("H", H), table("N", N, "xhat = N z + M y"), table("M", M),
                 *([table("E", E, "and the part of u in it")] if E is not None else []),
                 *([table("U", U, "z+ has the sum of u[k] U_k y besides")] if U is not None else [])]
    parts = [READINGS, ESTIMATE, *([DIRECT] if E is not None and not drives else []), *([FEEDBACK] if drives else []),
             STEP.format(bilinear=BILINEAR if U is not None else "")]
    states = [table("znext", start, "the observer's own states"), table("held", np.zeros(p), "readings, the last of each")]
    if drives:
        states.append(table("r", np.zeros(m) if r is None else r, "command"))
    return Routine(kind, period, {"q": q, "p": p, "m": m, "g": g}, tuple(constants), tuple(states), {"z": q, "xhat": g},
                   "".join(parts).strip() + "\n", tuple(names[2]), tuple(names[1]), tuple(names[0]), drives,
                   ("xhat", "u") if drives else ("xhat",), rule)
