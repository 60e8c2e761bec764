"""List what a person can ask of the guide, which leads along the scenes of a lesson's path."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SetMode:
    """Show the lesson as a guide, as a lab, or for a hall."""

    mode: object


@dataclass(frozen=True)
class GoToScene:
    """Open a scene of the path by its number from 0."""

    index: object


@dataclass(frozen=True)
class TurnScene:
    """So many scenes on, or back where `steps` is negative."""

    steps: int


@dataclass(frozen=True)
class ChooseOption:
    """Choose an option of the scene's question; −1 skips it."""

    index: object


@dataclass(frozen=True)
class ToggleGlossary:
    """Open or close the page of all terms."""


@dataclass(frozen=True)
class OpenLecture:
    """Give the lecture of a TOML file, from its first stop."""

    words: object


@dataclass(frozen=True)
class EndLecture:
    """Leave the lecture; the lesson that is open stays open, as a guide."""


@dataclass(frozen=True)
class RecordStop:
    """Note the scene that is open as the next stop of a lecture that is being recorded."""


@dataclass(frozen=True)
class SaveLecture:
    """Hand over what was recorded as a TOML file, and begin a new recording."""


Guiding = OpenLecture | EndLecture | RecordStop | SaveLecture | SetMode | GoToScene | TurnScene | ChooseOption
