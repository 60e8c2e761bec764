"""Maps by what they take, angles, iterated corrections and several models at once; beside 50 digits and FilterPy."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from filterpy.kalman import IMMEstimator
from filterpy.kalman import KalmanFilter as Peer
from mpmath import mp

from observer_lab.engine import (
    Belief,
    EngineError,
    ExtendedKalmanFilter,
    KalmanFilter,
    MultipleModelFilter,
    UnscentedKalmanFilter,
    angles,
    smooth,
)
from observer_lab.engine.filters import Beliefs
from observer_lab.engine.systems import each_column

KINDS = [ExtendedKalmanFilter, UnscentedKalmanFilter]
Y, U, T = np.random.default_rng(0).standard_normal((12, 1)), np.linspace(-1, 1, 12)[:, None], 0.1 * np.arange(12)


class Bent:
    def __call__(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.sin(x) + u[0]

    def method(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return self(x, u)


def gained(x: np.ndarray, u: np.ndarray, gain: float = 1.0) -> np.ndarray:
    return np.sin(x) + gain * u[0]


def by_time(x: np.ndarray, u: np.ndarray, t: float) -> np.ndarray:
    return np.sin(x) + u[0] + 0 * t


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("f", [Bent(), Bent().method, gained, functools.partial(gained, gain=1.0), by_time,
                               lambda x, *more: np.sin(x) + more[0][0], lambda state, force: np.sin(state) + force[0],
                               lambda x, u, dt: np.sin(x) + u[0] + 0 * dt, each_column(lambda x, u: np.sin(x) + u[0])], ids=range(9))
def test_a_map_is_called_by_what_it_takes(kind: type, f: object) -> None:
    wanted = kind(lambda x, u: np.sin(x) + u[0], lambda x, u: x, 0.1, 0.2).run(([0.0], 1.0), Y, U)
    np.testing.assert_array_equal(kind(f, lambda x: x, 0.1, 0.2).run(([0.0], 1.0), Y, U, t=T).means, wanted.means)
    np.testing.assert_array_equal(kind(f, lambda x, u: x, 0.1, 0.2).run(([0.0], 1.0), Y, U).means, wanted.means)


def test_a_function_of_one_state_may_take_it_alone() -> None:
    np.testing.assert_array_equal(each_column(lambda x: [x[0] * x[1]])(np.array([[1, 2], [3, 4]]), np.zeros((0, 1))), [[3, 8]])


@pytest.mark.parametrize("kind", KINDS)
def test_time_and_step_reach_both_maps(kind: type) -> None:
    def f(x: np.ndarray, u: np.ndarray, t: float, dt: float) -> np.ndarray:
        return x + dt * np.cos(t)

    def h(x: np.ndarray, t: float) -> np.ndarray:
        return x + t**2

    t = np.array([0.0, 0.1, 0.5, 0.55])
    ours = kind(f, h, 0.1, 0.2)
    track, belief = ours.run(([0.0], 1.0), [1.0, 2.0, 3.0, 4.0], t=t), Belief([0.0], [[1.0]])
    for k in range(4):
        assert track.innovations[k, 0] == pytest.approx(k + 1 - belief.mean[0] - t[k] ** 2, abs=1e-14)
        belief = ours.correct(belief, [k + 1.0], t=t[k]).belief
        if k < 3:
            belief = ours.predict(belief, t=t[k], dt=t[k + 1] - t[k])
    np.testing.assert_allclose(track.means[-1], belief.mean, atol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_a_number_is_that_number_times_one(kind: type) -> None:
    def f(x: np.ndarray) -> np.ndarray:
        return np.stack([x[1], -np.sin(x[0])])

    given, start = np.random.default_rng(2).standard_normal((9, 2)), ([0.1, 0.2], np.eye(2))
    by_number, by_matrix = kind(f, lambda x: x, 0.3, 0.7), kind(f, lambda x: x, 0.3 * np.eye(2), 0.7 * np.eye(2))
    np.testing.assert_array_equal(by_number.run(start, given).means, by_matrix.run(start, given).means)
    np.testing.assert_array_equal(by_number.predict(start).covariance, by_matrix.predict(start).covariance)
    np.testing.assert_array_equal(by_number.correct(start, given[0]).S, by_matrix.correct(start, given[0]).S)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("where", ["f", "h"])
def test_what_a_map_raises_within_a_run_has_its_own_words(kind: type, where: str) -> None:
    def broken(x: np.ndarray) -> np.ndarray:
        raise KeyError("no entry for the third valve")

    maps = {"f": lambda x: x, "h": lambda x: x, where: broken}
    with pytest.raises(KeyError, match="third valve"):
        kind(maps["f"], maps["h"], 1.0, 1.0).run(([0.0], 1.0), [1.0, 2.0])


def turning(seed: int, steps: int = 200) -> tuple[np.ndarray, np.ndarray]:
    """A heading that turns more than once around, and a compass that knows it between −π and π alone."""
    rng = np.random.default_rng(seed)
    heading = np.cumsum(0.09 + 0.02 * rng.standard_normal(steps))
    return heading, heading + 0.1 * rng.standard_normal(steps)


def wrapped(angle: np.ndarray) -> np.ndarray:
    return np.angle(np.exp(1j * angle))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_a_heading_is_filtered_and_smoothed_through_the_jump_of_its_compass(kind: type, seed: int) -> None:
    """Beside the linear filter that is given the unwrapped readings, which needs no angles."""
    _, compass = turning(seed)
    A, Q, start = np.array([[1.0, 1.0], [0.0, 1.0]]), np.diag([1e-6, 1e-4]), ([0.0, 0.0], np.eye(2))
    kf = KalmanFilter(A, np.zeros((2, 1)), [[1.0, 0.0]], Q, 0.01)
    free = kf.run(start, compass)

    def turn(x: np.ndarray, step: np.ndarray) -> np.ndarray:
        moved = x + step
        return np.stack([np.angle(np.exp(1j * moved[0])), moved[1]])

    def f(x: np.ndarray) -> np.ndarray:
        return np.stack([x[0] + x[1] - 2 * np.pi * np.round(np.real(x[0] + x[1]) / (2 * np.pi)), x[1]])

    ours = kind(f, lambda x: x[:1], Q, 0.01, y_minus=angles([0]), x_minus=angles([0]), x_plus=turn)
    track = ours.run(start, wrapped(compass))
    for found, wanted in ((track.means, free.means), (smooth(ours, track).means, smooth(kf, free).means)):
        assert np.abs(found[:, 0]).max() <= np.pi + 1e-6
        np.testing.assert_allclose(wrapped(found[:, 0] - wanted[:, 0]), 0, atol=1e-7)
        np.testing.assert_allclose(found[:, 1], wanted[:, 1], atol=1e-7)
    lost = kind(f, lambda x: x[:1], Q, 0.01).run(start, wrapped(compass))
    assert np.abs(wrapped(lost.means[:, 0] - free.means[:, 0])).max() > 0.05  # without them it is lost


@pytest.mark.parametrize("seed", range(4))
def test_an_iterated_correction_is_the_most_likely_state_in_fifty_digits(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((2, 2))
    mean, P, R, y = rng.standard_normal(2) + 2, root @ root.T + 0.1 * np.eye(2), np.diag([0.05, 0.02]), np.array([2.0, 0.3])

    def h(x: np.ndarray) -> np.ndarray:
        return np.stack([np.sqrt(x[0] ** 2 + x[1] ** 2 + 1), np.arctan(x[1] / 3)])

    def slope_of_cost(a: object, b: object) -> tuple[object, object]:
        r = mp.sqrt(a**2 + b**2 + 1)
        rest = [(mp.mpf(y[0]) - r) / mp.mpf(R[0, 0]), (mp.mpf(y[1]) - mp.atan(b / 3)) / mp.mpf(R[1, 1])]
        own = mp.inverse(mp.matrix(P.tolist())) * mp.matrix([a - mp.mpf(mean[0]), b - mp.mpf(mean[1])])
        return own[0] - a / r * rest[0], own[1] - b / r * rest[0] - 3 / (9 + b**2) * rest[1]

    found = ExtendedKalmanFilter(lambda x: x, h, np.eye(2), R, iterations=200).correct(Belief(mean, P), y)
    with mp.workdps(50):
        true = mp.findroot(slope_of_cost, tuple(found.belief.mean))
        np.testing.assert_allclose(found.belief.mean, [float(v) for v in true], atol=1e-11)
    once = ExtendedKalmanFilter(lambda x: x, h, np.eye(2), R).correct(Belief(mean, P), y)
    np.testing.assert_array_equal(once.innovation, found.innovation)
    assert np.abs(once.belief.mean - found.belief.mean).max() > 1e-3
    readings = np.repeat(y[:, None], 3, axis=1)
    many = ExtendedKalmanFilter(lambda x: x, h, np.eye(2), R, iterations=200).correct(Beliefs.alike(mean, P, 3), readings)
    np.testing.assert_allclose(many.beliefs.mean, np.repeat(found.belief.mean[:, None], 3, axis=1), atol=1e-11)


def models(count: int = 2) -> list[KalmanFilter]:
    A = np.array([[1.0, 0.5], [0.0, 1.0]])
    Q = np.array([[0.1, 0.2], [0.2, 0.5]])
    return [KalmanFilter(A, [[0.0], [1.0]], [[1.0, 0.0]], q * Q, 0.3) for q in (0.01, 4.0, 0.3, 50.0)[:count]]


@pytest.mark.parametrize("count", [2, 3, 4])
def test_several_models_are_those_of_filterpy(count: int) -> None:
    rng = np.random.default_rng(count)
    switching = rng.random((count, count)) + 3 * np.eye(count)
    switching /= switching.sum(axis=1, keepdims=True)
    y, u, mu = np.cumsum(rng.standard_normal(30)), 0.1 * rng.standard_normal(30), np.full(count, 1 / count)
    ours = MultipleModelFilter(models(count), switching).run(([0.0, 0.0], np.eye(2)), y, u, probabilities=mu @ switching)
    peers = []
    for one in models(count):
        peer = Peer(2, 1, 1)
        peer.x, peer.P, peer.F, peer.B, peer.H, peer.Q, peer.R = np.zeros((2, 1)), np.eye(2), one.A, one.B, one.C, one.Q, one.R
        peers.append(peer)
    imm = IMMEstimator(peers, mu, switching)
    for k in range(30):
        if k:
            imm.predict(np.array([[u[k - 1]]]))
        imm.update(np.array([[y[k]]]))
        np.testing.assert_allclose(ours.probabilities[k], imm.mu, atol=1e-9)
        np.testing.assert_allclose(ours.means[k], imm.x.ravel(), atol=1e-8)
        np.testing.assert_allclose(ours.covariances[k], imm.P, atol=1e-8)


def test_models_that_never_switch_are_weighed_by_their_evidence_in_fifty_digits() -> None:
    kfs, y = models(3), np.cumsum(np.random.default_rng(1).standard_normal(12))
    y[4] = np.nan
    found = MultipleModelFilter(kfs, np.eye(3)).run(([0.0, 0.0], np.eye(2)), y)
    seen = np.flatnonzero(np.isfinite(y))
    with mp.workdps(50):
        evidence = []
        for one in kfs:
            A, Q, P = (mp.matrix(M.tolist()) for M in (one.A, one.Q, np.eye(2)))
            covariance = [[P]]
            for _ in range(1, 12):
                covariance.append([A * row for row in covariance[-1]] + [A * covariance[-1][-1] * A.T + Q])
            S = mp.matrix([[covariance[max(i, j)][min(i, j)][0, 0] + (mp.mpf(0.3) if i == j else 0) for j in seen] for i in seen])
            z = mp.matrix([mp.mpf(y[i]) for i in seen])
            evidence.append(mp.exp(-(z.T * mp.inverse(S) * z)[0] / 2) / mp.sqrt(mp.det(S)))
        np.testing.assert_allclose(found.probabilities[-1], [float(e / sum(evidence)) for e in evidence], rtol=1e-10)


def test_alike_models_are_one_filter_and_nonlinear_ones_serve_too() -> None:
    kf, y = models()[0], np.cumsum(np.random.default_rng(2).standard_normal(20))
    found = MultipleModelFilter([kf, kf], [[0.9, 0.1], [0.3, 0.7]]).run(([0.0, 0.0], np.eye(2)), y)
    np.testing.assert_allclose(found.means, kf.run(([0.0, 0.0], np.eye(2)), y).means, atol=1e-12)
    bent = [UnscentedKalmanFilter(lambda x: kf.A @ x, lambda x: x[:1], one.Q, 0.3) for one in models()]
    switching = [[0.9, 0.1], [0.2, 0.8]]
    np.testing.assert_allclose(MultipleModelFilter(bent, switching).run(([0.0, 0.0], np.eye(2)), y).means,
                               MultipleModelFilter(models(), switching).run(([0.0, 0.0], np.eye(2)), y).means, atol=1e-9)


@pytest.mark.parametrize("call, sentence", [
    (lambda: MultipleModelFilter(models(1), [[1.0]]), "has 2 to 4"),
    (lambda: MultipleModelFilter(models(), np.ones((2, 2))), "add up to 1"),
    (lambda: MultipleModelFilter(models(), np.eye(3)), "must be 2×2"),
    (lambda: MultipleModelFilter(models(), np.eye(2)).run(([0, 0], 1.0), [1.0], probabilities=[1.0, 1.0]), "numbers that add up to 1")])
def test_models_that_do_not_fit_are_refused(call: object, sentence: str) -> None:
    with pytest.raises(EngineError, match=sentence):
        call()  # type: ignore[operator]
