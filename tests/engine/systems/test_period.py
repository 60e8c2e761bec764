"""No public call ignores a plant's period: its answer depends on dt, or it refuses, or time plays no part in what it says."""

from __future__ import annotations

from dataclasses import is_dataclass, replace
from typing import Any

import numpy as np
import pytest
from public_calls import calls, the_call

from observer_lab.engine import EngineError, Plant
from observer_lab.engine.network import delayed_loop, mean_square_growth
from observer_lab.engine.sampled import sampled_cost
from observer_lab.engine.simulation import emulated_gain
from observer_lab.engine.systems import discretise

TIMELESS = {  # A, B, C and D alone say it, whatever the period; of the first ones `dt` itself travels along
    "design.negated", "observers.every_entry", "observers.perturbations", "structure.controllability_matrix",
    "structure.observability_matrix", "structure.coprime_factors",
    "structure.kalman_decomposition", "plant_files.to_control", "plant_files.to_json", "plant_files.to_mat",
    "systems.transmission_zeros", "observers.UnknownInputObserver.residuals", "observers.existence", "feedback.to_tf",
    "feedback.compensator", "design.series", "design.in_natural_units",
    "aliases.ctrb", "aliases.estim", "aliases.obsv", "aliases.poles", "aliases.zeros",
    "observers.decoupling", "observers.reduced_observer",
    "observers.unknown_input_observer",  # without zeros here; with zeros see test_unknown_input
}


def _numbers(found: Any, depth: int = 0) -> list[np.ndarray]:
    """All numbers of an answer but the period itself."""
    if isinstance(found, np.ndarray | int | float | complex | np.number):
        return [np.asarray(found).ravel()] if np.asarray(found).dtype.kind in "fciub" else []
    if isinstance(found, tuple | list):
        return [part for one in found for part in _numbers(one, depth)]
    if is_dataclass(found) and depth < 6:
        return [part for name, value in vars(found).items() if name != "dt" for part in _numbers(value, depth + 1)]
    return []


def _answer(name: str, dt: float) -> list[np.ndarray] | str:
    arguments = {key: replace(value, A=-0.2 * value.A, dt=dt) if isinstance(value, Plant) else value
                 for key, value in calls()[name].items() if key != "self"}
    try:
        found = the_call(name)(**arguments)
        found = list(found) if hasattr(found, "__next__") else found
        for record in found if isinstance(found, tuple) else (found,):
            for lazy in ("poles", "stable", "omega", "modes", "detectable", "stabilizable"):
                getattr(record, lazy, None)
        return _numbers(found)
    except EngineError as problem:
        return str(problem)


NAMES = sorted(name for name, arguments in calls().items()
               if name not in TIMELESS and any(isinstance(value, Plant) for key, value in arguments.items() if key != "self"))


@pytest.mark.parametrize("name", NAMES)
def test_a_call_that_takes_a_plant_does_not_ignore_its_period(name: str) -> None:
    continuous, sampled = _answer(name, 0.0), _answer(name, 0.1)
    same = (not isinstance(continuous, str) and not isinstance(sampled, str) and len(continuous) == len(sampled)
            and all(a.shape == b.shape and np.array_equal(a, b, equal_nan=True) for a, b in zip(continuous, sampled, strict=True)))
    assert not same


SAMPLED = Plant([[0.5]], [[1.0]], [[1.0]], dt=0.1)


@pytest.mark.parametrize("call", [lambda: discretise(SAMPLED, 0.1), lambda: sampled_cost(SAMPLED, [[1]], [[1]], 0.1),
                                  lambda: emulated_gain(SAMPLED, np.ones((1, 1)), 0.1)])
def test_what_is_for_continuous_plants_refuses_a_sampled_one(call: Any) -> None:
    with pytest.raises(EngineError, match="sampled already; give the continuous one"):
        call()


@pytest.mark.parametrize("call", [lambda p: delayed_loop(p, np.array([[0.1]]), np.array([[0.1]]), 1),
                                  lambda p: mean_square_growth(p, np.ones((1, 1)), 0.1, "hold")])
def test_what_is_for_sampled_plants_refuses_a_continuous_one(call: Any) -> None:
    call(SAMPLED)
    with pytest.raises(EngineError, match="needs a sampled plant"):
        call(replace(SAMPLED, dt=0.0))
