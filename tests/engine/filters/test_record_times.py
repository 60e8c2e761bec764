"""Records as people have them: irregular times, gaps, rates, noises and gates a sample; beside 50 digits and FilterPy."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from filterpy.kalman import MerweScaledSigmaPoints
from filterpy.kalman import UnscentedKalmanFilter as Peer
from mpmath import mp

from observer_lab.engine import EngineError, ExtendedKalmanFilter, KalmanFilter, Plant, SquareRootFilter, UnscentedKalmanFilter, smooth
from observer_lab.engine.systems import Flow

SEEDS = range(4)
DIGITS = 50


def exact(M: np.ndarray) -> mpmath.matrix:
    return mp.matrix(np.asarray(M, dtype=float).tolist())


def exact_step(plant: Plant, intensity: np.ndarray, span: float) -> tuple[mpmath.matrix, ...]:
    """Φ, ∫Φ B and Q of one step in 50 digits: one exponential of [−A W 0; 0 Aᵀ 0] and one of [A B; 0 0]."""
    n, m, h = plant.n, plant.m, mp.mpf(span)
    wide, drive = mp.zeros(2 * n), mp.zeros(n + m)
    A, B, W = exact(plant.A), exact(plant.B), exact(intensity)
    wide[:n, :n], wide[:n, n:], wide[n:, n:] = -A, W, A.T
    drive[:n, :n], drive[:n, n:] = A, B
    power, pushed = mp.expm(wide * h), mp.expm(drive * h)
    Phi = power[n:, n:].T
    return Phi, pushed[:n, n:], Phi * power[:n, n:]


def batch(case: Case) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Mean and covariance of each state given the whole record, from the joint Gaussian of all states, in 50 digits."""
    with mp.workdps(DIGITS):
        n, steps = case.plant.n, len(case.y)
        means, covariance = [exact(case.start[0])], [[exact(case.start[1])]]
        for k in range(1, steps):
            Phi, Gamma, Q = exact_step(case.plant, case.intensity, case.t[k] - case.t[k - 1])
            means.append(Phi * means[-1] + Gamma * exact(case.u[k - 1]))
            covariance.append([Phi * covariance[-1][i] for i in range(k)] + [Phi * covariance[-1][k - 1] * Phi.T + Q])
        m, P, rows, right, noise = mp.zeros(n * steps, 1), mp.zeros(n * steps), [], [], []
        for k in range(steps):
            m[n * k:n * k + n, 0] = means[k]
            for i in range(k + 1):
                P[n * k:n * k + n, n * i:n * i + n] = covariance[k][i]
                P[n * i:n * i + n, n * k:n * k + n] = covariance[k][i].T
            for j in np.flatnonzero(np.isfinite(case.y[k])):
                rows.append((k, exact(case.plant.C[j])))
                right.append(mp.mpf(case.y[k, j]))
                noise.append((k, j))
        H, R, y = mp.zeros(len(rows), n * steps), mp.zeros(len(rows)), mp.matrix(right)
        for i, (k, c) in enumerate(rows):
            for j in range(n):
                H[i, n * k + j] = c[j]
            for other, (l, j) in enumerate(noise):
                if l == k:
                    R[i, other] = mp.mpf(case.R[k][noise[i][1], j])
        gain = P * H.T * mp.inverse(H * P * H.T + R)
        m, P = m + gain * (y - H * m), P - gain * H * P
        found = np.array(m.tolist(), dtype=float).reshape(steps, n), np.array(P.tolist(), dtype=float)
    return list(found[0]), [found[1][n * k:n * k + n, n * k:n * k + n] for k in range(steps)]


class Case:
    """A plant of two states and two sensors at different rates, at times of any distance, two of them the same."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.plant = Plant([[0.0, 1.0], [-2.0 * rng.random(), -0.4]], [[0.0], [1.0]], rng.standard_normal((2, 2)))
        self.intensity = np.diag([0.1, 1.0])
        self.t = np.cumsum(rng.exponential(0.7, 9))
        self.t[4] = self.t[3]
        self.u, self.y = rng.standard_normal((9, 1)), rng.standard_normal((9, 2))
        self.y[rng.random((9, 2)) < 0.3] = np.nan
        self.y[::2, 1] = np.nan
        roots = rng.standard_normal((9, 2, 2))
        self.R = roots @ roots.swapaxes(1, 2) + 0.1 * np.eye(2)
        self.start = np.array([1.0, -1.0]), np.diag([2.0, 0.5])


def filters_of(case: Case) -> dict[str, object]:
    """All kinds of filter on this plant: the nonlinear ones by a map that takes its step."""
    def f(x: np.ndarray, u: np.ndarray, dt: float) -> np.ndarray:
        with mp.workdps(DIGITS):
            Phi, Gamma, _ = exact_step(case.plant, case.intensity, dt)
        return np.array(Phi.tolist(), dtype=float) @ x + np.array(Gamma.tolist(), dtype=float) @ u

    def h(x: np.ndarray) -> np.ndarray:
        return case.plant.C @ x

    linear = {kind: kind.from_plant(case.plant, case.intensity, np.eye(2), dt=1.0) for kind in (KalmanFilter, SquareRootFilter)}
    return {**{kind.__name__: one for kind, one in linear.items()}, "extended": ExtendedKalmanFilter(f, h, 1.0, 1.0),
            "unscented": UnscentedKalmanFilter(f, h, 1.0, 1.0)}


@pytest.mark.parametrize("seed", SEEDS)
def test_irregular_times_gaps_rates_and_noises_are_the_batch_solution_in_fifty_digits(seed: int) -> None:
    case = Case(seed)
    means, covariances = batch(case)
    with mp.workdps(DIGITS):
        Q = np.array([np.array(exact_step(case.plant, case.intensity, span)[2].tolist(), dtype=float) for span in np.diff(case.t)])
    for name, one in filters_of(case).items():
        more = {} if "KalmanFilter" in name or "Square" in name else {"Q": Q}
        track = one.run(case.start, case.y, case.u, t=case.t, R=case.R, **more)  # type: ignore[attr-defined]
        found = smooth(one, track)  # type: ignore[arg-type]
        np.testing.assert_allclose(found.means, means, atol=1e-10, err_msg=name)
        np.testing.assert_allclose(found.covariances, covariances, atol=1e-10, err_msg=name)
        np.testing.assert_allclose(track.means[-1], means[-1], atol=1e-11, err_msg=name)


@pytest.mark.parametrize("seed", SEEDS)
def test_regular_times_change_nothing(seed: int) -> None:
    case = Case(seed)
    for kind in (KalmanFilter, SquareRootFilter):
        kf = kind.from_plant(case.plant, case.intensity, np.eye(2), dt=0.3)
        plain, timed = (kf.run(case.start, case.y, case.u, **given) for given in ({}, {"t": 0.3 * np.arange(9), "R": kf.R, "gate": 1.0}))
        np.testing.assert_allclose(timed.means, plain.means, atol=1e-12)
        np.testing.assert_allclose(smooth(kf, timed).means, smooth(kf, plain).means, atol=1e-12)
        assert timed.rejected is not None and not timed.rejected.any()


def drag(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    return np.stack([x[1], -np.sin(x[0]) - 0.3 * x[1] * np.abs(x[1]) + u[0]])


def reading(x: np.ndarray) -> np.ndarray:
    return np.sin(x[:1]) + 0.1 * x[1:]


@pytest.mark.parametrize("kind", [ExtendedKalmanFilter, UnscentedKalmanFilter])
def test_a_flow_makes_steps_of_any_length_and_its_noise_grows_with_them(kind: type) -> None:
    """One step of 0.3 s with no reading in between is three of 0.1 s, as far as the covariance's own curvature goes."""
    rng = np.random.default_rng(0)
    u, y = np.zeros((31, 1)), rng.standard_normal((31, 1)) / 10
    t = 0.02 * np.arange(31)
    y[np.arange(31) % 3 != 0] = np.nan
    fine = kind(Flow(drag, 0.02), reading, 1e-4, 0.04).run(([0.2, 0.0], 0.1), y, u)
    coarse = kind(Flow(drag, 0.02), reading, 1e-4, 0.04).run(([0.2, 0.0], 0.1), y[::3], u[::3], t=t[::3])
    np.testing.assert_allclose(coarse.means, fine.means[::3], atol=2e-4)
    np.testing.assert_allclose(coarse.covariances, fine.covariances[::3], atol=2e-3)
    same = kind(Flow(drag, 0.02), reading, 1e-4, 0.04).run(([0.2, 0.0], 0.1), y, u, t=t)
    np.testing.assert_allclose(same.means, fine.means, atol=1e-13)


def test_the_unscented_smoother_is_that_of_filterpy() -> None:
    rng = np.random.default_rng(3)
    flow, y = Flow(drag, 0.1), 0.3 * rng.standard_normal((40, 1))
    ukf = UnscentedKalmanFilter(flow, reading, 1e-3 * np.eye(2), [[0.01]])
    track = ukf.run(([0.3, 0.0], 0.1), y, np.zeros((40, 1)))
    peer = Peer(2, 1, 0.1, hx=None, fx=lambda x, dt: flow(x[:, None], np.zeros((1, 1)))[:, 0],
                points=MerweScaledSigmaPoints(2, 1.0, 2.0, 0.0))
    peer.Q = ukf.Q
    means, covariances, _ = peer.rts_smoother(track.means, track.covariances, dts=0.1)
    found = smooth(ukf, track)
    np.testing.assert_allclose(found.means, means, atol=1e-10)
    np.testing.assert_allclose(found.covariances, covariances, atol=1e-10)


def test_the_extended_smoother_is_the_recursion_with_slopes_by_hand() -> None:
    def f(x: np.ndarray) -> np.ndarray:
        return np.stack([x[0] + 0.1 * x[1], x[1] - 0.1 * np.sin(x[0])])

    rng = np.random.default_rng(5)
    ekf = ExtendedKalmanFilter(f, lambda x: x[:1] ** 3, 1e-3, 0.1)
    track = ekf.run(([1.0, 0.0], 0.1), rng.standard_normal(25))
    x, P = track.means[-1], track.covariances[-1]
    found = smooth(ekf, track)
    for k in range(23, -1, -1):
        F = np.array([[1.0, 0.1], [-0.1 * np.cos(track.means[k, 0]), 1.0]])
        ahead = F @ track.covariances[k] @ F.T + 1e-3 * np.eye(2)
        G = track.covariances[k] @ F.T @ np.linalg.inv(ahead)
        x, P = track.means[k] + G @ (x - f(track.means[k])), track.covariances[k] + G @ (P - ahead) @ G.T
        np.testing.assert_allclose(found.means[k], x, atol=1e-11)
        np.testing.assert_allclose(found.covariances[k], P, atol=1e-11)


@pytest.mark.parametrize("kind", ["linear", "extended", "unscented"])
def test_what_a_gate_rejects_is_as_if_it_had_not_arrived(kind: str) -> None:
    kf = KalmanFilter(np.eye(2) * 0.9, np.zeros((2, 1)), np.eye(2), np.eye(2) * 0.1, np.eye(2))
    one = kf if kind == "linear" else {"extended": ExtendedKalmanFilter, "unscented": UnscentedKalmanFilter}[kind](
        lambda x: 0.9 * x, lambda x: x, 0.1, 1.0)
    rng = np.random.default_rng(0)
    y, start = rng.standard_normal((60, 2)), ([0.0, 0.0], 1.0)
    y[[20, 41]] += 25.0
    track = one.run(start, y, gate=0.9999)
    assert np.flatnonzero(track.rejected).tolist() == [20, 41] and track.innovations[20, 0] > 10
    gone = y.copy()
    gone[[20, 41]] = np.nan
    np.testing.assert_allclose(track.means, one.run(start, gone).means, atol=1e-12)
    np.testing.assert_allclose(track.covariances, one.run(start, gone).covariances, atol=1e-12)
    levels = np.where(np.arange(60) == 41, 1.0, 0.9999)
    open_once = one.run(start, y, gate=levels).rejected
    assert open_once[20] and not open_once[41]


def test_a_gate_lets_through_its_share_of_good_readings() -> None:
    kf = KalmanFilter([[0.9]], [[0.0]], [[1.0]], 1.0, 1.0)
    rng = np.random.default_rng(1)
    x, y = 0.0, np.empty(4000)
    for k in range(4000):
        x = 0.9 * x + rng.standard_normal()
        y[k] = x + rng.standard_normal()
    assert kf.run(([0.0], 5.0), y, gate=0.95).rejected.mean() == pytest.approx(0.05, abs=0.015)  # type: ignore[union-attr]


@pytest.mark.parametrize("call, sentence", [
    (lambda kf: KalmanFilter([[0.9]], [[0.0]], [[1.0]], 1.0, 1.0).run(([0.0], 1.0), [1.0, 2.0], t=[0.0, 1.5]), "from_plant"),
    (lambda kf: kf.run(([0.0], 1.0), [1.0, 2.0], t=[1.0, 0.0]), "go back: sample 1"),
    (lambda kf: kf.run(([0.0], 1.0), [1.0, 2.0], t=[1.0]), "t must have 2 entries"),
    (lambda kf: kf.run(([0.0], 1.0), [1.0, 2.0], gate=0.0), "share of good readings"),
    (lambda kf: kf.run(([0.0], 1.0), [1.0, 2.0], R=[1.0, -1.0]), "negative"),
    (lambda kf: kf.run(([0.0], 1.0), [1.0, 2.0], R=np.ones((3, 1, 1))), "one such matrix a sample"),
    (lambda kf: kf.run(([0.0], 1.0), [1.0, 2.0], R=2.0, schedule=kf.schedule(([0.0], 1.0), 2)), "schedule"),
    (lambda kf: ExtendedKalmanFilter(lambda x: x, lambda x: x, 1.0, 1.0).run(([0.0], 1.0), [1.0, 2.0, 3.0], t=[0, 1, 5]), "takes dt"),
    (lambda kf: ExtendedKalmanFilter(lambda x, u, t: x, lambda x: x, 1.0, 1.0).predict(([0.0], 1.0)), "takes x, u, t")])
def test_what_does_not_fit_a_record_is_one_sentence(call: object, sentence: str) -> None:
    kf = KalmanFilter.from_plant(Plant([[-1.0]], [[1.0]], [[1.0]]), 1.0, 1.0, dt=0.1)
    with pytest.raises(EngineError, match=sentence):
        call(kf)  # type: ignore[operator]
