"""Files to take away: asked for in the page, made beside the worker, handed over by it."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import assert_never

from ..lesson.knobs import KnobError
from ..text import text, told
from .errands import Errands
from .orders import Made, TakeFile, Taking
from .picture import Picture
from .playing import locked
from .presenter import Presenter
from .token import write_token
from .unexpected import NOT_DONE, kind_of

log = logging.getLogger(__name__)

SLOW = frozenset({"zip", "sheet", "replay"})
COMING = text("The file is being made; it comes as a download.")
TOO_MANY = text("Several files are being made already; wait until they are here.")


def obey(show: Presenter, errands: Errands, command: Taking) -> None:
    """Do what a command about files asks. Raises KnobError."""
    match command:
        case TakeFile(kind, figure):
            if kind == "replay" and locked(show):
                return
            picture, saved, view = show.picture, show.saved(), show.view
            token = write_token(show.lesson, saved)
            if not errands.send(lambda: make(picture, token, kind, figure, lambda: view.replay(picture, token, saved.camera))):
                raise KnobError(TOO_MANY)
            if kind in SLOW:
                show.view.say(COMING, False)
        case Made(name, content, why):
            if why is not None:
                raise KnobError(why)
            show.view.hand_over(name, content)
        case _:
            assert_never(command)


def make(picture: Picture, token: str, kind: str, figure: str, replay: Callable[[], bytes]) -> Made:
    """The file, or in one sentence why there is none."""
    from ..export import files  # matplotlib is loaded only when a file is wanted

    shown = (*picture.seen, *([picture.compared] if picture.compared is not None else []))
    taken = files.Taken(picture.lesson, picture.outcome, shown, token, picture.state.language)
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
            case _:
                file = files.figure_file(taken, figure, kind)
    except files.FileError as problem:
        return Made("", b"", told(problem))
    except Exception as problem:
        log.exception("a file of kind %s could not be made", kind)
        return Made("", b"", NOT_DONE.format(kind=kind_of(problem)))
    return Made(file.name, file.content)
