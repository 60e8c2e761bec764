"""Declare the argument checks of the public calls of `engine.sampled`."""

from __future__ import annotations

from ..filters.belief import Belief
from ..filters.linear_filter import LinearFilter
from ..systems.argument_checks import (
    FINITE,
    SECONDS,
    SEED,
    SERIES,
    array,
    choice,
    count,
    covariance,
    gated,
    instance,
    items,
    matrix,
    number,
    pair,
)
from ..systems.plant import Plant
from . import lqg_sampled, monte_carlo, sampled_control, sampled_spectrum, trial
from .hardware import Hardware
from .hardware import coil_driver as _coil_driver
from .mechanics import thin_root as _thin_root
from .sampled_loop import SampledLoop as SampledLoop
from .sampled_loop import sampled_loop as _sampled_loop

_PLANT, _LOOP, _HARDWARE = instance(Plant), instance(SampledLoop), instance(Hardware)
_STEPS = count(1, 10_000_000)

coil_driver = gated(hardware=_HARDWARE, coils=count(1, 1000))(_coil_driver)
mechanics_response = gated(loop=_LOOP, frequency=SERIES)(sampled_spectrum.mechanics_response)
loop_density = gated(loop=_LOOP, mechanics=instance(sampled_spectrum.MechanicsResponse))(sampled_spectrum.loop_density)
recursive_controller = gated(estimator=instance(LinearFilter), K=matrix(), start=instance(Belief), steps=count(1, 100_000),
                             told=choice("commanded", "applied"))(sampled_control.recursive_controller)
sampled_controller = gated(controller=_PLANT, dt=SECONDS, method=choice("tustin", "hold"))(sampled_control.sampled_controller)
sampled_cost = gated(plant=_PLANT, Q=covariance("n"), R=covariance("m"), dt=SECONDS)(lqg_sampled.sampled_cost)
sampled_lqg = gated(plant=_PLANT, Q=covariance("n"), R=covariance("m"), W=covariance(), V=covariance("p"), dt=SECONDS, G=matrix())(
    lqg_sampled.sampled_lqg)
sampled_loop = gated(plant=_PLANT, controller=instance(sampled_control.SampledController), controls=items(count(-1000), 1000),
                     hardware=_HARDWARE, W=covariance(), V=covariance("p"), shaping=instance(Plant), disturbances=matrix(),
                     outputs=matrix())(_sampled_loop)
simulate_trial = gated(loop=_LOOP, steps=_STEPS, seed=SEED, start=matrix(), disturbance=matrix(),
                       kicks=items(pair(count(0), matrix())))(trial.simulate_trial)
simulate_trials = gated(loop=_LOOP, runs=count(1, 100_000), seconds=SECONDS, seed=SEED, segment=_STEPS, together=count(1, 100_000))(
    monte_carlo.simulate_trials)
response_measures = gated(t=array(), y=array(), u=array(), band=number(0), final=FINITE)(trial.response_measures)
trial_draws = gated(loop=_LOOP, steps=_STEPS, seed=SEED)(trial.trial_draws)
thin_root = gated(Q=matrix("n n"))(_thin_root)
welch_expectation = gated(loop=_LOOP, length=count(2, 1_000_000))(monte_carlo.welch_expectation)
