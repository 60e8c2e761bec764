"""List the keyboard shortcuts, for the keys, the command palette and the help dialog."""

from __future__ import annotations

from dataclasses import dataclass

from ...text import Text, text
from .commands import (
    ChangeSpeed,
    CheckNextTask,
    Command,
    Kick,
    LookFrom,
    Play,
    Redo,
    Reset,
    Rewind,
    RunJob,
    SetLanguage,
    ToggleCourse,
    ToggleDownloads,
    ToggleHelp,
    ToggleLandscape,
    ToggleLecture,
    ToggleNames,
    ToggleTheme,
    TurnPage,
    Undo,
)
from .files import PinDesign
from .guide import RecordStop, ToggleGlossary


@dataclass(frozen=True)
class Shortcut:
    """A command that has a key; `key` and `modifier` are what the browser listens to."""

    label: Text
    command: Command
    key: str
    modifier: str | None = None


SHORTCUTS: tuple[Shortcut, ...] = (
    Shortcut(text("Play or pause"), Play(), "space"),
    Shortcut(text("Kick the plant"), Kick(), "K"),
    Shortcut(text("Back to the start of the run"), Rewind(), "0"),
    Shortcut(text("Slower"), ChangeSpeed(-1), "S"),
    Shortcut(text("Faster"), ChangeSpeed(+1), "F"),
    Shortcut(text("Undo"), Undo(), "Z"),
    Shortcut(text("Redo"), Redo(), "Y"),
    Shortcut(text("Reset the lesson's knobs"), Reset(), "R"),
    Shortcut(text("Pin this design to compare"), PinDesign(), "C"),
    Shortcut(text("All lessons"), ToggleCourse(), "O"),
    Shortcut(text("Next lesson"), TurnPage(+1), "N"),
    Shortcut(text("Previous lesson"), TurnPage(-1), "P"),
    Shortcut(text("Chinese / English"), SetLanguage(), "L"),
    Shortcut(text("Lecture mode: large print"), ToggleLecture(), "M"),
    Shortcut(text("Dark or light"), ToggleTheme(), "D"),
    Shortcut(text("Landscape of |det(sI − A + LC)|⁻¹"), ToggleLandscape(), "G"),
    Shortcut(text("Names of the plant's parts"), ToggleNames(), "W"),
    Shortcut(text("View everything"), LookFrom("all"), "1"),
    Shortcut(text("View the plant"), LookFrom("plant"), "2"),
    Shortcut(text("View the boards"), LookFrom("boards"), "3"),
    Shortcut(text("Start or cancel the long computation"), RunJob(), "J"),
    Shortcut(text("Check the first unsolved task"), CheckNextTask(), "T"),
    Shortcut(text("Take it with you"), ToggleDownloads(), "E"),
    Shortcut(text("Note this scene for a lecture"), RecordStop(), "B"),
    Shortcut(text("Glossary"), ToggleGlossary(), "I"),
    Shortcut(text("This list"), ToggleHelp(), "H"),
)
