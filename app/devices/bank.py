"""Write the routine of a fault bank: residuals, a statistic over a window, alarms."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..engine import Plant
from ..text import text
from .routine import Routine, table

__all__ = ["bank_routine"]

RULE = text("The bank is sampled already; an alarm rises where a member's statistic over the window passes its threshold.")

RESIDUALS = """
for i in range(n):
    z[i] = znext[i]
for i in range(p):
    if y[i] == y[i]:
        held[i] = y[i]
for i in range(members * q):
    s = 0.0
    for j in range(n):
        s = s + C[i * n + j] * z[j]
    for j in range(m):
        s = s + D[i * (m + p) + j] * u[j]
    for j in range(p):
        s = s + D[i * (m + p) + m + j] * held[j]
    residual[i] = s
for i in range(n):
    s = 0.0
    for j in range(n):
        s = s + A[i * n + j] * z[j]
    for j in range(m):
        s = s + B[i * (m + p) + j] * u[j]
    for j in range(p):
        s = s + B[i * (m + p) + m + j] * held[j]
    znext[i] = s
taken[0] = taken[0] + 1.0
for k in range(window - 1):
    for i in range(members * q):
        last[k * (members * q) + i] = last[(k + 1) * (members * q) + i]
for i in range(members * q):
    last[(window - 1) * (members * q) + i] = residual[i]
"""
ENERGY = """
for i in range(members):
    s = 0.0
    for k in range(window):
        for j in range(q):
            s = s + last[k * (members * q) + i * q + j] * last[k * (members * q) + i * q + j]
    statistic[i] = s
"""
MEAN = """
for i in range(members):
    s = 0.0
    for j in range(q):
        sum = 0.0
        for k in range(window):
            sum = sum + last[k * (members * q) + i * q + j]
        s = s + sum * sum
    statistic[i] = s / threshold[1]
"""
ALARMS = """
alarms = 0.0
for i in range(members):
    alarm[i] = 0.0
    if statistic[i] > threshold[0] and taken[0] >= threshold[1]:
        alarm[i] = 1.0
        alarms = alarms + 1.0
found = 0.0
fault[0] = -1.0
if alarms > 0.0:
    fault[0] = -2.0
    for j in range(faults):
        s = 0.0
        for i in range(members):
            if alarm[i] != signature[i * faults + j]:
                s = 1.0
        if s == 0.0:
            found = found + 1.0
            column = numbers[j]
    if found == 1.0:
        fault[0] = column
"""


def bank_routine(system: Plant, members: int, signature: np.ndarray, threshold: float, window: int, energy: bool,
                 start: Sequence[float] | np.ndarray, names: tuple[Sequence[str], Sequence[str], Sequence[str]],
                 kind: str = "fault bank") -> Routine:
    """The bank `system` from (u, y) to the residuals of all members, judged over `window` samples.

    `fault` is the column of the signature that alone fits the alarms, −1 without an alarm, −2 where none or several fit.
    `names`: of the residuals' members, of the inputs, of the readings.
    """
    m, p = len(names[1]), len(names[2])
    q = system.p // members
    faults = signature.shape[1]
    source = "".join([RESIDUALS, ENERGY if energy else MEAN, "column = -1.0\n", ALARMS.lstrip()])
    return Routine(
        kind, system.dt, {"n": system.n, "m": m, "p": p, "q": q, "members": members, "faults": faults, "window": window},
        (table("A", system.A, "all members: z+ = A z + B (u, y), residual = C z + D (u, y)"), table("B", system.B), table("C", system.C),
         table("D", np.asarray(system.D)), table("threshold", [threshold, float(window)], "of the statistic, and samples of the window"),
         table("signature", signature.astype(float), "which member sees which fault"),
         table("numbers", np.arange(faults, dtype=float), "of the faults")),
        (table("znext", start, "states of all members"), table("held", np.zeros(p), "readings, the last of each"),
         table("last", np.zeros(window * members * q), "residuals of the window"), table("taken", [0.0], "samples so far")),
        {"z": system.n, "residual": members * q, "statistic": members, "alarm": members, "fault": 1, "xhat": 1}, source.strip() + "\n",
        tuple(names[2]), tuple(names[1]), ("fault",), False, ("statistic", "alarm", "fault"), RULE)
