"""Nonsense for every argument of every public call: one sentence, before any work; never a raw exception, a warning or a wait."""

from __future__ import annotations

import inspect
import sys

import numpy as np
import pytest
from nonsense import cases, findings
from public_calls import ANSWERS, NO_CALLS, calls, public, the_call

from observer_lab import engine
from observer_lab.engine import EngineError, Link, Plant, Scenario, psd

SHARE = 20  # one (call, argument) of so many is fed all nonsense here; `python tests/engine/nonsense.py` feeds them all


def test_every_public_call_has_an_example_here() -> None:
    """Whoever adds a name adds what nonsense is fed to: an argument with a default too."""
    there = public()
    assert not [name for name in there if name not in calls() and name not in ANSWERS | NO_CALLS]
    assert not [name for name in {*ANSWERS, *NO_CALLS, *(n for n in calls() if n.count(".") == 1)} if name not in there]
    for name, arguments in calls().items():
        asked = [p for p in inspect.signature(the_call(name)).parameters if p != "self"]
        assert sorted(asked) == sorted(key for key in arguments if key != "self"), name


def test_the_flat_names_are_those_of_the_rooms() -> None:
    there = public()
    assert not [name for name in engine.__all__ if not any(value is getattr(engine, name) for value in there.values())]


def test_every_public_function_stands_behind_a_gate() -> None:
    take_any = {"plant_files.from_control", "plant_files.from_scipy"}
    bare = [name for name, value in public().items()
            if inspect.isfunction(value) and not hasattr(value, "__wrapped__") and name not in NO_CALLS | take_any]
    assert not bare


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="memory is bounded by the operating system")
@pytest.mark.parametrize("part", range(2))
def test_nonsense_is_one_sentence(part: int) -> None:
    chosen = cases()[part * SHARE // 2::SHARE]
    assert not list(findings(chosen))


@pytest.mark.parametrize("call", [
    lambda: Scenario(Plant([[0]], [[1]], [[1]]), delay=1e9, horizon=1.0),
    lambda: Scenario(Plant([[0]], [[1]], [[1]]), horizon=1e12, dt=1e-3),
    lambda: engine.sampled.Hardware(delay=-1.0), lambda: Link(delay=10**12), lambda: psd(np.ones(100), 1.0, segment=10**12),
    lambda: engine.filters.chi2_band(10**400), lambda: engine.design.sylvester([1, 1], [1], 10**12)])
def test_sizes_without_bounds_are_refused_before_any_work(call: object) -> None:
    with pytest.raises(EngineError):
        call()  # type: ignore[operator]


def test_a_delay_that_is_no_whole_step_is_refused_and_not_rounded() -> None:
    with pytest.raises(EngineError, match="whole number of steps"):
        Scenario(Plant([[0]], [[1]], [[1]]), dt=0.01, delay=0.004)


def test_a_masked_measurement_did_not_arrive() -> None:
    kf = engine.KalmanFilter([[0.9]], [[0]], [[1]], 1.0, 1.0)
    start = engine.Belief([0], [[1]])
    y = np.ma.masked_array([1.0, 9.0, 2.0], mask=[False, True, False])
    np.testing.assert_array_equal(kf.run(start, y).means, kf.run(start, [1.0, np.nan, 2.0]).means)


@pytest.mark.parametrize("P", [[[1.0, 0.5], [0.0, 1.0]], [[1.0, 2.0], [2.0, 1.0]]])
def test_a_start_that_is_no_covariance_is_refused(P: list[list[float]]) -> None:
    kf = engine.KalmanFilter(np.eye(2) / 2, np.zeros((2, 1)), np.eye(2), 1.0, 1.0)
    with pytest.raises(EngineError, match=r"symmetric|negative"):
        kf.run(engine.Belief([0, 0], P), np.zeros((3, 2)))


def test_numbers_that_overflow_are_a_sentence_and_not_a_warning() -> None:
    with pytest.raises(EngineError, match="units"):
        engine.lqr(np.diag([1e200, -1e200]), [[1.0], [1e-200]], np.eye(2) * 1e200, [[1e-200]])


def test_what_comes_step_by_step_comes_whole_through_its_gate() -> None:
    scenario = Scenario(Plant([[-1.0]], [[1]], [[1]]), x0=[1.0], horizon=0.2)
    steps = list(engine.simulation.simulate_starts(scenario, np.ones((2, 2))))
    assert [z.shape for z in steps] == [(2, 2)] * scenario.n_t


def test_a_size_of_zero_is_a_size() -> None:
    with pytest.raises(EngineError, match="0×0"):
        engine.systems.step_covariance(np.zeros((0, 0)), np.eye(3), 0.1)
    assert engine.systems.step_covariance(np.zeros((0, 0)), np.zeros((0, 0)), 0.1).shape == (0, 0)
