"""Design functional, robust, reduced, bilinear and unknown-input observers, and fault banks."""

from ..systems.gates.room_gates import with_gates
from .bilinear import BilinearForm, BilinearObserver, BilinearPlant
from .bilinear_run import BilinearRun, simulate_bilinear
from .bilinear_steps import bilinear_functional_observer
from .existence import Existence, existence
from .fault_bank import FaultBank, ResidualGenerator, isolate, residual_generator
from .functional import FunctionalObserver, functional_observer
from .functional_loop import FunctionalRun, error_index, error_transfer, peak_gain, perturbed_loop, simulate_functional, worst_error_gain
from .perturbation import Norm, Perturbations, criterion, every_entry, perturbations, vertices
from .reduced import ReducedObserver, reduced_observer
from .residual_threshold import alarm_probability, binomial_band, needed_noncentrality, residual_threshold, window_energy, window_mean
from .rlo import Attempt, Region, RobustObserver, rlo, rlo_steps
from .unknown_input import Decoupling, UnknownInputObserver, decoupling, unknown_input_observer

__all__ = [
    "Attempt",
    "BilinearForm",
    "BilinearObserver",
    "BilinearPlant",
    "BilinearRun",
    "Decoupling",
    "Existence",
    "FaultBank",
    "FunctionalObserver",
    "FunctionalRun",
    "Norm",
    "Perturbations",
    "ReducedObserver",
    "Region",
    "ResidualGenerator",
    "RobustObserver",
    "UnknownInputObserver",
    "alarm_probability",
    "bilinear_functional_observer",
    "binomial_band",
    "criterion",
    "decoupling",
    "error_index",
    "error_transfer",
    "every_entry",
    "existence",
    "functional_observer",
    "isolate",
    "needed_noncentrality",
    "peak_gain",
    "perturbations",
    "perturbed_loop",
    "reduced_observer",
    "residual_generator",
    "residual_threshold",
    "rlo",
    "rlo_steps",
    "simulate_bilinear",
    "simulate_functional",
    "unknown_input_observer",
    "vertices",
    "window_energy",
    "window_mean",
    "worst_error_gain",
]

with_gates(globals())
