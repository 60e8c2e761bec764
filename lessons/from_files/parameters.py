"""Read parameters and knobs of a lesson file, and compute entries that are formulas of them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any  # an entry of a TOML file is `Any` until it is computed

import numpy as np

from observer_lab.course.exercises.typed_answers import UnreadableInput, evaluate_typed
from observer_lab.course.knobs import Knob, KnobError, Number, Poles
from observer_lab.course.lesson import Design
from observer_lab.course.reading.toml_table import LessonFileError, Table, is_number
from observer_lab.text import SaidError, text
from observer_lab.text.schema import shown

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,29}")
KNOB_KEYS = ("name", "kind", "label", "symbol", "unit", "hint", "low", "high", "default", "scale", "step", "window")
POLES, NUMBER = "poles", "number"
MAX_KNOBS = 20
RESERVED = frozenset({"kick", "seed"})


@dataclass(frozen=True)
class Parameters:
    """Numbers by name that a lesson file gives, and the knobs that move some of them."""

    fixed: Mapping[str, float]
    knobs: tuple[Knob, ...]

    def values(self, design: Design) -> dict[str, float]:
        """Every number of a design by name; pole knobs hold no number."""
        return {**self.fixed, **{k.name: design[k.name] for k in self.knobs if isinstance(k, Number)}}

    @property
    def names(self) -> tuple[str, ...]:
        """The names that a formula may use."""
        return (*self.fixed, *(k.name for k in self.knobs if isinstance(k, Number) and k.name not in self.fixed))

    @property
    def pole_knobs(self) -> tuple[str, ...]:
        """The names of the knobs that hold poles."""
        return tuple(k.name for k in self.knobs if isinstance(k, Poles))


def read_parameters(top: Table, given: Mapping[str, float]) -> Parameters:
    """`[parameters]` and `[[knobs]]`; `given` are the parameters of a named plant. Raises LessonFileError."""
    table = top.table("parameters")
    fixed = dict(given)
    for name in table.data:
        if not NAME.fullmatch(name) or name in RESERVED:
            raise table.refuse(name, text("{name} cannot name a parameter; use letters, digits and _.", name=shown(name)))
        fixed[name] = table.number(name)
    knobs: list[Knob] = []
    for each in top.tables("knobs"):
        knob = _knob(each.only(*KNOB_KEYS), fixed)
        if knob.name in [other.name for other in knobs]:
            raise each.refuse("name", text("There are two knobs {name}; choose another name.", name=knob.name))
        knobs.append(knob)
    if len(knobs) > MAX_KNOBS:
        raise top.refuse("knobs", text("A lesson may have at most {most} of [[knobs]]; this one has {count}.", most=MAX_KNOBS,
                                        count=len(knobs)))
    return Parameters(fixed, tuple(knobs))


def _knob(table: Table, fixed: Mapping[str, float]) -> Knob:
    name = table.words("name")
    if not NAME.fullmatch(name) or name in RESERVED:
        raise table.refuse("name", text("{name} cannot name a parameter; use letters, digits and _.", name=shown(name)))
    label, unit, hint = table.label("label", name), table.words("unit", ""), table.label("hint", "")
    symbol = table.words("symbol", name if len(name) == 1 else rf"\mathrm{{{name.replace('_', ' ')}}}")
    kind = table.one_of("kind", (NUMBER, POLES), NUMBER)
    try:
        if kind == POLES:
            return _poles(table, name, symbol, label, unit or "rad/s", hint)
        low, high = table.number("low"), table.number("high")
        if low >= high:
            raise table.refuse("low", text("The range of {key} is reversed: {low:g} is above {high:g}.", key=name, low=low, high=high))
        scale = table.one_of("scale", ("linear", "log", "integer"), "linear")
        if scale == "log" and low <= 0:
            raise table.refuse("low", text("The knob {name} has a log scale, so low must be positive.", name=name))
        step = table.number("step") if "step" in table.data else None
        knob = Number(name, symbol, label, unit, hint, low=low, high=high, default=table.number("default", fixed.get(name)), scale=scale,
                      step=step)
        knob.check(knob.default)
        return knob
    except LessonFileError:
        raise
    except KnobError as problem:
        raise table.refuse("default", problem.text) from problem


def _poles(table: Table, name: str, symbol: str, label: Any, unit: str, hint: Any) -> Poles:
    given = table.data.get("default")
    if not isinstance(given, list) or not given:
        raise table.refuse("default", text("{key} must be a list of poles such as [-2, \"-3+1j\", \"-3-1j\"].", key="default"))
    poles = tuple(_pole(table, "default", value) for value in given)
    size = max(max(abs(p) for p in poles), 1e-9)
    window = table.data.get("window", [-3 * size, size, 2 * size])
    if not isinstance(window, list) or len(window) != 3 or not all(map(is_number, window)) or window[0] >= window[1] or window[2] <= 0:
        raise table.refuse("window", text("window must be three numbers: leftmost, rightmost, highest imaginary part."))
    left, right, top = map(float, window)
    knob = Poles(name, symbol, label, unit, hint, default=poles, re_low=left, re_high=right, im_high=top, role="estimate")
    return Poles(name, symbol, label, unit, hint, default=knob.check(poles), re_low=left, re_high=right, im_high=top, role="estimate")


def _pole(table: Table, key: str, value: object) -> complex:
    try:
        return complex(value.replace(" ", "").replace("i", "j")) if isinstance(value, str) else complex(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise table.refuse(key, text("{value} is no pole; write a number, or a pair in quotes as \"-3+1j\", \"-3-1j\".",
                                     value=shown(value))) from None


def poles_in(table: Table, key: str) -> tuple[complex, ...]:
    """Fixed poles of a list."""
    return tuple(_pole(table, key, value) for value in table.data[key])


@dataclass(frozen=True)
class Entries:
    """A matrix, a vector or a number whose entries are numbers, or formulas of the parameters in quotes."""

    table: Table
    key: str
    given: Any

    def at(self, values: Mapping[str, float]) -> np.ndarray:
        """The numbers. Raises SaidError where a formula has no value."""
        return np.array(_computed(self, self.given, values), dtype=float)


def read_entries(table: Table, key: str, parameters: Parameters, given: object = None) -> Entries:
    """The entries of a key, each tried with the parameters at their defaults. Raises LessonFileError."""
    entries = Entries(table, key, table.data.get(key, given))
    start = {**parameters.fixed, **{k.name: k.default for k in parameters.knobs if isinstance(k, Number)}}
    try:
        entries.at(start)
    except ValueError as problem:
        if isinstance(problem, SaidError):
            raise
        raise table.refuse(key, text("The rows of {key} must be equally long.", key=key)) from problem
    return entries


def _computed(entries: Entries, given: Any, values: Mapping[str, float]) -> Any:
    if isinstance(given, list):
        return [_computed(entries, each, values) for each in given]
    if is_number(given):
        return float(given)
    if not isinstance(given, str):
        raise entries.table.refuse(entries.key, text("{key} must hold numbers or formulas in quotes; it holds {value}.", key=entries.key,
                                                     value=shown(given)))
    try:
        return evaluate_typed(given, values)
    except UnreadableInput as problem:
        raise entries.table.refuse(entries.key, text(
            "The formula {formula} of {key} has no value; it may use {names}.", formula=shown(given), key=entries.key,
            names=", ".join(values) or "—")) from problem


def vector(entries: Entries, values: Mapping[str, float], length: int) -> np.ndarray:
    """A vector of that many entries; one number stands for all. Raises LessonFileError."""
    found = entries.at(values)
    if found.ndim == 0:
        return np.full(length, float(found))
    if found.shape != (length,):
        raise entries.table.refuse(entries.key, text("{key} must have {length} entries; it has {count}.", key=entries.key, length=length,
                                                     count=found.size))
    return found


