"""Read gains and run of a lesson file: observer, controller, start, noise, limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from observer_lab.course.figures.scene import StagePicture
from observer_lab.course.lesson import Design
from observer_lab.course.reading.toml_table import Table
from observer_lab.engine import EngineError, Plant, lqe, lqr, observer_gain, place
from observer_lab.text import error_words, text
from observer_lab.text.schema import shown

from .parameters import Entries, Parameters, poles_in, read_entries, vector
from .plant_source import PlantSource, Values

RUN_KEYS = ("seconds", "step", "start", "guess", "input", "limit", "noise", "disturbance", "kick")
Gain = Callable[[Design, Plant, Values], np.ndarray]  # the gain of a design on the plant that is believed
MAX_STEPS = 5000


@dataclass(frozen=True, eq=False)
class Setup:
    """All that a lesson file says about plant, gains and run. `observer_knob`, `controller_knob` hold poles that can be dragged."""

    source: PlantSource
    parameters: Parameters
    believed: Mapping[str, Entries]
    K: Gain
    L: Gain
    observer_knob: str
    controller_knob: str
    run: Mapping[str, Entries]
    horizon: float
    step: float
    picture: StagePicture | None = None
    assumed: Callable[[Plant, Values], tuple[np.ndarray, np.ndarray]] | None = None  # W and V of `[observer]`, None where it has none

    def belief(self, values: Values) -> dict[str, float]:
        """The parameters that observer and controller assume."""
        return {**values, **{name: float(entries.at(values)) for name, entries in self.believed.items()}}

    def vector(self, name: str, values: Values, length: int) -> np.ndarray:
        """A vector of the run, at a design's parameters."""
        return vector(self.run[name], values, length)

    def number(self, name: str, values: Values) -> float:
        """A number of the run; infinite where the file does not give it."""
        return float(np.max(self.run[name].at(values))) if self.run[name].given is not None else np.inf


def read_setup(top: Table, source: PlantSource, parameters: Parameters, picture: StagePicture | None) -> Setup:
    """`[model]`, `[observer]`, `[controller]` and `[run]`, with the picture of the stage. Raises LessonFileError."""
    model_table = top.table("model")
    for name in model_table.data:
        if name not in parameters.names:
            raise model_table.refuse(name, text("There is no parameter {name}; there are {names}.", name=shown(name),
                                                names=", ".join(parameters.names) or "—"))
    believed = {name: read_entries(model_table, name, parameters) for name in model_table.data}
    observer, controller = top.table("observer").only("poles", "L", "W", "V"), top.table("controller").only("poles", "K", "Q", "R")
    run, model = top.table("run").only(*RUN_KEYS), source.model
    horizon, step = run.number("seconds", model.horizon), run.number("step", model.plant.dt or model.dt)
    if not 0 < step <= horizon:
        raise run.refuse("step", text("step must lie between 0 and seconds; it is {step:g} s of {seconds:g} s.", step=step,
                                      seconds=horizon))
    if horizon / step > MAX_STEPS:
        raise run.refuse("step", text("{count:.0f} steps are too many; lengthen step or shorten seconds to have at most {most}.",
                                      count=horizon / step, most=MAX_STEPS))
    defaults = {"start": list(model.x0), "guess": list(model.guess), "input": 0.0, "noise": 0.0, "disturbance": 0.0,
                "kick": list(model.kick), "limit": None}
    entries = {key: read_entries(run, key, parameters, given) if key in run.data or given is not None else Entries(run, key, None)
               for key, given in defaults.items()}
    return Setup(source, parameters, believed, _feedback(controller, parameters, source), _injection(observer, parameters, source),
                 _knob_of(observer, parameters), _knob_of(controller, parameters), entries, horizon, step, picture,
                 _assumed(observer, parameters))


def _knob_of(table: Table, parameters: Parameters) -> str:
    given = table.data.get("poles", "")
    if isinstance(given, list):
        return ""
    if given and given not in parameters.pole_knobs:
        raise table.refuse("poles", text("poles must be a list, or name a knob of kind \"poles\"; there is no such knob {name}.",
                                         name=shown(given)))
    return str(given)


def _poles_of(table: Table, parameters: Parameters, plant: Plant) -> Callable[[Design], tuple[complex, ...]]:
    knob = _knob_of(table, parameters)
    poles = poles_in(table, "poles") if not knob else next(k.default for k in parameters.knobs if k.name == knob)
    if len(poles) != plant.n:
        raise table.refuse("poles", text("This plant has {n} states and needs as many poles; there are {count}.", n=plant.n,
                                         count=len(poles)))
    return (lambda design: design[knob]) if knob else (lambda design: poles)


def _injection(table: Table, parameters: Parameters, source: PlantSource) -> Gain:
    plant = source.model.plant
    if "poles" in table.data:
        poles = _poles_of(table, parameters, plant)
        return _tried(table, "poles", lambda d, p, v: observer_gain(p.A, p.C, poles(d)).gain)
    if "L" in table.data:
        return _given(table, "L", parameters, (plant.n, plant.p))
    assumed = _assumed(table, parameters)
    if assumed is not None:
        return lambda d, p, v: lqe(p.A, p.B, p.C, *assumed(p, v)).gain
    return lambda d, p, v: np.zeros((p.n, p.p))


def _assumed(table: Table, parameters: Parameters) -> Callable[[Plant, Values], tuple[np.ndarray, np.ndarray]] | None:
    """The noise intensities that the observer assumes, W (m×m) and V (p×p); None where its gain is chosen otherwise."""
    if {"poles", "L"} & table.data.keys() or not {"W", "V"} & table.data.keys():
        return None
    W, V = (read_entries(table, key, parameters, 1.0) for key in "WV")
    return lambda p, v: (_weight(W, v, p.m), _weight(V, v, p.p))


def _feedback(table: Table, parameters: Parameters, source: PlantSource) -> Gain:
    plant = source.model.plant
    if "poles" in table.data:
        poles = _poles_of(table, parameters, plant)
        return _tried(table, "poles", lambda d, p, v: place(p.A, p.B, poles(d)).gain)
    if "K" in table.data:
        return _given(table, "K", parameters, (plant.m, plant.n))
    if "Q" in table.data or "R" in table.data:
        Q, R = (read_entries(table, key, parameters, 1.0) for key in "QR")
        return lambda d, p, v: lqr(p.A, p.B, _weight(Q, v, p.n), _weight(R, v, p.m)).gain
    return lambda d, p, v: np.zeros((p.m, p.n))


def _given(table: Table, key: str, parameters: Parameters, shape: tuple[int, int]) -> Gain:
    entries = read_entries(table, key, parameters)

    def gain(design: Design, plant: Plant, values: Values) -> np.ndarray:
        found = np.atleast_2d(entries.at(values))
        if found.shape != shape:
            raise table.refuse(key, text("{key} must be {rows}×{columns}; it is {rows2}×{columns2}.", key=key, rows=shape[0],
                                         columns=shape[1], rows2=found.shape[0], columns2=found.shape[1]))
        return found
    return gain


def _tried(table: Table, key: str, gain: Gain) -> Gain:
    """The gain; an error names the line of the file."""
    def found(design: Design, plant: Plant, values: Values) -> np.ndarray:
        try:
            return gain(design, plant, values)
        except EngineError as problem:
            raise table.refuse(key, error_words(problem)) from problem
    return found


def _weight(entries: Entries, values: Values, size: int) -> np.ndarray:
    """A weight of that size: a matrix, its diagonal, or one number for all entries."""
    found = entries.at(values)
    return found if found.ndim == 2 else np.diag(vector(entries, values, size))
