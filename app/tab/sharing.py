"""States that travel: opened from a link, a token or a file, taken away as such."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import assert_never

from ..engine import EngineError
from ..lesson.figures import tabs
from ..lesson.knobs import KnobError
from ..text import joined, told
from .commands import OpenState, Placed, SaveState, Sharing, ToggleTake
from .presenter import Presenter
from .state import NO_STATE, Saved, read_state, write_state
from .token import is_token, read_token, write_token
from .unexpected import NOT_DONE, kind_of

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
        case Placed(tab, step):
            _place(show, tab, step)
        case ToggleTake():
            show.view.offer(write_token(show.lesson, show.saved()))
        case SaveState():
            show.view.hand_over(f"{show.lesson.id}.json", write_state(show.lesson, show.saved()).encode())
        case _:
            assert_never(command)


def take(show: Presenter, words: object) -> None:
    """Open the state in a token, a link or the words of a file, and say what could not be taken over. Raises KnobError and
    what the lesson raises."""
    saved = _read(show, words)
    show.open_state(saved)
    if saved.notes:
        show.tell(joined(*saved.notes), False)


def open_words(show: Presenter, words: str) -> None:
    """Open a state with which a page was called; where that fails, the page opens as it would, with a sentence."""
    try:
        take(show, words)
    except (KnobError, EngineError) as problem:
        show.tell(told(problem), True)
    except Exception as problem:
        log.exception("a link could not be opened")
        show.tell(NOT_DONE.format(kind=kind_of(problem)), True)


def look_again(show: Presenter, token: str) -> None:
    """After a reload: how the page looked, from the token that this tab has put into the address bar itself."""
    try:
        saved = _read(show, token)
    except KnobError:
        return
    if saved.design.lesson == show.lesson.id:
        show.state = replace(show.state, tab=saved.tab, step=saved.step, camera=saved.camera)


def _read(show: Presenter, words: object) -> Saved:
    if isinstance(words, bytes):
        words = words.decode(errors="replace")
    if not isinstance(words, str):
        raise KnobError(NO_STATE)
    return read_token(words, show.lessons) if is_token(words) or "{" not in words else read_state(words, show.lessons)


def _place(show: Presenter, tab: object, step: object) -> None:
    names, steps = tabs(show.picture.figures), show.lesson.words["en"].steps
    chosen = names[tab]("en") if isinstance(tab, int) and 0 < tab < len(names) else None
    opened = step if isinstance(step, int) and 0 <= step < len(steps) else None
    if (chosen, opened) != (show.state.tab, show.state.step):
        show.state = replace(show.state, tab=chosen, step=opened)
        show.remember()
