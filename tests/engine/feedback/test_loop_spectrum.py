"""A loop under white noise: areas are variances, the paths agree with Monte-Carlo, with SciPy and with python-control."""

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from observer_lab.engine import EngineError, Plant, Scenario, ShapeError, compensator, lqg, noisy_loop, psd, simulate
from observer_lab.plants.platform import lqg_weights, model
from observer_lab.plants.platform.channels import CHANNELS, T_u, T_y, controller_from_channels, in_channels


def random_loop(seed: int, n: int = 3, m: int = 2, p: int = 2) -> tuple[Plant, Plant, np.ndarray]:
    """A stable plant, an LQG controller of it, and where the disturbances enter."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A -= (max(np.linalg.eigvals(A).real.max(), 0.0) + 0.3) * np.eye(n)
    plant = Plant(A, rng.standard_normal((n, m)), rng.standard_normal((p, n)))
    G = rng.standard_normal((n, 2))
    return plant, lqg(plant, np.eye(n), np.eye(m), np.eye(2), 0.1 * np.eye(p), G=G).controller, G


def area(loop, rows, points: int = 40_000) -> np.ndarray:
    """∫ S df by substitution f = tan(πs/2) f0, which reaches every frequency."""
    f0 = np.median(np.abs(loop.poles)) / (2 * np.pi)
    s = (np.arange(points) + 0.5) / points
    f = f0 * np.tan(np.pi * s / 2)
    weight = f0 * np.pi / 2 / np.cos(np.pi * s / 2) ** 2 / points
    return weight @ loop.psd(f, rows)


@pytest.mark.slow
@settings(max_examples=25, derandomize=True)
@given(st.integers(0, 10_000))
def test_the_area_under_the_density_is_the_lyapunov_variance(seed: int) -> None:
    plant, controller, G = random_loop(seed)
    loop = noisy_loop(plant, controller, G, np.eye(2), V=0.3)
    rows = np.vstack([loop.outputs(np.array([[1.0, -0.5]])), loop.inputs()])
    assert area(loop, rows) == pytest.approx(loop.variance(rows), rel=1e-4)


@pytest.mark.slow
@settings(max_examples=15, derandomize=True)
@given(st.integers(0, 10_000))
def test_samples_of_a_loop_keep_its_variance_and_fold_its_density(seed: int) -> None:
    plant, controller, G = random_loop(seed)
    loop = noisy_loop(plant, controller, G, np.eye(2), V=0.3)
    dt = 0.2
    sampled = loop.sampled(dt)
    assert sampled.variance(sampled.outputs()) == pytest.approx(loop.variance(), rel=1e-8)
    f = np.array([0.1, 0.7, 2.0])
    count = 4000
    images = np.arange(-count, count + 1) / dt
    folded = np.array([loop.psd(np.abs(x + images)).sum(axis=0) for x in f])
    folded += 2 * (count + 0.5) * loop.psd((count + 0.5) / dt)  # what is left beyond falls as 1/f²
    assert sampled.psd(f) == pytest.approx(folded, rel=2e-3)


def test_one_integrator_with_a_spring_of_its_own_has_the_textbook_density() -> None:
    """ẋ = −a x + w, y = x: one-sided 2W/(a² + ω²), variance W/(2a)."""
    a, W = 3.0, 0.7
    loop = noisy_loop(Plant([[-a]], [[1.0]], [[1.0]]), None, [[1.0]], W)
    f = np.array([0.0, 0.4, 5.0])
    assert loop.psd(f)[:, 0] == pytest.approx(2 * W / (a**2 + (2 * np.pi * f) ** 2), rel=1e-12)
    assert loop.variance() == pytest.approx(np.array([W / (2 * a)]), rel=1e-12)


def test_a_static_output_feedback_lets_white_noise_through_to_the_input() -> None:
    """u = −k(y + v): y has W + k²V over 2(a + k), u an infinite variance but a finite density."""
    a, k, W, V = 1.0, 2.0, 0.5, 0.2
    plant = Plant([[-a]], [[1.0]], [[1.0]])
    gain = Plant(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), [[-k]])
    loop = noisy_loop(plant, gain, [[1.0]], W, V=V)
    assert loop.variance() == pytest.approx(np.array([(W + k**2 * V) / (2 * (a + k))]), rel=1e-12)
    assert np.isinf(loop.variance(loop.inputs())).all() and np.isinf(loop.cost(np.eye(1), np.eye(1))[1])
    assert loop.psd(1e6, loop.inputs())[0, 0] == pytest.approx(2 * k**2 * V, rel=1e-6)
    with pytest.raises(EngineError, match="straight through"):
        loop.sampled(0.1)


def test_a_direct_path_of_the_plant_is_closed_as_python_control_closes_it() -> None:
    rng = np.random.default_rng(5)
    plant = Plant(-np.eye(2) + 0.3 * rng.standard_normal((2, 2)), rng.standard_normal((2, 1)), rng.standard_normal((1, 2)), [[0.4]])
    controller = Plant([[-2.0]], [[1.0]], [[-0.5]], [[-0.3]])
    loop = noisy_loop(plant, controller, plant.B, 1.0, V=1.0)
    P, K = (control.ss(s.A, s.B, s.C, s.D) for s in (plant, controller))
    for w in (0.0, 0.7, 9.0):
        p, k = complex(P(1j * w)), complex(K(1j * w))
        p0 = p - 0.4  # w enters the states only
        H = loop.response(w / (2 * np.pi), np.eye(2))[0]
        assert H[:, 0] == pytest.approx(np.array([p0, k * p0]) / (1 - p * k), rel=1e-9)
        assert H[:, 1] == pytest.approx(np.array([p * k, k]) / (1 - p * k), rel=1e-9)


def test_a_shaped_ground_replaces_the_white_one() -> None:
    plant, controller, G = random_loop(3)
    loop = noisy_loop(plant, controller, G, np.diag([0.5, 2.0]), V=0.0)
    f = np.geomspace(0.01, 10, 30)
    flat = np.tile([1.0, 4.0], (30, 1))  # one-sided: 2W
    assert loop.psd(f, ground=flat) == pytest.approx(loop.psd(f), rel=1e-12)
    assert loop.psd(f, ground=3.0 * np.ones(30)) == pytest.approx(
        noisy_loop(plant, controller, G, 1.5, V=0.0).psd(f), rel=1e-12)
    with pytest.raises(ShapeError, match="density"):
        loop.psd(f, ground=-np.ones(30))


def test_monte_carlo_lies_within_its_chi_square_band_of_the_prediction() -> None:
    """Periodograms of independent records are S χ²₂/2 each; the mean of 40 lies in the band of χ²₈₀."""
    plant, controller, G = random_loop(11)
    n, dt, count, records = plant.n, 0.05, 1024, 40
    W, V = np.diag([1.0, 0.4]), 0.2
    loop = noisy_loop(plant, controller, G, W, V=V)
    design = lqg(plant, np.eye(n), np.eye(2), np.eye(2), 0.1 * np.eye(2), G=G)
    seen = loop.sampled(dt)
    factor = np.linalg.cholesky(loop.covariance + 1e-14 * np.eye(2 * n))
    rng, total = np.random.default_rng(8), 0.0
    for k in range(records):
        z0 = factor @ rng.standard_normal(2 * n)
        run = simulate(Scenario(plant, design.K, design.L, x0=z0[:n], xhat0=z0[n:], horizon=dt * (count - 1), dt=dt, G=G,
                                W=W, V=V * np.eye(2), seed=k))
        total = total + psd(run.x @ plant.C.T, 1 / dt, segment=count).density
    ratio = (total / records)[5:count // 4] / seen.psd(np.arange(5, count // 4) / (count * dt))  # type: ignore[operator]
    low, high = chi2.ppf([1e-4, 1 - 1e-4], 2 * records) / (2 * records)
    # the simulator holds v over a step, so the top of the band is left out
    inside = (ratio > low) & (ratio < high)
    assert inside.mean() > 0.99
    assert ratio.mean() == pytest.approx(1.0, abs=0.03)


def test_causes_add_up_and_states_can_be_watched() -> None:
    plant, controller, G = random_loop(21)
    loop = noisy_loop(plant, controller, G, np.eye(2), V=0.3)
    f = np.geomspace(0.01, 3, 9)
    assert loop.only(sensors=0.0).psd(f) + loop.only(disturbances=0.0).psd(f) == pytest.approx(loop.psd(f), rel=1e-12)
    assert loop.only(disturbances=0.0).variance() + loop.only(sensors=0.0).variance() == pytest.approx(loop.variance(), rel=1e-9)
    assert loop.watching(plant.C).psd(f) == pytest.approx(loop.psd(f), rel=1e-12)
    assert loop.watching(np.eye(3)).variance() == pytest.approx(np.diag(loop.covariance)[:3], rel=1e-12)


def test_an_unstable_loop_has_a_density_but_no_variance() -> None:
    loop = noisy_loop(Plant([[1.0]], [[1.0]], [[1.0]]), None, [[1.0]], 1.0)
    assert not loop.stable and np.isfinite(loop.psd(0.3)).all()
    with pytest.raises(EngineError, match="unstable"):
        loop.variance()


def test_parts_that_do_not_fit_are_refused_in_a_sentence() -> None:
    plant, controller, G = random_loop(1)
    with pytest.raises(ShapeError, match="G must have 3 rows"):
        noisy_loop(plant, controller, np.eye(2), 1.0)
    with pytest.raises(ShapeError, match="controller must have 2 inputs"):
        noisy_loop(plant, Plant([[-1.0]], [[1.0]], [[1.0]]), G, 1.0)
    with pytest.raises(EngineError, match="sampling period"):
        noisy_loop(plant, Plant(controller.A, controller.B, controller.C, None, 0.1), G, 1.0)
    with pytest.raises(ShapeError, match="T must have 2 columns"):
        noisy_loop(plant, controller, G, 1.0).outputs(np.ones((1, 3)))


# --- LQG -------------------------------------------------------------------------------------------------------------
@pytest.mark.slow
@settings(max_examples=25, derandomize=True)
@given(st.integers(0, 10_000))
def test_the_riccati_cost_is_the_lyapunov_cost_and_no_other_gain_is_cheaper(seed: int) -> None:
    plant, _, G = random_loop(seed)
    n = plant.n
    d = lqg(plant, np.eye(n), 0.5 * np.eye(2), np.eye(2), 0.1, G=G)
    least = sum(noisy_loop(plant, d.controller, G, np.eye(2), V=0.1).cost(np.eye(n), 0.5 * np.eye(2)))
    assert d.cost == pytest.approx(least, rel=1e-8)
    # the other way to split it: tr(P Q) + tr(S L V Lᵀ)
    other = np.trace(d.estimator.solution) + 0.1 * np.trace(d.regulator.solution @ d.L @ d.L.T)
    assert other == pytest.approx(least, rel=1e-8)
    rng = np.random.default_rng(seed)
    for _ in range(3):
        K, L = d.K * (1 + 0.1 * rng.standard_normal(d.K.shape)), d.L * (1 + 0.1 * rng.standard_normal(d.L.shape))
        loop = noisy_loop(plant, compensator(plant, K, L), G, np.eye(2), V=0.1)
        if loop.stable:
            assert sum(loop.cost(np.eye(n), 0.5 * np.eye(2))) >= least * (1 - 1e-9)


# --- the platform ----------------------------------------------------------------------------------------------------
def test_the_channels_are_the_reports_and_the_residual_of_a_rigid_deck_is_zero() -> None:
    p = model.plant()
    y = dict(zip(p.output_names, np.eye(4), strict=True))
    assert T_y[0] == pytest.approx((y["VL"] + y["VR"]) / 2) and T_y[1] == pytest.approx((y["VL"] - y["VR"]) / 2)
    assert T_y[2] == pytest.approx((y["HL"] - y["HR"]) / 2) and T_y[3] == pytest.approx((y["HL"] + y["HR"]) / 2)
    assert np.linalg.inv(T_u) == pytest.approx(np.array([[0.5, 0.5, 0], [0.5, -0.5, 0], [0, 0, 1]]))  # (12)–(14)
    assert np.abs(T_y[3] @ p.C).max() == 0.0
    assert [c.id for c in CHANNELS] == ["vertical", "rotation", "horizontal", "residual"]


def test_a_controller_in_the_channels_is_the_same_loop_as_its_matrix_controller() -> None:
    p = model.plant()
    inside = in_channels(p)
    assert (inside.m, inside.p) == (3, 4)
    damper = Plant(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((3, 0)), np.hstack([-np.diag([30.0, 20.0, 10.0]), np.zeros((3, 1))]))
    W = 1e-12
    in_z = noisy_loop(inside, damper, lqg_weights.ground(p), W)
    in_y = noisy_loop(lqg_weights.coils(p), controller_from_channels(damper), lqg_weights.ground(p), W)
    assert np.sort_complex(in_z.poles) == pytest.approx(np.sort_complex(in_y.poles))
    f = np.array([0.3, 1.0, 1.5, 20.0])
    assert in_y.psd(f, in_y.outputs(T_y[:3])) == pytest.approx(in_z.psd(f)[:, :3], rel=1e-6)


# design V: suppression of the open loop's highest peak in dB, vertical, pitch, horizontal, real sensor noise 1e-18
SUPPRESSION = {1e-18: (110, 96, 113), 1e-12: (61, 61, 57), 1e-10: (41, 26, 37), 1e-9: (31, 11, 27), 1e-8: (21, 3, 17),
               1e-6: (3.6, 0, 1.8)}


@pytest.mark.parametrize("V", SUPPRESSION)
def test_the_lqg_of_the_report_suppresses_the_peaks_as_the_table_says(V: float) -> None:
    p = model.plant()
    d = lqg_weights.lqg(p, lqg_weights.Weights(v0=V))
    loops = (noisy_loop(lqg_weights.coils(p), c, lqg_weights.ground(p), 1e-12, V=lqg_weights.LITERAL_V)
             for c in (None, d.controller))
    f = np.unique(np.concatenate([np.geomspace(0.01, 100, 400), np.linspace(0.9, 1.6, 1500)]))
    opened, closed = (loop.psd(f, loop.outputs(T_y[:3])).max(axis=0) for loop in loops)
    decibel = 10 * np.log10(opened / closed)
    assert decibel == pytest.approx(np.array(SUPPRESSION[V]), abs=0.55)
    assert opened == pytest.approx(np.array([1.312e-6, 4.97e-9, 5.17e-7]), rel=2e-3)


def test_at_v_1e_9_the_pitch_is_amplified_at_a_tenth_of_a_hertz() -> None:
    p = model.plant()
    d = lqg_weights.lqg(p)
    loops = [noisy_loop(lqg_weights.coils(p), c, lqg_weights.ground(p), 1e-12, V=lqg_weights.LITERAL_V)
             for c in (None, d.controller)]
    opened, closed = (loop.psd(0.1, loop.outputs(T_y[:3]))[0] for loop in loops)
    assert closed[1] > 100 * opened[1]  # 31 dB
    assert closed[[0, 2]] == pytest.approx(opened[[0, 2]], rel=0.02)  # off resonance little is gained


def test_the_literal_design_is_stiff_and_has_a_drift_pole() -> None:
    d = lqg_weights.lqg(model.plant(), lqg_weights.LITERAL)
    assert d.regulator.poles[0].real == pytest.approx(-3.8e5, rel=0.02)
    assert d.regulator.poles[-1].real == pytest.approx(-1.06e-4, rel=0.005)
    assert d.regulator.residual < 1e-10 and d.estimator.residual < 1e-10


def test_the_controller_is_equations_88_and_89() -> None:
    p = model.plant()
    d = lqg_weights.lqg(p)
    B = lqg_weights.coils(p).B
    assert np.array_equal(d.controller.A, p.A - B @ d.K - d.L @ p.C)
    assert np.array_equal(d.controller.B, d.L) and np.array_equal(d.controller.C, -d.K) and not np.any(d.controller.D)


def test_a_double_integrator_has_an_infinite_density_at_zero_and_no_library_error() -> None:
    plant = Plant([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]], [[1.0, 0.0]])
    density = noisy_loop(plant, None, plant.B, 1.0).psd([0.0, 0.5])[:, 0]
    assert np.isinf(density[0]) and density[1] == pytest.approx(2 / np.pi**4)  # 2/(2πf)⁴


def test_what_a_loop_is_asked_must_fit_it() -> None:
    plant, controller, G = random_loop(1)
    loop = noisy_loop(plant, controller, G, 1.0)
    with pytest.raises(ShapeError, match="ground's density"):
        loop.psd([1.0, 2.0, 3.0], ground=[1.0, 2.0])
    with pytest.raises(ShapeError, match="column for each state"):
        loop.watching(np.ones((1, 9)))
    for Q, R in ((np.eye(9), np.eye(2)), (np.ones((2, 3)), np.eye(2)), (np.eye(3), np.eye(1))):  # the last was broadcast
        with pytest.raises(ShapeError):
            loop.cost(Q, R)
    for dt in (0.0, -0.1, np.nan):  # a negative period gave a negative covariance
        with pytest.raises(EngineError, match="dt must be"):
            loop.sampled(dt)
    with pytest.raises(ValueError, match="read-only"):
        loop.covariance[0, 0] = 1.0
