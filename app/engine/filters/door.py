"""Declare the argument checks of the public calls of `engine.filters`."""

from __future__ import annotations

from types import MappingProxyType

from ..systems.argument_checks import (
    BOOLEAN,
    GENERATOR,
    LEVEL,
    MOST_NUMBERS,
    NAME,
    POSITIVE,
    RECORD,
    SECONDS,
    SEED,
    SERIES,
    array,
    choice,
    count,
    covariance,
    gated,
    gated_runs,
    instance,
    matrix,
    number,
    optional,
    pair,
    vector,
)
from ..systems.flow import NonlinearPlant
from ..systems.plant import Plant
from . import (
    adc,
    bound,
    consistency,
    experiment,
    filter_trial,
    kalman,
    many_runs,
    sigma_points,
    slopes,
    squared_error,
    track,
    trade_off,
    two_forms,
)
from .linear_filter import LinearFilter

_PLANT = instance(Plant)
_NOISE = MappingProxyType({"G": matrix("n q"), "W": covariance("q"), "V": covariance("p")})
_SAMPLES = count(1, 1_000_000)

as_record = gated(value=optional(RECORD), name=NAME, columns=count(), rows=optional(count(0, MOST_NUMBERS)))(track.as_record)
chi2_band = gated(dof=number(0, 1e9), count=number(0, 1e12), level=LEVEL)(squared_error.chi2_band)
correct = gated(C=matrix("p n"), R=matrix("p p"), mean=vector("n"), P=matrix("n n"), y=vector("p"))(kalman.correct)
predict = gated(A=matrix("n n"), Q=matrix("n n"), mean=vector("n"), P=matrix("n n"))(kalman.predict)
joseph = gated(P=array("… n n"), C=array("… p n"), R=array("… p p"), M=array("… n p"))(kalman.joseph)
posterior_bound = gated(F=array("k N n n"), H=array("j N p n"), Q=covariance("n"), R=covariance("p"), P=covariance("n"),
                        unknown=choice("states", "noise"))(bound.posterior_bound)
short_form = gated(P=array("… n n"), C=array("… p n"), M=array("… n p"))(kalman.short_form)
posterior_covariances = gated(A=matrix("n n"), C=matrix("p n"), Q=matrix("n n"), R=matrix("p p"), P=matrix("n n"), steps=_SAMPLES,
                              form=choice(*two_forms.FORMS), gain=optional(matrix("n p")), single=BOOLEAN)(two_forms.posterior_covariances)
error_parts = gated(plant=_PLANT, L=matrix("n p"), **_NOISE)(trade_off.error_parts)
noise_ladder = gated(plant=_PLANT, **_NOISE, ratio=SERIES)(trade_off.noise_ladder)
growing_error = gated(plant=_PLANT, L=matrix("n p"), parts=instance(trade_off.ErrorParts), V=covariance("p"), dt=SECONDS,
                      rows=matrix("k n"), steps=_SAMPLES)(trade_off.growing_error)
errors_squared = gated_runs(e=array("… n", missing=True, infinite=True),
                            P=array("… n n", missing=True, infinite=True))(many_runs.errors_squared)
independent_errors = gated(Phi=matrix(), P=matrix(), steps=_SAMPLES, T=matrix())(squared_error.independent_errors)
innovation_test = gated(innovations=RECORD, S=array(), lags=count(1, 10_000), level=LEVEL)(consistency.innovation_test)
whiteness = gated(innovations=RECORD, lags=count(1, 10_000), level=LEVEL)(consistency.whiteness)
nees = gated(x=array(), xhat=array(), P=array(), level=LEVEL, independent=optional(POSITIVE))(squared_error.nees)
nis = gated(innovations=RECORD, S=array(), level=LEVEL)(squared_error.nis)
means_along = gated(A=matrix("n n"), C=matrix("p n"), schedule=instance(track.Schedule), start=vector("n"),
                    known=array("k p", missing=True), push=optional(array("k n")))(track.means_along)
sigma_weights = gated(n=count(1, 1000), alpha=number(high=1e6, above=0), beta=number(), kappa=number())(sigma_points.sigma_weights)
slopes_along = gated(plant=instance(NonlinearPlant), step=SECONDS, x=array("n k"), u=array("m l"),
                     parts=count(1, 100_000))(slopes.slopes_along)
simulate_filter = gated(plant=_PLANT, **_NOISE, step=SECONDS, samples=count(1, MOST_NUMBERS // 8, beside="n n"),
                        believed=pair(number(0), number(0)), seed=SEED,
                        kick=optional(pair(number(0, 1e9), vector())))(filter_trial.simulate_filter)
simulate_filters = gated(e=instance(experiment.Experiment), rng=GENERATOR)(many_runs.simulate_filters)
with_coloured_noise = gated(plain=instance(LinearFilter), noise=instance(adc.AdcNoise))(adc.with_coloured_noise)
