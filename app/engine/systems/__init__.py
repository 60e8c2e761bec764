"""Plants, poles, conversion, noise and sampling: what every other room of the engine stands on."""

from .arrays import as_covariance, symmetric
from .balance import Balance, balance, natural_scale, stable_poles, state_scale
from .convert import from_control, from_json, from_mat, load_plant, read_plant, to_control, to_json, to_mat
from .errors import EngineError, PoleError, RiccatiError, ShapeError, phrase
from .flow import Flow, NonlinearPlant
from .jacobian import Map, each_column, slopes
from .lyapunov import settled_covariance
from .noise import process_noise, root, step_covariance
from .plant import Plant, as_matrix
from .pole_sets import Poles, all_stable, check_poles, match_poles, move_pole, pole_text, sorted_poles
from .sampling import continuous_of, discretise
from .scan import affine_scan, held_scan, step_matrices
from .spectrum import Spectrum, amplitude_response, frequency_response, modal_coordinates, psd
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
    "from_control",
    "from_json",
    "from_mat",
    "held_scan",
    "invariant_zeros",
    "load_plant",
    "match_poles",
    "modal_coordinates",
    "move_pole",
    "natural_scale",
    "phrase",
    "pole_text",
    "process_noise",
    "psd",
    "read_plant",
    "root",
    "settled_covariance",
    "slopes",
    "sorted_poles",
    "stable_poles",
    "state_scale",
    "step_covariance",
    "step_matrices",
    "symmetric",
    "to_control",
    "to_json",
    "to_mat",
    "transmission_zeros",
]
