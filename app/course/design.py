"""Define a design: all that a person has chosen in a lesson."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ..text import text
from .knobs import KnobError


def missing_knob(name: str, lesson: str, plant: str, names: Iterable[str]) -> KnobError:
    """The error of a knob that a lesson, or its variant for a person's own plant, does not have; it lists those that exist."""
    said = {"id": lesson, "name": name[:40], "names": ", ".join(names)}
    if not plant:
        return KnobError(text("Lesson {id} has no knob {name}; it has {names}.", **said))
    from ..plants.own_plant import plant_of  # late: it brings numpy, before a command has settled its threads
    from ..plants.signal_names import title_of

    return KnobError(text("Lesson {id}, adapted to {plant}, has no knob {name}; it has {names}.", plant=title_of(plant_of(plant)), **said))


@dataclass(frozen=True)
class Design:
    """Everything a person has chosen in a lesson: the one record that undo, share links, files and tests carry.

    `plant` is the user's own plant as canonical JSON (`observer_lab.plants.own_plant.canonical`), empty for the lesson's own.
    """

    lesson: str
    values: tuple[tuple[str, Any], ...]
    plant: str = ""

    def __getitem__(self, name: str) -> Any:
        """The value of a knob. Raises KnobError."""
        for key, value in self.values:
            if key == name:
                return value
        raise missing_knob(name, self.lesson, self.plant, self._names())

    def _names(self) -> tuple[str, ...]:
        return tuple(name for name, _ in self.values)

    def with_values(self, **changes: Any) -> Design:
        """The same design with some values changed; no value is checked here, `Lesson.apply` does that. Raises KnobError."""
        names = self._names()
        for name in changes:
            if name not in names:
                raise missing_knob(name, self.lesson, self.plant, names)
        return Design(self.lesson, tuple((key, changes.get(key, value)) for key, value in self.values), self.plant)
