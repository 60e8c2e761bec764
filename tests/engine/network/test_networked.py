"""The loop over packets: optimal re-ordering, held and zeroed inputs, and when separation survives a delay."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

from observer_lab.engine import Belief, EngineError, KalmanFilter, Link, NetworkScenario, Plant, ShapeError, dlqe, dlqr, simulate_network
from observer_lab.engine.network import NetworkRun, delayed_loop, mean_square_growth, network_meter, newest_packet_age, promised_error

A = np.array([[1.1, 0.3], [0.0, 0.9]])
B = np.array([[0.1], [1.0]])
C = np.array([[1.0, 0.0]])
Q, R = np.diag([0.01, 0.02]), np.array([[0.05]])
PLANT = Plant(A, B, C, dt=0.1)
K = dlqr(A, B, np.eye(2), np.eye(1)).gain
STEADY = dlqe(A, np.eye(2), C, Q, R)


def scenario(**more: Any) -> NetworkScenario:
    given: dict[str, Any] = dict(plant=PLANT, K=K, Q=Q, R=R, P0=STEADY.solution, x0=[1.0, 0.0], steps=60, seed=5)
    return NetworkScenario(**(given | more))


def filtered(run: NetworkRun, k: int, u: np.ndarray) -> Belief:
    """x̂[k] and P[k] of a fresh Kalman filter on what has arrived by sample k, everything else NaN."""
    s = run.scenario
    arrived = (run.sensed >= 0) & (run.sensed <= k)
    record = np.where(arrived[:, None], run.y, np.nan)[:k + 1]
    start = Belief(s.x0 - run.draw.e0, s.P0)
    return KalmanFilter(A, B, C, Q, R).run(start, record, u[:k + 1]).last


# --- estimates -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("link", [Link(), Link(0.5), Link(0.2, 3), Link(0.3, 1, 4)],
                         ids=["ideal", "loss", "late", "late and out of order"])
def test_at_every_sample_the_estimate_is_the_optimal_one_of_what_has_arrived(link: Link) -> None:
    run = simulate_network(scenario(sensor=link, actuator=Link(0.3)))
    for k in (0, 1, 2, 7, 30, 59):
        best = filtered(run, k, run.u_applied)
        assert run.xhat[k] == pytest.approx(best.mean, abs=1e-10)
        assert run.P[k] == pytest.approx(best.covariance, rel=1e-9)


@pytest.mark.slow
def test_the_promised_covariance_is_the_one_that_many_runs_have() -> None:
    link = Link(0.3, 1, 3)
    total, believed = np.zeros((2, 2)), np.zeros((2, 2))
    for seed in range(400):
        run = simulate_network(scenario(sensor=link, steps=25, seed=seed))
        total += np.outer(run.e[-1], run.e[-1])
        believed += run.P[-1]
    assert np.trace(total) / np.trace(believed) == pytest.approx(1, abs=0.2)  # 400 runs: about ±7 %


def test_taking_packets_as_they_come_is_worse_than_reading_their_time_stamps() -> None:
    def late_error(order: Any) -> float:
        runs = [simulate_network(scenario(sensor=Link(0.1, 1, 3), order=order, seed=seed)) for seed in range(20)]
        return float(np.mean([np.sum(run.e[20:] ** 2) for run in runs]))
    assert late_error("arrival") > 3 * late_error("stamped")


# --- packets -----------------------------------------------------------------------------------------------------------
def test_a_larger_loss_loses_all_that_a_smaller_one_loses_and_every_delay_is_kept_to() -> None:
    few, many = (Link(p, 2, 3).draw(5000, np.random.default_rng(3)) for p in (0.2, 0.6))
    assert np.all(many[few == -1] == -1)
    assert np.mean(few == -1) == pytest.approx(0.2, abs=0.02)
    late = (few - np.arange(5000))[few >= 0]
    assert set(late) == {2, 3, 4, 5}
    assert np.bincount(late)[2:] / len(late) == pytest.approx([0.25] * 4, abs=0.03)


def test_age_of_the_newest_packet_by_hand() -> None:
    # packet 0 comes at 2, packet 1 at 1, packet 2 is lost, packet 3 at 5, packet 4 at 5
    assert newest_packet_age(np.array([2, 1, -1, 5, 5, -1])).tolist() == [1, 0, 1, 2, 3, 1]


def test_a_lost_input_is_held_or_zero() -> None:
    held = simulate_network(scenario(actuator=Link(0.5)))
    zeroed = simulate_network(scenario(actuator=Link(0.5), on_loss="zero"))
    assert np.array_equal(held.acted, zeroed.acted) and not held.fresh.all()
    for k in range(60):
        before = held.u_applied[k - 1] if k else np.zeros(1)
        assert np.array_equal(held.u_applied[k], held.u_asked[k] if held.fresh[k] else before)
        assert np.array_equal(zeroed.u_applied[k], zeroed.u_asked[k] if zeroed.fresh[k] else np.zeros(1))


def test_noise_and_packets_have_streams_of_their_own() -> None:
    one, other = simulate_network(scenario()), simulate_network(scenario(sensor=Link(0.4), actuator=Link(0.2, 1)))
    assert np.array_equal(one.draw.w, other.draw.w) and np.array_equal(one.draw.v, other.draw.v)
    again = simulate_network(scenario(sensor=Link(0.4), actuator=Link(0.2, 1)))
    assert np.array_equal(other.x, again.x)
    assert not np.array_equal(one.draw.w, simulate_network(scenario(seed=6)).draw.w)


def test_a_runaway_ends_early_and_is_finite() -> None:
    run = simulate_network(scenario(K=-8 * np.sign(K), steps=400))
    assert run.diverged_at is not None and len(run.x) < 400
    assert all(np.isfinite(v).all() for v in (run.x, run.e, run.u_asked, run.P, run.prior))


# --- separation --------------------------------------------------------------------------------------------------------
def test_a_delay_that_the_observer_does_not_know_breaks_separation_and_knowing_it_restores_it() -> None:
    late = Link(0.0, 2)
    unknown = simulate_network(scenario(actuator=late, told="asked"))
    known = simulate_network(scenario(actuator=late))
    assert network_meter(simulate_network(scenario())) < 1e-12
    assert network_meter(unknown) > 0.5
    assert network_meter(known) < 1e-12
    assert known.e == pytest.approx(promised_error(unknown), abs=1e-11)


def test_the_error_of_an_observer_that_is_told_is_the_same_under_every_controller() -> None:
    lossy = dict(sensor=Link(0.4, 1, 2), actuator=Link(0.3, 1))
    runs = [simulate_network(scenario(K=factor * K, **lossy)) for factor in (1.0, 0.5, 0.0)]
    for run in runs[1:]:
        count = min(len(run.e), len(runs[0].e))
        assert run.e[:count] == pytest.approx(runs[0].e[:count], abs=1e-9)


def test_a_lost_input_of_which_the_observer_hears_nothing_breaks_separation_too() -> None:
    assert network_meter(simulate_network(scenario(actuator=Link(0.3), told="asked"))) > 0.1
    assert network_meter(simulate_network(scenario(actuator=Link(0.3)))) < 1e-12
    assert network_meter(simulate_network(scenario(sensor=Link(0.0, 2), order="arrival"))) > 0.1
    assert network_meter(simulate_network(scenario(sensor=Link(0.0, 2)))) < 1e-12


def test_a_loop_that_runs_away_on_a_known_delay_still_separates() -> None:
    """The states grow to 1e9 and x − x̂ with them only by rounding."""
    away = dict(K=-8 * np.sign(K), steps=400, actuator=Link(0.0, 2))
    assert network_meter(simulate_network(scenario(**away))) == 0.0
    assert network_meter(simulate_network(scenario(**away, told="asked"))) > 1e3


def nearest(values: np.ndarray, wanted: np.ndarray) -> float:
    """How far the wanted poles are from the values, taken greedily."""
    left, worst = list(values), 0.0
    for pole in wanted:
        best = min(left, key=lambda v: abs(v - pole))
        worst = max(worst, abs(best - pole))
        left.remove(best)
    return worst


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_the_lower_left_block_is_zero_exactly_where_the_observer_is_told(delay: int) -> None:
    N = 2 + delay
    told = delayed_loop(PLANT, K, STEADY.filter_gain, delay)
    untold = delayed_loop(PLANT, K, STEADY.filter_gain, delay, told="asked")
    assert not told[N:, :N].any()
    assert bool(untold[N:, :N].any()) == (delay > 0)
    assert nearest(np.linalg.eigvals(told), STEADY.poles) < 1e-9
    if delay:
        assert nearest(np.linalg.eigvals(untold), STEADY.poles) > 0.05


@pytest.mark.parametrize("delay", [1, 2, 3])
def test_predicting_over_the_delay_brings_the_chosen_spectrum_back(delay: int) -> None:
    poles = np.linalg.eigvals(delayed_loop(PLANT, K, STEADY.filter_gain, delay, told="applied", ahead=delay))
    chosen = np.concatenate([np.linalg.eigvals(A - B @ K), STEADY.poles])
    assert nearest(poles, chosen) < 1e-9
    assert np.sort(np.abs(poles))[:delay].max() < 1e-4  # the rest: the delay itself, at zero


@pytest.mark.parametrize(("told", "ahead"), [("asked", 0), ("applied", 0), ("applied", 1), ("applied", 2)])
def test_the_matrix_is_the_loop_that_is_simulated(told: Any, ahead: int) -> None:
    """With hardly any noise; the gain depends on the ratio of the covariances alone."""
    tiny = 1e-18
    run = simulate_network(scenario(Q=tiny * Q, R=tiny * R, P0=tiny * STEADY.solution, steps=25, actuator=Link(0.0, 2),
                                    told=told, ahead=ahead))
    F = delayed_loop(PLANT, K, STEADY.filter_gain, 2, told=told, ahead=ahead)
    z = np.concatenate([run.x[0], np.zeros(2), run.draw.e0])
    for k in range(25):
        assert z[:2] == pytest.approx(run.x[k], abs=1e-7)
        assert (np.eye(2) - STEADY.filter_gain @ C) @ z[4:] == pytest.approx(run.e[k], abs=1e-7)
        z = F @ z
    assert (float(np.abs(run.e).max()) > 0.1) == (told == "asked")


# --- lossy inputs on average ---------------------------------------------------------------------------------------------
def test_zeroed_inputs_with_a_deadbeat_gain_have_the_critical_loss_of_the_filter() -> None:
    a = 1.4
    plant = Plant(np.array([[a]]), np.eye(1), np.eye(1), dt=1.0)
    for loss in (0.2, 1 / a**2, 0.8):
        assert mean_square_growth(plant, np.array([[a]]), loss, "zero") == pytest.approx(loss * a**2, rel=1e-12)
    k = 0.9
    assert mean_square_growth(plant, np.array([[k]]), 0.3, "zero") == pytest.approx(0.7 * (a - k) ** 2 + 0.3 * a**2)


@pytest.mark.parametrize("on_loss", ["hold", "zero"])
def test_the_growth_is_that_of_the_second_moment(on_loss: Any) -> None:
    """E zzᵀ, z = (x, last input), exact over all 2^10 patterns, then step by step until its growth has settled."""
    loss, hold = 0.4, np.array([[0.0 if on_loss == "zero" else 1.0]])
    heard = np.block([[A - B @ K, np.zeros((2, 1))], [-K, np.zeros((1, 1))]])
    lost = np.block([[A, B @ hold], [np.zeros((1, 2)), hold]])
    records = np.array(list(product((False, True), repeat=10)))
    weight = np.prod(np.where(records, 1 - loss, loss), axis=1)
    z = np.tile([1.0, 0.5, 0.2], (len(records), 1))
    X = np.outer(z[0], z[0])
    for k in range(10):
        z = np.where(records[:, k, None], z @ heard.T, z @ lost.T)
        X = (1 - loss) * heard @ X @ heard.T + loss * lost @ X @ lost.T
    assert np.einsum("r,ri,rj->ij", weight, z, z) == pytest.approx(X, rel=1e-10)
    for _ in range(300):
        last, X = np.trace(X), (1 - loss) * heard @ X @ heard.T + loss * lost @ X @ lost.T
    assert np.trace(X) / last == pytest.approx(mean_square_growth(PLANT, K, loss, on_loss), rel=1e-6)


# --- bad input -----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("bad", [
    dict(plant=Plant(A, B, C)), dict(steps=0), dict(ahead=-1), dict(told="maybe"), dict(order="any"), dict(on_loss="drop"),
    dict(plant=Plant(A, B, C, np.eye(1), dt=0.1)),
])
def test_what_makes_no_sense_is_refused_in_one_sentence(bad: dict[str, Any]) -> None:
    with pytest.raises(EngineError):
        scenario(**bad)


def test_wrong_shapes_and_links_are_refused() -> None:
    for bad in (dict(K=[[1.0]]), dict(x0=[1.0]), dict(jumps=np.zeros((3, 2)))):
        with pytest.raises(ShapeError):
            scenario(**bad)
    for loss, delay, jitter in ((1.2, 0, 0), (0.1, -1, 0), (0.1, 0, -1), (0.1, 60, 10)):
        with pytest.raises(EngineError):
            Link(loss, delay, jitter)
    with pytest.raises(EngineError):
        delayed_loop(PLANT, K, STEADY.filter_gain, 1, told="applied", ahead=2)


def test_half_a_sample_of_delay_is_refused_and_a_loss_is_a_probability() -> None:
    for delay, jitter in ((0.5, 0), (0, 1.5), (float("nan"), 0)):
        with pytest.raises(EngineError, match="whole number"):
            Link(0.1, delay, jitter)  # type: ignore[arg-type]
    with pytest.raises(EngineError, match="whole number"):
        scenario(steps=2.5)
    for loss in (1.5, float("nan")):
        with pytest.raises(EngineError, match="loss"):
            mean_square_growth(PLANT, K, loss, "hold")
    with pytest.raises(EngineError, match="on_loss"):
        mean_square_growth(PLANT, K, 0.1, "drop")  # type: ignore[arg-type]
    with pytest.raises(ShapeError):
        delayed_loop(PLANT, K[:, :1], STEADY.filter_gain, 1)


def test_a_known_start_with_perfect_sensors_is_not_a_run_that_diverged() -> None:
    with pytest.raises(EngineError, match="innovation is singular"):
        simulate_network(scenario(P0=0.0, R=0.0))


def test_nobody_predicts_over_inputs_that_have_been_applied_already() -> None:
    """Ahead of the delay each such input was counted twice: in the estimate, and once more in the prediction."""
    with pytest.raises(EngineError, match="farther than the delay"):
        scenario(ahead=2, actuator=Link(delay=1))
    assert scenario(ahead=2, actuator=Link(delay=1, jitter=1)).ahead == 2
