"""Clipping, noise and optimal estimates: exams of lessons 7 to 10."""

from __future__ import annotations

from collections.abc import Callable

import control
import numpy as np
from scipy.integrate import quad
from scipy.linalg import expm, solve_continuous_lyapunov, solve_discrete_lyapunov
from scipy.optimize import brentq
from scipy.stats import norm, uniform

from .shared import INTEGRATOR, POSITION, Given


# --- saturation --------------------------------------------------------------------------------------------------------
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


# --- noise -------------------------------------------------------------------------------------------------------------
def least(g: Given) -> float:
    return control.lqe(np.array([[-g["a"]]]), np.eye(1), np.eye(1), np.array([[g["W"]]]), np.array([[g["V"]]]))[0][0, 0]


def valley(g: Given) -> float:
    return control.lyap(np.array([[-g["a"] - g["L"]]]), np.array([[g["W"] + g["L"] ** 2 * g["V"]]]))[0, 0]


def force(g: Given) -> float:
    """The deviation of K e by Lyapunov's equation, as the gain grows beyond that of the Kalman filter."""
    def beyond(L: float) -> float:
        P = solve_continuous_lyapunov(np.array([[-L]]), -np.array([[g["W"] + L * L * g["V"]]]))[0, 0]
        return g["K"] * np.sqrt(P) - g["s"]
    return brentq(beyond, np.sqrt(g["W"] / g["V"]), 1e4, xtol=1e-11)


def samples(g: Given) -> float:
    """The gain per second of discrete filters with ever more readings, each as much noisier, at no period at all."""
    def gain_at(h: float) -> float:
        Q, R = g["W"] * h, g["sigma"] ** 2 / g["f"] / h
        P = (Q + np.sqrt(Q * Q + 4 * Q * R)) / 2
        return P / (P + R) / h
    return 2 * gain_at(0.5e-5 / g["f"]) - gain_at(1e-5 / g["f"])


# --- kalman ------------------------------------------------------------------------------------------------------------
def sheet(g: Given) -> float:
    """R by the spectrum of an average over T and the spread of a rounded reading, Q by Van Loan's exponential of an integrator."""
    averaged = quad(lambda f: g["n"] ** 2 * np.sinc(f * g["T"]) ** 2, 0.0, 400 / g["T"], limit=4000)[0]
    averaged += g["n"] ** 2 / (2 * np.pi**2 * 400 * g["T"])  # beyond: sinc² is 1/(2 π² f² T²) on average
    R = averaged + uniform(-g["step"] / 2, g["step"]).var()
    Q = expm(np.array([[0.0, g["d"] ** 2 / 2], [0.0, 0.0]]) * g["T"])[0, 1]
    return 1 / (1 / (g["p"] + Q) + 1 / R)


def steady(g: Given) -> float:
    return control.dlqe(np.eye(1), np.eye(1), np.eye(1), np.array([[g["Q"]]]), np.array([[g["R"]]]))[0][0, 0]


def nis(g: Given) -> float:
    """By the densities: −2 ln of the ratio of the reading's likelihood to the largest one."""
    sure = norm(g["c"] * g["xhat"], np.sqrt(g["c"] ** 2 * g["P"] + g["R"]))
    return float(2 * (sure.logpdf(g["c"] * g["xhat"]) - sure.logpdf(g["y"])))


def late(g: Given) -> float:
    """The stationary covariance of (x, x̂) under the predictor gain of python-control."""
    a, one = np.array([[g["a"]]]), np.eye(1)
    L = control.dlqe(a, one, one, [[g["Q"]]], [[g["R"]]])[0][0, 0]  # x̂⁺ = a x̂ + u + L (y − x̂)
    loop = np.array([[g["a"], -g["a"]], [L, -L]])
    return float(solve_discrete_lyapunov(loop, np.diag([g["Q"], L * L * g["R"]]))[0, 0])


# --- lqg ---------------------------------------------------------------------------------------------------------------
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


# --- record ------------------------------------------------------------------------------------------------------------
def of_lags(g: Given) -> float:
    """The pole at which the covariances of a state keep their ratio."""
    return brentq(lambda a: g["c1"] * a - g["c2"], 0.0, 2.0, xtol=1e-14)


def sensor(g: Given) -> float:
    """The variance that, taken off lag 0, leaves a Hankel matrix of rank one."""
    return brentq(lambda R: np.linalg.det([[g["c0"] - R, g["c1"]], [g["c1"], g["c2"]]]), -100.0, 200.0, xtol=1e-13)


def mean_band(g: Given) -> float:
    return 1 + 2 * float(np.hypot(*(np.sqrt(2 / g[name]) for name in ("N", "M"))))


def one_step_back(g: Given) -> float:
    """The regression of x[k] on x[k + 1], from their joint covariance."""
    a, P, q = g["a"], g["P"], g["q"]
    T = np.array([[1.0, 0.0], [a, 1.0]])
    joint = T @ np.diag([P, q]) @ T.T
    return float(joint[0, 1] / joint[1, 1])


ORACLES: dict[tuple[str, str], Callable[[Given], float]] = {
    ("saturation", "windup"): windup,
    ("saturation", "reach"): reach,
    ("saturation", "fastest"): fastest,
    ("saturation", "believed"): believed,
    ("noise", "valley"): valley,
    ("noise", "force"): force,
    ("noise", "samples"): samples,
    ("noise", "least"): least,
    ("kalman", "steady"): steady,
    ("kalman", "nis"): nis,
    ("kalman", "late"): late,
    ("kalman", "sheet"): sheet,
    ("lqg", "doyle"): doyle,
    ("lqg", "cost"): cost,
    ("lqg", "drop"): drop,
    ("lqg", "phase"): phase,
    ("record", "pole"): of_lags,
    ("record", "sensor"): sensor,
    ("record", "band"): mean_band,
    ("record", "back"): one_step_back,
}
