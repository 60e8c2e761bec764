"""The linear loop is exact on the grid, and what disturbs it does so where it should."""

import mpmath
import numpy as np
import pytest
from laws import each
from scipy import signal
from scipy.linalg import expm

from observer_lab.engine import EngineError, Plant, Scenario, autonomous_error, simulate
from observer_lab.engine.simulation import emulated_gain, separation_meter
from observer_lab.engine.systems import affine_scan, discretise, held_scan

DOUBLE = Plant([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
K, L = np.array([[4.0, 4.0]]), np.array([[12.0], [36.0]])  # poles −2, −2 and −6, −6
RNG = np.random.default_rng(7)


def random_loop(n: int, m: int, p: int) -> tuple[Plant, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(n)
    A = rng.standard_normal((n, n)) - 2.0 * np.sqrt(n) * np.eye(n)
    plant = Plant(A, rng.standard_normal((n, m)), rng.standard_normal((p, n)), 0.1 * rng.standard_normal((p, m)))
    return plant, 0.2 * rng.standard_normal((m, n)), 0.2 * rng.standard_normal((n, p))


def loop_matrix(plant: Plant, K: np.ndarray, L: np.ndarray) -> np.ndarray:
    """The 2n×2n loop written out by hand in (x, x̂); D drops out of y − ŷ."""
    A, B, C = plant.A, plant.B, plant.C
    return np.block([[A, -B @ K], [L @ C, A - L @ C - B @ K]])


@pytest.mark.slow
@pytest.mark.parametrize("n", [2, 10])
def test_linear_run_agrees_with_forty_digits(n: int) -> None:
    plant, gain, observer = random_loop(n, 2, 2)
    x0, xhat0 = np.ones(n), -np.ones(n)
    run = simulate(Scenario(plant, gain, observer, x0=x0, xhat0=xhat0, horizon=1.0, dt=0.001))
    with mpmath.workdps(40):
        for k in (1, 500, 1000):
            power = mpmath.expm(mpmath.matrix(loop_matrix(plant, gain, observer).tolist()) * mpmath.mpf(k) / 1000)
            true = np.array((power * mpmath.matrix([*x0, *xhat0])).tolist(), dtype=float).ravel()
            ours = np.concatenate([run.x[k], run.xhat[k]])
            assert np.abs(ours - true).max() <= 1e-11 * np.abs(true).max()


def test_held_reference_agrees_with_scipy_discretisation() -> None:
    plant, gain, observer = random_loop(4, 2, 3)
    s = Scenario(plant, gain, observer, x0=np.ones(4), horizon=2.0, dt=0.01, reference=RNG.standard_normal((201, 2)))
    run = simulate(s)
    B = np.vstack([plant.B, plant.B])
    Ad, Bd, *_ = signal.cont2discrete((loop_matrix(plant, gain, observer), B, np.eye(8), np.zeros((8, 2))), 0.01)
    z = np.concatenate([np.ones(4), np.zeros(4)])
    for k in range(201):
        assert np.allclose(np.concatenate([run.x[k], run.xhat[k]]), z, rtol=0, atol=1e-12)
        z = Ad @ z + Bd @ s.reference[k]
    assert np.allclose(run.y, run.x @ plant.C.T + run.u_applied @ plant.D.T)


def test_error_does_not_depend_on_the_input() -> None:
    starts = {"x0": [1.0, -1.0], "xhat0": [0.0, 0.5]}
    quiet = simulate(Scenario(DOUBLE, K, L, **starts))
    steered = simulate(Scenario(DOUBLE, K, L, reference=10 * RNG.standard_normal((1001, 1)), **starts))
    true = np.array([expm((DOUBLE.A - L @ DOUBLE.C) * t) @ [1.0, -1.5] for t in quiet.t])
    assert np.abs(steered.x - quiet.x).max() > 0.5
    for run in (quiet, steered):
        assert np.abs(run.e - true).max() < 1e-11
        assert separation_meter(run) < 1e-10


def test_open_loop_copy_never_recovers_an_unstable_start() -> None:
    unstable = Plant([[0.5]], [[1]], [[1]])
    run = simulate(Scenario(unstable, x0=[1.0], xhat0=[0.9], horizon=4.0))
    assert np.allclose(run.e[:, 0], 0.1 * np.exp(0.5 * run.t), rtol=1e-11)


def test_state_feedback_ignores_the_estimate() -> None:
    run = simulate(Scenario(DOUBLE, K, L, x0=[1.0, 0.0], xhat0=[7.0, 7.0], state_feedback=True, horizon=3.0))
    t = run.t
    assert np.allclose(run.x[:, 0], (1 + 2 * t) * np.exp(-2 * t), atol=1e-12)  # double pole at −2 from rest


@pytest.mark.parametrize("spoil", [
    {"model": Plant([[0, 1], [-0.3, 0]], [[0], [1]], [[1, 0]])}, {"delay": 0.05},
    {"u_min": -1, "u_max": 1, "fed": "commanded"}])
def test_mismatch_delay_and_hidden_saturation_raise_the_separation_meter(spoil: dict) -> None:
    assert separation_meter(simulate(Scenario(DOUBLE, K, L, x0=[1.0, 0.0], **spoil))) > 1e-2


def test_impulse_between_grid_points_is_exact() -> None:
    kicks = (0.33, [0.0, 2.0]), (0.5, [1.0, 0.0])
    run = simulate(Scenario(DOUBLE, x0=[1.0, 0.0], horizon=1.0, dt=0.1, impulses=kicks))
    t = run.t
    assert np.allclose(run.x[:, 0], 1 + 2 * np.clip(t - 0.33, 0, None) + (t >= 0.5 - 1e-9), atol=1e-13)
    assert np.abs(run.xhat).max() == 0.0  # the observer is not told


def test_impulse_at_zero_joins_the_start_and_one_after_the_end_does_nothing() -> None:
    with_kick = simulate(Scenario(DOUBLE, K, L, impulses=((0.0, [1.0, 0.0]), (99.0, [1e6, 0.0]))))
    assert np.array_equal(with_kick.x, simulate(Scenario(DOUBLE, K, L, x0=[1.0, 0.0])).x)


def test_impulses_and_noise_keep_the_autonomous_error() -> None:
    run = simulate(Scenario(DOUBLE, K, L, x0=[1.0, 0.0], W=1e-3, V=1e-4, impulses=((3.005, [1.0, 0.0]),)))
    assert np.abs(run.e - autonomous_error(run)).max() < 1e-12


def test_delay_follows_the_method_of_steps() -> None:
    integrator = Plant([[0]], [[1]], [[1]])
    run = simulate(Scenario(integrator, K=[[1.0]], x0=[1.0], delay=1.0, state_feedback=True, horizon=4.0, dt=0.05))
    t = run.t
    true = sum((-1) ** j * np.clip(t - j, 0, None) ** j / (1, 1, 2, 6)[j] for j in range(1, 4)) + 1
    three = t <= 3 + 1e-9
    assert np.abs(run.x[three, 0] - true[three]).max() < 1e-13  # a straight input: exact
    assert np.abs(run.x[:, 0] - true)[t <= 4].max() < 3e-4  # a curved one: O(dt²); true up to t = 4
    assert np.all(run.u_applied[t < 1 - 1e-9] == 0)


@pytest.mark.parametrize("delay", [0.02, 0.24])
def test_delayed_loop_converges_with_the_square_of_the_step(delay: float) -> None:
    coarse, half, fine = (simulate(Scenario(DOUBLE, K, L, x0=[1.0, 0.0], delay=delay, dt=dt)) for dt in
                          (0.02, 0.01, 0.00125))
    error = [np.abs(run.x[::step] - fine.x[::16]).max() for run, step in ((coarse, 1), (half, 2))]
    assert error[1] < 5e-3 and 3.5 < error[0] / error[1] < 4.6


def test_sampled_loop_agrees_with_a_plain_recursion_on_scipy_matrices() -> None:
    h = 0.05
    Ad, Bd, *_ = signal.cont2discrete((DOUBLE.A, DOUBLE.B, DOUBLE.C, DOUBLE.D), h)
    Ld = emulated_gain(DOUBLE, L, h)
    for more in ({}, {"u_min": -1, "u_max": 1}, {"delay": 0.1}):
        run = simulate(Scenario(DOUBLE, K, L, x0=[1.0, 0.0], dt=h, sampled=True, **more))
        x, xhat, past = np.array([1.0, 0.0]), np.zeros(2), [np.zeros(1)] * (2 if "delay" in more else 0)
        for k in range(len(run.t)):
            assert np.allclose(run.x[k], x, atol=1e-11) and np.allclose(run.xhat[k], xhat, atol=1e-11)
            u = -K @ xhat
            u = np.clip(u, -1, 1) if "u_min" in more else u
            past = [*past, u]
            xhat = Ad @ xhat + Bd @ u + Ld @ (DOUBLE.C @ (x - xhat))
            x = Ad @ x + Bd @ past.pop(0)


def test_emulated_gain_of_an_integrator_keeps_the_pole() -> None:
    gain = emulated_gain(Plant([[0]], [[1]], [[1]]), np.array([[3.0]]), 0.4)
    assert 1 - gain[0, 0] == pytest.approx(np.exp(-1.2), abs=1e-14)


def test_sampled_plant_runs_as_it_is_given() -> None:
    plant = Plant([[0.5]], [[1.0]], [[1.0]], dt=1.0)
    run = simulate(Scenario(plant, K=[[0.2]], L=[[0.4]], x0=[1.0], xhat0=[1.0], dt=1.0, horizon=5.0))
    assert np.allclose(run.x[:, 0], 0.3 ** np.arange(6))
    assert np.allclose(discretise(Plant([[0]], [[1]], [[1]]), 0.5).B, 0.5)


def test_reduced_model_may_drive_a_larger_plant() -> None:
    plant = Plant(np.diag([-1.0, -50.0]), [[1.0], [0.1]], [[1.0, 0.1]])
    run = simulate(Scenario(plant, K=[[1.0]], L=[[2.0]], model=Plant([[-1]], [[1]], [[1]]), x0=[1.0, 1.0]))
    assert run.xhat.shape == (1001, 1) and run.e.shape == (1001, 0)
    with pytest.raises(EngineError, match="order"):
        separation_meter(run)


def test_divergence_ends_the_run_with_finite_arrays() -> None:
    run = simulate(Scenario(Plant([[3.0]], [[1]], [[1]]), x0=[1.0], horizon=100.0))
    assert run.diverged_at == pytest.approx(np.log(1e9) / 3, abs=0.02)
    assert all(np.isfinite(a).all() and len(a) == len(run.t) for a in
               (run.t, run.x, run.xhat, run.e, run.u_asked, run.u_applied, run.y, run.yhat, run.w, run.v))
    for limit in (None, 1.0):
        wild = Plant([[1e5]], [[1]], [[1]])
        stiff = simulate(Scenario(wild, x0=[1.0], horizon=1.0, reference=np.ones(1), u_max=limit))
        assert stiff.diverged_at == pytest.approx(0.01) and np.isfinite(stiff.x).all()


@pytest.mark.parametrize("more", [{"u_min": -1, "u_max": 1}, {"delay": 0.02}, {"sampled": True, "delay": 0.02},
                                  {"u_min": -1, "u_max": 1, "delay": 0.02}])
def test_divergence_is_seen_on_every_path(more: dict) -> None:
    run = simulate(Scenario(Plant([[3.0]], [[1]], [[1]]), K=[[-1.0]], x0=[2.0], xhat0=[2.0], horizon=100.0, **more))
    assert run.diverged_at is not None and run.diverged_at < 8 and np.isfinite(run.x).all()


def test_block_scan_equals_the_plain_recursion_for_every_length() -> None:
    Phi = 0.5 * RNG.standard_normal((3, 3))
    for steps in (0, 1, 2, 23, 24, 25, 32, 33, 400, 1000):
        push, z = RNG.standard_normal((steps, 3)), np.ones(3)
        states = affine_scan(Phi, push, z, steps)
        free = affine_scan(Phi, None, np.ones(3), steps)
        assert states.shape == free.shape == (steps + 1, 3)
        w = np.ones(3)
        for k in range(steps):
            z, w = Phi @ z + push[k], Phi @ w
            assert np.allclose(states[k + 1], z, rtol=1e-11, atol=1e-12) and np.allclose(free[k + 1], w, atol=1e-12)


def test_scan_of_held_inputs_equals_the_plain_recursion_for_every_length() -> None:
    Phi, Gamma = 0.4 * RNG.standard_normal((5, 5)), RNG.standard_normal((5, 2))
    for steps in (1, 23, 24, 25, 31, 32, 33, 1000):
        u, z = RNG.standard_normal((steps, 2)), np.ones(5)
        states = held_scan(Phi, Gamma, u, z)
        assert states.shape == (steps + 1, 5)
        for k in range(steps):
            z = Phi @ z + Gamma @ u[k]
            assert np.allclose(states[k + 1], z, rtol=1e-11, atol=1e-12)


@each("wrong, words", [
    ({"K": [[1, 2, 3]]}, "K must be 1×2"), ({"L": [[1, 2]]}, "L must be 2×1"), ({"x0": [1]}, "x0 must have 2"),
    ({"dt": 0}, "dt must be"), ({"dt": np.nan}, "dt must be"), ({"horizon": 1e12}, "too many"),
    ({"horizon": 0.001}, "shorter"), ({"u_min": 1, "u_max": -1}, "below"), ({"u_max": [1, 2]}, "one number"),
    ({"u_max": np.nan}, "NaN"), ({"fed": "both"}, "fed must be"), ({"V": [[-1]]}, "negative"),
    ({"W": np.eye(3)}, "W must be"), ({"G": [[1]]}, "G must have 2"), ({"x0": [np.inf, 0]}, "infinity"),
    ({"reference": np.ones((3, 1))}, "1001×1"), ({"delay": -1}, "delay"), ({"impulses": ((-1, [0, 0]),)}, "impulse"),
    ({"model": Plant([[0]], [[1, 1]], [[1]])}, "agree"), ({"K": "gain"}, "real numbers")])
def test_wrong_scenarios_are_refused_in_one_sentence(wrong: dict, words: str) -> None:
    with pytest.raises(EngineError, match=words) as caught:
        Scenario(DOUBLE, **wrong)
    assert "\n" not in str(caught.value) and str(caught.value).endswith(".")


