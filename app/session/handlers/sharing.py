"""Handle the commands that open or export a state as a link, a token or a file."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import assert_never

from ...course.figures.records import tab_names
from ...course.knobs import KnobError
from ...engine import EngineError
from ...text import error_words, joined
from ..commands.commands import OpenState, PlaceOpened, SaveState, Sharing, ToggleDownloads
from ..runtime.error_words import NOT_DONE, error_kind
from ..state.saved_state import NO_STATE, SavedState, read_state, write_state
from ..state.token import is_token, read_token, write_token
from .presenter import Presenter

log = logging.getLogger(__name__)


def obey(show: Presenter, command: Sharing) -> None:
    """Do what a command about travelling states asks. Raises KnobError and what a lesson raises."""
    match command:
        case OpenState(words, asked):
            show.asked = asked if isinstance(asked, int) else show.asked
            try:
                take(show, words)
            except Exception:
                show.remember()  # the address bar goes back to what is shown
                raise
        case PlaceOpened(tab, step):
            _place(show, tab, step)
        case ToggleDownloads():
            show.view.offer(write_token(show.lesson, show.saved()))
        case SaveState():
            show.view.download(f"{show.lesson.id}.json", write_state(show.lesson, show.saved()).encode())
        case _:
            assert_never(command)


def take(show: Presenter, words: object) -> None:
    """Open the state in a token, a link or the words of a file, and say what could not be taken over. Raises KnobError and
    what the lesson raises."""
    saved = _read(show, words)
    show.open_state(saved)
    if saved.scene:
        scene = [each.id for each in show.lesson.path].index(saved.scene)
        show.desk.scene, show.desk.entered = scene, True
        if show.shown is not None:
            show.change(replace(show.state, scene=scene))
    if saved.notes:
        show.tell(joined(*saved.notes), False)


def open_words(show: Presenter, words: str) -> None:
    """Open a state with which a page was called; where that fails, the page opens as it would, with a sentence."""
    try:
        take(show, words)
    except (KnobError, EngineError) as problem:
        show.tell(error_words(problem), True)
    except Exception as problem:
        log.exception("a link could not be opened")
        show.tell(NOT_DONE.format(kind=error_kind(problem)), True)


def look_again(show: Presenter, token: str) -> None:
    """After a reload: how the page looked, from the token that this tab has put into the address bar itself."""
    try:
        saved = _read(show, token)
    except KnobError:
        return
    if saved.design.lesson == show.lesson.id:
        show.state = replace(show.state, tab=saved.tab, step=saved.step, camera=saved.camera)


def _read(show: Presenter, words: object) -> SavedState:
    if isinstance(words, bytes):
        words = words.decode(errors="replace")
    if not isinstance(words, str):
        raise KnobError(NO_STATE)
    return read_token(words, show.lessons) if is_token(words) or "{" not in words else read_state(words, show.lessons)


def _place(show: Presenter, tab: object, step: object) -> None:
    names, steps = tab_names(show.picture.figures), show.lesson.words["en"].steps
    chosen = names[tab]("en") if isinstance(tab, int) and 0 < tab < len(names) else None
    opened = step if isinstance(step, int) and 0 <= step < len(steps) else None
    if (chosen, opened) != (show.state.tab, show.state.step):
        show.state = replace(show.state, tab=chosen, step=opened)
        show.remember()
