"""Name the signals of a plant in every language."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..engine import Plant
from ..text import Text, same, text, text_in

__all__ = ["SIGNALS", "TITLES", "in_unit", "signal_name", "title_of", "with_unit"]

UNNAMED = text("your plant")
NO_NAMES: Mapping[str, Text] = MappingProxyType({})


def _signals(*names: Text) -> Mapping[str, Text]:
    return MappingProxyType({name.id: name for name in names})


SIGNALS: Mapping[str, Mapping[str, Text]] = MappingProxyType({
    "Aircraft, lateral motion": _signals(
        text_in("signal", "sideslip"), text_in("signal", "roll rate"), text_in("signal", "yaw rate"),
        text_in("signal", "bank"), text_in("signal", "aileron"), text_in("signal", "rudder"),
        text_in("signal", "yaw gyro"), text_in("signal", "bank angle")),
    "Motor with a flexible shaft": _signals(
        text_in("signal", "current"), text_in("signal", "motor speed"), text_in("signal", "twist"),
        text_in("signal", "load speed"), text_in("signal", "voltage"), text_in("signal", "tachometer")),
    "Four tanks": _signals(
        text_in("signal", "level 1"), text_in("signal", "level 2"), text_in("signal", "level 3"),
        text_in("signal", "level 4"), text_in("signal", "pump 1"), text_in("signal", "pump 2"),
        text_in("signal", "gauge 1"), text_in("signal", "gauge 2")),
    "Inverted pendulum, sampled": _signals(
        text_in("signal", "cart"), text_in("signal", "angle"), text_in("signal", "cart speed"),
        text_in("signal", "turn rate"), text_in("signal", "force"), text_in("signal", "cart place"),
        text_in("signal", "lean")),
    "Flexible beam": _signals(
        text_in("signal", "force"), text_in("signal", "middle"), text_in("signal", "end")),
    "Heat exchanger": _signals(
        text_in("signal", "hot 1"), text_in("signal", "hot 2"), text_in("signal", "hot 3"), text_in("signal", "wall 1"),
        text_in("signal", "wall 2"), text_in("signal", "wall 3"), text_in("signal", "cold 1"), text_in("signal", "cold 2"),
        text_in("signal", "cold 3"), text_in("signal", "flow"), text_in("signal", "sensor hot 1"), text_in("signal", "sensor hot 2"),
        text_in("signal", "sensor hot 3"), text_in("signal", "sensor cold 1"), text_in("signal", "sensor cold 2"),
        text_in("signal", "sensor cold 3")),
})
TITLES: Mapping[str, Text] = MappingProxyType({title.id: title for title in (
    text("Aircraft, lateral motion"), text("Motor with a flexible shaft"), text("Four tanks"),
    text("Inverted pendulum, sampled"), text("Flexible beam"), text("Heat exchanger"))})


def title_of(plant: Plant) -> Text:
    """What the plant is called."""
    return TITLES.get(plant.name, same(plant.name)) if plant.name else UNNAMED


def signal_name(plant: Plant, name: str) -> Text:
    """What a signal of the plant is called: as in its file, in every language where the plant is an example."""
    return SIGNALS.get(plant.name, NO_NAMES).get(name, same(name))


def with_unit(plant: Plant, name: str) -> Text:
    """The same with its unit in brackets, for an axis or a table."""
    unit = plant.unit(name)
    return in_unit(signal_name(plant, name), unit)


def in_unit(name: Text, unit: str) -> Text:
    """A name with its unit in brackets, if it has one."""
    return text_in("unit", "{name} [{unit}]", name=name, unit=unit) if unit else name
