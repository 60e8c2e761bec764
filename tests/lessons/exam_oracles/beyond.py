"""Robust and bilinear observers, faults, networks, any plant, the arm: exams of lessons 15 to 20."""

from __future__ import annotations

from collections.abc import Callable

import control
import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.stats import binom, geom

from .shared import INTEGRATOR, POSITION, Given, placed, spring


# --- robust-observer ---------------------------------------------------------------------------------------------------
def criterion(g: Given) -> float:
    s = g["s"]
    return 2 * g["a"] * abs(s) + g["b"] * abs((s + 1) * (s + 3)) + g["c"] * abs(50 + 30 * s)


def functional(g: Given, s: float) -> np.ndarray:
    """(t, L, N, M) of the one-state observer, as one linear system of both conditions."""
    A, K = spring(g["b"], g["k"]), np.array([g["k1"], g["k2"]])
    rows, right = np.zeros((4, 4)), np.zeros(4)
    rows[:2, 0], rows[:2, 1] = A[0] - s * np.array([1.0, 0.0]), [-1.0, 0.0]  # t (A − s) row by row, minus L C
    right[:2] = -(A[1] - s * np.array([0.0, 1.0]))
    t, L = np.linalg.lstsq(rows[:2, :2], right[:2], rcond=None)[0]
    N, M = np.linalg.solve(np.array([[t, 1.0], [1.0, 0.0]]), K)
    return np.array([t, L, N, M])


def direct(g: Given) -> float:
    return functional(g, g["s"])[3]


def aside(g: Given) -> float:
    return brentq(lambda s: float(functional(g, s)[3]), -50.0, 50.0, xtol=1e-12)


def damper(g: Given) -> float:
    """Plant and observer together, driven so that the velocity stays, after many time constants."""
    k, b, s, v, k1 = 3.0, 1.5, g["s"], g["v"], 4.0
    _, L, N, M = functional({"k": k, "b": b, "k1": k1, "k2": g["k2"]}, s)
    forced = b + g["delta"]  # the force that keeps the velocity is u = k x + (b + δ) v, and drives z through T B = 1
    F = np.array([[0.0, 0.0, v], [L + k, s, forced * v], [0.0, 0.0, 0.0]])  # of place, z and 1
    x, z, _ = expm(F * 40 / abs(s)) @ [0.0, v, 1.0]
    return N * z + M * x - (k1 * x + g["k2"] * v)


# --- bilinear-observer -------------------------------------------------------------------------------------------------
def pole(g: Given) -> float:
    return brentq(lambda v: g["a"] - g["b"] * v - g["p"], -1e3, 1e3, xtol=1e-13)


def patience(g: Given) -> float:
    return 1000 * brentq(lambda t: g["e0"] * float(expm(np.array([[g["p"] * t]]))[0, 0]) - g["e1"], 0.0, 5.0, xtol=1e-13)


def silence(g: Given) -> float:
    seen, own = np.hstack([g["F3"], g["A3"]])[:2], np.hstack([g["F3"], g["A3"]])[2]
    return np.linalg.solve(seen.T, own - [0.0, g["p"]])[0]


def lag(g: Given) -> float:
    """Observer and differentiator on a parabola, after many time constants; states: lag of the differentiator, error, 1."""
    tau = g["tau"] / 1000
    F = np.array([[-1 / tau, 0.0, g["c"]], [-g["L"], g["p"], 0.0], [0.0, 0.0, 0.0]])  # the lag grows by ÿ and decays with τ
    return (expm(F * 40 * max(tau, -1 / g["p"])) @ [0.0, 0.0, 1.0])[1]


# --- fault-diagnosis ---------------------------------------------------------------------------------------------------
def zero(g: Given) -> float:
    def pencil(s: float) -> float:
        return float(np.linalg.det(np.block([[s * np.eye(2) - g["A"], -g["E"]], [POSITION, np.zeros((1, 1))]])))
    return -pencil(0.0) / (pencil(1.0) - pencil(0.0))


def ignore(g: Given) -> float:
    return (np.eye(2) - g["B"] @ np.linalg.pinv(g["B"]))[0, 0]


def delay(g: Given) -> float:
    """The window slides into the fault, sample by sample."""
    N = int(g["N"])
    residual = np.concatenate([np.zeros(N), np.full(N, g["f"])])
    means = np.convolve(residual, np.ones(N) / N, "valid")
    return float(np.argmax(means > g["z"] * g["sigma"] / np.sqrt(N)))


def wolves(g: Given) -> float:
    windows = sum(g["rate"] / g["N"] for _ in range(24 * 60)) * 60
    return float(binom(round(windows * 1000), g["alpha"]).mean()) / 1000 * g["members"]


# --- network -----------------------------------------------------------------------------------------------------------
def loss(g: Given) -> float:
    return 100 / float(expm(np.array([[g["s"] * g["h"] / 1000]]))[0, 0]) ** 2


def gap(g: Given) -> float:
    step = np.array([[g["a"] ** 2, g["Q"]], [0.0, 1.0]])
    return (np.linalg.matrix_power(step, 3) @ [g["p"], 1.0])[0]


def burst(g: Given) -> float:
    """The chance of going on at which a two-state chain's second moment has the spectral radius one; then its mean stay."""
    def radius(r: float) -> float:
        M = np.array([[0.0, 0.0], [0.1 * g["a"] ** 2, r * g["a"] ** 2]])  # a reading takes the variance back, a loss multiplies it
        return float(np.max(np.abs(np.linalg.eigvals(M)))) - 1
    r = brentq(radius, 0.0, 1.0, xtol=1e-14)
    return float(geom(1 - r).mean())


def one_late(g: Given) -> float:
    held = control.c2d(control.ss([[g["s"]]], [[1.0]], [[1.0]], 0), g["h"] / 1000)
    lam, b = held.A[0, 0], held.B[0, 0]

    def radius(K: float) -> float:
        return float(np.max(np.abs(np.linalg.eigvals([[lam, -b * K], [1.0, 0.0]])))) - 1
    top = 3 / b
    while radius(top) > 0:  # down to where the loop is stable; the edge lies just above
        top *= 0.999
    return brentq(radius, top, top / 0.998, xtol=1e-13)


# --- sandbox -----------------------------------------------------------------------------------------------------------
def silent(g: Given) -> float:
    values, vectors = np.linalg.eig(np.array([[g["a"], 1.0], [0.0, g["b"]]]))
    mode = vectors[:, np.argmin(np.abs(values - g["b"]))]
    return -mode[0] / mode[1]


# --- arm ---------------------------------------------------------------------------------------------------------------
def holding(g: Given) -> float:
    """Current and voltage of a motor that stands under its load."""
    return np.linalg.solve([[g["R"], -1.0], [g["n"] * g["k"], 0.0]], [0.0, g["tau"]])[1]


def load_bias(g: Given) -> float:
    M = INTEGRATOR - np.outer(placed(INTEGRATOR, POSITION, [g["p"], g["p"]]), POSITION)
    return float(np.degrees(-np.linalg.solve(M, [0.0, g["tau"] / g["J"]])[0]))


def load_gain(g: Given) -> float:
    A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1 / g["J"]], [0.0, 0.0, 0.0]])
    return placed(A, np.array([1.0, 0.0, 0.0]), [g["a"], g["b"], g["c"]])[2]


def across(g: Given) -> float:
    """In turns of the motor: its angle under a constant torque reaches n times the play."""
    push, far = g["k"] * g["i"] / (g["Jr"] * 1e-7), np.radians(g["gap"]) * g["n"]
    chain = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, push], [0.0, 0.0, 0.0]])
    return 1000 * brentq(lambda t: float(expm(chain * t)[0, 2]) - far, 0.0, 10.0, xtol=1e-14)


def zero_of(g: Given) -> float:
    A = spring(g["b"], g["k"])
    return complex(control.ss(A, g["B"], POSITION, 0).zeros()[0]).real


def static(g: Given) -> float:
    return float(control.ss(g["A"], g["B"], POSITION, 0).dcgain())


def held(g: Given) -> float:
    h = g["h"] / 1000
    return brentq(lambda s: float(control.c2d(control.ss([[s]], [[1.0]], [[1.0]], 0), h).A[0, 0]) - g["z"], -1e3, 1e3, xtol=1e-12)


ORACLES: dict[tuple[str, str], Callable[[Given], float]] = {
    ("robust-observer", "criterion"): criterion,
    ("robust-observer", "direct"): direct,
    ("robust-observer", "aside"): aside,
    ("robust-observer", "damper"): damper,
    ("bilinear-observer", "pole"): pole,
    ("bilinear-observer", "patience"): patience,
    ("bilinear-observer", "silence"): silence,
    ("bilinear-observer", "lag"): lag,
    ("fault-diagnosis", "zero"): zero,
    ("fault-diagnosis", "ignore"): ignore,
    ("fault-diagnosis", "delay"): delay,
    ("fault-diagnosis", "wolves"): wolves,
    ("network", "loss"): loss,
    ("network", "gap"): gap,
    ("network", "burst"): burst,
    ("network", "late"): one_late,
    ("sandbox", "static"): static,
    ("sandbox", "held"): held,
    ("sandbox", "zero"): zero_of,
    ("sandbox", "silent"): silent,
    ("arm", "holding"): holding,
    ("arm", "bias"): load_bias,
    ("arm", "product"): load_gain,
    ("arm", "play"): across,
}
