"""Habits of a notebook: what python-control's and MATLAB's calls take, ours take too, and the answers solve their equations."""

from __future__ import annotations

import control
import matplotlib
import numpy as np
import pytest
from matplotlib import pyplot
from scipy.linalg import solve_continuous_are, solve_discrete_are

from observer_lab import engine
from observer_lab.engine import EngineError, KalmanFilter, Plant, RiccatiError

matplotlib.use("Agg")
A, B, C = np.array([[0.0, 1.0], [-2.0, -3.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
PLANT = Plant(A, B, C)
SEEDS = range(6)


def noises(seed: int, sampled: bool) -> tuple[np.ndarray, ...]:
    """A, G, C, W, V, N of a random estimator whose noises agree."""
    rng = np.random.default_rng(seed)
    n, q, p = 3, 2, 2
    F = rng.standard_normal((n, n))
    if sampled:
        F *= 0.9 / np.abs(np.linalg.eigvals(F)).max()
    root = rng.standard_normal((q + p, q + p))
    both = root @ root.T + 0.1 * np.eye(q + p)
    return F, rng.standard_normal((n, q)), rng.standard_normal((p, n)), both[:q, :q], both[q:, q:], both[:q, q:]


@pytest.mark.parametrize("seed", SEEDS)
def test_gains_of_noises_that_agree_are_those_of_scipy(seed: int) -> None:
    F, G, H, W, V, N = noises(seed, False)
    P = solve_continuous_are(F.T, H.T, G @ W @ G.T, V, s=G @ N)
    found = engine.lqe(F, G, H, W, V, N)
    np.testing.assert_allclose(found.solution, P, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(found.gain, (P @ H.T + G @ N) @ np.linalg.inv(V), rtol=1e-8, atol=1e-9)
    F, G, H, W, V, N = noises(seed, True)
    P = solve_discrete_are(F.T, H.T, G @ W @ G.T, V, s=G @ N)
    found, S = engine.dlqe(F, G, H, W, V, N), H @ P @ H.T + V
    np.testing.assert_allclose(found.gain, (F @ P @ H.T + G @ N) @ np.linalg.inv(S), rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(found.filter_gain, P @ H.T @ np.linalg.inv(S), rtol=1e-8, atol=1e-9)
    assert found.residual < 1e-12 and not np.allclose(found.gain, F @ found.filter_gain)


def test_noises_that_agree_too_much_are_refused() -> None:
    with pytest.raises(EngineError, match="negative eigenvalue"):
        engine.lqe(A, B, C, [[1.0]], [[1.0]], [[1.5]])
    with pytest.raises(EngineError, match="N must be 1×1"):
        engine.dlqe(A / 4, B, C, [[1.0]], [[1.0]], [[0.1, 0.2]])


def test_the_cross_weight_stands_where_python_control_has_it() -> None:
    Q, R, N = np.eye(2), [[2.0]], [[0.3], [0.1]]
    for ours, theirs, F in ((engine.lqr, control.lqr, A), (engine.dlqr, control.dlqr, A / 4)):
        np.testing.assert_allclose(ours(F, B, Q, R, N).gain, theirs(F, B, Q, R, N)[0], rtol=1e-9)
    np.testing.assert_array_equal(engine.lqr(PLANT, Q, R, N).gain, engine.lqr(A, B, Q, R, N).gain)  # type: ignore[call-arg]
    with pytest.raises(EngineError, match="not both"):
        engine.lqr(PLANT, B, Q, R)


@pytest.mark.parametrize("method", ["zoh", "tustin", "bilinear"])
def test_sampling_there_and_back(method: str) -> None:
    theirs = control.c2d(control.ss(A, B, C, 0.5), 0.2, method)
    ours = engine.c2d(Plant(A, B, C, [[0.5]], state_names=("a", "b")), 0.2, method)  # type: ignore[arg-type]
    for key in "ABCD":
        np.testing.assert_allclose(getattr(ours, key), getattr(theirs, key), atol=1e-14)
    back = engine.d2c(ours, method)  # type: ignore[arg-type]
    for key, value in zip("ABCD", (A, B, C, [[0.5]]), strict=True):
        np.testing.assert_allclose(getattr(back, key), value, atol=1e-12)
    assert back.dt == 0 and back.state_names == ("a", "b")


def test_what_no_rule_samples_is_refused() -> None:
    for call, match in ((lambda: engine.c2d(Plant([[20.0]], [[1]], [[1]]), 0.1, "tustin"), "pole at 2/dt"),
                        (lambda: engine.d2c(Plant([[-1.0]], [[1]], [[1]], dt=0.1), "tustin"), "pole at −1"),
                        (lambda: engine.d2c(PLANT), "continuous already"), (lambda: engine.c2d(PLANT, 0.1, "euler"), "one of")):  # type: ignore[arg-type]
        with pytest.raises(EngineError, match=match):
            call()


@pytest.mark.parametrize("seed", SEEDS)
def test_all_forms_of_lyapunovs_and_sylvesters_equations(seed: int) -> None:
    rng = np.random.default_rng(seed)
    F, E, S, H = (rng.standard_normal(shape) for shape in ((4, 4), (4, 4), (3, 3), (4, 3)))
    Q = np.eye(4)
    X, Y, Z, U = engine.lyap(F, S, H), engine.dlyap(F, S, H), engine.lyap(F, Q, None, E), engine.dlyap(F, Q, None, E)
    for left in (F @ X + X @ S + H, F @ Y @ S - Y + H, F @ Z @ E.T + E @ Z @ F.T + Q, F @ U @ F.T - E @ U @ E.T + Q):
        np.testing.assert_allclose(left, 0, atol=1e-9)
    np.testing.assert_allclose(X, control.lyap(F, S, H), atol=1e-10)


def test_equations_without_a_unique_solution_are_refused() -> None:
    for call, match in ((lambda: engine.lyap([[1.0]], [[-1.0]], [[1.0]]), "minus one of Q"),
                        (lambda: engine.dlyap([[2.0]], [[0.5]], [[1.0]]), "inverse"),
                        (lambda: engine.lyap(A, np.eye(2), None, np.zeros((2, 2))), "singular"),
                        (lambda: engine.lyap(A, A, A, A), "not both"), (lambda: engine.lyap(A, np.eye(3)), "Q must be 2×2")):
        with pytest.raises(EngineError, match=match):
            call()


def test_transfer_functions_as_people_write_them() -> None:
    num, den = [[[1], [1, 2]], [[0], [3]]], [[[1, 1], [1, 3]], [[1], [1, 0.5]]]
    w = np.array([0.1, 0.7, 5.0])
    theirs = control.tf(num, den)(1j * w)
    np.testing.assert_allclose(engine.frequency_response(engine.tf(num, den), w), np.moveaxis(theirs, -1, 0), atol=1e-12)  # type: ignore[call-arg]
    s = engine.tf("s")
    for given, wanted in ((engine.tf((s + 3) / (s**2 + 3 * s + 2)), engine.tf([1, 3], [1, 3, 2])),
                          (engine.tf([[[1], [2]]], [1, 2]), engine.tf([[[1], [2]]], [[[1, 2], [1, 2]]]))):
        np.testing.assert_allclose(engine.frequency_response(given, w), engine.frequency_response(wanted, w), rtol=1e-12)  # type: ignore[call-arg]
    z = engine.tf("z", 0.1)
    assert engine.tf(1 / (z - 0.5)).dt == 0.1 == engine.tf("z", dt=0.1).dt
    for call in (lambda: engine.tf("z"), lambda: engine.tf("s", dt=0.1), lambda: engine.tf([1]), lambda: engine.tf(s, [1]),
                 lambda: engine.tf(s), lambda: engine.tf([[[1], [2]], [[1]]], [1, 1]), lambda: engine.tf([[[1], [2]]], [[[1, 1]]])):
        with pytest.raises(EngineError):
            call()


ANSWERS = (control.poles, control.zeros, control.dcgain, control.damp, control.margin, control.step_response, control.impulse_response,
           control.bode_plot, control.nyquist_plot, control.minreal, control.ss2tf,
           lambda system: control.forced_response(system, [0, 1, 2], [0, 1, 0]),
           lambda system: control.initial_response(system, X0=[1, 0]),
           lambda system: control.feedback(control.series(control.parallel(system, system), system)),
           lambda system: control.norm(system, 2))


@pytest.mark.parametrize("call", ANSWERS, ids=range(len(ANSWERS)))
def test_python_controls_own_functions_take_our_plants_by_one_word(call: object, capsys: pytest.CaptureFixture[str]) -> None:
    if call in (ANSWERS[9], ANSWERS[14]):
        pytest.importorskip("slycot")
    try:
        assert call(engine.to_control(PLANT)) is not None  # type: ignore[operator]
    finally:
        pyplot.close("all")  # python-control draws with it


def test_a_loop_of_python_control_comes_back_as_a_plant() -> None:
    loop = control.feedback(engine.to_control(PLANT), 2)
    np.testing.assert_allclose(np.sort(engine.ss(loop).poles), np.sort(np.roots([1, 3, 4])), atol=1e-12)  # type: ignore[call-arg, arg-type]


@pytest.mark.parametrize("seed", SEEDS)
def test_kalman_runs_as_the_filter_of_a_record_does(seed: int) -> None:
    rng = np.random.default_rng(seed)
    F, G, H, W, V, _ = noises(seed, True)
    B2 = rng.standard_normal((3, 1))
    kest, L, P = engine.kalman(Plant(F, np.hstack([B2, G]), H, dt=1.0), W, V)
    late, *_ = engine.kalman(Plant(F, np.hstack([B2, G]), H, dt=1.0), W, V, type="delayed")
    u, y = rng.standard_normal((40, 1)), rng.standard_normal((40, 2))
    track = KalmanFilter(F, B2, H, G @ W @ G.T, V).run((np.zeros(3), P), y, u)
    for system, wanted in ((kest, track.means), (late, track.predicted)):
        x = np.zeros(3)
        for k in range(40):
            given = np.concatenate([u[k], y[k]])
            out = system.C @ x + np.asarray(system.D) @ given
            np.testing.assert_allclose(out, np.concatenate([H @ wanted[k], wanted[k]]), atol=1e-7)
            x = system.A @ x + system.B @ given
    np.testing.assert_allclose(L, engine.dlqe(F, G, H, W, V).gain)


def test_kalman_takes_noise_that_reaches_the_readings() -> None:
    """y = C x + H w + v is another plant with the noises w and H w + v, which agree."""
    D = np.array([[0.0, 0.4]])
    wide = Plant(A, np.hstack([B, B]), C, D)
    _, L, P = engine.kalman(wide, [[2.0]], [[0.5]], [[0.1]])
    expected = engine.lqe(A, B, C, [[2.0]], [[0.5 + 0.16 * 2 + 2 * 0.4 * 0.1]], [[2 * 0.4 + 0.1]])
    np.testing.assert_allclose(L, expected.gain)
    np.testing.assert_allclose(P, expected.solution)


def test_estim_forgets_its_start_and_counts_signals_from_zero() -> None:
    plant = Plant(A, np.hstack([B, 2 * B]), np.eye(2), [[0.1, 0.0], [0.0, 0.2]], output_names=("p", "q"))
    L = engine.observer_gain(A, plant.C[1:], [-4, -5])
    found = engine.estim(plant, L, [1], [0])  # type: ignore[arg-type]
    np.testing.assert_allclose(np.sort(found.poles.real), [-5, -4])
    assert found.input_names == ("u1", "q") and found.p == 3
    np.testing.assert_allclose(found.B, np.hstack([B, L.gain]))
    for arguments in (([2], [0]), ([0, 0], []), ([0], [5])):
        with pytest.raises(EngineError):
            engine.estim(plant, np.ones((2, len(arguments[0]))), *arguments)


@pytest.mark.parametrize("seed", SEEDS)
def test_lqg_of_a_sampled_plant_costs_what_it_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    F, G, H, W, V, _ = noises(seed, True)
    plant = Plant(F * 1.3, rng.standard_normal((3, 2)), H, rng.standard_normal((2, 2)), dt=0.5)
    Q, R = np.diag([1.0, 2.0, 0.5]), np.diag([1.0, 0.3])
    found = engine.lqg(plant, Q, R, W, V, G=G)
    assert engine.closed_loop(plant, found.K, found.L).stable
    a, b, c, k, d = plant.A, plant.B, plant.C, found.controller, np.asarray(plant.D)
    whole = np.block([[a, b @ k.C], [k.B @ c, k.A + k.B @ d @ k.C]])
    noise = np.block([[G @ W @ G.T, np.zeros((3, 3))], [np.zeros((3, 3)), k.B @ V @ k.B.T]])
    P = np.linalg.solve(np.eye(36) - np.kron(whole, whole), noise.ravel()).reshape(6, 6)
    cost = np.trace(P[:3, :3] @ Q) + np.trace(k.C @ P[3:, 3:] @ k.C.T @ R)
    assert found.cost == pytest.approx(cost, rel=1e-8)


def test_sampled_lqg_takes_a_plant_that_is_sampled_already() -> None:
    plant = engine.c2d(PLANT, 0.1)
    late, now = engine.lqg(plant, np.eye(2), 1.0, 1.0, 1.0), engine.sampled_lqg(plant, np.eye(2), 1.0, 1.0, 1.0, 0.1)
    np.testing.assert_allclose(now.K, late.K)
    np.testing.assert_allclose(now.filter.steady.predictor_gain, late.L)
    assert sum(now.loop().cost(np.eye(2), np.eye(1))) < late.cost  # it uses a reading more
    with pytest.raises(EngineError, match="sampled every"):
        engine.sampled_lqg(plant, np.eye(2), 1.0, 1.0, 1.0, 0.2)
    with pytest.raises(RiccatiError):
        engine.lqg(Plant([[2.0]], [[0.0]], [[1.0]], dt=0.1), 1.0, 1.0, 1.0, 1.0)
