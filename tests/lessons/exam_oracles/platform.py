"""The platform and worlds that bend: exams of lessons 11 to 14."""

from __future__ import annotations

from collections.abc import Callable

import control
import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import lambertw

from .shared import Given


# --- decoupling --------------------------------------------------------------------------------------------------------
def diophantine(g: Given) -> float:
    target = np.poly([-g["c"], -g["c"]])  # (s − a)(s + e) + k F
    e = target[1] + g["a"]
    return (target[2] + g["a"] * e) / g["k"]


def geophone(g: Given) -> float:
    """Where the rightmost root of the closed loop crosses the axis, by companion matrices alone."""
    omega = 2 * np.pi * g["corner"]
    bare = np.polymul([g["m"], 0.0, g["k"]], [1.0, 2 * g["zeta"] * omega, omega**2])

    def rightmost(gain: float) -> float:
        return float(np.roots(np.polyadd(bare, [gain, 0.0, 0.0, 0.0])).real.max())
    return brentq(rightmost, 10.0, 1e5, xtol=1e-9)


def mixing(g: Given) -> float:
    """The gain to z₂ of a command that leaves z₁ at zero."""
    v = np.linalg.solve(g["G"], [0.0, 1.0])
    return 1.0 / v[1]


def tilt(g: Given) -> float:
    """Where the accelerations d²x/dt² and g θ of the two oscillations have equal amplitudes."""
    twice = control.tf([1.0, 0.0, 0.0], [1.0])

    def apart(f: float) -> float:
        return abs(twice(2j * np.pi * f)) * g["x"] - 9.81 * g["theta"]
    return brentq(apart, 1e-3, 1e2, xtol=1e-13)


# --- weak-states -------------------------------------------------------------------------------------------------------
def bound(g: Given) -> float:
    P = control.ss([[0.0, 1.0], [-g["k"], -g["c"]]], [[0.0], [g["g"]]], [[0.0, 1.0]], 0)
    W = [control.lyap(P.A, P.B @ P.B.T), control.lyap(P.A.T, P.C.T @ P.C)]
    values = np.sqrt(np.real(np.linalg.eigvals(W[0] @ W[1])))
    assert np.ptp(values) < 1e-6 * values.max()  # equal: they count once
    return 2 * float(values.max())


def balance(g: Given) -> float:
    def apart(T: float) -> float:
        A = np.array([[-g["a"]]])
        return float(control.lyap(A, np.array([[(g["b"] / T) ** 2]]))[0, 0] - control.lyap(A, np.array([[(g["c"] * T) ** 2]]))[0, 0])
    return brentq(apart, 1e-2, 1e2, xtol=1e-13)


def slow(g: Given) -> float:
    """The pole as the second row is made faster and faster, at no time constant at all."""
    def at(tiny: float) -> float:
        return float(np.max(np.real(np.linalg.eigvals(np.diag([1.0, 1 / tiny]) @ g["A"]))))
    return 2 * at(0.5e-5) - at(1e-5)


def tail(g: Given) -> float:
    return 2 * float(np.sum(g["s"] * g["q"] ** np.arange(g["r"], 400.0)))


# --- showdown ----------------------------------------------------------------------------------------------------------
def sampled(g: Given) -> float:
    held = control.c2d(control.ss([[0.0]], [[2.0 / g["m"]]], [[1.0]], 0), 1 / g["f"])
    return brentq(lambda k: float(held.A[0, 0] - k * held.B[0, 0]) + 1.0, 0.0, 1e6, xtol=1e-9)


def passive(g: Given) -> float:
    P = control.ss([[0.0, 1.0], [-g["k"] / g["m"], 0.0]], [[0.0], [g["k"] / g["m"]]], [[1.0, 0.0]], 0)
    return -20 * np.log10(abs(P(2j * np.pi * g["f"])))


def late(g: Given) -> float:
    """The rightmost root of s + (k/m) e^{−sτ} by Lambert's function."""
    tau = g["tau"] / 1000
    return g["m"] / tau * brentq(lambda x: float(np.real(lambertw(-x))), 1.0, 3.0, xtol=1e-14)


def rounding(g: Given) -> float:
    width = 2 * g["U"] / 2 ** g["bits"] * 1e6
    return np.sqrt(quad(lambda e: e * e / width, -width / 2, width / 2)[0])


# --- nonlinear ---------------------------------------------------------------------------------------------------------
def sigma(g: Given) -> float:
    density = lambda x: np.exp(-((x - g["m"]) ** 2) / (2 * g["P"])) / np.sqrt(2 * np.pi * g["P"])  # noqa: E731
    wide = 12 * np.sqrt(g["P"])
    return quad(lambda x: g["a"] * x * x * density(x), g["m"] - wide, g["m"] + wide, epsabs=1e-11, epsrel=1e-11)[0]


def update(g: Given) -> float:
    """The most probable state under the tangent: least squares of both deviations."""
    H = 2 * g["a"] * g["m"]
    rows = np.array([[1 / np.sqrt(g["P"])], [H / np.sqrt(g["R"])]])
    seen = np.array([0.0, (g["y"] - g["a"] * g["m"] ** 2) / np.sqrt(g["R"])])
    return g["m"] + np.linalg.lstsq(rows, seen, rcond=None)[0][0]


def spread(g: Given) -> float:
    points = g["m"] + np.sqrt(3 * g["P"]) * np.array([0.0, 1.0, -1.0])
    weights, read = np.array([4.0, 1.0, 1.0]) / 6, g["a"] * points**2
    return float(weights @ (read - weights @ read) ** 2 + g["R"])


def hardening(g: Given) -> float:
    """The slope of the force by a complex step."""
    x, tiny = g["x"] / 1000, 1e-20
    moved = complex(x, tiny)
    force = g["k"] * moved * (1 + (moved / (g["l"] / 1000)) ** 2)
    return np.sqrt(force.imag / tiny / g["m"])


ORACLES: dict[tuple[str, str], Callable[[Given], float]] = {
    ("decoupling", "diophantine"): diophantine,
    ("decoupling", "geophone"): geophone,
    ("decoupling", "mixing"): mixing,
    ("decoupling", "tilt"): tilt,
    ("weak-states", "bound"): bound,
    ("weak-states", "balance"): balance,
    ("weak-states", "slow"): slow,
    ("weak-states", "tail"): tail,
    ("showdown", "sampled"): sampled,
    ("showdown", "passive"): passive,
    ("showdown", "late"): late,
    ("showdown", "rounding"): rounding,
    ("nonlinear", "sigma"): sigma,
    ("nonlinear", "update"): update,
    ("nonlinear", "spread"): spread,
    ("nonlinear", "hardening"): hardening,
}
