"""Write the routine of an extended Kalman filter from one description of its plant."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..text import text
from . import kalman
from .derivatives import slope_of, with_slopes
from .routine import Routine, table

__all__ = ["Equations", "extended_routine"]

RULE = text("The filter is an extended Kalman filter: a step of Runge and Kutta each part of a period, and its exact slopes.")

SINE = """
def lab_sin(a):
    b = a - 6.283185307179586 * floor(a / 6.283185307179586 + 0.5)
    q = b * b
    s = 1.0 - q / 812.0
    s = 1.0 - s * q / 702.0
    s = 1.0 - s * q / 600.0
    s = 1.0 - s * q / 506.0
    s = 1.0 - s * q / 420.0
    s = 1.0 - s * q / 342.0
    s = 1.0 - s * q / 272.0
    s = 1.0 - s * q / 210.0
    s = 1.0 - s * q / 156.0
    s = 1.0 - s * q / 110.0
    s = 1.0 - s * q / 72.0
    s = 1.0 - s * q / 42.0
    s = 1.0 - s * q / 20.0
    s = 1.0 - s * q / 6.0
    return b * s
def lab_cos(a):
    return lab_sin(a + 1.5707963267948966)
"""
EXPONENTIAL = """
def lab_exp(a):
    b = a / 1024.0
    s = 1.0 + b / 9.0
    s = 1.0 + s * b / 8.0
    s = 1.0 + s * b / 7.0
    s = 1.0 + s * b / 6.0
    s = 1.0 + s * b / 5.0
    s = 1.0 + s * b / 4.0
    s = 1.0 + s * b / 3.0
    s = 1.0 + s * b / 2.0
    s = 1.0 + s * b
    s = s * s
    s = s * s
    s = s * s
    s = s * s
    s = s * s
    s = s * s
    s = s * s
    s = s * s
    s = s * s
    s = s * s
    return s
"""
MOVED = """    at[i] = xhat[i] + {share} * rate[i]
    for j in range(n):
        dat[i * n + j] = A[i * n + j] + {share} * drate[i * n + j]
"""
STAGE = """
for i in range(n):
    at[i] = xhat[i]
    for j in range(n):
        dat[i * n + j] = A[i * n + j]
{moved}{rates}
for i in range(n):
    rate[i] = f[i]
    sum[i] = sum[i] + {weight} * f[i]
    for j in range(n):
        s = 0.0
        for k in range(n):
            s = s + G[i * n + k] * dat[k * n + j]
        drate[i * n + j] = s
        dsum[i * n + j] = dsum[i * n + j] + {weight} * s
"""


LINEAR = "    for j in range(n):\n        s = s - C[i * n + j] * xhat[j]\n"
DIRECT = "    for j in range(m):\n        s = s - D[i * m + j] * u[j]\n"
BEGUN = """
for i in range(n):
    kept[i] = xhat[i]
    for j in range(n):
        A[i * n + j] = 0.0
        if i == j:
            A[i * n + j] = 1.0
"""
CLEARED = """
for i in range(n):
    sum[i] = 0.0
    for j in range(n):
        dsum[i * n + j] = 0.0
"""
SUMMED = """
for i in range(n):
    xhat[i] = xhat[i] + sum[i]
    for j in range(n):
        A[i * n + j] = A[i * n + j] + dsum[i * n + j]
"""
ENDED = """
for i in range(n):
    xnext[i] = xhat[i]
    xhat[i] = kept[i]
"""


@dataclass(frozen=True)
class Equations:
    """ẋ = f(x, u) and y = h(x), as statements in turn: names of the states, of ẋ and of y among them, and constants by name.

    The one description from which the step takes f, h and their slopes.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    rates: tuple[tuple[str, str], ...]
    slopes: tuple[str, ...]
    readings: tuple[tuple[str, str], ...]
    outputs: tuple[str, ...]
    constants: Mapping[str, float]


def extended_routine(e: Equations, Q: np.ndarray, R: np.ndarray, start: tuple[np.ndarray, np.ndarray], period: float, parts: int,
                     y_names: Sequence[str]) -> Routine:
    """The filter with `parts` steps of Runge and Kutta in a period, from its belief before the first reading."""
    n, m, p = len(e.states), max(len(e.inputs), 1), len(e.outputs)
    h = period / parts
    rates = _evaluated(e, e.rates, e.slopes, "at", "f", "G")
    predicted = _evaluated(e, e.readings, e.outputs, "xhat", "h", "C")
    innovation = kalman.INNOVATION.replace(LINEAR, "    s = s - h[i]\n", 1).replace(DIRECT, "")
    shares = ((h, h / 6), (h / 2, h / 3), (h / 2, h / 3), (h, h / 6))
    stages = "".join(STAGE.format(moved=MOVED.format(share=repr(share)) if k else "", weight=repr(weight), rates=rates)
                     for k, (share, weight) in enumerate(shares))
    part = textwrap.indent(CLEARED + stages + SUMMED, "    ")
    forward = f"{BEGUN}for part in range({parts}):\n{part}{ENDED}"
    used = "".join(words for _, words in (*e.rates, *e.readings))
    helpers = (SINE if "lab_sin(" in used or "lab_cos(" in used else "") + (EXPONENTIAL if "lab_exp(" in used else "")
    source = helpers + "".join([kalman.PREDICTED, predicted, innovation, kalman.SPREAD, kalman.CORRECTION, forward, kalman.SPREADING])
    scratch = {"xhat": n, "v": p, "seen": p, "CP": p * n, "S": p * p, "F": p * p, "w": p, "M": n * p, "N": n * n, "W": n * n, "MR": n * p,
               "nis": 1, "A": n * n, "C": p * n, "G": n * n, "at": n, "dat": n * n, "f": n, "h": p, "rate": n, "drate": n * n, "sum": n,
               "dsum": n * n, "kept": n}
    constants = (*(table(f"k_{name}", [value]) for name, value in e.constants.items()), table("Q", Q, "covariance of w"),
                 table("R", R, "covariance of v"))
    return Routine("extended Kalman filter", period, {"n": n, "m": m, "p": p}, constants,
                   (table("xnext", start[0], "prediction of the next sample's state"), table("P", start[1], "its covariance")), scratch,
                   source.strip() + "\n", tuple(y_names), e.inputs or ("unused",), e.states, False, ("xhat", "nis"), RULE)


def _evaluated(e: Equations, statements: Sequence[tuple[str, str]], results: Sequence[str], at: str, into: str, slopes: str) -> str:
    """Statements that put the results and their slopes into tables, from the states in `at`."""
    full = with_slopes(statements, e.states)
    n = len(e.states)
    lines = [f"{name} = {at}[{k}]" for k, name in enumerate(e.states)] + [f"{name} = u[{k}]" for k, name in enumerate(e.inputs)]
    lines += [f"{name} = k_{name}[0]" for name in e.constants]
    lines += [f"{name} = {words}" for name, words in full]
    lines += [f"{into}[{i}] = {name}" for i, name in enumerate(results)]
    lines += [f"{slopes}[{i * n + k}] = {slope_of(full, name, state)}" for i, name in enumerate(results)
              for k, state in enumerate(e.states)]
    return "\n".join(["", *lines, ""])
