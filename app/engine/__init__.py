"""The engine: pure numerics of observers and estimate feedback. Arrays in, frozen records out."""

from .adc import AdcNoise, with_coloured_noise
from .analysis import Controllability, Mode, Observability, controllability, observability
from .belief import Belief, Correction, RootBelief, as_covariance, symmetric
from .bilinear import BilinearForm, BilinearObserver, BilinearPlant, bilinear_functional_observer
from .bilinear_run import BilinearRun, simulate_bilinear
from .canonise import Canonisation, canonise, canonise_right
from .compensator import ClosedLoop, TransferFunction, closed_loop, compensator, to_tf
from .consistency import InnovationTest, SquaredError, Whiteness, chi2_band, innovation_test, nees, nis, whiteness
from .convert import from_control, from_json, from_mat, load_plant, read_plant, to_control, to_json, to_mat
from .coprime import CoprimeFactors, coprime_factors
from .decomposition import KalmanDecomposition, kalman_decomposition, reachable_subspace, unobservable_subspace
from .diophantine import Diophantine, diophantine, sylvester
from .dominance import Dominance, dominance, dominance_of, relative_gains
from .errors import EngineError, PoleError, RiccatiError, ShapeError
from .fault_bank import FaultBank, ResidualGenerator, isolate, residual_generator
from .flow import Flow, NonlinearPlant, slopes
from .functional import FunctionalObserver, functional_observer
from .functional_loop import (
    FunctionalRun,
    error_index,
    error_transfer,
    peak_gain,
    perturbed_loop,
    run_functional,
    worst_error_gain,
)
from .gramian import (
    Gramians,
    StableSplit,
    Truncation,
    balanced_truncation,
    gramians,
    hankel_singular_values,
    observability_gramian,
    reachability_gramian,
    split_stable,
)
from .hardware import Hardware, coil_driver
from .hold import continuous_of
from .intermittent import (
    CriticalLoss,
    critical_loss,
    intermittent_covariances,
    intermittent_steps,
    lossy_growth,
    mare,
    mean_bounds,
    mean_lower_limit,
    measured,
    riccati_step,
    spectral_radius,
)
from .jacobian import columns, each_column, expand, jacobian
from .kalman import KalmanFilter, gain_of, joseph, short_form
from .linear_filter import LinearFilter
from .loop_spectrum import NoisyLoop, noisy_loop
from .lqg import Lqg, lqg
from .lqg_sampled import SampledLqg, SampledRun, sampled_cost, sampled_lqg
from .ltr import Recovered, recover, recover_at_output, transmission_zeros
from .many_filters import (
    Beliefs,
    Corrections,
    ExtendedFilters,
    LinearFilters,
    ManyFilters,
    PrintedUnscentedFilters,
    UnscentedFilters,
)
from .many_runs import Experiment, Sample, Steering, errors_squared, march_many
from .margins import ChannelMargins, DiskMargin, LoopMargins, MultiMargins, loop_margins, state_feedback_margins
from .mixing import Coupling, Mixing, best_mixing, coupling, mixing_matrix
from .monte_carlo import MonteCarlo, monte_carlo, welch_expectation
from .network_loop import delayed_loop, mean_square_growth
from .networked import NetworkRun, NetworkScenario, network_meter, promised_error, simulate_network
from .nonlinear import ExtendedKalmanFilter, UnscentedKalmanFilter
from .optimal import DiscreteFilter, Optimal, dlqe, dlqr, lqe, lqr
from .packets import Link
from .perturbation import Norm, Perturbations, criterion, every_entry, perturbations, vertices
from .placement import Placement, match_poles, move_pole, observer_gain, place
from .plant import Plant, as_matrix
from .pole_sets import Poles, check_poles, pole_text
from .recovery import RecoveryMap, recovery_map
from .residual_threshold import (
    alarm_probability,
    binomial_band,
    needed_noncentrality,
    residual_threshold,
    window_energy,
    window_mean,
)
from .rlo import Attempt, Region, RobustObserver, rlo, rlo_steps
from .sampled_control import SampledController, recursive_controller, sampled_controller
from .sampled_loop import SampledLoop, sampled_loop
from .sampled_spectrum import MechanicsResponse, loop_density, mechanics_response
from .scenario import Run, Scenario
from .sensitivity import Sensitivity, sensitivity
from .simulate import autonomous_error, separation_meter, simulate
from .siso import LoopShape, diagonal_controller, loop_shaped, negated, polynomial_roots, rational, realise, series
from .spectrum import Spectrum, amplitude_response, frequency_response, modal_coordinates, psd
from .square_root import SquareRootFilter
from .starting import StartingGain, shift_observer, shift_poles, starting_feedback, starting_observer, typical_rate
from .track import Schedule, Track, as_record, means_along
from .trial import ResponseMeasures, Trial, response_measures, run_trial
from .unknown_input import Decoupling, UnknownInputObserver, decoupling, unknown_input_observer

__all__ = [
    "AdcNoise",
    "Attempt",
    "Belief",
    "Beliefs",
    "BilinearForm",
    "BilinearObserver",
    "BilinearPlant",
    "BilinearRun",
    "Canonisation",
    "ChannelMargins",
    "ClosedLoop",
    "Controllability",
    "CoprimeFactors",
    "Correction",
    "Corrections",
    "Coupling",
    "CriticalLoss",
    "Decoupling",
    "Diophantine",
    "DiscreteFilter",
    "DiskMargin",
    "Dominance",
    "EngineError",
    "Experiment",
    "ExtendedFilters",
    "ExtendedKalmanFilter",
    "FaultBank",
    "Flow",
    "FunctionalObserver",
    "FunctionalRun",
    "Gramians",
    "Hardware",
    "InnovationTest",
    "KalmanDecomposition",
    "KalmanFilter",
    "LinearFilter",
    "LinearFilters",
    "Link",
    "LoopMargins",
    "LoopShape",
    "Lqg",
    "ManyFilters",
    "MechanicsResponse",
    "Mixing",
    "Mode",
    "MonteCarlo",
    "MultiMargins",
    "NetworkRun",
    "NetworkScenario",
    "NoisyLoop",
    "NonlinearPlant",
    "Norm",
    "Observability",
    "Optimal",
    "Perturbations",
    "Placement",
    "Plant",
    "PoleError",
    "Poles",
    "PrintedUnscentedFilters",
    "Recovered",
    "RecoveryMap",
    "Region",
    "ResidualGenerator",
    "ResponseMeasures",
    "RiccatiError",
    "RobustObserver",
    "RootBelief",
    "Run",
    "Sample",
    "SampledController",
    "SampledLoop",
    "SampledLqg",
    "SampledRun",
    "Scenario",
    "Schedule",
    "Sensitivity",
    "ShapeError",
    "Spectrum",
    "SquareRootFilter",
    "SquaredError",
    "StableSplit",
    "StartingGain",
    "Steering",
    "Track",
    "TransferFunction",
    "Trial",
    "Truncation",
    "UnknownInputObserver",
    "UnscentedFilters",
    "UnscentedKalmanFilter",
    "Whiteness",
    "alarm_probability",
    "amplitude_response",
    "as_covariance",
    "as_matrix",
    "as_record",
    "autonomous_error",
    "balanced_truncation",
    "best_mixing",
    "bilinear_functional_observer",
    "binomial_band",
    "canonise",
    "canonise_right",
    "check_poles",
    "chi2_band",
    "closed_loop",
    "coil_driver",
    "columns",
    "compensator",
    "continuous_of",
    "controllability",
    "coprime_factors",
    "coupling",
    "criterion",
    "critical_loss",
    "decoupling",
    "delayed_loop",
    "diagonal_controller",
    "diophantine",
    "dlqe",
    "dlqr",
    "dominance",
    "dominance_of",
    "each_column",
    "error_index",
    "error_transfer",
    "errors_squared",
    "every_entry",
    "expand",
    "frequency_response",
    "from_control",
    "from_json",
    "from_mat",
    "functional_observer",
    "gain_of",
    "gramians",
    "hankel_singular_values",
    "innovation_test",
    "intermittent_covariances",
    "intermittent_steps",
    "isolate",
    "jacobian",
    "joseph",
    "kalman_decomposition",
    "load_plant",
    "loop_density",
    "loop_margins",
    "loop_shaped",
    "lossy_growth",
    "lqe",
    "lqg",
    "lqr",
    "march_many",
    "mare",
    "match_poles",
    "mean_bounds",
    "mean_lower_limit",
    "mean_square_growth",
    "means_along",
    "measured",
    "mechanics_response",
    "mixing_matrix",
    "modal_coordinates",
    "monte_carlo",
    "move_pole",
    "needed_noncentrality",
    "nees",
    "negated",
    "network_meter",
    "nis",
    "noisy_loop",
    "observability",
    "observability_gramian",
    "observer_gain",
    "peak_gain",
    "perturbations",
    "perturbed_loop",
    "place",
    "pole_text",
    "polynomial_roots",
    "promised_error",
    "psd",
    "rational",
    "reachability_gramian",
    "reachable_subspace",
    "read_plant",
    "realise",
    "recover",
    "recover_at_output",
    "recovery_map",
    "recursive_controller",
    "relative_gains",
    "residual_generator",
    "residual_threshold",
    "response_measures",
    "riccati_step",
    "rlo",
    "rlo_steps",
    "run_functional",
    "run_trial",
    "sampled_controller",
    "sampled_cost",
    "sampled_loop",
    "sampled_lqg",
    "sensitivity",
    "separation_meter",
    "series",
    "shift_observer",
    "shift_poles",
    "short_form",
    "simulate",
    "simulate_bilinear",
    "simulate_network",
    "slopes",
    "spectral_radius",
    "split_stable",
    "starting_feedback",
    "starting_observer",
    "state_feedback_margins",
    "sylvester",
    "symmetric",
    "to_control",
    "to_json",
    "to_mat",
    "to_tf",
    "transmission_zeros",
    "typical_rate",
    "unknown_input_observer",
    "unobservable_subspace",
    "vertices",
    "welch_expectation",
    "whiteness",
    "window_energy",
    "window_mean",
    "with_coloured_noise",
    "worst_error_gain",
]
