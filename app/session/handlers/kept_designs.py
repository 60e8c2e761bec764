"""Handle the commands for designs that are pinned or kept under a name, and for steps of the history."""

from __future__ import annotations

from dataclasses import replace

from ...course.knobs import KnobError
from ...course.pinned_designs import MAX_PINS, Pin, next_pin_letter
from ...text import text
from ..state.saved_state import MAX_SAVED_BYTES, MAX_SAVED_DESIGNS, SavedDesign, SavedState, read_state, write_state
from ..state.validate import check_name, check_number
from .lesson_reload import drop_own_lessons
from .presenter import Presenter

TOO_MANY_PINS = text("{most} designs are pinned already; unpin one first.", most=MAX_PINS)
ALREADY_PINNED = text("This design is pinned already, as {name}.")
NAMESAKE = text("There is a pin {name} already; choose another name.")
NO_PIN = text("There is no such pin any more.")
NO_STEP = text("There is no such step any more.")
TOO_MANY_SAVED = text("{most} designs are kept already; remove one first.", most=MAX_SAVED_DESIGNS)
NO_ROOM = text("There is no room left for this design with its plant; remove one, or save it as a file.")
NAME_IT = text("Give the design a name first.")
NO_SUCH = text("There is no kept design of that name any more.")
SAVED_MESSAGE = text("Kept in this browser as {name}.")
CLEARED = text("This browser now keeps none of your data; the page starts again.")


def pin(show: Presenter, name: object) -> None:
    """Pin the present design. Raises KnobError."""
    name, pins = check_name(name), show.state.pins
    for each in pins:
        if each.design == show.picture.design:
            raise KnobError(ALREADY_PINNED.format(name=each.name))
        if each.name == name:
            raise KnobError(NAMESAKE.format(name=name))
    if len(pins) >= MAX_PINS:
        raise KnobError(TOO_MANY_PINS)
    show.change(replace(show.state, pins=(*pins, Pin(name or next_pin_letter([each.name for each in pins]), show.picture.design))))


def _at(show: Presenter, place: object) -> Pin:
    index = int(check_number(place))
    if not 0 <= index < len(show.state.pins):
        raise KnobError(NO_PIN)
    return show.state.pins[index]


def unpin(show: Presenter, place: object) -> None:
    """Take a pin away. Raises KnobError."""
    gone = _at(show, place)
    show.change(replace(show.state, pins=tuple(each for each in show.state.pins if each is not gone)))


def open_pin(show: Presenter, place: object) -> None:
    """Make a pinned design the present one. Raises KnobError."""
    show.adopt_design(_at(show, place).design)


def toggle_ghost(show: Presenter, place: object) -> None:
    """Show a pin's ghost on the stage, or no longer. Raises KnobError."""
    turned = _at(show, place)
    pins = tuple(replace(each, ghost=not each.ghost) if each is turned else each for each in show.state.pins)
    show.change(replace(show.state, pins=pins))


def go_to_step(show: Presenter, place: object) -> None:
    """Open a design of the history. Raises KnobError."""
    index = int(check_number(place))
    if not 0 <= index < len(show.picture.steps):
        raise KnobError(NO_STEP)
    if index != show.picture.at:
        show.walk(index - show.picture.at)


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
