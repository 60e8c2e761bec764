"""Put a room's gates in front of its functions; a plant may stand where its matrices stand."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numpy as np

from ..errors import EngineError
from ..plant import Plant
from .checked_calls import Taken, with_checks
from .plant_gate import PlantGate, plant_like

__all__ = ["with_gates"]

P = ParamSpec("P")
R = TypeVar("R")
_PLAIN = (np.ndarray, list, tuple, float, int, str)  # what no plant is: asked of every call
_OF_PLANT = {"A": "A", "B": "B", "C": "C", "D": "D", "G": "B"}.get  # noise enters where the input does unless G is said


def with_gates(names: dict[str, Any]) -> None:
    """Replace each function marked by `takes` among the names of a room by the same one behind its gates."""
    for name, call in list(names.items()):
        taken = vars(call).get("taken") if inspect.isfunction(call) and not hasattr(call, "__wrapped__") else None
        if taken is not None:
            names[name] = _open(call, taken)


def _open(call: Callable[P, R], taken: Taken) -> Callable[P, R]:
    """The call behind its gates; where matrices A, B, … come first a plant may stand, and matrices where a plant comes alone."""
    checked = with_checks(call, taken)
    places = [name for name, parameter in inspect.signature(call).parameters.items() if parameter.kind is not parameter.KEYWORD_ONLY]
    first = taken.gates.get(places[0]) if places else None
    if isinstance(first, PlantGate) and len(places) == 1:
        return _with_matrices(checked, first)
    lead = _leading(places)
    return _with_plant(checked, call, lead, len(places), taken.time) if lead else checked


def _leading(places: list[str]) -> list[str]:
    lead: list[str] = []
    for name in places:
        if _OF_PLANT(name) is None or places[0] != "A":
            break
        lead.append(name)
    return lead


def _with_matrices(checked: Callable[P, R], gate: PlantGate) -> Callable[P, R]:
    @functools.wraps(checked)
    def called(*args: P.args, **kwargs: P.kwargs) -> R:
        if 1 < len(args) <= len(gate.letters):
            return checked(gate.of_matrices(args), **kwargs)  # type: ignore[call-arg]
        return checked(*args, **kwargs)
    return called


def _with_plant(checked: Callable[P, R], call: Callable[P, R], lead: list[str], most: int, time: str) -> Callable[P, R]:
    needed = sum(p.default is p.empty for p in inspect.signature(call).parameters.values()) - len(lead)
    has_period = "dt" in inspect.signature(call).parameters

    @functools.wraps(checked)
    def called(*args: P.args, **kwargs: P.kwargs) -> R:
        if not args or isinstance(args[0], _PLAIN) or (plant := plant_like(args[0])) is None:
            return checked(*args, **kwargs)
        if len(args) - 1 + len(lead) > most or any(name in kwargs for name in lead) or _given_twice(plant, lead, needed, args):
            raise EngineError("{call} takes a plant or its matrices {matrices}, not both.", call=call.__name__, matrices=", ".join(lead))
        _right_time(plant, call.__name__, time)
        if has_period:
            kwargs.setdefault("dt", plant.dt)
        return checked(*(getattr(plant, str(_OF_PLANT(name))) for name in lead), *args[1:], **kwargs)  # type: ignore[call-arg]
    return called


def _given_twice(plant: Plant, lead: list[str], needed: int, args: tuple[Any, ...]) -> bool:
    """Whether a matrix of the plant follows it where its call would take another: more was given than is needed, and it is no weight."""
    own = [getattr(plant, str(_OF_PLANT(name))) for name in lead[1:]]
    return len(args) - 1 > max(needed, 0) and any(np.array_equal(args[1], M) and not np.array_equal(M, M.T) for M in own)


def _right_time(plant: Plant, name: str, time: str) -> None:
    if time == "continuous" and plant.dt:
        raise EngineError("{call} is for continuous time but this plant is sampled every {dt:g} s: use d{call}.", call=name, dt=plant.dt)
    if time == "sampled" and not plant.dt:
        raise EngineError("{call} is for sampled plants but this one is continuous: sample it first, or use {other}.", call=name,
                          other=name.removeprefix("d"))
