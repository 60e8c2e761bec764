"""Make the files that a person downloads, beside the worker, and hand them to the page."""

from __future__ import annotations

import logging
from collections.abc import Callable

from ...course.knobs import KnobError
from ...text import Text, error_words, text
from ..commands.files import FileReady
from ..runtime.error_words import NOT_DONE, error_kind
from ..state.token import write_token
from ..state.view import Picture
from .playback import warn_if_locked
from .presenter import Presenter

log = logging.getLogger(__name__)

SLOW_KINDS = frozenset({"zip", "sheet", "replay"})
FILE_IN_PROGRESS = text("The file is being made; it comes as a download.")
TOO_MANY = text("Several files are being made already; wait until they are here.")


def download_file(show: Presenter, kind: str, figure: str) -> None:
    """Begin to make a file of what is shown. Raises KnobError."""
    if kind == "replay" and warn_if_locked(show):
        return
    picture, saved, view = show.picture, show.saved(), show.view
    token = write_token(show.lesson, saved)
    if not show.background.send(lambda: make_file(picture, token, kind, figure, lambda: view.replay(picture, token, saved.camera))):
        raise KnobError(TOO_MANY)
    if kind in SLOW_KINDS:
        show.view.say(FILE_IN_PROGRESS, False)


def take_file(show: Presenter, name: str, content: bytes, why: Text | None) -> None:
    """Hand a file that is ready to the page. Raises KnobError where it could not be made."""
    if why is not None:
        raise KnobError(why)
    show.view.download(name, content)


def make_file(picture: Picture, token: str, kind: str, figure: str, replay: Callable[[], bytes]) -> FileReady:
    """The file, or in one sentence why there is none."""
    from ...export import files  # matplotlib is loaded only when a file is wanted

    shown = (*picture.seen, *([picture.compared] if picture.compared is not None else []))
    taken = files.DownloadContent(picture.lesson, picture.outcome, shown, token, picture.state.language)
    try:
        match kind:
            case "zip":
                file = files.all_in_one(taken)
            case "sheet":
                file = files.sheet_file(taken)
            case "replay":
                file = files.File(f"{picture.lesson.id}-replay.html", replay())
            case "python" | "notebook" | "matlab" | "engine-notebook":
                file = files.script_file(taken, kind)
            case "c" | "arduino" | "micropython" | "st" | "simulink":
                file = files.device_file(taken, kind)
            case _:
                file = files.figure_file(taken, figure, kind)
    except files.FileError as problem:
        return FileReady("", b"", error_words(problem))
    except Exception as problem:
        log.exception("a file of kind %s could not be made", kind)
        return FileReady("", b"", NOT_DONE.format(kind=error_kind(problem)))
    return FileReady(file.name, file.content)
