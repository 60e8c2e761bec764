"""Placement knows no unit: no jump of the gain with a state's unit, and the same verdicts whatever the unit of time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import place_poles

from observer_lab.engine import EngineError, Plant, RiccatiError, lqr, observer_gain, place
from observer_lab.engine.structure import controllability, observability, split_stable
from observer_lab.engine.systems import is_stable, transmission_zeros

STEP = 1.12  # of a unit
TIMES = (1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9)
CHAIN = np.array([[0, 0, 0, 0], [1, 10, 100, 1000], [0, 1, 10, 100], [0, 0, 1, 10.0]]), np.eye(4, 2)


def test_the_gain_of_a_graded_chain_is_as_small_as_that_of_a_peer() -> None:
    poles = np.arange(-4.0, 0.0)
    ours = np.linalg.norm(place(*CHAIN, poles).gain, 2)
    assert ours <= 1.1 * 6.6e3
    assert ours <= 1.1 * np.linalg.norm(place_poles(*CHAIN, poles, method="YT").gain_matrix, 2)


@settings(max_examples=4, derandomize=True, database=None, deadline=None)
@given(st.integers(0, 10_000), st.integers(3, 5))
def test_a_slowly_changed_unit_of_a_state_never_makes_the_gain_jump(seed: int, n: int) -> None:
    """‖K‖ of one feedback changes by 1.12 at most from step to step; another one may be taken where it is 1.5 times smaller."""
    rng = np.random.default_rng(seed)
    grade, poles = 10.0 ** rng.uniform(-2, 2, n), -np.arange(1.0, n + 1)
    A, B = rng.standard_normal((n, n)) * grade / grade[:, None], rng.standard_normal((n, 2)) / grade[:, None]
    state, sizes = rng.integers(n), []
    for k in range(-12, 13):
        unit = np.ones(n)
        unit[state] = STEP**k
        sizes.append(np.linalg.norm(place(A * unit / unit[:, None], B / unit[:, None], poles).gain))
    change = np.abs(np.diff(np.log(sizes)))
    assert np.exp(change.max()) < 1.8, np.exp(change)


def test_the_printed_chain_does_not_jump_with_the_unit_of_its_first_state() -> None:
    sizes = []
    for unit in STEP ** np.arange(-30.0, 30.0):
        scale = np.array([unit, 1, 1, 1])
        sizes.append(np.linalg.norm(place(CHAIN[0] * scale / scale[:, None], CHAIN[1] / scale[:, None], np.arange(-4.0, 0.0)).gain))
    assert np.exp(np.abs(np.diff(np.log(sizes))).max()) < 1.8


def _verdict(call, *arguments) -> str:
    try:
        call(*arguments)
    except EngineError as problem:
        return type(problem).__name__
    return "found"


def _verdicts(A: np.ndarray, B: np.ndarray, C: np.ndarray, poles: np.ndarray, time: float) -> list[object]:
    """What the engine decides of a plant whose seconds are 1/time long."""
    A, B, poles = A * time, B * time, poles * time
    plant, n = Plant(A, B, C), len(A)
    seen, reached, zeros = observability(plant), controllability(plant), transmission_zeros(plant)
    return [_verdict(place, A, B, poles), _verdict(observer_gain, A, C, poles), seen.rank, reached.rank, seen.detectable,
            reached.stabilizable, len(seen.unobservable), is_stable(A), split_stable(plant).stable.n,
            None if zeros is None else (len(zeros), int(np.count_nonzero(zeros.real > 0))),
            _verdict(lqr, A, B, np.eye(n), np.eye(B.shape[1])), sorted(mode.visible for mode in seen.modes)]


@settings(max_examples=6, derandomize=True, database=None, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 3), st.integers(0, 2), st.booleans(), st.booleans())
def test_no_verdict_depends_on_the_unit_of_time(seed: int, free: int, hidden: int, grows: bool, asked: bool) -> None:
    rng = np.random.default_rng(seed)
    n = free + hidden
    own = -10.0 ** rng.uniform(-1, 1, hidden) * ([-1, 1] if grows else [1, 1])[:hidden]
    A = np.zeros((n, n))
    A[:free, :free], A[free:, free:] = rng.standard_normal((free, free)), np.diag(own)
    B = np.vstack([rng.standard_normal((free, 1)), np.zeros((hidden, 1))])
    C = np.hstack([rng.standard_normal((1, free)), np.zeros((1, hidden))])
    T = np.linalg.qr(rng.standard_normal((n, n)))[0]
    poles = np.concatenate([-np.arange(1.0, free + 1), own if asked else -np.abs(own) - 3])
    found = [_verdicts(T @ A @ T.T, T @ B, C @ T.T, poles, time) for time in TIMES]
    assert all(one == found[0] for one in found), found
    assert found[0][0] == ("found" if asked or not hidden else "PoleError")


@pytest.mark.parametrize("time", [1e-9, 1.0, 1e6, 1e9])
@pytest.mark.parametrize("call, through", [(place, [[0], [1]]), (observer_gain, [[0, 1]])])
def test_a_slow_mode_that_cannot_be_moved_is_named_in_any_unit_of_time(call, through, time: float) -> None:
    A = np.diag([5e-6, -1e-6]) * time
    with pytest.raises(EngineError, match=r"no [KL] can move it"):
        call(A, through, np.array([-5e-6, -2e-6]) * time)
    assert call(A, through, np.array([5e-6, -2e-6]) * time).gain.any()


def test_the_unstable_slow_mode_of_a_regulator_is_named_too() -> None:
    with pytest.raises(RiccatiError, match="not stable and is uncontrollable"):
        lqr(np.diag([5e-6, -1e-6]), [[0], [1]], np.eye(2), [[1]])
