"""Kalman filters, linear and not, one or many at once, and whether they are consistent."""

from .adc import AdcNoise, with_coloured_noise
from .belief import Belief, Beliefs, Correction, Corrections, RootBelief
from .consistency import InnovationTest, Whiteness, innovation_test, whiteness
from .extended import ExtendedKalmanFilter, LinearisedFilter
from .filter_trial import FilterTrial, simulate_filter
from .kalman import KalmanFilter, correct, joseph, predict, short_form
from .linear_filter import LinearFilter
from .many_runs import Experiment, Sample, Steering, errors_squared, simulate_filters
from .nonlinear import NonlinearFilter
from .sigma_points import sigma_weights
from .square_root import SquareRootFilter
from .squared_error import SquaredError, chi2_band, independent_errors, nees, nis
from .track import Schedule, Track, as_record, means_along
from .trade_off import ErrorParts, Ladder, error_parts, growing_error, noise_ladder
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
    "predict",
    "short_form",
    "sigma_weights",
    "simulate_filter",
    "simulate_filters",
    "whiteness",
    "with_coloured_noise",
]
