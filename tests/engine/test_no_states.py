"""A plant without states, y = D u, is a plant: what asks nothing of states answers, what designs a gain refuses in one sentence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from observer_lab.engine import EngineError, Plant, Scenario, compensator, dlqr, lqe, lqr, observer_gain, place, simulate
from observer_lab.engine.feedback import loop_margins, recover, recover_at_output, sensitivity
from observer_lab.engine.simulation import separation_meter, simulate_until

K, L = np.zeros((1, 0)), np.zeros((0, 1))
GAIN = Plant(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), [[2.0]])
SAMPLED = replace(GAIN, dt=0.1)
LAG = Plant([[-1.0]], [[1.0]], [[1.0]])
RAMP = np.linspace(-1.5, 1.5, 11)[:, None]


@pytest.mark.parametrize("plant", [GAIN, SAMPLED])
@pytest.mark.parametrize("limit", [np.inf, 1.0])
@pytest.mark.parametrize("delay", [0.0, 0.2])
def test_a_gain_runs_as_its_input_asks(plant: Plant, limit: float, delay: float) -> None:
    run = simulate(Scenario(plant, K=K, L=L, horizon=1.0, dt=0.1, reference=RAMP, u_min=-limit, u_max=limit, delay=delay))
    late = round(delay / 0.1)
    clipped = np.clip(RAMP, -limit, limit)
    np.testing.assert_allclose(run.y[late:], 2 * clipped[:len(RAMP) - late], atol=1e-12)
    assert run.x.shape == run.e.shape == (11, 0) and run.diverged_at is None


def test_what_is_asked_of_a_run_has_an_answer() -> None:
    scenario = Scenario(GAIN, K=K, L=L, horizon=1.0, dt=0.1, reference=RAMP, u_min=-1.0, u_max=1.0, V=[[1.0]])
    assert separation_meter(simulate(scenario)) == 0.0
    assert len(simulate_until(scenario, [0.5], lambda x: True).t) <= 11


def test_loops_of_a_gain_have_sensitivities_and_margins() -> None:
    """L = 2/(s + 1) with both parts in turn as the plant: |S| is largest, 1, at high frequency."""
    for plant, controller in ((GAIN, LAG), (LAG, GAIN)):
        negative = Plant(controller.A, controller.B, -controller.C, -np.asarray(controller.D))
        loop = sensitivity(plant, negative)
        np.testing.assert_allclose(np.abs(loop.at([1.0]))[0, :1, :1], abs(1 / (1 + 2 / (1 + 1j))), rtol=1e-12)
        assert loop_margins(plant, negative).loop.omega.size
    assert compensator(GAIN, K, L).n == 0
    assert loop_margins(GAIN, compensator(GAIN, K, L)).loop.omega.size


@pytest.mark.parametrize("design", [
    lambda: place(GAIN, []), lambda: observer_gain(GAIN, []), lambda: lqr(GAIN.A, GAIN.B, np.zeros((0, 0)), [[1]]),
    lambda: dlqr(SAMPLED.A, SAMPLED.B, np.zeros((0, 0)), [[1]]), lambda: lqe(GAIN.A, np.zeros((0, 1)), GAIN.C, [[1]], [[1]]),
    lambda: recover(GAIN, K, [[1]], [[1]], 1.0), lambda: recover_at_output(GAIN, L, np.zeros((0, 0)), [[1]], 1.0)])
def test_no_gain_is_designed_for_no_states(design) -> None:
    with pytest.raises(EngineError, match="The plant has no states"):
        design()
