"""Designs kept under names in the browser's own storage: put there, opened, removed; and all that a browser keeps, cleared."""

from __future__ import annotations

from dataclasses import replace
from typing import assert_never

from ..lesson.knobs import KnobError
from ..text import text
from .gate import named
from .orders import ClearBrowser, ForgetDesign, KeepDesign, OpenKept, Shelving
from .presenter import Presenter
from .shelf import MOST, ROOM, Kept
from .state import Saved, read_state, write_state

FULL = text("{most} designs are kept already; remove one first.", most=MOST)
NO_ROOM = text("There is no room left for this design with its plant; remove one, or save it as a file.")
NAME_IT = text("Give the design a name first.")
NO_SUCH = text("There is no kept design of that name any more.")
KEPT = text("Kept in this browser as {name}.")
CLEARED = text("This browser keeps nothing of yours any more; the page starts anew.")


def obey(show: Presenter, command: Shelving) -> None:
    """Do what a command about kept designs asks. Raises KnobError and what a lesson raises."""
    match command:
        case KeepDesign(name):
            _keep(show, named(name))
        case OpenKept(name):
            state = show.state
            saved = read_state(_found(show, name).words, show.lessons)
            show.open_state(replace(saved, language=state.language, lecture=state.lecture, tab=None, step=None, camera=show.view.eye()))
        case ForgetDesign(name):
            gone = _found(show, name)
            show.view.shelve(gone.name, "")
            show.change(replace(show.state, shelf=tuple(kept for kept in show.state.shelf if kept is not gone)))
        case ClearBrowser():
            _clear(show)
        case _:
            assert_never(command)


def _keep(show: Presenter, name: str) -> None:
    """Keep the present design; one of that name is replaced."""
    words = write_state(show.lesson, Saved(show.picture.design))
    others = tuple(kept for kept in show.state.shelf if kept.name != name)
    if not name:
        raise KnobError(NAME_IT)
    if len(others) >= MOST:
        raise KnobError(FULL)
    if sum(len(each.encode()) for each in (words, *(kept.words for kept in others))) > ROOM:
        raise KnobError(NO_ROOM)
    show.view.shelve(name, words)
    show.change(replace(show.state, shelf=(*others, Kept(name, show.lesson.id, words))))
    show.view.say(KEPT.format(name=name), False)


def _found(show: Presenter, name: object) -> Kept:
    for kept in show.state.shelf:
        if kept.name == name:
            return kept
    raise KnobError(NO_SUCH)


def _clear(show: Presenter) -> None:
    """The browser forgets everything, and so does this tab: whoever sits here next finds a page as on the first day."""
    show.view.wipe()
    show.lesson = show.lessons[show.lesson.id]
    show.desks.forget()
    show.desks.renew(show.lesson.id, show.lesson.start())
    show.state = replace(show.state, shelf=(), plant="", key="", tab=None, step=None)
    show.open()
    show.view.say(CLEARED, False)
