"""Analyse plants: observability, controllability, decomposition, Gramians, dominance."""

from ..systems.gates.room_gates import with_gates
from .analysis import Controllability, Mode, Observability, controllability, controllability_matrix, observability, observability_matrix
from .canonise import Canonisation, canonise, canonise_right
from .coprime import CoprimeFactors, coprime_factors
from .decomposition import KalmanDecomposition, kalman_decomposition, reachable_subspace, unobservable_subspace
from .dominance import Dominance, dominance, dominance_of, relative_gains
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
from .mixing import Coupling, Mixing, best_mixing, coupling, mixing_matrix

__all__ = [
    "Canonisation",
    "Controllability",
    "CoprimeFactors",
    "Coupling",
    "Dominance",
    "Gramians",
    "KalmanDecomposition",
    "Mixing",
    "Mode",
    "Observability",
    "StableSplit",
    "Truncation",
    "balanced_truncation",
    "best_mixing",
    "canonise",
    "canonise_right",
    "controllability",
    "controllability_matrix",
    "coprime_factors",
    "coupling",
    "dominance",
    "dominance_of",
    "gramians",
    "hankel_singular_values",
    "kalman_decomposition",
    "mixing_matrix",
    "observability",
    "observability_gramian",
    "observability_matrix",
    "reachability_gramian",
    "reachable_subspace",
    "relative_gains",
    "split_stable",
    "unobservable_subspace",
]

with_gates(globals())
