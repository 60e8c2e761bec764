"""Handle the commands that save, open and remove named designs or clear the browser's storage."""

from __future__ import annotations

from dataclasses import replace

from ...course.knobs import KnobError
from ...text import text
from ..state.saved_designs import MAX_SAVED_BYTES, MAX_SAVED_DESIGNS, SavedDesign
from ..state.saved_state import SavedState, read_state, write_state
from ..state.validate import check_name
from .lesson_reload import drop_own_lessons
from .presenter import Presenter

TOO_MANY_SAVED = text("{most} designs are kept already; remove one first.", most=MAX_SAVED_DESIGNS)
NO_ROOM = text("There is no room left for this design with its plant; remove one, or save it as a file.")
NAME_IT = text("Give the design a name first.")
NO_SUCH = text("There is no kept design of that name any more.")
SAVED_MESSAGE = text("Kept in this browser as {name}.")
CLEARED = text("This browser now keeps none of your data; the page starts again.")


def save_design(show: Presenter, name: object) -> None:
    """Keep the present design in the browser; one of that name is replaced. Raises KnobError."""
    name = check_name(name)
    words = write_state(show.lesson, SavedState(show.picture.design))
    others = tuple(kept for kept in show.state.shelf if kept.name != name)
    if not name:
        raise KnobError(NAME_IT)
    if len(others) >= MAX_SAVED_DESIGNS:
        raise KnobError(TOO_MANY_SAVED)
    if sum(len(each.encode()) for each in (words, *(kept.words for kept in others))) > MAX_SAVED_BYTES:
        raise KnobError(NO_ROOM)
    show.view.save_design(name, words)
    show.change(replace(show.state, shelf=(*others, SavedDesign(name, show.lesson.id, words))))
    show.view.say(SAVED_MESSAGE.format(name=name), False)


def open_saved_design(show: Presenter, name: object) -> None:
    """Open a kept design; the page keeps its language and its camera. Raises KnobError and what a lesson raises."""
    state, saved = show.state, read_state(_found(show, name).words, show.lessons)
    show.open_state(replace(saved, language=state.language, lecture=state.lecture, tab=None, step=None, camera=show.view.eye()))


def delete_saved_design(show: Presenter, name: object) -> None:
    """Keep a design no longer. Raises KnobError."""
    gone = _found(show, name)
    show.view.save_design(gone.name, "")
    show.change(replace(show.state, shelf=tuple(kept for kept in show.state.shelf if kept is not gone)))


def _found(show: Presenter, name: object) -> SavedDesign:
    for kept in show.state.shelf:
        if kept.name == name:
            return kept
    raise KnobError(NO_SUCH)


def clear_browser(show: Presenter) -> None:
    """The browser forgets everything, and so does this tab: whoever sits here next finds a page as on the first day."""
    show.view.clear_storage()
    drop_own_lessons(show)
    show.lesson = show.lessons[show.lesson.id]
    show.lesson_states.forget()
    show.lesson_states.reset_lesson(show.lesson.id, show.lesson.start())
    show.state = replace(show.state, shelf=(), plant="", key="", tab=None, step=None)
    show.open()
    show.view.say(CLEARED, False)
