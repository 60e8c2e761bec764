"""Simulate loops with sampled controllers and real hardware, one run or many."""

from .door import (
    SampledLoop,
    coil_driver,
    loop_density,
    mechanics_response,
    recursive_controller,
    response_measures,
    sampled_controller,
    sampled_cost,
    sampled_loop,
    sampled_lqg,
    simulate_trial,
    simulate_trials,
    thin_root,
    trial_draws,
    welch_expectation,
)
from .hardware import Hardware
from .lqg_sampled import SampledLqg, SampledRun
from .monte_carlo import MonteCarlo
from .sampled_control import SampledController
from .sampled_spectrum import MechanicsResponse
from .trial import ResponseMeasures, Trial

__all__ = [
    "Hardware",
    "MechanicsResponse",
    "MonteCarlo",
    "ResponseMeasures",
    "SampledController",
    "SampledLoop",
    "SampledLqg",
    "SampledRun",
    "Trial",
    "coil_driver",
    "loop_density",
    "mechanics_response",
    "recursive_controller",
    "response_measures",
    "sampled_controller",
    "sampled_cost",
    "sampled_loop",
    "sampled_lqg",
    "simulate_trial",
    "simulate_trials",
    "thin_root",
    "trial_draws",
    "welch_expectation",
]
