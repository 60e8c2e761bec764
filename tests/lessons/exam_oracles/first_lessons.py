"""A copy, an error and its observability: exams of lessons 1 to 6."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import quad
from scipy.linalg import expm, solve_continuous_are
from scipy.optimize import brentq
from scipy.signal import place_poles

from .shared import POSITION, Given, placed, spring


# --- virtual-sensor ----------------------------------------------------------------------------------------------------
def jump(g: Given) -> float:
    """The gain on the derivative of y, by placing the dual of the core alone; w is continuous."""
    A = np.asarray(g["A"])
    return place_poles(A[:1, :1], A[1:, :1].T, [g["p"]]).gain_matrix[0, 0] * g["v"]


def copy(g: Given) -> float:
    return brentq(lambda t: g["e0"] * float(expm(np.array([[-g["a"] * t]]))[0, 0]) - g["e1"], 0.0, 200.0, xtol=1e-12)


def bias(g: Given) -> float:
    """Plant and observer side by side, with the constant as a state that rests."""
    M = np.array([[-g["a"], 0.0], [g["L"], -g["a"] - g["L"]]])
    T, That = np.linalg.solve(M, [-g["q"], -g["qhat"]])
    return T - That


def core(g: Given) -> float:
    return placed(g["A"], np.array([0.0, 1.0]), [g["p"], g["r"]])[0]


# --- error-dynamics ----------------------------------------------------------------------------------------------------
def double(g: Given) -> float:
    return placed(spring(g["b"], g["k"]), POSITION, [g["p"], g["p"]])[1]


def decay(g: Given) -> float:
    return np.log(g["N"]) / -np.max(np.real(np.linalg.eigvals(spring(g["b"], g["k"]) - g["L"] @ POSITION)))


def push(g: Given) -> float:
    A = spring(g["b"], g["k"])
    L = place_poles(A.T, POSITION.T, [g["p"], g["r"]]).gain_matrix.T
    return -np.linalg.solve(A - L @ POSITION, [0.0, g["d"]])[1]


def accelerometer(g: Given) -> float:
    """Where the run itself ends: the block and an observer that leaves the force out of its reading, by matrix exponential."""
    A, L, B = spring(g["b"], g["k"]), g["L"], np.array([[0.0], [1.0]])
    C = A[1:]
    whole = np.block([[A, np.zeros((2, 2)), B], [L @ C, A - L @ C, B + L], [np.zeros((1, 5))]])  # ŷ = C x̂, y = C x + u
    end = expm(1e4 * whole) @ np.array([0.0, 0.0, 1.0, 0.0, g["u"]])
    return end[0] - end[2]


# --- observability -----------------------------------------------------------------------------------------------------
def start(g: Given) -> float:
    return np.linalg.solve(np.vstack([[1.0, 0.0], g["A"][0]]), [g["y"], g["dy"]])[1]


def blind(g: Given) -> float:
    values, left = np.linalg.eig(g["A"])
    v = left[:, np.argmin(np.abs(values - g["hidden"]))]
    return -(v[0] / v[1]).real


def stroboscope(g: Given) -> float:
    """The determinant of (C, C Φ) as the period grows from nothing: its first zero."""
    A = np.array([[0.0, 1.0], [-g["k"] / g["m"], 0.0]])
    quarter = np.pi / 2 / np.sqrt(g["k"] / g["m"])
    return 1000 * brentq(lambda h: float(expm(A * h)[0, 1]), quarter, 3 * quarter, xtol=1e-14)


def energy(g: Given) -> float:
    return quad(lambda t: (g["c"] * g["x0"] * np.exp(-g["a"] * t)) ** 2, 0.0, g["T"], epsabs=1e-12, epsrel=1e-12)[0]


# --- separation --------------------------------------------------------------------------------------------------------
def offset(g: Given) -> float:
    """Plant and observer side by side at rest, under the command and the push."""
    a, r = np.array([[g["a"]]]), g["r"]
    K, L = (place_poles(a, np.eye(1), [-g[pole]]).gain_matrix[0, 0] for pole in ("c", "o"))
    N = 1 / float(np.linalg.solve([[K - g["a"]]], [1.0])[0])
    M = np.array([[g["a"], -K], [L, g["a"] - K - L]])
    return -np.linalg.solve(M, [N * r + g["d"], N * r])[0] - r


def peak(g: Given) -> float:
    """The loop with a = 0: K = −p, L = −q."""
    M = np.array([[g["p"], -g["p"]], [0.0, g["q"]]])
    return brentq(lambda t: float((M @ expm(M * t) @ [0.0, 1.0])[0]), 1e-6, 50.0, xtol=1e-12)


def own(g: Given) -> float:
    a = np.array([[g["a"]]])
    K, L = place_poles(a, np.eye(1), [g["p"]]).gain_matrix, place_poles(a, np.eye(1), [g["q"]]).gain_matrix
    return (a - K - L)[0, 0]


def leak(g: Given) -> float:
    def slowest(a: float) -> float:
        K, L, m = g["K"], g["L"], g["m"]
        return float(np.max(np.real(np.linalg.eigvals([[a, -K], [L, m - K - L]]))))
    return brentq(slowest, g["m"], 50.0, xtol=1e-12)


# --- duality -----------------------------------------------------------------------------------------------------------
def gain(g: Given) -> float:
    return place_poles(spring(g["b"], g["k"]).T, POSITION.T, [g["p"], g["q"]]).gain_matrix[0, 1]


def pendulum_locus(g: Given) -> float:
    A, B, Q = np.array([[0, 1], [g["a"], 0]]), np.array([[0.0], [1.0]]), np.diag([g["q"], 0.0])
    S = solve_continuous_are(A, B, Q, np.array([[g["r"]]]))
    return float(np.abs(np.linalg.eigvals(A - B @ (B.T @ S) / g["r"])).max())


def predictor(g: Given) -> float:
    """The gain that minimises the variance (a − L c)² P + L² R of the next error, by its slope."""
    slope = lambda L: -2 * g["c"] * (g["a"] - L * g["c"]) * g["P"] + 2 * L * g["R"]  # noqa: E731
    return brentq(slope, 0.0, 10.0, xtol=1e-13)


def adjoint(g: Given) -> float:
    """Transition matrices Φ that take x(0) to x(T): λ(T) = Φ⁻ᵀ λ(0); the one that gives λ the first entry that was read."""
    x0, x1, l0 = (g[name][:, 0] for name in ("x0", "x1", "l0"))
    across, free = np.array([-x0[1], x0[0]]), np.array([-x1[1], x1[0]])

    def dual(along: float, beside: float) -> np.ndarray:
        return np.linalg.solve((np.outer(x1, x0) / (x0 @ x0) + np.outer(along * x1 + beside * free, across)).T, l0)
    for along in (0.3, 1.7, (l0 @ across) / (x0 @ x0) / (l0 @ x0)):
        slope, offset = np.polyfit([0.5, 0.25], [dual(along, 2.0)[0] - g["first"], dual(along, 4.0)[0] - g["first"]], 1)
        found = dual(along, -slope / offset if abs(offset) > 1e-9 and abs(slope) > 1e-9 else 1.0)
        if abs(found[0] - g["first"]) < 1e-9:
            return found[1]
    raise AssertionError("no matrix does it")


# --- hidden-modes ------------------------------------------------------------------------------------------------------
def bolted(g: Given) -> float:
    C = np.array([[1.0, -1.0]])
    spectra = [np.linalg.eigvals(g["A"] - L @ C) for L in np.random.default_rng(1).normal(size=(3, 2, 1))]
    return min(spectra[0], key=lambda s: sum(np.min(np.abs(other - s)) for other in spectra[1:])).real


def cancel(g: Given) -> float:
    """The zero of (s + c)/(s² + b s + k) lies on the faster pole."""
    return -float(np.min(np.roots([1.0, g["b"], g["k"]]).real))


def left(g: Given) -> float:
    """The error itself, with a gain so large that nothing else is left."""
    return (expm((g["A"] - 1e4 * np.ones((2, 2))) * g["t"]) @ g["e0"])[0, 0]


def draft(g: Given) -> float:
    C = np.array([[1.0, -1.0]])
    L = np.array([[3.0], [-40.0]])
    return np.linalg.solve(g["A"] - L @ C, -g["d"] * np.ones(2))[0]


ORACLES: dict[tuple[str, str], Callable[[Given], float]] = {
    ("virtual-sensor", "jump"): jump,
    ("virtual-sensor", "copy"): copy,
    ("virtual-sensor", "bias"): bias,
    ("virtual-sensor", "core"): core,
    ("error-dynamics", "double"): double,
    ("error-dynamics", "decay"): decay,
    ("error-dynamics", "push"): push,
    ("error-dynamics", "direct"): accelerometer,
    ("observability", "start"): start,
    ("observability", "blind"): blind,
    ("observability", "stroboscope"): stroboscope,
    ("observability", "energy"): energy,
    ("separation", "offset"): offset,
    ("separation", "peak"): peak,
    ("separation", "own"): own,
    ("separation", "leak"): leak,
    ("duality", "gain"): gain,
    ("duality", "locus"): pendulum_locus,
    ("duality", "predictor"): predictor,
    ("duality", "adjoint"): adjoint,
    ("hidden-modes", "cancel"): cancel,
    ("hidden-modes", "left"): left,
    ("hidden-modes", "draft"): draft,
    ("hidden-modes", "bolted"): bolted,
}
