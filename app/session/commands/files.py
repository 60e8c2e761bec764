"""Define the commands about files, changed lessons, pins, saved designs and steps of the history."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...course.lesson import Lesson
from ...text import Text


@dataclass(frozen=True)
class DownloadFile:
    """A file of what is shown: a figure by its id, or all for "", as "png", "svg", "pdf", "csv" or "json"; everything as "zip"; a
    "python", "notebook", "engine-notebook" or "matlab" script; the "replay" as a page; the "sheet" for print."""

    kind: str
    figure: str = ""


@dataclass(frozen=True)
class FileReady:
    """A file that was asked for is there, or it is known why it cannot be made."""

    name: str
    content: bytes
    why: Text | None = None


@dataclass(frozen=True)
class LessonsChanged:
    """Files of lessons have changed on the server: these are the lessons now, by id."""

    lessons: Mapping[str, Lesson]


@dataclass(frozen=True)
class PinDesign:
    """Pin the present design, under a name of one's own or the next letter."""

    name: object = ""


@dataclass(frozen=True)
class Unpin:
    """Take the pin of that place away."""

    place: object


@dataclass(frozen=True)
class OpenPin:
    """Make the pinned design of that place the present one."""

    place: object


@dataclass(frozen=True)
class ToggleGhost:
    """Let the ghost of the pin of that place walk on the stage, or no longer."""

    place: object


@dataclass(frozen=True)
class GoToStep:
    """The design of that place in the history."""

    place: object


@dataclass(frozen=True)
class SaveDesign:
    """Keep the present design in the browser's own storage, under a name of one's own."""

    name: object


@dataclass(frozen=True)
class OpenSavedDesign:
    """Open the design that is kept under a name."""

    name: object


@dataclass(frozen=True)
class DeleteSavedDesign:
    """Keep the design of that name no longer."""

    name: object


@dataclass(frozen=True)
class ClearBrowser:
    """Let the browser forget all that it keeps."""


Taking = DownloadFile | FileReady
Shelving = SaveDesign | OpenSavedDesign | DeleteSavedDesign | ClearBrowser
Comparing = PinDesign | Unpin | OpenPin | ToggleGhost | GoToStep
