"""Designs for tasks with targets on two sides: right ones reached another way, near misses, and every number that the words print."""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import degrees, radians, sqrt
from typing import Any

import numpy as np
import pytest
from laws import each
from scipy.linalg import expm, solve_continuous_are, solve_continuous_lyapunov

from observer_lab.course.lesson import Outcome
from observer_lab.engine import Plant
from observer_lab.lessons import LESSONS
from observer_lab.plants import MODELS, two_mass

NUMBER = re.compile(r"(?<![\d.])\d+(?:\.\d+)?(?![\d.]*\d)")


def pairs(*upper: complex) -> tuple[complex, ...]:
    return tuple(pole for p in upper for pole in (p.conjugate(), p))


def solution(lesson: str, task: str) -> dict[str, Any]:
    return dict(next(t.solution for t in LESSONS[lesson].tasks if t.id == task))


def outcome(lesson: str, changes: Mapping[str, Any]) -> Outcome[Any]:
    here = LESSONS[lesson]
    return here.compute(here.apply(here.start(), changes))


GENTLE = solution("separation", "gentle")
CEILING = solution("saturation", "near-the-ceiling")
WEIGHTS: dict[str, Any] = {"method": "weights", "mirror": False}
POLES: dict[str, Any] = {"method": "poles"}
CASES: tuple[tuple[str, str, dict[str, Any], bool, str], ...] = (  # lesson, task, design, whether it solves, numbers in words and verdict
    ("virtual-sensor", "quiet-core", {"noise": 1.0, "observer_poles": (-1.4, -1.4)}, True, "0.179"),
    ("virtual-sensor", "quiet-core", {"noise": 1.0, "observer_poles": pairs(-1.37 + 0.1j)}, True, ""),
    ("virtual-sensor", "quiet-core", {"noise": 1.0, "observer_poles": (-2.8, -2.8), "trust": 0.3}, False, "1.35 1.45"),
    ("virtual-sensor", "quiet-core", {"noise": 1.0, "observer_poles": pairs(-1.4 + 0.5j)}, False, "0.281 0.2"),
    ("virtual-sensor", "quiet-core", {"noise": 1.0, "observer_poles": (-1.4, -2.1)}, False, "0.268"),
    ("error-dynamics", "calm-speed", {"observer_poles": pairs(-2 + 1.3j)}, True, "2.19 0.68"),
    ("error-dynamics", "calm-speed", {"method": "numbers", "l1": 3.5, "l2": 2.95, "input": "square"}, True, ""),
    ("error-dynamics", "calm-speed", {"observer_poles": (-3.0, -3.0)}, False, "2.22 0.766 0.7"),
    ("error-dynamics", "calm-speed", {"observer_poles": pairs(-1.5 + 1j)}, False, "2.1 2.25"),
    ("observability", "two-sensors", {"across_on": True, "left": -0.106}, True, "0.0964"),
    ("observability", "two-sensors", {"across_on": True, "left_on": False, "right_on": True, "right": 0.11}, True, ""),
    ("observability", "two-sensors", {"left": -0.2, "right_on": True, "right": 0.2}, False, "0.2792 0.09 0.1"),
    ("observability", "two-sensors", {"across_on": True}, False, "0.2565"),
    ("separation", "gentle", GENTLE, True, "0.83 0.955"),
    ("separation", "gentle", {"controller_poles": pairs(-9 + 10.5j, -7.5 + 9j, -6 + 7.5j),
                              "observer_poles": pairs(-9.1 + 5.6j, -7.7 + 4.9j, -6.3 + 4.2j)}, True, ""),
    ("separation", "gentle", {"controller_poles": GENTLE["controller_poles"]}, False, "1.1 0.8 0.9 1"),
    ("virtual-sensor", "at-once", {"noise": 1.0, "reduced": True, "observer_poles": (-1.0, -1.0)}, True, "1 0.122"),
    ("virtual-sensor", "at-once", {"noise": 1.0, "reduced": True, "observer_poles": (-1.03, -2.0)}, True, "0.3"),
    ("virtual-sensor", "at-once", {"noise": 1.0, "reduced": True}, False, "1.6 3.62"),
    ("virtual-sensor", "at-once", {"noise": 1.0, "observer_poles": (-1.0, -1.0)}, False, ""),
    ("observability", "untold", {"second": "theta", "apart": 1.5}, True, "1.5"),
    ("observability", "untold", {"second": "x", "apart": 2.0}, True, ""),
    ("observability", "untold", {"second": "theta", "left": 0.01, "apart": 1.5}, False, "1.5"),
    ("observability", "untold", {"second": "theta", "apart": 0.5}, False, "1.5"),
    ("separation", "follow", {"stiffness_error": 10.0, "command": 3.0, "integral": True}, True, "3"),
    ("separation", "follow", {"stiffness_error": 10.0, "command": 3.0}, False, "3.3 0.05"),
    ("separation", "follow", {"stiffness_error": 10.0, "command": 2.7}, False, "10"),
    ("duality", "meet", {"method": "weights", "q": 7.62, "r": 1.0}, True, "1.71"),
    ("duality", "meet", {"method": "weights", "q": 15.24, "r": 2.0}, True, ""),
    ("duality", "meet", {"method": "weights", "q": 8.2, "r": 1.0}, False, "0.3"),
    ("duality", "meet", {"poles": (-1.7, -1.7)}, False, ""),
    ("duality", "threefold", {**WEIGHTS, "q": 0.39, "w": 5.25}, True, ""),
    ("duality", "threefold", {**WEIGHTS, "q": 3.9, "r": 10.0, "w": 0.525, "v": 0.1}, True, ""),
    ("duality", "threefold", {**WEIGHTS, "q": 0.39, "w": 10.0}, False, "3.45 3"),
    ("duality", "threefold", {"method": "weights", "q": 0.39}, False, "0.5 1.5"),
    ("hidden-modes", "gentle-cure", solution("hidden-modes", "gentle-cure"), True, "3.94 0.966"),
    ("hidden-modes", "gentle-cure", {"plant": "visible", "controller_all": pairs(-1 + 1.5j, -1.5 + 3.5j),
                                     "observer_all": pairs(-2 + 1j, -2 + 3j)}, True, ""),
    ("hidden-modes", "gentle-cure", {"plant": "visible"}, False, "3.84 1.7 3.8 4 1.1"),
    ("hidden-modes", "gentle-cure", solution("hidden-modes", "cure"), False, "3.52 2.19"),
    ("saturation", "never-clipped", solution("saturation", "never-clipped"), True, "3.71 0.349"),
    ("saturation", "never-clipped", {"controller_poles": pairs(-3 + 1j, -1 + 0.5j), "observer_poles": pairs(-12 + 4j, -10 + 3j)}, True, ""),
    ("saturation", "never-clipped", {"controller_poles": pairs(-3 + 1j, -1 + 0.5j)}, False, "3.6 3.9"),
    ("saturation", "never-clipped", {"controller_poles": pairs(-2.5 + 1j, -1.5 + 1j)}, False, "0.36"),
    ("saturation", "near-the-ceiling", CEILING, True, "2 9.5"),
    ("saturation", "near-the-ceiling", {**CEILING, "u_max": 1.9}, True, "1.9"),
    ("saturation", "near-the-ceiling", {**CEILING, "controller_poles": (-4.5, -4.4, *pairs(-0.6 + 0.6j))}, True, ""),
    ("saturation", "near-the-ceiling", {"fed": "applied", "angle0": 8.0, "error0": 4.0, "u_max": 2.0}, False, "9.5"),
    ("noise", "bargain", {**POLES, "observer_poles": pairs(-3 + 2.3j)}, True, "1.27 1.093"),
    ("noise", "bargain", {**POLES, "observer_poles": pairs(-2.9 + 2.3j)}, True, ""),
    ("noise", "bargain", {"speed": 1.0}, False, "2.26 1.2 1.3 1.1"),
    ("noise", "bargain", {"speed": 1.2}, False, "1.88 1.058"),
    ("kalman", "shy", {"q": 2.0, "r": 2.0}, True, "2 1.67 3.00"),
    ("kalman", "shy", {"q": 2.0, "r": 1.9}, True, ""),
    ("kalman", "shy", {"q": 1.0, "r": 2.0}, False, "2.18 5.28 1.9 2.1 2"),
    ("lqg", "patience", {"sensor": 1e7, "beta_r": 3.5e7}, True, "1.204 0.125"),
    ("lqg", "patience", {"sensor": 1e7, "beta_r": 7e6, "beta_q": 0.2}, True, ""),
    ("lqg", "patience", {"sensor": 1e7, "beta_r": 3.5e7, "recovery": 1.0}, False, ""),
    ("lqg", "patience", {"sensor": 1e7, "beta_r": 1e7}, False, "0.080 1.25 0.12 0.13"),
    ("lqg", "stages", {"alpha_r": 100.0, "beta_r": 1e5}, True, "83.6"),
    ("lqg", "stages", {"alpha_r": 100.0, "beta_r": 1.0}, True, ""),
    ("lqg", "stages", {"alpha_r": 0.1, "beta_r": 1.0}, False, "80 90 60"),
    ("lqg", "stages", {"alpha_r": 100.0}, False, "60"),
    ("lqg", "sparse", {"alpha_r": 1e4, "beta_r": 1.0}, True, "1.0035"),
    ("lqg", "sparse", {"alpha_r": 1e4, "beta_r": 1e4}, True, ""),
    ("lqg", "sparse", {"beta_r": 1.0}, False, "20"),
)


@each("lesson, id, changes, solves, numbers", CASES)
def test_what_solves_solves_and_the_verdict_says_the_numbers_of_the_words(
        lesson: str, id: str, changes: dict[str, Any], solves: bool, numbers: str) -> None:
    task = next(t for t in LESSONS[lesson].tasks if t.id == id)
    verdict = task.judge(outcome(lesson, changes))
    assert verdict.solved is solves, verdict.text("en")
    assert set(numbers.split()) <= set(NUMBER.findall(verdict.text("en"))), verdict.text("en")
    for prose in LESSONS[lesson].words.values():
        words = prose.tasks[id]
        assert set(numbers.split()) <= set(NUMBER.findall(" ".join([words.statement, *words.hints, words.solution]))), words.title


# --- by other means than the verdict --------------------------------------------------------------------------------
def loop(lesson: str, changes: Mapping[str, Any], plant: Plant, x0: Any, guess: Any, step: float, end: float) -> tuple[np.ndarray, ...]:
    """t, x and u of the loop in (x, x̂), by its matrix exponential."""
    gains = outcome(lesson, changes).gains
    K, L, n = gains["K"], gains["L"], plant.n
    Phi: np.ndarray = expm(step * np.block([[plant.A, -plant.B @ K], [L @ plant.C, plant.A - plant.B @ K - L @ plant.C]]))
    z = [np.concatenate([x0, guess])]
    for _ in range(round(end / step)):
        z.append(Phi @ z[-1])
    both = np.array(z)
    return step * np.arange(len(both)), both[:, :n], -both[:, n:] @ K.T


def settled(t: np.ndarray, size: np.ndarray) -> float:
    """From when on a signal is below 2 % of its peak."""
    return float(t[np.flatnonzero(np.abs(size) > 0.02 * np.abs(size).max())[-1]])


def test_the_noise_of_the_case_reaches_the_core_as_lyapunov_says() -> None:
    chip = MODELS["chip"].plant
    for poles, sigma in (((-1.4, -1.4), 0.179), (pairs(-1.4 + 0.5j), 0.281), ((-1.4, -2.1), 0.268)):
        L = outcome("virtual-sensor", {"observer_poles": poles}).gains["L"]
        F = chip.A - L @ chip.C
        assert np.poly(F) == pytest.approx(np.poly(poles).real, rel=1e-9)
        assert sqrt(solve_continuous_lyapunov(F, -0.03 * L @ L.T)[0, 0]) == pytest.approx(sigma, abs=5e-4)
    L = outcome("virtual-sensor", {"observer_poles": (-1.4, -1.4)}).gains["L"]
    assert L[:, 0] == pytest.approx([1.96, 1.53], abs=5e-3)


def test_the_error_of_the_block_settles_as_its_matrix_exponential_does() -> None:
    A, t = np.array([[0.0, 1.0], [-1.0, -0.5]]), np.arange(0.0, 8.0, 0.005)
    for poles, when, peak in ((pairs(-2 + 1.3j), 2.19, 0.68), ((-3.0, -3.0), 2.22, 0.766)):
        l1 = -sum(poles).real - 0.5
        L = np.array([[l1], [np.prod(poles).real - 1 - 0.5 * l1]])
        e = expm(t[:, None, None] * (A - L @ [[1.0, 0.0]]))[:, :, 0]
        assert settled(t, np.linalg.norm(e, axis=1)) == pytest.approx(when, abs=0.035)
        assert np.abs(e[:, 1]).max() == pytest.approx(peak, abs=1e-3)


def test_the_deck_rests_when_the_matrix_of_the_loop_says_so() -> None:
    deck = MODELS["deck"]
    t, x, u = loop("separation", GENTLE, deck.plant, deck.x0, deck.guess, 0.002, 3.0)
    assert max(settled(t, x[:, i]) for i in range(3)) == pytest.approx(0.83, abs=0.01)
    assert np.abs(u).max() == pytest.approx(0.955, abs=2e-3)


def test_both_blocks_are_home_when_the_matrix_of_the_loop_says_so() -> None:
    plant, design = two_mass.plant(two_mass.DEPARTS, "first", "first"), solution("hidden-modes", "gentle-cure")
    for changes, when, force in ((design, 3.94, 0.966), ({"plant": "visible"}, 3.84, 1.7), (solution("hidden-modes", "cure"), 3.52, 2.19)):
        t, x, u = loop("hidden-modes", changes, plant, (0.16, -0.04, 0, 0), np.zeros(4), 0.004, 8.0)
        assert settled(t, np.abs(x[:, :2]).max(axis=1)) == pytest.approx(when, abs=0.02)
        assert np.abs(u).max() == pytest.approx(force, rel=0.01)


def test_weights_reach_what_the_riccati_equation_of_scipy_reaches() -> None:
    A, C, B = np.array([[0.0, 1.0], [-1.0, -0.5]]), np.array([[1.0, 0.0]]), np.array([[0.0], [1.0]])

    def gain(ratio: float) -> np.ndarray:
        return solve_continuous_are(A.T, C.T, ratio * np.eye(2), np.eye(1)) @ C.T

    def slowest(ratio: float) -> float:
        return float(np.linalg.eigvals(A - gain(ratio) @ C).real.max())
    K = B.T @ solve_continuous_are(A, B, 0.39 * np.eye(2), np.eye(1))
    assert np.linalg.eigvals(A - B @ K).real.max() == pytest.approx(-0.5, rel=0.01)
    assert slowest(5.25) == pytest.approx(-1.5, rel=1e-3) and gain(5.25)[:, 0] == pytest.approx([2.5, 0.5], rel=1e-3)
    assert slowest(10.0) == pytest.approx(-1.5, rel=1e-9) and gain(10.0)[0, 0] == pytest.approx(3.45, abs=5e-3)
    assert min(map(slowest, np.linspace(8.4, 8.8, 81))) == pytest.approx(-1.85, abs=5e-3) and slowest(1e6) == pytest.approx(-1.12, abs=5e-3)


def test_a_force_never_clipped_leaves_a_linear_loop_and_a_weak_one_a_ceiling() -> None:
    cart = MODELS["cart-pendulum"].plant
    start, guess = (0, radians(6), 0, 0), (0, radians(2), 0, 0)
    _, x, u = loop("saturation", solution("saturation", "never-clipped"), cart, start, guess, 0.005, 8.0)
    assert np.abs(u).max() == pytest.approx(3.71, abs=5e-3) and np.abs(x[:, 0]).max() == pytest.approx(0.349, abs=1e-3)
    values, left = np.linalg.eig(cart.A.T)
    rates = np.real(values)
    rate, q = float(rates.max()), np.real(left[:, rates.argmax()])
    assert degrees(abs(q @ cart.B[:, 0]) * 2.0 / (rate * abs(q[1]))) == pytest.approx(9.5, abs=5e-3)
    lesson = {"fed": "applied", "angle0": 8.0, "error0": 4.0}
    assert [outcome("saturation", {**lesson, "u_max": u}).metrics["comes_home"] for u in (3.5, 3.6)] == [0.0, 1.0]


def test_the_bargain_in_the_valley_is_what_lyapunov_and_the_matrix_exponential_say() -> None:
    A, C, B, t = np.array([[0.0, 1.0], [-1.0, -0.5]]), np.array([[1.0, 0.0]]), np.array([[0.0], [1.0]]), np.arange(0.0, 6.0, 0.004)
    P = solve_continuous_are(A.T, C.T, 0.04 * B @ B.T, np.array([[4e-4]]))
    F = A - (P @ C.T / 4e-4) @ C
    kalman = np.linalg.eigvals(F)
    for poles, when, ratio in ((kalman, 2.26, (1, 1)), (1.2 * kalman, 1.88, (1.054, 1.058)), (pairs(-3 + 2.3j), 1.27, (1.093, 1.028))):
        l1 = -sum(poles).real - 0.5
        L = np.array([[l1], [np.prod(poles).real - 1 - 0.5 * l1]])
        F = A - L @ C
        assert settled(t, expm(t[:, None, None] * F)[:, 1, 0]) == pytest.approx(when, abs=0.02)
        S = solve_continuous_lyapunov(F, -0.04 * B @ B.T - 4e-4 * L @ L.T)
        for i in range(2):
            assert S[i, i] / P[i, i] == pytest.approx(ratio[i], abs=6e-4)


def test_beliefs_doubled_together_leave_the_gain_and_halve_the_surprise() -> None:
    right, shy = (outcome("kalman", {"q": k, "r": k}) for k in (1.0, 2.0))
    assert shy.gains["M"] == pytest.approx(right.gains["M"], rel=1e-3, abs=1e-6)
    assert shy.metrics["nis_mean"] == pytest.approx(right.metrics["nis_mean"] / 2, rel=1e-3)
