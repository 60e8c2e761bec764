"""Results found with a pencil, beside a computation that does not know them: matrices, eigenvalues, simulations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from laws import each
from scipy.linalg import eigvals, expm, solve_continuous_are, solve_continuous_lyapunov
from scipy.optimize import brentq, minimize_scalar
from scipy.signal import cont2discrete

from observer_lab.course.exercises.typed_answers import evaluate_typed
from observer_lab.lessons import LESSONS

Letters = Mapping[str, float]
POINTS = 6
INTEGRATOR = np.array([[0.0, 1.0], [0.0, 0.0]])
FIRST = np.array([[1.0, 0.0]])


def gains(A: np.ndarray, C: np.ndarray, poles: list[float]) -> np.ndarray:
    """L (n,) that puts the eigenvalues of A − L C: from the coefficients of the polynomial, Ackermann's way."""
    seen = np.vstack([C @ np.linalg.matrix_power(A, k) for k in range(len(A))])
    value = sum(c * np.linalg.matrix_power(A, k) for k, c in enumerate(np.poly(poles)[::-1]))
    return value @ np.linalg.solve(seen, np.eye(len(A))[:, -1])


def match(v: Letters) -> float:
    A = np.array([[-v["a"], v["a"]], [v["b"], -1.7]])
    return float(gains(A, np.array([[0.0, 1.0]]), [-v["p"], -v["q"]])[0])


def unknown_push(v: Letters) -> float:
    A = np.array([[0.0, 1.0], [-0.8, -v["b"]]])
    L = gains(A, FIRST, [-v["p"], -v["p"]])
    return float(np.linalg.solve(A - np.outer(L, FIRST), [0.0, -v["d"]])[1])


def direct(v: Letters) -> float:
    """The error at rest with its own equation solved as it stands."""
    A, L = np.array([[0.0, 1.0], [-v["k"], -v["b"]]]), np.array([v["l1"], v["l2"]])
    return float(np.linalg.solve(A - np.outer(L, A[1]), L * v["u"])[0])


def blind_angle(v: Letters) -> float:
    A, C = np.array([[v["a"], v["b"]], [v["c"], v["d"]]]), np.array([1.0, v["g"]])
    return float(np.linalg.det(np.array([C, C @ A])))


def toll(v: Letters) -> float:
    return float(gains(np.diag([-v["a"], -v["b"]]), np.array([[1.0, 1.0]]), [-v["p"], -v["q"]])[0])


def spring(v: Letters) -> float:
    A, B = INTEGRATOR, np.array([[0.0], [1.0]])
    K, L = gains(A.T, B.T, [-v["c"]] * 2)[None], gains(A, FIRST, [-v["o"]] * 2)[:, None]
    return float((K @ np.linalg.solve(-(A - B @ K - L @ FIRST), L)).item())


def wrong_belief(v: Letters) -> float:
    """∫x² dt from Lyapunov's equation of the loop in (x, x̂), started at (0, −f)."""
    K, L = v["a"] + v["c"], v["a"] + v["o"]
    loop, start = np.array([[v["a"], -K], [L, v["a"] - K - L]]), np.array([0.0, -v["f"]])
    return float(start @ solve_continuous_lyapunov(loop.T, -np.diag([1.0, 0.0])) @ start)


def read_off(v: Letters) -> float:
    P = solve_continuous_are(INTEGRATOR.T, FIRST.T, np.diag([0.0, v["W"]]), np.array([[v["V"]]]))
    return float(P[0, 0] / v["V"])


def listen(v: Letters) -> float:
    """What many readings in a row leave open, by least squares: intensity V is the variance V/h of a reading every h."""
    count = 4000
    h = v["T"] / count
    t = (np.arange(count) + 0.5) * h
    rows = np.column_stack([np.ones(count), t])
    return float(np.linalg.inv(rows.T @ rows)[1, 1] * v["V"] / h) * (1 - 1 / count**2)  # the midpoints' own exactness


def unlike(v: Letters) -> float:
    """The spring with which a common start leaves the distance at rest: its second derivative, C A² x, vanishes."""
    def leaves(spring: float) -> float:
        A = np.zeros((4, 4))
        A[:2, 2:] = np.eye(2)
        A[2:, :2] = [[-(v["k"] + 1.3) / v["m"], 1.3 / v["m"]], [1.3 / v["n"], -(spring + 1.3) / v["n"]]]
        return float(np.array([-1.0, 1.0, 0.0, 0.0]) @ A @ A @ [1.0, 1.0, 0.0, 0.0])
    return float(brentq(leaves, 0.0, 1e4, xtol=1e-12))


def last_start(v: Letters) -> float:
    """The lean from which the full force just fails, with ẋ of the pendulum integrated exactly."""
    A, push = np.array([[0.0, 1.0], [v["k"] ** 2, 0.0]]), np.array([[0.0], [-v["b"] * v["U"]]])
    Phi, Gamma = cont2discrete((A, push, np.eye(2), np.zeros((2, 1))), 30.0 / v["k"])[:2]
    return float(brentq(lambda lean: (Phi @ [lean, v["w"]] + Gamma[:, 0])[0], -1e4, 1e4, xtol=1e-12))


def both_in_one_place(v: Letters) -> float:
    def variance(p: float) -> float:
        L = gains(INTEGRATOR, FIRST, [-p, -p])
        return solve_continuous_lyapunov(INTEGRATOR - np.outer(L, FIRST),
                                         -np.diag([0.0, v["W"]]) - v["V"] * np.outer(L, L))[0, 0]
    near = minimize_scalar(variance, bounds=(0.05, 8.0), method="bounded", options={"xatol": 1e-9}).x
    step = 1e-3 * near
    return float(brentq(lambda p: variance(p + step) - variance(p - step), 0.8 * near, 1.2 * near, xtol=1e-13))


def offset(v: Letters) -> float:
    def square(L: float) -> float:
        bias = np.linalg.solve([[-L]], [-v["d"]])[0]
        return float(bias**2 + solve_continuous_lyapunov(np.array([[-L]]), np.array([[-(L**2) * v["V"]]])).item())
    near = minimize_scalar(square, bounds=(0.05, 20.0), method="bounded", options={"xatol": 1e-9}).x
    step = 1e-4 * near
    return float(brentq(lambda L: square(L + step) - square(L - step), 0.8 * near, 1.2 * near, xtol=1e-13))


def second_sensor(v: Letters) -> float:
    C, R = np.ones((2, 1)), np.diag([v["r"], v["s"]])  # both at once: what the second gets is its gain there
    return float((v["P"] * C.T @ np.linalg.inv(v["P"] * C @ C.T + R))[0, 1])


def late(v: Letters) -> float:
    """Var x under both estimates, from the covariance of (x, e⁻) that u = −a x̂ leaves; Q makes p and M those of a settled filter."""
    a, M, p = v["a"], v["M"], v["p"]
    R, Q = p * (1 - M) / M, p - a * a * (1 - M) * p
    row = np.array([a * (1 - M), -a * M])
    return a * a * p + Q - float(row @ np.diag([p, R]) @ row + Q)


def weaker(v: Letters) -> float:
    def loop(m: float) -> float:
        return float(np.linalg.det([[v["a"], -m * v["K"]], [v["L"], v["a"] - v["K"] - v["L"]]]))
    return float(brentq(loop, -1e3, 1e3, xtol=1e-13))


def one_lag(v: Letters) -> float:
    gramians = [solve_continuous_lyapunov(np.array([[-v["a"]]]), np.array([[-v[name] ** 2]])).item() for name in ("b", "c")]
    return float(np.sqrt(np.prod(gramians)))


def too_late(v: Letters) -> float:
    lost = np.deg2rad(v["d"])
    return float(brentq(lambda t: np.angle(np.exp(-2j * np.pi * v["f"] * t)) + lost, 0.0, 0.49 / v["f"], xtol=1e-14))


def square(v: Letters) -> float:
    small = 1e-5
    slope = ((v["m"] + small) ** 2 - (v["m"] - small) ** 2) / (2 * small)
    return v["P"] * slope / (slope * v["P"] * slope + v["R"])


def swallowed(v: Letters) -> float:
    return float(v["f"] - np.linalg.solve([[-v["a"] - v["L"]]], [-v["L"] * v["f"]])[0])


def perfect_readings(v: Letters) -> float:
    """Σ a²ᵏ Q pᵏ over the readings lost in a row, k or more with probability pᵏ; where it diverges, the series continued."""
    ratio = v["p"] * v["a"] ** 2
    if ratio < 1:
        return float(v["Q"] * np.sum(ratio ** np.arange(20_000)))
    return float(-v["Q"] * np.sum(ratio ** -np.arange(1.0, 20_000)))


def deadbeat(v: Letters) -> float:
    A = np.array([[1.0, v["h"]], [0.0, v["d"]]])
    L = gains(A, FIRST, [0.0, 0.0])
    assert np.allclose(np.linalg.matrix_power(A - np.outer(L, FIRST), 2), 0)
    return float(L[1])


def one_observer(v: Letters) -> float:
    return float(np.array([1.0, v["w"]]) @ np.array([v["a"], v["b"]]))


def cancel(v: Letters) -> float:
    """The c with which, at the target, voltage, current and load are at rest: two equations in i and c."""
    tau = 1.3
    i, u = np.linalg.solve([[v["n"] * v["k"], 0.0], [-v["R"], 1.0]], [tau, 0.0])
    return float((u + v["K"] * i) / tau)


def injection(v: Letters) -> float:
    """With a winding so fast that its pole stays where it is: poles placed numerically."""
    R, L, J, k, b = 1.0, 2e-7, v["J"], 1.0, 0.0
    A = np.array([[-R / L, -k / L, 0, 0], [k / J, -b / J, 0, -1 / J], [0, 1, 0, 0], [0, 0, 0, 0]])
    return float(gains_by_units(A, np.array([[0, 0, 1.0, 0]]), [-R / L, -v["p"], -v["p"], -v["p"]])[3])


def gains_by_units(A: np.ndarray, C: np.ndarray, poles: list[float]) -> np.ndarray:
    """The same with the first state, a fast one, counted in small units."""
    scale = np.array([np.abs(A).max(), 1.0, 1.0, 1.0])
    return gains(A * scale[:, None] / scale, C / scale, poles) / scale


def seen(v: Letters) -> float:
    J, b = v["J"], 0.4
    A = np.array([[-v["R"] / v["L"], -v["n"] * v["k"] / v["L"], 0, 0], [v["n"] * v["k"] / J, -b / J, 0, -1 / J],
                  [0, 1.0, 0, 0], [0, 0, 0, 0]])
    C = np.array([[0, 0, 1.0, 0]])
    return float(np.linalg.det(np.vstack([C @ np.linalg.matrix_power(A, k) for k in range(4)])))


def zero(v: Letters) -> float:
    """The invariant zero from the force on the line to its place: a matrix pencil."""
    line, spring = np.array([[1.0, v["h"]]]), 0.7
    stiff = np.diag([0.0, v["k"]]) + spring * line.T @ line
    mass = np.diag([v["m"], v["J"]])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, stiff), np.zeros((2, 2))]])
    B, C = np.vstack([np.zeros((2, 1)), np.linalg.solve(mass, line.T)]), np.hstack([line, np.zeros((1, 2))])
    found = np.asarray(eigvals(np.block([[A, B], [C, np.zeros((1, 1))]]), np.diag([1.0, 1, 1, 1, 0])))
    return float(np.abs(np.imag(found[np.abs(found) < 1e4])).max())


def almost_twins(v: Letters) -> float:
    A, b = -np.diag([v["a"], v["b"]]), np.ones((2, 1))
    Wc, Wo = solve_continuous_lyapunov(A, -b @ b.T), solve_continuous_lyapunov(A.T, -b @ b.T)
    return float(np.prod(np.sqrt(np.linalg.eigvals(Wc @ Wo).real)))


def drag(v: Letters) -> float:
    """With the slopes of the fall by steps into the complex plane."""
    def rates(x: np.ndarray) -> np.ndarray:
        return np.array([-x[1], -np.exp(-v["k"] * x[0]) * x[1] ** 2 * x[2], 0.0])
    step = 1e-30j
    A = np.column_stack([rates(np.array([v["h"], v["v"], 0.9]) + step * e).imag / 1e-30 for e in np.eye(3)])
    C = np.array([[v["c"], 0.0, 0.0]])
    return float(np.linalg.det(np.vstack([C, C @ A, C @ A @ A])))


def least(v: Letters) -> float:
    """By quadrature over the truths, each with the slope of its reading by a step into the complex plane."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(6)
    slope = np.imag((v["m"] + np.sqrt(v["P"]) * nodes + 1e-30j) ** 2) / 1e-30
    return 1 / (1 / v["P"] + v["N"] * float(weights @ slope**2 / weights.sum()) / v["R"])


def noisy_readings(v: Letters) -> float:
    """The root of (P⁺ − P)(P + R) that is not zero."""
    a2, R = v["a"] ** 2, v["R"]
    growing = np.polymul([a2, 0.0], [1.0, R])
    return float(np.roots(growing - (1 - v["p"]) * np.array([a2, 0.0, 0.0]) - np.polymul([1.0, 0.0], [1.0, R]))[0])


def budget(v: Letters) -> float:
    """The p at which the mean square, carried from packet to packet while none of a sample has come, neither grows nor fades."""
    copies = 1 + int(v["k"])
    way = np.roll(np.eye(copies), 1, axis=0) * np.exp(2 * v["a"] / v["R"])
    return float(brentq(lambda p: np.abs(np.linalg.eigvals(p * way)).max() - 1, 1e-12, 1.0))


def stroboscope(v: Letters) -> float:
    Phi = expm(v["h"] * np.array([[0.0, 1.0], [-v["w"] ** 2, 0.0]]))
    return float(np.linalg.det(np.vstack([FIRST, FIRST @ Phi])))


def wrong_sensor(v: Letters) -> float:
    """Where the determinant of the loop, linear in the share, is zero: from two points of the line."""
    a, k, l = v["a"], v["k"], v["l"]
    at = [float(np.linalg.det([[a, -k], [l * (1 - d), a - k - l]])) for d in (0.0, 5.0)]
    return 5.0 * at[0] / (at[0] - at[1])


def no_say(v: Letters) -> float:
    """The direct path at which the second of two states falls silent, from two points of the line N(M) = (K − MC)T⁻¹."""
    at = [float((np.array([30.0, -50.0 - M]) @ np.linalg.inv(np.array([[1.0, v["s"]], [1.0, v["s"] - 2.0]])))[1]) for M in (0.0, 9.0)]
    return 9.0 * at[0] / (at[0] - at[1])


def circle(v: Letters) -> float:
    """|s₁|² where the tachometer's entry of M vanishes: rows t of the carts by linear equations, M from two imaginary parts."""
    def direct(square: float) -> float:
        s = complex(v["s"], np.sqrt(complex(square - v["s"] ** 2)).real) if square > v["s"] ** 2 else complex(v["s"], 1e-3)
        # t = (t₁, t₂, s, 1): column q₂ of tA − st = lC says 9 t₂ − 9 = s²
        T = np.array([[part(1 + s * s / 9), part(s), part(1 + 0j)] for part in (np.real, np.imag)])
        N = np.linalg.solve(T[:, 1:].T, [-88.0, 8.0])
        return float(14.0 - N @ T[:, 0])
    low, high = v["s"] ** 2 + 1.0, v["s"] ** 2 + 5.0
    return low - direct(low) * (high - low) / (direct(high) - direct(low))  # M₂ is linear in |s₁|²


def blind_input(v: Letters) -> float:
    C = np.array([1.0, v["g"]])
    at = [float(np.linalg.det([C, C @ np.array([[0.0, 1.0], [u * v["f"], -v["b"]]])])) for u in (0.0, 5.0)]
    return 5.0 * at[0] / (at[0] - at[1])


def enough(v: Letters) -> float:
    """Where a row of L has as many entries as Q has columns, counted block by block."""
    n, k, r = v["n"], v["k"], v["r"]
    return float(brentq(lambda m: k * r + (n - m - r) + k * (n - m - r) - m, -50.0, 50.0))


def back(v: Letters) -> float:
    """P and R from both equations at once: P + R = s and a P = k s."""
    return float(np.linalg.solve([[1.0, 1.0], [v["a"], 0.0]], [v["s"], v["k"] * v["s"]])[1])


COMPUTED: Mapping[tuple[str, str], Callable[[Letters], float]] = {
    ("virtual-sensor", "match"): match, ("error-dynamics", "unknown-push"): unknown_push,
    ("error-dynamics", "direct"): direct,
    ("observability", "blind-angle"): blind_angle, ("observability", "toll"): toll, ("separation", "spring"): spring,
    ("separation", "wrong-belief"): wrong_belief, ("duality", "read-off"): read_off, ("duality", "listen"): listen,
    ("hidden-modes", "unlike"): unlike, ("saturation", "last-start"): last_start,
    ("noise", "both-in-one-place"): both_in_one_place, ("noise", "offset"): offset, ("kalman", "second-sensor"): second_sensor,
    ("kalman", "late"): late, ("lqg", "weaker"): weaker, ("weak-states", "one-lag"): one_lag,
    ("showdown", "too-late"): too_late, ("nonlinear", "square"): square, ("fault-diagnosis", "swallowed"): swallowed,
    ("network", "perfect-readings"): perfect_readings, ("sandbox", "deadbeat"): deadbeat,
    ("robust-observer", "one-observer"): one_observer,
    ("decoupling", "zero"): zero, ("weak-states", "almost-twins"): almost_twins, ("nonlinear", "drag"): drag, ("nonlinear", "least"): least,
    ("network", "noisy-readings"): noisy_readings, ("network", "budget"): budget, ("sandbox", "stroboscope"): stroboscope,
    ("robust-observer", "wrong-sensor"): wrong_sensor, ("robust-observer", "no-say"): no_say,
    ("robust-observer", "circle"): circle,
    ("bilinear-observer", "blind-input"): blind_input, ("bilinear-observer", "enough"): enough,
    ("arm", "cancel"): cancel, ("arm", "injection"): injection, ("arm", "seen"): seen,
    ("record", "back"): back,
}
COUNTED = {("robust-observer", "remark-3"), ("robust-observer", "sizes")}  # ratios and numbers of rows, which the lesson's sizes show
PENCILS = {(lesson.id, task.id): task for lesson in LESSONS.values() for task in lesson.tasks
           if task.typed is not None and task.typed.letters}


def test_every_expression_has_a_computation_beside_it() -> None:
    assert set(PENCILS) == set(COMPUTED) | COUNTED


@each("place", sorted(PENCILS))
def test_every_slip_is_refuted_by_its_own_sentence(place: tuple[str, str]) -> None:
    typed: Any = PENCILS[place].typed
    for slip, why in typed.slips:
        assert typed.judge(None, slip) == (False, why), slip


@each("place", sorted(COMPUTED))
def test_the_right_answer_is_what_a_computation_finds(place: tuple[str, str]) -> None:
    typed: Any = PENCILS[place].typed
    rng = np.random.default_rng(len(place[1]))
    for _ in range(POINTS):
        point = {letter: float(rng.uniform(*typed.span)) for letter in typed.letters}
        assert evaluate_typed(typed.answer, point) == pytest.approx(COMPUTED[place](point), rel=2e-6), point
