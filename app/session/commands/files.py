"""Define the commands about files, changed lessons, pins, saved designs and steps of the history."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ...course.lesson import Lesson
from ...text import Text
from .commands import Command, Notice


class DownloadFile(Command, frozen=True):
    """A file of what is shown: a figure by its id, or all for "", as "png", "svg", "pdf", "csv" or "json"; everything as "zip"; a
    "python", "notebook", "engine-notebook" or "matlab" script; code for a device as "c", "arduino", "micropython",
    "st" or "simulink"; the "replay" as a page; the "sheet" for print."""

    kind: str
    figure: str = ""


class FileReady(Notice, frozen=True):
    """A file that was asked for is there, or it is known why it cannot be made."""

    name: str
    content: bytes
    why: Text | None = None


class LessonsChanged(Notice, frozen=True):
    """Files of lessons have changed on the server: these are the lessons now, by id."""

    lessons: Mapping[str, Lesson]


class UploadLessons(Command, frozen=True):
    """The .zip of lessons that the person chose, for this tab alone."""

    name: object
    data: object


class LessonsRead(Notice, frozen=True):
    """A .zip of lessons is read: its lessons by id, or what is wrong with it.

    `own` is what the tab had when it began; `then` is told whether it could be read.
    """

    own: object
    file: str
    content: bytes
    lessons: Mapping[str, Lesson] | None
    problem: BaseException | None
    then: Callable[[bool], object]


class LinesCame(Notice, frozen=True):
    """The running plant has sent lines; `done` is called once this tab shows them: `whole`, or by its body and ghost alone."""

    tab: int
    done: Callable[[], object]
    whole: bool = True


class PinDesign(Command, frozen=True):
    """Pin the present design, under a name of one's own or the next letter."""

    name: object = ""


class Unpin(Command, frozen=True):
    """Take the pin of that place away."""

    place: object


class OpenPin(Command, frozen=True):
    """Make the pinned design of that place the present one."""

    place: object


class ToggleGhost(Command, frozen=True):
    """Let the ghost of the pin of that place walk on the stage, or no longer."""

    place: object


class GoToStep(Command, frozen=True):
    """The design of that place in the history."""

    place: object


class SaveDesign(Command, frozen=True):
    """Keep the present design in the browser's own storage, under a name of one's own."""

    name: object


class OpenSavedDesign(Command, frozen=True):
    """Open the design that is kept under a name."""

    name: object


class DeleteSavedDesign(Command, frozen=True):
    """Keep the design of that name no longer."""

    name: object


class ClearBrowser(Command, frozen=True):
    """Let the browser forget all that it keeps."""
