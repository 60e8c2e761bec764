"""Define plants, poles, conversion, noise and sampling, on which the rest of the engine builds."""

from .balance import Balance, balance, natural_scale, state_scale
from .errors import EngineError, PoleError, RiccatiError, ShapeError, phrase
from .flow import Flow, NonlinearPlant
from .gates.public_arrays import as_covariance, as_matrix, symmetric
from .gates.room_gates import with_gates
from .jacobian import Map, each_column, slopes
from .lyapunov import settled_covariance
from .noise import process_noise, root, step_covariance
from .plant import Plant
from .pole_sets import Poles, check_poles, match_poles, move_pole, pair_conjugates, pole_text, sorted_poles
from .recursions import affine_scan, held_scan, step_matrices
from .sampling import continuous_of, discretise
from .spectrum import Spectrum, amplitude_response, frequency_response, modal_coordinates, psd
from .stability import all_stable, is_stable, stable_poles
from .zeros import invariant_zeros, transmission_zeros

__all__ = [
    "Balance",
    "EngineError",
    "Flow",
    "Map",
    "NonlinearPlant",
    "Plant",
    "PoleError",
    "Poles",
    "RiccatiError",
    "ShapeError",
    "Spectrum",
    "affine_scan",
    "all_stable",
    "amplitude_response",
    "as_covariance",
    "as_matrix",
    "balance",
    "check_poles",
    "continuous_of",
    "discretise",
    "each_column",
    "frequency_response",
    "held_scan",
    "invariant_zeros",
    "is_stable",
    "match_poles",
    "modal_coordinates",
    "move_pole",
    "natural_scale",
    "pair_conjugates",
    "phrase",
    "pole_text",
    "process_noise",
    "psd",
    "root",
    "settled_covariance",
    "slopes",
    "sorted_poles",
    "stable_poles",
    "state_scale",
    "step_covariance",
    "step_matrices",
    "symmetric",
    "transmission_zeros",
]

with_gates(globals())
