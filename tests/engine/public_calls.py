"""Every public call of the engine with one call that is right: what nonsense is fed to, argument by argument.

`calls()` maps "room.name" to the call and its arguments, all by name, as the tables of `calls_of_….py` have them; `ANSWERS` are
the records that calls give back and that nobody makes by hand. Whoever adds a public name adds it there or here.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from functools import cache
from typing import Any

import calls_of_estimates as estimates
import calls_of_loops as loops
import calls_of_plants as plants
import calls_of_records as records
from call_parts import A, B, C

from observer_lab.engine import Plant
from observer_lab.engine.systems import discretise

ROOMS = ("systems", "structure", "design", "feedback", "simulation", "filters", "observers", "sampled", "network", "plant_files",
         "identification", "aliases")
ANSWERS = frozenset({
    "identification.Column", "identification.RecordPreview",
    "systems.Balance", "structure.Canonisation", "structure.Controllability", "structure.CoprimeFactors", "structure.Dominance",
    "structure.Gramians", "structure.KalmanDecomposition", "structure.Mixing", "structure.Mode", "structure.Observability",
    "structure.StableSplit", "structure.Truncation", "design.Diophantine", "design.DiscreteFilter", "design.Optimal",
    "design.Placement", "design.StartingGain", "feedback.ChannelMargins", "feedback.ClosedLoop", "feedback.DiskMargin",
    "feedback.IntegralAction", "feedback.LoopMargins", "feedback.Lqg", "feedback.MultiMargins", "feedback.NoisyLoop", "feedback.Recovered",
    "feedback.Sensitivity", "feedback.TransferFunction", "filters.Correction", "filters.Corrections", "filters.ErrorParts",
    "filters.FilterTrial", "filters.InnovationTest", "filters.Ladder", "filters.RootBelief", "filters.Sample", "filters.Schedule",
    "filters.SquaredError", "filters.Track", "filters.Whiteness", "filters.HorizonTrack",
    "filters.ModelTrack", "filters.ParticleTrack", "filters.RobustGain", "filters.Smoothed", "observers.Attempt", "observers.BilinearForm",
    "observers.BilinearObserver", "observers.BilinearRun", "observers.Decoupling", "observers.Existence", "observers.FaultBank",
    "observers.FunctionalObserver", "observers.FunctionalRun", "observers.Perturbations", "observers.ReducedObserver",
    "observers.ResidualGenerator",
    "observers.RobustObserver", "observers.UnknownInputObserver", "sampled.MechanicsResponse", "sampled.MonteCarlo",
    "sampled.ResponseMeasures", "sampled.SampledController", "sampled.SampledLoop", "sampled.SampledLqg", "sampled.SampledRun",
    "sampled.Trial", "network.CriticalLoss", "network.NetworkRun", "simulation.GearedRun", "simulation.RecoveryMap", "simulation.Run",
    "plant_files.Content", "structure.Coupling", "systems.Spectrum",
    "identification.FilteredRecord", "identification.FittedFilter", "identification.RecordFit", "identification.SensorBias",
    "identification.Smoothed", "identification.Subspace", "identification.Trend",
})
NO_CALLS = frozenset({  # kinds of error, names of types, words, and kinds of filter that others are made of
    "systems.EngineError", "systems.PoleError", "systems.RiccatiError", "systems.ShapeError", "systems.Map", "systems.Poles",
    "systems.phrase", "observers.Norm", "filters.LinearFilter", "filters.NonlinearFilter",
})


def public() -> dict[str, Any]:
    """Everything public, by "room.name"."""
    return {f"{room}.{name}": getattr(module, name) for room in ROOMS
            for module in [importlib.import_module(f"observer_lab.engine.{room}")] for name in module.__all__}


@cache
def calls() -> dict[str, dict[str, Any]]:
    """Arguments by name of one right call of each public name, methods as "room.Class.method"."""
    return {f"{room}.{name}": arguments for room, table in _tables().items() for name, arguments in table.items()}


def _tables() -> dict[str, dict[str, dict[str, Any]]]:
    plant = Plant(A, B, C)
    dplant = discretise(plant, 0.1)
    return {"systems": plants.systems(plant, dplant), "plant_files": plants.plant_files(plant),
            "structure": plants.structure(plant), "design": plants.design(plant),
            "feedback": loops.feedback(plant), "simulation": loops.simulation(plant), "filters": estimates.filters(plant, dplant),
            "observers": estimates.observers(plant), "sampled": loops.sampled(plant), "network": loops.network(dplant),
            "identification": records.identification(dplant), "aliases": plants.aliases(plant)}


def the_call(name: str) -> Callable[..., Any]:
    """The call behind a name of `calls()`; of a method, unbound or bound to its class, the record under "self" left out."""
    room, first, *rest = name.split(".")
    found = getattr(importlib.import_module(f"observer_lab.engine.{room}"), first)
    return getattr(calls()[name]["self"], rest[0]) if rest else found
