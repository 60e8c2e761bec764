"""Compute gains: pole placement, Riccati equations, LQR, LQE, Diophantine equations."""

from ..systems.gates.room_gates import with_gates
from .diophantine import Diophantine, diophantine, sylvester
from .optimal import DiscreteFilter, Optimal, dlqe, dlqr, lqe, lqr
from .placement import Placement, observer_gain, place
from .siso import LoopShape, diagonal_controller, loop_shaped, negated, polynomial_roots, rational, realise, series
from .starting_gains import StartingGain, in_natural_units, shift_observer, shift_poles, starting_feedback, starting_observer, typical_rate

__all__ = [
    "Diophantine",
    "DiscreteFilter",
    "LoopShape",
    "Optimal",
    "Placement",
    "StartingGain",
    "diagonal_controller",
    "diophantine",
    "dlqe",
    "dlqr",
    "in_natural_units",
    "loop_shaped",
    "lqe",
    "lqr",
    "negated",
    "observer_gain",
    "place",
    "polynomial_roots",
    "rational",
    "realise",
    "series",
    "shift_observer",
    "shift_poles",
    "starting_feedback",
    "starting_observer",
    "sylvester",
    "typical_rate",
]

with_gates(globals())
