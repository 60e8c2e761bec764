"""Declare the argument checks of the public calls of `engine.observers`."""

from __future__ import annotations

from types import MappingProxyType

from ..filters.linear_filter import LinearFilter
from ..systems.argument_checks import (
    FUNCTION,
    LEVEL,
    NAME,
    POLES,
    SECONDS,
    SEED,
    SERIES,
    SHARE,
    array,
    choice,
    count,
    either,
    gated,
    instance,
    items,
    matrix,
    number,
    optional,
    pair,
    vector,
)
from ..systems.plant import Plant
from . import bilinear, bilinear_run, bilinear_steps, fault_bank, functional, functional_loop, perturbation, unknown_input
from .existence import Existence as Existence  # through the door: its module has the name of a call
from .existence import existence as _existence
from .residual_threshold import alarm_probability as _alarm_probability
from .residual_threshold import binomial_band as _binomial_band
from .residual_threshold import needed_noncentrality as _needed_noncentrality
from .residual_threshold import residual_threshold as _residual_threshold
from .residual_threshold import window_energy as _window_energy
from .residual_threshold import window_mean as _window_mean
from .rlo import Attempt as Attempt  # through the door: their module has the name of a call
from .rlo import Region as Region
from .rlo import RobustObserver as RobustObserver
from .rlo import rlo as _rlo
from .rlo import rlo_steps as _rlo_steps

_PLANT, _OBSERVER = instance(Plant), instance(functional.FunctionalObserver)
_WRONG, _NORM = instance(perturbation.Perturbations), choice(1, 2, "inf")
_MATRIX, _MAYBE = matrix(), optional(matrix())
_ERRORS = MappingProxyType({"dA": _MAYBE, "dB": _MAYBE, "dC": _MAYBE})
_INDICES = items(count(), 1000)
_DOF, _WINDOW = number(0, 1e6), count(1)
_SEARCH = MappingProxyType({"plant": _PLANT, "K": _MATRIX, "wrong": _WRONG, "norm": _NORM, "max_order": optional(count(1, 1000)),
                            "measure": FUNCTION, "region": optional(either(Region, items(instance(Region), 1000))),
                            "seed": SEED, "worst_condition": number(1)})

bilinear_functional_observer = gated(A=_MATRIX, B=_MATRIX, F=_MATRIX, C=_MATRIX, K=_MATRIX, pole=POLES)(
    bilinear_steps.bilinear_functional_observer)
simulate_bilinear = gated(plant=instance(bilinear.BilinearPlant), form=instance(bilinear.BilinearForm), K=_MATRIX, u=FUNCTION, x0=_MATRIX,
                          z0=_MATRIX, horizon=SECONDS, dt=SECONDS, noise=_MAYBE)(bilinear_run.simulate_bilinear)
alarm_probability = gated(noncentrality=array(), dof=_DOF, false_alarm=SHARE)(_alarm_probability)
binomial_band = gated(count=count(1, 10**9), rate=SHARE, level=LEVEL)(_binomial_band)
needed_noncentrality = gated(dof=_DOF, false_alarm=SHARE, power=SHARE)(_needed_noncentrality)
residual_threshold = gated(dof=_DOF, false_alarm=SHARE)(_residual_threshold)
window_energy = gated(residual=array(missing=True), window=_WINDOW)(_window_energy)
window_mean = gated(residual=array(missing=True), window=_WINDOW)(_window_mean)
criterion = gated(T=matrix("q n"), L=matrix("q p"), M=matrix("r p"), wrong=_WRONG, norm=_NORM)(perturbation.criterion)
every_entry = gated(plant=_PLANT)(perturbation.every_entry)
perturbations = gated(plant=_PLANT, A=array(), C=array(), alpha=vector(), beta=vector(), gamma=vector())(perturbation.perturbations)
vertices = gated(wrong=_WRONG, delta_A=vector(), delta_C=vector())(perturbation.vertices)
decoupling = gated(plant=_PLANT, E=matrix("n d"), weight=_MAYBE)(unknown_input.decoupling)
unknown_input_observer = gated(plant=_PLANT, E=matrix("n d"), poles=POLES)(unknown_input.unknown_input_observer)
error_index = gated(observer=_OBSERVER, wrong=_WRONG)(functional_loop.error_index)
error_transfer = gated(observer=_OBSERVER, omega=SERIES, dA=_MAYBE, dC=_MAYBE)(functional_loop.error_transfer)
peak_gain = gated(A=matrix("n n"), B=matrix("n m"), C=matrix("p n"), D=matrix("p m"))(functional_loop.peak_gain)
perturbed_loop = gated(observer=_OBSERVER, **_ERRORS)(functional_loop.perturbed_loop)
simulate_functional = gated(observer=_OBSERVER, v=optional(FUNCTION), x0=_MAYBE, z0=_MAYBE, horizon=SECONDS, dt=SECONDS, **_ERRORS)(
    functional_loop.simulate_functional)
worst_error_gain = gated(observer=_OBSERVER, errors=items(pair(_MATRIX, matrix()), 1_000_000))(functional_loop.worst_error_gain)
functional_observer = gated(plant=_PLANT, K=_MATRIX, order=count(-1000), poles=POLES, directions=array(imaginary=True), W=_MATRIX,
                            free=_MATRIX, wrong=_WRONG, norm=_NORM)(functional.functional_observer)
existence = gated(plant=_PLANT, K=_MATRIX, poles=POLES)(_existence)
isolate = gated(alarms=array(), signature=array())(fault_bank.isolate)
residual_generator = gated(model=instance(LinearFilter), name=NAME, outputs=_INDICES, E=_MATRIX)(fault_bank.residual_generator)
rlo = gated(**_SEARCH)(_rlo)
rlo_steps = gated(**_SEARCH)(_rlo_steps)
