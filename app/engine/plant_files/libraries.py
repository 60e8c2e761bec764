"""Plants from and to python-control and scipy.signal, with names, units and the period."""

from __future__ import annotations

import re
from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..systems.errors import EngineError
from ..systems.gates.argument_checks import takes
from ..systems.gates.plant_gate import PLANT, fractions_of, period_of
from ..systems.plant import Plant
from .build import bounded, realised

if TYPE_CHECKING:
    import control  # imported where it is used: it takes a second to load

__all__ = ["from_control", "from_scipy", "to_control"]


@takes(plant=PLANT)
def to_control(plant: Plant) -> control.StateSpace:
    """The plant as control.StateSpace, with names and dt; units ride along in the attribute `units`.

    A dot is not allowed in python-control's system names and becomes an underscore.
    Raises EngineError when two signals of one kind share a name, which python-control would merge.

    >>> to_control(Plant([[-1]], [[1]], [[1]])).nstates
    1
    """
    from control import StateSpace

    for names in (plant.state_names, plant.input_names, plant.output_names):
        twice = [name for name, count in Counter(names).items() if count > 1]
        if twice:
            raise EngineError("Two signals are called {twice}; give each its own name.", twice=twice[0])
    system = StateSpace(plant.A, plant.B, plant.C, plant.D, plant.dt, states=list(plant.state_names),
                        inputs=list(plant.input_names), outputs=list(plant.output_names),
                        name=plant.name.replace(".", "_") or None)
    system.units = dict(plant.units)  # type: ignore[attr-defined]
    return system


def from_control(system: control.StateSpace | control.TransferFunction) -> Plant:
    """The plant of a control.StateSpace or TransferFunction; its default names (x[0], sys[3]) become the lab's own.

    A transfer function is realised with as few states as possible, and `Plant.notes` says so.
    Raises EngineError for any other object, for dt=True (period unknown), and beyond the bounds.

    >>> import control
    >>> from_control(control.ss([[-1]], [[1]], [[1]], [[0]])).A
    array([[-1.]])
    """
    from control import StateSpace, TransferFunction

    if not isinstance(system, StateSpace | TransferFunction):
        raise EngineError("Only a control.StateSpace or TransferFunction can be taken over; convert the system with control.ss first.")
    dt, name = period_of(system), str(system.name or "")
    if isinstance(system, StateSpace):
        plant = Plant(*(np.asarray(getattr(system, key)) for key in "ABCD"), dt, _given(system.state_labels, "x"))  # type: ignore[arg-type]
    else:
        plant, notes = realised(fractions_of(system), dt)
        plant = _noted(plant, notes)
    return bounded(Plant(
        plant.A, plant.B, plant.C, plant.D, dt, plant.state_names, _given(system.input_labels, "u"), _given(system.output_labels, "y"),
        tuple(dict(getattr(system, "units", {})).items()), "" if re.fullmatch(r"sys\[\d+\]", name) else name, plant.notes))


def _noted(plant: Plant, notes: tuple[str, ...]) -> Plant:
    return Plant(plant.A, plant.B, plant.C, plant.D, plant.dt, notes=notes)


def _given(labels: list[str], letter: str) -> tuple[str, ...]:
    return () if labels == [f"{letter}[{i}]" for i in range(len(labels))] else tuple(labels)


def from_scipy(system: Any) -> Plant:
    """The plant of a scipy.signal StateSpace, TransferFunction or ZerosPolesGain, continuous (lti) or sampled (dlti).

    A transfer function is realised with as few states as possible, and `Plant.notes` says so.
    Raises EngineError for any other object, for dt=True (period unknown), and beyond the bounds.

    >>> import scipy.signal
    >>> from_scipy(scipy.signal.lti([1], [1, 2])).poles
    array([-2.+0.j])
    """
    from scipy.signal import StateSpace, TransferFunction, ZerosPolesGain

    if not isinstance(system, StateSpace | TransferFunction | ZerosPolesGain):
        raise EngineError("Only systems of scipy.signal can be taken over: StateSpace, TransferFunction or ZerosPolesGain.")
    dt = period_of(system)
    if isinstance(system, StateSpace):
        return bounded(Plant(system.A, system.B, system.C, system.D, dt))
    return bounded(_noted(*realised(fractions_of(system), dt)))
