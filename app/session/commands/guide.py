"""List what a person can ask of the guide, which leads along the scenes of a lesson's path."""

from __future__ import annotations

from .commands import Command


class SetMode(Command, frozen=True):
    """Show the lesson as a guide, as a lab, or for a hall."""

    mode: object


class GoToScene(Command, frozen=True):
    """Open a scene of the path by its number from 0."""

    index: object


class TurnScene(Command, frozen=True):
    """So many scenes on, or back where `steps` is negative."""

    steps: int


class TurnedTo(Command, frozen=True):
    """A turn on another page of the presenter has led to the scene of this number."""

    index: int


class ChooseOption(Command, frozen=True):
    """Choose an option of the scene's question; −1 skips it."""

    index: object


class AnswerByHand(Command, frozen=True):
    """Answer the scene's question by a drawing: the heights of its columns, as shares of the figure's height, with commas."""

    heights: object


class RestartScene(Command, frozen=True):
    """Begin the open scene anew."""


class ShowKeptRun(Command, frozen=True):
    """Show the run again that the scene's verdict speaks of."""


class ToggleGlossary(Command, frozen=True):
    """Open or close the page of all terms."""


class OpenLecture(Command, frozen=True):
    """Give the lecture of a TOML file, from its first stop."""

    words: object


class EndLecture(Command, frozen=True):
    """Leave the lecture; the lesson that is open stays open, as a guide."""


class RecordStop(Command, frozen=True):
    """Note the scene that is open as the next stop of a lecture that is being recorded."""


class SaveLecture(Command, frozen=True):
    """Hand over what was recorded as a TOML file, and begin a new recording."""
