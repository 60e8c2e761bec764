"""Kalman filters, linear and not, one or many at once, and whether they are consistent."""

from .adc import AdcNoise, with_coloured_noise
from .belief import Belief, Correction, RootBelief
from .consistency import (
    InnovationTest,
    SquaredError,
    Whiteness,
    chi2_band,
    independent_errors,
    innovation_test,
    nees,
    nis,
    whiteness,
)
from .filter_trial import FilterTrial, simulate_filter
from .kalman import KalmanFilter, gain_of, joseph, short_form
from .linear_filter import LinearFilter
from .many_filters import (
    Beliefs,
    Corrections,
    ExtendedFilters,
    LinearFilters,
    ManyFilters,
    PrintedUnscentedFilters,
    UnscentedFilters,
)
from .many_runs import Experiment, Sample, Steering, errors_squared, simulate_filters
from .nonlinear import ExtendedKalmanFilter, UnscentedKalmanFilter
from .sigma_points import sigma_weights
from .square_root import SquareRootFilter
from .track import Schedule, Track, as_record, means_along
from .trade_off import ErrorParts, Ladder, error_parts, growing_error, noise_ladder

__all__ = [
    "AdcNoise",
    "Belief",
    "Beliefs",
    "Correction",
    "Corrections",
    "ErrorParts",
    "Experiment",
    "ExtendedFilters",
    "ExtendedKalmanFilter",
    "FilterTrial",
    "InnovationTest",
    "KalmanFilter",
    "Ladder",
    "LinearFilter",
    "LinearFilters",
    "ManyFilters",
    "PrintedUnscentedFilters",
    "RootBelief",
    "Sample",
    "Schedule",
    "SquareRootFilter",
    "SquaredError",
    "Steering",
    "Track",
    "UnscentedFilters",
    "UnscentedKalmanFilter",
    "Whiteness",
    "as_record",
    "chi2_band",
    "error_parts",
    "errors_squared",
    "gain_of",
    "growing_error",
    "independent_errors",
    "innovation_test",
    "joseph",
    "means_along",
    "nees",
    "nis",
    "noise_ladder",
    "short_form",
    "sigma_weights",
    "simulate_filter",
    "simulate_filters",
    "whiteness",
    "with_coloured_noise",
]
