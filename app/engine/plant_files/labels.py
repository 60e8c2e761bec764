"""Names and units of a plant's signals, as JSON, MATLAB's objects and the lab's own files give them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..systems.errors import EngineError, phrase
from ..systems.plant import Plant
from .found import Found
from .input_gate import Entry

__all__ = ["MAX_NAME", "labels_of", "labels_record"]

MAX_NAME, MAX_NAMES, MAX_UNITS = 100, 200, 232
Labels = tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...], tuple[tuple[str, str], ...], str]


def labels_record(plant: Plant) -> dict[str, Any]:
    """Names and units as JSON carries them."""
    return {"name": plant.name, "states": list(plant.state_names), "inputs": list(plant.input_names),
            "outputs": list(plant.output_names), "units": dict(plant.units)}


def labels_of(found: Found) -> Labels:
    """Names of states, inputs and outputs, units by name, and the plant's name; empty where there are none. Raises EngineError."""
    states, inputs, outputs = (_names(found, what) for what in ("states", "inputs", "outputs"))
    units = _units(found)
    for names, what in ((states, "state_units"), (inputs, "input_units"), (outputs, "output_units")):
        given = _names(found, what)
        units += tuple(pair for pair in zip(names, given, strict=False) if pair[1])
    return states, inputs, outputs, units, _name(found)


def _word(value: object, what: str) -> str:
    if not isinstance(value, str) or len(value) > MAX_NAME or not value.isprintable():
        raise EngineError("{what} must be plain text of at most {max_name} characters.",
                          what=what, max_name=MAX_NAME)
    return value


def _name(found: Found) -> str:
    keys = found.fitting("name", str)
    return _word(found.take("name", ""), keys[0]) if keys else ""


def _names(found: Found, what: str) -> tuple[str, ...]:
    """A list of names; none where all are empty, as MATLAB writes them."""
    keys = found.fitting(what, list, str)
    if not keys:
        return ()
    value = _flat(found.take(what, []))
    if not isinstance(value, list) or len(value) > MAX_NAMES:
        raise EngineError("{what} must be a list of at most {max_states} names.", what=keys[0], max_states=MAX_NAMES)
    names = tuple(_word(item, phrase("Each name in {what}", what=keys[0])) for item in value)
    return names if any(names) else ()


def _flat(value: Entry) -> Entry:
    """A cell array, which is a list of rows, as a list; a single text of MATLAB as a list of one."""
    if isinstance(value, list) and value and all(isinstance(row, list) for row in value):
        return [item for row in value for item in row]
    if isinstance(value, list):
        return ["" if isinstance(item, np.ndarray) and not item.size else item for item in value]
    return value


def _units(found: Found) -> tuple[tuple[str, str], ...]:
    if not found.fitting("units", Mapping):
        return ()
    value = found.take("units", {})
    if not isinstance(value, Mapping) or len(value) > MAX_UNITS:
        raise EngineError("units must be an object that maps a signal name to its unit.")
    return tuple((_word(k, phrase("A unit's signal")), _word(v, phrase("A unit"))) for k, v in value.items())


def spread(entries: dict[str, Entry], parse: Any) -> dict[str, Entry]:
    """The variables with those of `labels` among them, the text of JSON in which the lab's own .mat files keep names and units."""
    labels = entries.get("labels")
    if not isinstance(labels, str) or not labels.lstrip().startswith(("{", "[")):
        return entries
    inside = parse(labels)
    return {**{key: value for key, value in entries.items() if key != "labels"}, **{k: v for k, v in inside.items() if k not in entries}}


def as_text(plant: Plant) -> str:
    """The text of `labels`."""
    return json.dumps(labels_record(plant))
