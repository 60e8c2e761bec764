"""Define a design: all that a person has chosen in a lesson."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Design:
    """Everything a person has chosen in a lesson: the one record that undo, share links, files and tests carry.

    `plant` is the user's own plant as canonical JSON (`observer_lab.plants.own_plant.canonical`), empty for the lesson's own.
    """

    lesson: str
    values: tuple[tuple[str, Any], ...]
    plant: str = ""

    def __getitem__(self, name: str) -> Any:
        for key, value in self.values:
            if key == name:
                return value
        raise KeyError(name)

    def with_values(self, **changes: Any) -> Design:
        """The same design with some values changed; nothing is checked here, `Lesson.apply` does that."""
        return Design(self.lesson, tuple((key, changes.get(key, value)) for key, value in self.values), self.plant)
