"""Handle the commands for pinned designs and for steps of the history."""

from __future__ import annotations

from dataclasses import replace

from ...course.knobs import KnobError
from ...course.pinned_designs import MAX_PINS, Pin, next_pin_letter
from ...text import text
from ..state.validate import check_name, check_number
from .presenter import Presenter

TOO_MANY_PINS = text("{most} designs are pinned already; unpin one first.", most=MAX_PINS)
ALREADY_PINNED = text("This design is pinned already, as {name}.")
NAMESAKE = text("There is a pin {name} already; choose another name.")
NO_PIN = text("There is no such pin any more.")
NO_STEP = text("There is no such step any more.")


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
