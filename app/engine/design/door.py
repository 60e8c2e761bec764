"""Declare the argument checks of the public calls of `engine.design`."""

from __future__ import annotations

from types import MappingProxyType

from ..systems.argument_checks import FINITE, NAME, POLES, POSITIVE, count, gated, instance, items, matrix, optional, vector
from ..systems.plant import Plant
from . import optimal, placement, siso, starting_gains
from .diophantine import diophantine as _diophantine
from .diophantine import sylvester as _sylvester

_PLANT = instance(Plant)
_PAIR, _SEEN = MappingProxyType({"A": matrix(), "B": matrix()}), MappingProxyType({"A": matrix(), "C": matrix()})
_REGULATOR = MappingProxyType({**_PAIR, "Q": matrix(), "R": matrix(), "N": matrix()})
_ESTIMATOR = MappingProxyType({**_SEEN, "G": matrix(), "W": matrix(), "V": matrix()})
_SHIFT = MappingProxyType({"before": POLES, "after": POLES})

lqr = gated(**_REGULATOR)(optimal.lqr)
dlqr = gated(**_REGULATOR)(optimal.dlqr)
lqe = gated(**_ESTIMATOR)(optimal.lqe)
dlqe = gated(**_ESTIMATOR)(optimal.dlqe)
place = gated(**_PAIR, poles=POLES)(placement.place)
observer_gain = gated(**_SEEN, poles=POLES)(placement.observer_gain)
shift_poles = gated(A=matrix("n n"), B=matrix("n m"), K=matrix("m n"), **_SHIFT)(starting_gains.shift_poles)
shift_observer = gated(A=matrix("n n"), C=matrix("p n"), L=matrix("n p"), **_SHIFT)(starting_gains.shift_observer)
starting_feedback = gated(plant=_PLANT, eager=POSITIVE)(starting_gains.starting_feedback)
starting_observer = gated(plant=_PLANT, eager=POSITIVE)(starting_gains.starting_observer)
in_natural_units = gated(plant=_PLANT)(starting_gains.in_natural_units)
typical_rate = gated(plant=_PLANT)(starting_gains.typical_rate)
diophantine = gated(A=vector(), B=vector(), desired=vector())(_diophantine)
sylvester = gated(A=vector(), B=vector(), degree=count(0, 2000))(_sylvester)
polynomial_roots = gated(polynomial=vector())(siso.polynomial_roots)
rational = gated(numerator=vector(), denominator=vector())(siso.rational)
realise = gated(zeros=POLES, poles=POLES, gain=FINITE)(siso.realise)
loop_shaped = gated(shape=instance(siso.LoopShape))(siso.loop_shaped)
negated = gated(plant=_PLANT)(siso.negated)
series = gated(last=_PLANT, first=instance(Plant))(siso.series)
diagonal_controller = gated(channels=items(optional(instance(Plant)), 1000), outputs=matrix(), inputs=matrix(), name=NAME)(
    siso.diagonal_controller)
