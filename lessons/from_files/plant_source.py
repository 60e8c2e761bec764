"""Read the plant of a lesson file: matrices, a plant file, a named plant, or Python functions f and h."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any  # Parameters of named plants are `Any` here: each plant has a record of its own

import numpy as np

from observer_lab.course.reading.toml_table import Table
from observer_lab.engine import EngineError, Plant
from observer_lab.plants import MODELS, Model, chip, spring_damper, two_mass
from observer_lab.plants import cart_pendulum as cart
from observer_lab.plants.own_plant import own_model, plant_of, read_plant_file
from observer_lab.text import error_words, text
from observer_lab.text.schema import shown

from .parameters import Entries, Parameters, read_entries, read_parameters
from .python_plant import PythonPlant, read_python

Values = Mapping[str, float]
NAMED: Mapping[str, tuple[Callable[[], Any], Callable[[Any], Plant]]] = MappingProxyType({
    "spring-damper": (spring_damper.Parameters, spring_damper.plant), "cart-pendulum": (cart.Parameters, cart.plant),
    "two-mass": (two_mass.Parameters, two_mass.plant), "chip": (chip.Parameters, chip.plant)})
MATRIX_KEYS = ("A", "B", "C", "D", "dt", "states", "inputs", "outputs", "units")
PYTHON_KEYS = ("python", "states", "inputs", "outputs", "units", "point", "point_input")
MAX_FILE_BYTES = 10_000_000
PLAIN_NAME = re.compile(r"[\w .,+/()°·²³⁻¹µ%-]{1,24}")


@dataclass(frozen=True, eq=False)
class PlantSource:
    """The plant for given parameters, what it is drawn by, and its nonlinear equations where it has some.

    `plant` is the linear plant, of a nonlinear one its linearisation. `model` is that of the default parameters.
    """

    plant: Callable[[Values], Plant]
    model: Model
    python: PythonPlant | None = None


def read_plant(top: Table, folder: Path, trusted: bool) -> tuple[PlantSource, Parameters]:
    """The plant and the parameters of a lesson. Raises LessonFileError."""
    table = top.table("plant")
    kinds = [key for key in ("A", "file", "named", "python") if key in table.data]
    if len(kinds) != 1:
        raise table.refuse("", text("[plant] needs exactly one of A (with B and C), file, named and python."))
    match kinds[0]:
        case "named":
            return _named(table.only("named"), top)
        case "file":
            parameters = read_parameters(top, {})
            plant = _from_file(table.only("file"), folder)
            return PlantSource(lambda values: plant, _model(table, plant)), parameters
        case "python":
            return _python(table.only(*PYTHON_KEYS), top, folder, trusted)
        case _:
            return _matrices(table.only(*MATRIX_KEYS), top)


def _named(table: Table, top: Table) -> tuple[PlantSource, Parameters]:
    id = table.one_of("named", MODELS)
    if id not in NAMED:
        return PlantSource(lambda values: MODELS[id].plant, MODELS[id]), read_parameters(top, {})
    made, build = NAMED[id]
    default = made()
    parameters = read_parameters(top, {each.name: float(getattr(default, each.name)) for each in fields(default)})

    @lru_cache(maxsize=16)
    def built(items: tuple[tuple[str, float], ...]) -> Plant:
        return build(replace(default, **dict(items)))
    names = [each.name for each in fields(default)]
    return PlantSource(lambda values: built(tuple((name, values[name]) for name in names)), MODELS[id]), parameters


def _from_file(table: Table, folder: Path) -> Plant:
    path = folder / table.words("file")
    if path.parent != folder or not path.is_file() or path.stat().st_size > MAX_FILE_BYTES:
        raise table.refuse("file", text("There is no plant file {file} beside this lesson.", file=path.name[:40]))
    try:
        return plant_of(read_plant_file(path.name, path.read_bytes()))
    except EngineError as problem:
        raise table.refuse("file", error_words(problem)) from problem


def _matrices(table: Table, top: Table) -> tuple[PlantSource, Parameters]:
    parameters = read_parameters(top, {})
    entries = {key: read_entries(table, key, parameters) for key in "ABCD" if key in table.data}
    names, dt = _names_of(table), table.number("dt", 0.0)
    if "B" not in entries or "C" not in entries:
        raise table.refuse("", text("[plant] needs A, B and C."))

    def plant(values: Values) -> Plant:
        return _built({key: each.at(values) for key, each in entries.items()}, dt, names)
    start = _start_values(parameters)
    try:
        first = plant(start)
    except EngineError as problem:
        raise table.refuse(_key_in(str(problem), entries), error_words(problem)) from problem
    return PlantSource(plant, _model(table, first)), parameters


def _key_in(words: str, entries: Mapping[str, Entries]) -> str:
    """The matrix that an error is about, the first in its sentence."""
    return next((word for word in words.replace(".", " ").split() if word in entries), "A")


def _built(matrices: Mapping[str, np.ndarray], dt: float, names: Mapping[str, Any]) -> Plant:
    return Plant(matrices["A"], matrices["B"], matrices["C"], matrices.get("D"), dt, **names)


def _names_of(table: Table) -> dict[str, Any]:
    """State, input and output names and units, all plain words: pages, formulas and scripts show them."""
    found: dict[str, Any] = {}
    for key, argument in (("states", "state_names"), ("inputs", "input_names"), ("outputs", "output_names")):
        if key in table.data:
            given = table.data[key]
            known = [each for each in given if isinstance(each, str)] if isinstance(given, list) else []
            found[argument] = tuple(_plain(table, key, name) for name in table.names(key, known))
    units = table.table("units")
    if units.data:
        found["units"] = tuple((name, _plain(units, name, units.words(name))) for name in units.data)
    return found


def _plain(table: Table, key: str, name: str) -> str:
    if not PLAIN_NAME.fullmatch(name):
        raise table.refuse(key, text("The name {name} must be short and plain; use letters, digits, spaces and signs such as + and %.",
                                     name=shown(name)))
    return name


def _python(table: Table, top: Table, folder: Path, trusted: bool) -> tuple[PlantSource, Parameters]:
    parameters = read_parameters(top, {})
    names = _names_of(table)
    counts = [len(names.get(key, ())) for key in ("state_names", "input_names", "output_names")]
    if not counts[0] or not counts[2]:
        raise table.refuse("", text("A plant in Python needs the names of its states and outputs."))
    point = read_entries(table, "point", parameters, [0.0] * counts[0])
    push = read_entries(table, "point_input", parameters, [0.0] * counts[1])
    python = read_python(table, folder, trusted, (counts[0], counts[1], counts[2]), point, push)
    start = _start_values(parameters)

    def plant(values: Values) -> Plant:
        return Plant(*python.linear(values), **names)
    try:
        first = plant(start)
    except EngineError as problem:
        raise table.refuse("python", error_words(problem)) from problem
    return PlantSource(plant, _model(table, first), python), parameters


def _start_values(parameters: Parameters) -> dict[str, float]:
    return {**parameters.fixed, **{k.name: k.default for k in parameters.knobs if k.name not in parameters.pole_knobs}}


def _model(table: Table, plant: Plant) -> Model:
    try:
        return own_model(plant)
    except EngineError as problem:
        raise table.refuse("", error_words(problem)) from problem
