"""Run Kalman filters, linear and nonlinear, one or many at once, and test their consistency."""

from ..systems.gates.room_gates import with_gates
from .belief import Belief, Beliefs, Correction, Corrections, RootBelief
from .consistency.innovation_tests import InnovationTest, Whiteness, innovation_test, whiteness
from .consistency.squared_error import SquaredError, chi2_band, independent_errors, nees, nis
from .linear.adc import AdcNoise, with_coloured_noise
from .linear.filter_trial import FilterTrial, simulate_filter
from .linear.h_infinity import RobustGain, h_infinity
from .linear.kalman import KalmanFilter, correct, joseph, posterior_covariances, predict, short_form
from .linear.linear_filter import LinearFilter
from .linear.square_root import SquareRootFilter
from .linear.trade_off import ErrorParts, Ladder, error_parts, growing_error, noise_ladder
from .multiple_models import ModelTrack, MultipleModelFilter
from .nonlinear.bound import posterior_bound
from .nonlinear.differences import angles
from .nonlinear.extended import ExtendedKalmanFilter, LinearisedFilter, slopes_along
from .nonlinear.many_runs import Experiment, Sample, Steering, errors_squared, simulate_filters
from .nonlinear.nonlinear_filter import NonlinearFilter
from .nonlinear.particle import ParticleFilter, ParticleTrack
from .nonlinear.unscented import PrintedUnscentedFilter, UnscentedKalmanFilter, sigma_weights
from .smoothing.moving_horizon import HorizonTrack, moving_horizon
from .smoothing.rts import Smoothed, smooth
from .track import Schedule, Track, as_record, means_along

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
    "HorizonTrack",
    "InnovationTest",
    "KalmanFilter",
    "Ladder",
    "LinearFilter",
    "LinearisedFilter",
    "ModelTrack",
    "MultipleModelFilter",
    "NonlinearFilter",
    "ParticleFilter",
    "ParticleTrack",
    "PrintedUnscentedFilter",
    "RobustGain",
    "RootBelief",
    "Sample",
    "Schedule",
    "Smoothed",
    "SquareRootFilter",
    "SquaredError",
    "Steering",
    "Track",
    "UnscentedKalmanFilter",
    "Whiteness",
    "angles",
    "as_record",
    "chi2_band",
    "correct",
    "error_parts",
    "errors_squared",
    "growing_error",
    "h_infinity",
    "independent_errors",
    "innovation_test",
    "joseph",
    "means_along",
    "moving_horizon",
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
    "smooth",
    "whiteness",
    "with_coloured_noise",
]

with_gates(globals())
