"""The engine: pure numerics of observers and estimate feedback. Arrays in, frozen records out."""

from .analysis import Controllability, Mode, Observability, controllability, observability
from .compensator import ClosedLoop, TransferFunction, closed_loop, compensator, to_tf
from .convert import from_control, from_json, from_mat, load_plant, to_control, to_json, to_mat
from .decomposition import KalmanDecomposition, kalman_decomposition, reachable_subspace, unobservable_subspace
from .errors import EngineError, PoleError, RiccatiError, ShapeError
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
from .optimal import DiscreteFilter, Optimal, dlqe, dlqr, lqe, lqr
from .placement import Placement, match_poles, move_pole, observer_gain, place
from .plant import Plant, as_matrix
from .pole_sets import Poles, check_poles, pole_text
from .recovery import RecoveryMap, recovery_map
from .scenario import Run, Scenario
from .simulate import autonomous_error, separation_meter, simulate
from .spectrum import Spectrum, amplitude_response, frequency_response, psd

__all__ = [
    "ClosedLoop",
    "Controllability",
    "DiscreteFilter",
    "EngineError",
    "Gramians",
    "KalmanDecomposition",
    "Mode",
    "Observability",
    "Optimal",
    "Placement",
    "Plant",
    "PoleError",
    "Poles",
    "RecoveryMap",
    "RiccatiError",
    "Run",
    "Scenario",
    "ShapeError",
    "Spectrum",
    "StableSplit",
    "TransferFunction",
    "Truncation",
    "amplitude_response",
    "as_matrix",
    "autonomous_error",
    "balanced_truncation",
    "check_poles",
    "closed_loop",
    "compensator",
    "controllability",
    "dlqe",
    "dlqr",
    "frequency_response",
    "from_control",
    "from_json",
    "from_mat",
    "gramians",
    "hankel_singular_values",
    "kalman_decomposition",
    "load_plant",
    "lqe",
    "lqr",
    "match_poles",
    "move_pole",
    "observability",
    "observability_gramian",
    "observer_gain",
    "place",
    "pole_text",
    "psd",
    "reachability_gramian",
    "reachable_subspace",
    "recovery_map",
    "separation_meter",
    "simulate",
    "split_stable",
    "to_control",
    "to_json",
    "to_mat",
    "to_tf",
    "unobservable_subspace",
]
