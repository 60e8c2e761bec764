"""Simulate loops with sampled controllers and real hardware, one run or many."""

from ..systems.gates.room_gates import with_gates
from .hardware import Hardware, coil_driver
from .lqg_sampled import SampledLqg, SampledRun, sampled_cost, sampled_lqg
from .mechanics import thin_root
from .monte_carlo import MonteCarlo, simulate_trials, welch_expectation
from .sampled_control import SampledController, recursive_controller, sampled_controller
from .sampled_loop import SampledLoop, sampled_loop
from .sampled_spectrum import MechanicsResponse, loop_density, mechanics_response
from .trial import ResponseMeasures, Trial, response_measures, simulate_trial, trial_draws

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

with_gates(globals())
