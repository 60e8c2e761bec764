"""The answer of every exam from the numbers that it gives, by code that shares nothing with the lessons."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import control
import numpy as np
from scipy.integrate import quad
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.signal import place_poles
from scipy.special import lambertw
from scipy.stats import binom, geom, norm

Given = Mapping[str, Any]
INTEGRATOR, POSITION = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[1.0, 0.0]])


def placed(A: np.ndarray, C: np.ndarray, poles: list[float]) -> np.ndarray:
    """The observer gain of one output, from the coefficients of the polynomial: linear in L."""
    n = len(A)
    base = np.poly(A)[1:]
    slopes = np.column_stack([np.poly(A - np.outer(np.eye(n)[:, i], C))[1:] - base for i in range(n)])
    return np.linalg.solve(slopes, np.poly(poles)[1:] - base)


def spring(b: float, k: float) -> np.ndarray:
    return np.array([[0.0, 1.0], [-k, -b]])


# --- virtual-sensor --------------------------------------------------------------------------------------------------
def trust(g: Given) -> float:
    return brentq(lambda L: float(expm(np.array([[(g["a"] - L) * g["t"]]]))[0, 0]) - 0.1, 0.0, 50.0, xtol=1e-12)


def copy(g: Given) -> float:
    return brentq(lambda t: g["e0"] * float(expm(np.array([[-g["a"] * t]]))[0, 0]) - g["e1"], 0.0, 200.0, xtol=1e-12)


def bias(g: Given) -> float:
    """Plant and observer side by side, with the constant as a state that rests."""
    M = np.array([[-g["a"], 0.0], [g["L"], -g["a"] - g["L"]]])
    T, That = np.linalg.solve(M, [-g["q"], -g["qhat"]])
    return T - That


def core(g: Given) -> float:
    return placed(g["A"], np.array([0.0, 1.0]), [g["p"], g["r"]])[0]


# --- error-dynamics --------------------------------------------------------------------------------------------------
def double(g: Given) -> float:
    return placed(spring(g["b"], g["k"]), POSITION, [g["p"], g["p"]])[1]


def decay(g: Given) -> float:
    return np.log(g["N"]) / -np.max(np.real(np.linalg.eigvals(spring(g["b"], g["k"]) - g["L"] @ POSITION)))


def form(g: Given) -> float:
    poles = [complex(g["re"], g["im"]), complex(g["re"], -g["im"])]
    return place_poles(g["A"].T, np.array([[0.0], [1.0]]), poles).gain_matrix[0, 0]


def push(g: Given) -> float:
    A = spring(g["b"], g["k"])
    L = place_poles(A.T, POSITION.T, [g["p"], g["r"]]).gain_matrix.T
    return -np.linalg.solve(A - L @ POSITION, [0.0, g["d"]])[1]


# --- observability ---------------------------------------------------------------------------------------------------
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


# --- separation ------------------------------------------------------------------------------------------------------
def trace(g: Given) -> float:
    B = np.array([[0.0], [1.0]])
    K = place_poles(INTEGRATOR, B, [g["c1"], g["c2"]]).gain_matrix
    L = place_poles(INTEGRATOR.T, POSITION.T, [g["o1"], g["o2"]]).gain_matrix.T
    return np.trace(np.block([[INTEGRATOR, -B @ K], [L @ POSITION, INTEGRATOR - B @ K - L @ POSITION]]))


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


# --- duality ---------------------------------------------------------------------------------------------------------
def gain(g: Given) -> float:
    return place_poles(spring(g["b"], g["k"]).T, POSITION.T, [g["p"], g["q"]]).gain_matrix[0, 1]


def pole_of_both(g: Given) -> float:
    E = control.lqr(np.array([[g["a"]]]), np.array([[g["c"]]]), np.array([[g["W"]]]), np.array([[g["V"]]]))[2]
    L = control.lqe(np.array([[g["a"]]]), np.eye(1), np.array([[g["c"]]]), np.array([[g["W"]]]), np.array([[g["V"]]]))[0]
    filtered = g["a"] - L[0, 0] * g["c"]
    assert abs(filtered - E[0].real) < 1e-8
    return filtered


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


# --- hidden-modes ----------------------------------------------------------------------------------------------------
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


# --- saturation ------------------------------------------------------------------------------------------------------
def believed(g: Given) -> float:
    L = np.array([[-2 * g["p"]], [g["p"] ** 2]])
    return -np.linalg.solve(INTEGRATOR - L @ POSITION, [0.0, g["limit"] - g["asked"]])[1]


def windup(g: Given) -> float:
    """The clipped integrator after many time constants, by its matrix exponential."""
    M = np.array([[-1 / g["Tt"], g["ki"] * g["e"] + g["U"] / g["Tt"]], [0.0, 0.0]])
    return (expm(M * 60 * g["Tt"]) @ [0.0, 1.0])[0]


def reach(g: Given) -> float:
    """The largest start from which full force after τ does not let the state grow, by the exact motion."""
    a, b, U = g["a"], g["b"], g["U"]
    return brentq(lambda x0: a * float(expm(np.array([[a * g["tau"]]]))[0, 0]) * x0 - b * U, 0.0, 1e4, xtol=1e-12)


def fastest(g: Given) -> float:
    """Full force there and back, by the exact double integrator: the time at which the cart stands at d."""
    def way(t: float) -> float:
        M = np.zeros((3, 3))
        M[0, 1] = 1.0
        there, back = M.copy(), M.copy()
        there[1, 2], back[1, 2] = g["U"] / g["m"], -g["U"] / g["m"]
        return float((expm(back * t / 2) @ expm(there * t / 2) @ [0.0, 0.0, 1.0])[0])
    return brentq(lambda t: way(t) - g["d"], 0.0, 1e3, xtol=1e-13)


# --- noise -----------------------------------------------------------------------------------------------------------
def least(g: Given) -> float:
    return control.lqe(np.array([[-g["a"]]]), np.eye(1), np.eye(1), np.array([[g["W"]]]), np.array([[g["V"]]]))[0][0, 0]


def valley(g: Given) -> float:
    return control.lyap(np.array([[-g["a"] - g["L"]]]), np.array([[g["W"] + g["L"] ** 2 * g["V"]]]))[0, 0]


def worse(g: Given) -> float:
    none = valley({**g, "L": 0.0})
    bottom = least(g)
    return brentq(lambda L: valley({**g, "L": L}) - none, bottom, 1e4, xtol=1e-11)


def samples(g: Given) -> float:
    """The gain per second of discrete filters with ever more readings, each as much noisier, at no period at all."""
    def gain_at(h: float) -> float:
        Q, R = g["W"] * h, g["sigma"] ** 2 / g["f"] / h
        P = (Q + np.sqrt(Q * Q + 4 * Q * R)) / 2
        return P / (P + R) / h
    return 2 * gain_at(0.5e-5 / g["f"]) - gain_at(1e-5 / g["f"])


# --- kalman ----------------------------------------------------------------------------------------------------------
def step(g: Given) -> float:
    return 1 / (1 / (g["a"] ** 2 * g["p"] + g["Q"]) + 1 / g["R"])


def steady(g: Given) -> float:
    return control.dlqe(np.eye(1), np.eye(1), np.eye(1), np.array([[g["Q"]]]), np.array([[g["R"]]]))[0][0, 0]


def nis(g: Given) -> float:
    """By the densities: −2 ln of the ratio of the reading's likelihood to the largest one."""
    sure = norm(g["c"] * g["xhat"], np.sqrt(g["c"] ** 2 * g["P"] + g["R"]))
    return float(2 * (sure.logpdf(g["c"] * g["xhat"]) - sure.logpdf(g["y"])))


def joseph(g: Given) -> float:
    """The variance of (1 − M) e − M v, by the covariance of both."""
    M = g["P"] / (g["P"] + g["believed"])
    row = np.array([1 - M, -M])
    return float(row @ np.diag([g["P"], g["R"]]) @ row)


# --- lqg -------------------------------------------------------------------------------------------------------------
def doyle(g: Given) -> float:
    A, B, C = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
    ones = np.ones((2, 2))
    K = control.lqr(A, B, g["q"] * ones, np.eye(1))[0]
    L = control.lqe(A, np.eye(2), C, g["sigma"] * ones, np.eye(1))[0]

    def rightmost(m: float) -> float:
        return float(np.max(np.real(np.linalg.eigvals(np.block([[A, -m * B @ K], [L @ C, A - B @ K - L @ C]])))))
    return 100 * (brentq(rightmost, 1.0, 1.06, xtol=1e-14) - 1)


def cost(g: Given) -> float:
    """The stationary covariance of plant and estimate under the gains of python-control, weighed."""
    a, one = np.array([[g["a"]]]), np.eye(1)
    K = control.lqr(a, one, [[g["Q"]]], [[g["R"]]])[0][0, 0]
    L = control.lqe(a, one, one, [[g["W"]]], [[g["V"]]])[0][0, 0]
    loop = np.array([[g["a"], -K], [L, g["a"] - K - L]])
    P = control.lyap(loop, np.diag([g["W"], L * L * g["V"]]))
    return g["Q"] * P[0, 0] + g["R"] * K * K * P[1, 1]


def regulator(g: Given) -> float:
    return control.lqr(np.array([[g["a"]]]), np.eye(1), [[g["Q"]]], [[g["R"]]])[0][0, 0]


def drop(g: Given) -> float:
    return brentq(lambda m: g["a"] - m * regulator(g), 0.0, 1.0, xtol=1e-14)


def phase(g: Given) -> float:
    """The angle by which the loop's value of size one has to turn to reach −1."""
    K = regulator(g)
    loop = lambda w: K / (1j * w - g["a"])  # noqa: E731
    w = brentq(lambda w: abs(loop(w)) - 1, 0.0, 1e4, xtol=1e-12)
    return abs(np.degrees(np.angle(-loop(w))))


# --- decoupling ------------------------------------------------------------------------------------------------------
def diophantine(g: Given) -> float:
    target = np.poly([-g["c"], -g["c"]])  # (s − a)(s + e) + k F
    e = target[1] + g["a"]
    return (target[2] + g["a"] * e) / g["k"]


def coils(g: Given) -> float:
    return np.linalg.solve([[1.0, 1.0], [-g["l"], g["l"]]], [g["F"], g["M"]])[1]


def mixing(g: Given) -> float:
    """The gain to z₂ of a command that leaves z₁ at zero."""
    v = np.linalg.solve(g["G"], [0.0, 1.0])
    return 1.0 / v[1]


def damping(g: Given) -> float:
    def ratio(gain: float) -> float:
        pole = np.roots([g["m"], g["d"] + gain, g["k"]])[0]
        return float(-pole.real / abs(pole)) - g["zeta"]
    return brentq(ratio, -g["d"], 2 * np.sqrt(g["m"] * g["k"]) - g["d"], xtol=1e-12)


# --- weak-states -----------------------------------------------------------------------------------------------------
def bound(g: Given) -> float:
    P = control.ss([[0.0, 1.0], [-g["k"], -g["c"]]], [[0.0], [g["g"]]], [[0.0, 1.0]], 0)
    W = [control.lyap(P.A, P.B @ P.B.T), control.lyap(P.A.T, P.C.T @ P.C)]
    return 2 * float(np.sum(np.sqrt(np.real(np.linalg.eigvals(W[0] @ W[1])))))


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


# --- showdown --------------------------------------------------------------------------------------------------------
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


# --- nonlinear -------------------------------------------------------------------------------------------------------
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


# --- robust-observer -------------------------------------------------------------------------------------------------
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


# --- bilinear-observer -----------------------------------------------------------------------------------------------
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


# --- fault-diagnosis -------------------------------------------------------------------------------------------------
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


# --- network ---------------------------------------------------------------------------------------------------------
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


# --- sandbox ---------------------------------------------------------------------------------------------------------
def silent(g: Given) -> float:
    values, vectors = np.linalg.eig(np.array([[g["a"], 1.0], [0.0, g["b"]]]))
    mode = vectors[:, np.argmin(np.abs(values - g["b"]))]
    return -mode[0] / mode[1]


# --- arm -------------------------------------------------------------------------------------------------------------
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
    ("arm", "holding"): holding,
    ("arm", "bias"): load_bias,
    ("arm", "product"): load_gain,
    ("arm", "play"): across,
    ("virtual-sensor", "trust"): trust,
    ("error-dynamics", "double"): double,
    ("observability", "start"): start,
    ("virtual-sensor", "copy"): copy,
    ("virtual-sensor", "bias"): bias,
    ("virtual-sensor", "core"): core,
    ("error-dynamics", "decay"): decay,
    ("error-dynamics", "form"): form,
    ("error-dynamics", "push"): push,
    ("observability", "blind"): blind,
    ("observability", "stroboscope"): stroboscope,
    ("observability", "energy"): energy,
    ("separation", "trace"): trace,
    ("separation", "peak"): peak,
    ("separation", "own"): own,
    ("separation", "leak"): leak,
    ("duality", "gain"): gain,
    ("hidden-modes", "cancel"): cancel,
    ("hidden-modes", "left"): left,
    ("hidden-modes", "draft"): draft,
    ("saturation", "windup"): windup,
    ("saturation", "reach"): reach,
    ("saturation", "fastest"): fastest,
    ("noise", "valley"): valley,
    ("noise", "worse"): worse,
    ("noise", "samples"): samples,
    ("kalman", "steady"): steady,
    ("kalman", "nis"): nis,
    ("kalman", "joseph"): joseph,
    ("duality", "predictor"): predictor,
    ("duality", "adjoint"): adjoint,
    ("duality", "pole"): pole_of_both,
    ("hidden-modes", "bolted"): bolted,
    ("saturation", "believed"): believed,
    ("noise", "least"): least,
    ("kalman", "step"): step,
    ("lqg", "doyle"): doyle,
    ("decoupling", "diophantine"): diophantine,
    ("weak-states", "bound"): bound,
    ("showdown", "sampled"): sampled,
    ("nonlinear", "sigma"): sigma,
    ("lqg", "cost"): cost,
    ("lqg", "drop"): drop,
    ("lqg", "phase"): phase,
    ("decoupling", "coils"): coils,
    ("decoupling", "mixing"): mixing,
    ("decoupling", "damping"): damping,
    ("weak-states", "balance"): balance,
    ("weak-states", "slow"): slow,
    ("weak-states", "tail"): tail,
    ("showdown", "passive"): passive,
    ("showdown", "late"): late,
    ("showdown", "rounding"): rounding,
    ("nonlinear", "update"): update,
    ("nonlinear", "spread"): spread,
    ("nonlinear", "hardening"): hardening,
    ("robust-observer", "criterion"): criterion,
    ("bilinear-observer", "pole"): pole,
    ("fault-diagnosis", "zero"): zero,
    ("network", "loss"): loss,
    ("robust-observer", "direct"): direct,
    ("robust-observer", "aside"): aside,
    ("robust-observer", "damper"): damper,
    ("bilinear-observer", "patience"): patience,
    ("bilinear-observer", "silence"): silence,
    ("bilinear-observer", "lag"): lag,
    ("fault-diagnosis", "ignore"): ignore,
    ("fault-diagnosis", "delay"): delay,
    ("fault-diagnosis", "wolves"): wolves,
    ("network", "gap"): gap,
    ("network", "burst"): burst,
    ("sandbox", "static"): static,
    ("sandbox", "held"): held,
    ("network", "late"): one_late,
    ("sandbox", "zero"): zero_of,
    ("sandbox", "silent"): silent,
}
