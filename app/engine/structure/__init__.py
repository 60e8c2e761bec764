"""Analyse plants: observability, controllability, decomposition, Gramians, dominance."""

from .analysis import Controllability, Mode, Observability
from .canonise import Canonisation
from .coprime import CoprimeFactors
from .decomposition import KalmanDecomposition
from .dominance import Dominance
from .door import (
    balanced_truncation,
    best_mixing,
    canonise,
    canonise_right,
    controllability,
    controllability_matrix,
    coprime_factors,
    coupling,
    dominance,
    dominance_of,
    gramians,
    hankel_singular_values,
    kalman_decomposition,
    mixing_matrix,
    observability,
    observability_gramian,
    observability_matrix,
    reachability_gramian,
    reachable_subspace,
    relative_gains,
    split_stable,
    unobservable_subspace,
)
from .gramian import Gramians, StableSplit, Truncation
from .mixing import Coupling, Mixing

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
