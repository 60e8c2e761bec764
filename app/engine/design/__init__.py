"""Compute gains: pole placement, Riccati equations, LQR, LQE, Diophantine equations."""

from .diophantine import Diophantine
from .door import (
    diagonal_controller,
    diophantine,
    dlqe,
    dlqr,
    in_natural_units,
    loop_shaped,
    lqe,
    lqr,
    negated,
    observer_gain,
    place,
    polynomial_roots,
    rational,
    realise,
    series,
    shift_observer,
    shift_poles,
    starting_feedback,
    starting_observer,
    sylvester,
    typical_rate,
)
from .optimal import DiscreteFilter, Optimal
from .placement import Placement
from .siso import LoopShape
from .starting_gains import StartingGain

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
