"""Declare the argument checks of the public calls of `engine.structure`."""

from __future__ import annotations

from ..systems.argument_checks import FINITE, SERIES, array, count, gated, instance, matrix, number, pair
from ..systems.plant import Plant
from . import analysis, coprime, decomposition, gramian, mixing
from .canonise import canonise as _canonise
from .canonise import canonise_right as _canonise_right
from .dominance import dominance as _dominance
from .dominance import dominance_of as _dominance_of
from .dominance import relative_gains as _relative_gains

_PLANT, _RTOL = instance(Plant), number()
_HORIZON, _CHANNELS = number(0, 1e9), pair(count(-1000), count(-1000))
_RESPONSE = array("… k k", imaginary=True)

controllability_matrix = gated(plant=_PLANT)(analysis.controllability_matrix)
observability_matrix = gated(plant=_PLANT)(analysis.observability_matrix)
controllability = gated(plant=_PLANT, rtol=_RTOL)(analysis.controllability)
observability = gated(plant=_PLANT, rtol=_RTOL)(analysis.observability)
kalman_decomposition = gated(plant=_PLANT, rtol=_RTOL)(decomposition.kalman_decomposition)
reachable_subspace = gated(A=matrix("n n"), B=matrix("n m"), rtol=_RTOL)(decomposition.reachable_subspace)
unobservable_subspace = gated(A=matrix("n n"), C=matrix("p n"), rtol=_RTOL)(decomposition.unobservable_subspace)
canonise = gated(M=matrix())(_canonise)
canonise_right = gated(M=matrix())(_canonise_right)
coprime_factors = gated(plant=_PLANT)(coprime.coprime_factors)
gramians = gated(plant=_PLANT)(gramian.gramians)
hankel_singular_values = gated(plant=_PLANT)(gramian.hankel_singular_values)
split_stable = gated(plant=_PLANT)(gramian.split_stable)
balanced_truncation = gated(plant=_PLANT, order=count(-1000))(gramian.balanced_truncation)
observability_gramian = gated(plant=_PLANT, horizon=_HORIZON)(gramian.observability_gramian)
reachability_gramian = gated(plant=_PLANT, horizon=_HORIZON)(gramian.reachability_gramian)
dominance = gated(plant=_PLANT, omega=SERIES)(_dominance)
dominance_of = gated(omega=SERIES, response=_RESPONSE)(_dominance_of)
relative_gains = gated(response=_RESPONSE)(_relative_gains)
best_mixing = gated(response=_RESPONSE, channels=_CHANNELS)(mixing.best_mixing)
coupling = gated(response=_RESPONSE, channels=_CHANNELS)(mixing.coupling)
mixing_matrix = gated(a=FINITE, b=FINITE, size=count(2, 1000), channels=_CHANNELS)(mixing.mixing_matrix)
