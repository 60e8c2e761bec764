"""Loop transfer recovery: margins come back, except where a zero forbids it."""

import numpy as np
import pytest
from doyle_loop import DOYLE, ONES

from observer_lab.engine import Plant, lqe, lqr, recover
from observer_lab.engine.feedback import recover_at_output
from observer_lab.engine.systems import transmission_zeros


def test_recovery_brings_doyles_margins_back():
    K = lqr(DOYLE.A, DOYLE.B, ONES, 1).gain
    steps = [recover(DOYLE, K, 1.0, 1.0, q, G=[[1], [1]]) for q in (0, 10, 1e3, 1e5, 1e7)]
    gaps = [step.gap for step in steps]
    assert (np.diff(gaps) < 0).all() and gaps[-1] < 3e-3
    channel, target = steps[-1].margins.inputs[0], steps[-1].target.inputs[0]
    assert target.gain[1] == np.inf and target.phase >= np.pi / 3 - 1e-9
    assert channel.phase == pytest.approx(target.phase, abs=0.01)
    assert channel.gain[0] == pytest.approx(target.gain[0], abs=0.01) and channel.gain[1] > 100
    assert steps[0].margins.inputs[0].gain[1] == pytest.approx(1 + 1 / (2 + np.sqrt(5)) ** 2)
    assert steps[0].minimum_phase is True


def test_right_half_plane_zero_forbids_recovery():
    """P = (1 − s)/((s + 1)(s + 2)): the gap stays."""
    plant = Plant([[0, 1], [-2, -3]], [[0], [1]], [[1, -1]])
    np.testing.assert_allclose(transmission_zeros(plant), [1.0], atol=1e-9)
    K = lqr(plant.A, plant.B, 100 * np.eye(2), 1).gain
    steps = [recover(plant, K, 1.0, 1.0, q) for q in (0, 1e3, 1e6)]
    assert steps[-1].minimum_phase is False and steps[-1].gap > 0.3


def test_recovery_at_the_output_is_the_dual_problem():
    """Mirror plant, gain and noise: the margins at the input of one are those at the output of the other."""
    rng = np.random.default_rng(3)
    plant = Plant(rng.standard_normal((3, 3)), rng.standard_normal((3, 1)), rng.standard_normal((1, 3)))
    L = lqe(plant.A, np.eye(3), plant.C, np.eye(3), 1.0).gain
    one = recover_at_output(plant, L, np.eye(3), 1.0, 50.0)
    twin = recover(plant.dual(), L.T, 1.0, 1.0, 50.0, G=np.eye(3))
    np.testing.assert_allclose(one.gain_K, twin.gain_L.T, rtol=1e-9)
    assert one.gap == pytest.approx(twin.gap, rel=1e-6)
    assert one.margins.outputs[0].disk.alpha == pytest.approx(twin.margins.inputs[0].disk.alpha, rel=1e-6)
    assert one.target.inputs[0].phase == pytest.approx(twin.target.inputs[0].phase, rel=1e-6)


def test_zeros_of_a_plant_with_two_inputs():
    """Two decoupled channels (s − 2)/(s + 1)² and (s + 3)/(s + 4)², and one input with two outputs that has none to give."""
    A = np.array([[0, 1, 0, 0], [-1, -2, 0, 0], [0, 0, 0, 1], [0, 0, -16, -8]])
    B, C = np.array([[0, 0], [1, 0], [0, 0], [0, 1]]), np.array([[-2, 1, 0, 0], [0, 0, 3, 1]])
    np.testing.assert_allclose(transmission_zeros(Plant(A, B, C)), [-3, 2], atol=1e-8)
    assert transmission_zeros(Plant(A, B[:, :1], C)) is None
