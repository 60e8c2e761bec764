"""Write the routine of a settled observer with state feedback, limits and missing readings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..engine import Plant
from ..text import Text
from .routine import Routine, table

__all__ = ["NO_LIMIT", "observer_routine"]

NO_LIMIT = 1e30  # stands for an infinite limit: it is a number of single precision too

ESTIMATE = """
for i in range(n):
    xhat[i] = xnext[i]
"""
FEEDBACK = """
for i in range(m):
    s = r[i]
    for j in range(n):
        s = s - K[i * n + j] * xhat[j]
    asked[i] = s
    u[i] = s
"""
CLIP = """
for i in range(m):
    if u[i] < u_min[i]:
        u[i] = u_min[i]
    if u[i] > u_max[i]:
        u[i] = u_max[i]
"""
INNOVATION = """
for i in range(p):
    s = y[i]
    for j in range(n):
        s = s - C[i * n + j] * xhat[j]
    v[i] = s
"""
FEEDTHROUGH = """
for i in range(p):
    s = v[i]
    for j in range(m):
        s = s - D[i * m + j] * {fed}[j]
    v[i] = s
"""
MISSING = """
for i in range(p):
    if y[i] != y[i]:
        v[i] = 0.0
"""
CORRECTION = """
for i in range(n):
    s = xhat[i]
    for j in range(p):
        s = s + L[i * p + j] * v[j]
    xhat[i] = s
"""
PREDICTION = """
for i in range(n):
    s = 0.0
    for j in range(n):
        s = s + A[i * n + j] * xhat[j]
    for j in range(m):
        s = s + B[i * m + j] * {fed}[j]
    for j in range(p):
        s = s + L[i * p + j] * v[j]
    xnext[i] = s
"""


def observer_routine(model: Plant, K: np.ndarray | None, L: np.ndarray, xhat0: Sequence[float] | np.ndarray, rule: Text, *,
                     limits: tuple[np.ndarray, np.ndarray] | None = None, applied: bool = True,
                     r: Sequence[float] | np.ndarray | None = None, current: bool = False) -> Routine:
    """The observer x̂⁺ = A x̂ + B u + L (y − C x̂ − D u) of a sampled model, with u = r − K x̂ within its limits where K is given.

    `applied`: the observer gets the input within its limits, else the one asked for. With `current` L corrects x̂ by the reading of its own
    sample, before the feedback (D = 0): x̂ + L (y − C x̂), then x̂⁺ = A x̂ + B u.
    """
    n, m, p, drives = model.n, model.m, model.p, K is not None
    direct, fed = bool(np.any(np.asarray(model.D))), "u" if applied or not drives or limits is None else "asked"
    parts = [ESTIMATE, *([FEEDBACK] if drives else []), *([CLIP] if drives and limits is not None else []), INNOVATION,
             *([FEEDTHROUGH] if direct else []), MISSING, PREDICTION]
    if current:
        predict = PREDICTION.replace("    for j in range(p):\n        s = s + L[i * p + j] * v[j]\n", "")
        clip = [CLIP] if drives and limits is not None else []
        parts = [ESTIMATE, INNOVATION, MISSING, CORRECTION, *([FEEDBACK] if drives else []), *clip, predict]
    constants = [table("A", model.A, "model: xhat+ = A xhat + B u + L (y - C xhat - D u)"), table("B", model.B), table("C", model.C)]
    if direct:
        constants.append(table("D", np.asarray(model.D)))
    constants.append(table("L", L, "observer gain"))
    states = [table("xnext", xhat0, "prediction of the next sample's state")]
    scratch = {"xhat": n, "v": p}
    if K is not None:
        constants.append(table("K", K, "feedback: u = r - K xhat"))
        states.append(table("r", np.zeros(m) if r is None else r, "command"))
        scratch["asked"] = m
        if limits is not None:
            low, high = (np.clip(each, -NO_LIMIT, NO_LIMIT) for each in limits)
            constants += [table("u_min", low, "limits of u"), table("u_max", high)]
    return Routine(
        "observer", model.dt, {"n": n, "m": m, "p": p}, tuple(constants), tuple(states), scratch,
        "".join(parts).format(fed=fed).strip() + "\n", model.output_names, model.input_names, model.state_names, drives,
        ("xhat", "u") if drives else ("xhat",), rule)
