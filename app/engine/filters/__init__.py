"""Run Kalman filters, linear and nonlinear, one or many at once, and test their consistency."""

from .adc import AdcNoise
from .belief import Belief, Beliefs, Correction, Corrections, RootBelief
from .consistency import InnovationTest, Whiteness
from .door import (
    as_record,
    chi2_band,
    correct,
    error_parts,
    errors_squared,
    growing_error,
    independent_errors,
    innovation_test,
    joseph,
    means_along,
    nees,
    nis,
    noise_ladder,
    posterior_bound,
    posterior_covariances,
    predict,
    short_form,
    sigma_weights,
    simulate_filter,
    simulate_filters,
    slopes_along,
    whiteness,
    with_coloured_noise,
)
from .experiment import Experiment, Sample, Steering
from .extended import ExtendedKalmanFilter, LinearisedFilter
from .filter_trial import FilterTrial
from .kalman import KalmanFilter
from .linear_filter import LinearFilter
from .nonlinear import NonlinearFilter
from .square_root import SquareRootFilter
from .squared_error import SquaredError
from .track import Schedule, Track
from .trade_off import ErrorParts, Ladder
from .unscented import PrintedUnscentedFilter, UnscentedKalmanFilter

__all__ = [
    "AdcNoise",
    "Belief",
    "Beliefs",
    "Correction",
    "Corrections",
    "ErrorParts",
    "Experiment",
    "ExtendedKalmanFilter",
    "FilterTrial",
    "InnovationTest",
    "KalmanFilter",
    "Ladder",
    "LinearFilter",
    "LinearisedFilter",
    "NonlinearFilter",
    "PrintedUnscentedFilter",
    "RootBelief",
    "Sample",
    "Schedule",
    "SquareRootFilter",
    "SquaredError",
    "Steering",
    "Track",
    "UnscentedKalmanFilter",
    "Whiteness",
    "as_record",
    "chi2_band",
    "correct",
    "error_parts",
    "errors_squared",
    "growing_error",
    "independent_errors",
    "innovation_test",
    "joseph",
    "means_along",
    "nees",
    "nis",
    "noise_ladder",
    "posterior_bound",
    "posterior_covariances",
    "predict",
    "short_form",
    "sigma_weights",
    "simulate_filter",
    "simulate_filters",
    "slopes_along",
    "whiteness",
    "with_coloured_noise",
]
