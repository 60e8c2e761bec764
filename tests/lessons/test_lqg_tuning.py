"""The report's tuning rules 1, 2 and 4 as experiments: every number anew by scipy, and each sentence beside it."""

from functools import lru_cache

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov

from observer_lab.course.guiding.questions import Asked
from observer_lab.course.lesson import Outcome
from observer_lab.course.scenes import entry_values
from observer_lab.lessons.lqg.lesson import LESSON
from observer_lab.lessons.lqg.tuning import INPUT_WEIGHTS, SENSOR_NOISES
from observer_lab.plants.platform import model

A, B, C = model.mechanics().matrices()
COILS, G = B[:, :3], B[:, 3:]
WEIGHT = C.T @ np.diag([1e8, 1e10, 1e8, 1e10]) @ C  # equations (81), (83), (84)
CHANNELS = np.array([[0.5, 0, 0.5, 0], [0.5, 0, -0.5, 0], [0, 0.5, 0, -0.5]]) @ C
HERTZ = np.geomspace(0.5, 3.0, 2000)
COUPLE = np.array([[0.5, -0.5, 0.0]])


def at(**values: object) -> Outcome:
    return LESSON.compute(LESSON.apply(LESSON.start(), values))


def figure(outcome: Outcome, id: str):
    return next(f for f in LESSON.figures(outcome) if f.id == id)


def gains(alpha_q: float, alpha_r: float, beta_q: float, beta_r: float) -> tuple[np.ndarray, np.ndarray]:
    """K and L by scipy; the sensor HR repeats HL, so V is what makes the filter's equation regular."""
    R, V = alpha_r * np.eye(3), beta_r * 1e-18 * np.eye(4)
    K = np.linalg.solve(R, COILS.T @ solve_continuous_are(A, COILS, alpha_q * WEIGHT, R))
    scale = 1e-12 * beta_q
    P = scale * solve_continuous_are(A.T, C.T, G @ G.T, V / scale)
    return K, P @ C.T @ np.linalg.inv(V)


def sparse(K: np.ndarray) -> np.ndarray:
    """K without its cross gains, by the symmetry of the deck: z and p_L + p_R, θ and p_R − p_L, x."""
    swap = np.diag([-1.0, 1, -1, 0, 0])  # a mirror: x and θ change their signs, p_L and p_R change places
    swap[3, 4] = swap[4, 3] = 1
    mirror = np.kron(np.eye(2), swap)
    even, odd = (np.eye(10) + mirror) / 2, (np.eye(10) - mirror) / 2
    x = np.diag(np.tile([1.0, 0, 0, 0, 0], 2))
    mean, half = (K[0] + K[1]) / 2 @ even, (K[0] - K[1]) / 2 @ (odd - x)
    return np.array([mean + half, mean - half, K[2] @ x])


def loop(K: np.ndarray, L: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Matrix of (x, x̂), covariance from the ground's 10⁻¹² and V = 10⁻¹⁸, and its part from the sensors alone."""
    M = np.block([[A, -COILS @ K], [L @ C, A - COILS @ K - L @ C]])
    ground, sensors = np.vstack([G, np.zeros((10, 2))]) * 1e-6, np.vstack([np.zeros((10, 4)), L]) * 1e-9
    parts = [solve_continuous_lyapunov(M, -N @ N.T) for N in (ground, sensors)]
    return M, parts[0] + parts[1], parts[1]


@lru_cache(maxsize=1)
def open_peaks() -> np.ndarray:
    return peaks(A, G * 1e-6, CHANNELS)


def peaks(M: np.ndarray, N: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """The highest density of each row between 0.5 and 3 Hz."""
    grid = np.union1d(HERTZ, [p.imag / 2 / np.pi for p in np.linalg.eigvals(A) if 0.5 < p.imag / 2 / np.pi < 3])
    H = np.array([rows @ np.linalg.solve(2j * np.pi * f * np.eye(len(M)) - M, N) for f in grid])
    return np.sum(np.abs(H) ** 2, axis=2).max(axis=0)


def drops(K: np.ndarray, L: np.ndarray) -> np.ndarray:
    M = loop(K, L)[0]
    N = np.block([[G * 1e-6, np.zeros((10, 4))], [np.zeros((10, 2)), L * 1e-9]])
    return 10 * np.log10(open_peaks() / peaks(M, N, np.hstack([CHANNELS, np.zeros((3, 10))])))


def first_number(cell: str) -> float:
    return float(cell.split(" ")[0].rstrip(",").replace("−", "-"))


# --- rule 1 ------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("values", [{}, {"alpha_r": 100.0, "beta_r": 1e5}, {"alpha_r": 1e4, "beta_r": 1.0}], ids=str)
def test_the_state_measured_and_the_filter_are_scipys(values: dict) -> None:
    o = at(**values)
    d = o.design
    K, L = gains(d["alpha_q"], d["alpha_r"], d["beta_q"], d["beta_r"])
    alone = 10 * np.log10(open_peaks() / peaks(A - COILS @ K, G * 1e-6, CHANNELS))
    rows = figure(o, "rule-1-table").table()[1]
    assert [first_number(row[1]) for row in rows[:3]] == pytest.approx(alone, abs=0.6)
    assert [first_number(row[2]) for row in rows[:3]] == pytest.approx(drops(K, L), abs=0.6)
    X = solve_continuous_lyapunov(A - COILS @ K, -1e-12 * G @ G.T)
    force = 1e3 * np.sqrt(np.diag(K @ X @ K.T))
    assert [first_number(row[1]) for row in rows[3:]] == pytest.approx(force, rel=5e-3)
    force = 1e3 * np.sqrt(np.diag(K @ loop(K, L)[1][10:, 10:] @ K.T))
    assert [first_number(row[2]) for row in rows[3:]] == pytest.approx(force, rel=5e-3)
    lost = float(np.max(alone - drops(K, L)))
    assert ("does not hold for the reduction" in figure(o, "rule-1-table").caption("en")) == (lost > 3)


def test_alpha_r_moves_the_regulator_alone_and_hardly_the_loop_with_the_default_filter() -> None:
    """Rule 1 determines the bandwidth and the use of force; with the report's V neither is what the loop has."""
    curves = {c.name("en"): 10.0**c.y for c in figure(at(), "rule-1").curves}
    known, filtered = curves["state measured (C = I)"], curves["with this filter"]
    assert known[-1] / known[0] == pytest.approx(100, rel=0.01) and filtered.max() / filtered.min() < 1.01
    for k in (0, 4, 8):
        K, _ = gains(100.0, INPUT_WEIGHTS[k], 1.0, 1e9)
        X = solve_continuous_lyapunov(A - COILS @ K, -1e-12 * G @ G.T)
        assert known[k] == pytest.approx(np.sqrt(np.trace(WEIGHT @ X)), rel=1e-4)


# --- rule 2 ------------------------------------------------------------------------------------------------------------
def sensor_rms(K: np.ndarray, L: np.ndarray) -> float:
    return float(np.sqrt(np.trace(K @ loop(K, L)[2][10:, 10:] @ K.T)))


def test_ten_times_beta_r_suppresses_noise_more_and_ten_times_beta_q_less() -> None:
    K, L = gains(100.0, 0.1, 1.0, 1e9)
    more, quick = gains(100.0, 0.1, 1.0, 1e10)[1], gains(100.0, 0.1, 10.0, 1e9)[1]
    factors = [np.linalg.norm(more) / np.linalg.norm(L), sensor_rms(K, more) / sensor_rms(K, L), np.linalg.norm(quick) / np.linalg.norm(L),
               np.trace(A - quick @ C) / np.trace(A - L @ C)]
    rows = figure(at(), "rule-2-table").table()[1]
    assert [float(row[1].split("×")[1]) for row in rows] == pytest.approx(factors, rel=5e-3)
    assert [row[2] for row in rows] == ["holds", "the reverse happens", "holds", "holds"]
    assert gains(100.0, 0.1, 10.0, 1e10)[1] == pytest.approx(L, rel=1e-5, abs=1e-6 * np.abs(L).max())


def test_the_curves_of_rule_2_are_scipys() -> None:
    noise, speed = (10.0**c.y for c in figure(at(), "rule-2").curves)
    K, L = gains(100.0, 0.1, 1.0, 1e9)
    for k, beta in enumerate(SENSOR_NOISES):
        if beta >= 1.0:
            other = gains(100.0, 0.1, 1.0, beta)[1]
            assert noise[k] == pytest.approx(sensor_rms(K, other) / sensor_rms(K, L), rel=1e-3)
            assert speed[k] == pytest.approx(np.trace(A - other @ C) / np.trace(A - L @ C), rel=1e-3)


def test_the_scene_asks_for_the_fall_that_follows() -> None:
    k = next(k for k, scene in enumerate(LESSON.path) if scene.id == "tune")
    entry = LESSON.apply(LESSON.start(), entry_values(LESSON.path, k, LESSON.start()))
    before, after = LESSON.compute(entry), LESSON.compute(LESSON.apply(entry, LESSON.path[k].play))
    drawn = LESSON.questions["tune"](Asked(LESSON, before, after))
    K, L = gains(100.0, 0.1, 1.0, 1e9)
    fall = sensor_rms(K, gains(100.0, 0.1, 1.0, 1e10)[1]) / sensor_rms(K, L)
    assert drawn.run[0].y[-1] == pytest.approx(fall, rel=1e-3) == pytest.approx(0.287, abs=1e-3)
    assert min(range(3), key=lambda i: abs(drawn.options[i][0].y[-1] - fall)) == LESSON.path[k].do.answer == 2
    assert after.metrics["sensor_less"] == pytest.approx(1 / fall, rel=1e-3)


# --- rule 4 ------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("values", [{}, {"alpha_r": 1e4, "beta_r": 1.0}, {"alpha_r": 1e4, "beta_r": 1e4},
                                    {"alpha_r": 100.0, "beta_r": 1e5}], ids=str)
def test_the_sparse_gain_is_judged_by_scipys_loop(values: dict) -> None:
    o = at(**values)
    d, said = o.design, figure(o, "rule-4-table")
    K, L = gains(d["alpha_q"], d["alpha_r"], d["beta_q"], d["beta_r"])
    both = (K, sparse(K))
    found = [drops(each, L) for each in both]
    cost, couple = [], []
    for each in both:
        X = loop(each, L)[1]
        cost.append(np.trace(d["alpha_q"] * WEIGHT @ X[:10, :10]) + d["alpha_r"] * np.trace(each @ X[10:, 10:] @ each.T))
        couple.append(1e3 * np.sqrt((COUPLE @ each @ X[10:, 10:] @ each.T @ COUPLE.T)[0, 0]))
    rows = said.table()[1]
    for column in (1, 2):
        assert [first_number(row[column]) for row in rows[:3]] == pytest.approx(found[column - 1], abs=0.6)
        assert first_number(rows[3][column]) == pytest.approx(couple[column - 1], rel=5e-3)
        assert first_number(rows[5][column]) == pytest.approx(cost[column - 1], rel=5e-3)
    gained, words = found[1][1] - found[0][1], said.caption("en")
    assert ("Rule 4 holds" in words) == (gained > 1) and ("cross gains lower the peak" in words) == (gained < -1)


def test_the_structure_that_the_task_asks_for_is_worth_32_decibels() -> None:
    K, L = gains(100.0, 1e4, 1.0, 1.0)
    assert drops(sparse(K), L)[1] - drops(K, L)[1] == pytest.approx(32.0, abs=0.1)


@pytest.mark.parametrize("values", [{"case": "doyle"}, {"case": "doyle", "q": 100.0}, {"case": "doyle", "gain": 2.0}], ids=str)
def test_a_plant_with_one_input_has_no_cross_gains(values: dict) -> None:
    o = at(**values)
    assert len(o.gains["K"]) == 1 and "one input" in figure(o, "rule-4-table").caption("en") == figure(o, "rule-4").caption("en")


@pytest.mark.parametrize("values", [{"recovery": 10.0}, {"case": "doyle", "recovery": 10.0}, {"beta_r": 1e-3, "beta_q": 1e3},
                                    {"recovery": 6.0, "beta_r": 1e3}, {"alpha_q": 1e6, "alpha_r": 1e-4}], ids=str)
def test_a_sweep_beyond_what_can_be_solved_does_not_refuse_the_design(values: dict) -> None:
    """Such points of a curve are left out; the design itself has a solution and is shown."""
    for each in LESSON.figures(at(**values)):
        if each.id.startswith("rule-") and each.kind == "plane":
            assert all(np.isfinite(c.y).all() and len(c.y) == len(c.xs) for c in each.curves) and np.isfinite(each.y_range).all()
