"""Handle the commands for pinned designs and for steps of the history."""

from __future__ import annotations

from dataclasses import replace
from typing import assert_never

from ...course.knobs import KnobError
from ...course.pinned_designs import MAX_PINS, Pin, next_pin_letter
from ...text import text
from ..commands.files import Comparing, GoToStep, OpenPin, PinDesign, ToggleGhost, Unpin
from ..state.validate import check_name, check_number
from .presenter import Presenter

TOO_MANY_PINS = text("{most} designs are pinned already; unpin one first.", most=MAX_PINS)
ALREADY_PINNED = text("This design is pinned already, as {name}.")
NAMESAKE = text("There is a pin {name} already; choose another name.")
NO_PIN = text("There is no such pin any more.")
NO_STEP = text("There is no such step any more.")


def obey(show: Presenter, command: Comparing) -> None:
    """Do what a command about pins and steps asks. Raises KnobError and what a lesson raises."""
    match command:
        case PinDesign(name):
            _pin(show, check_name(name))
        case Unpin(place):
            gone = _at(show, place)
            show.change(replace(show.state, pins=tuple(pin for pin in show.state.pins if pin is not gone)))
        case OpenPin(place):
            show.adopt_design(_at(show, place).design)
        case ToggleGhost(place):
            turned = _at(show, place)
            show.change(replace(show.state, pins=tuple(replace(pin, ghost=not pin.ghost) if pin is turned else pin
                                                       for pin in show.state.pins)))
        case GoToStep(place):
            _go(show, place)
        case _:
            assert_never(command)


def _pin(show: Presenter, name: str) -> None:
    pins = show.state.pins
    for pin in pins:
        if pin.design == show.picture.design:
            raise KnobError(ALREADY_PINNED.format(name=pin.name))
        if pin.name == name:
            raise KnobError(NAMESAKE.format(name=name))
    if len(pins) >= MAX_PINS:
        raise KnobError(TOO_MANY_PINS)
    show.change(replace(show.state, pins=(*pins, Pin(name or next_pin_letter([pin.name for pin in pins]), show.picture.design))))


def _at(show: Presenter, place: object) -> Pin:
    index = int(check_number(place))
    if not 0 <= index < len(show.state.pins):
        raise KnobError(NO_PIN)
    return show.state.pins[index]


def _go(show: Presenter, place: object) -> None:
    index = int(check_number(place))
    if not 0 <= index < len(show.picture.steps):
        raise KnobError(NO_STEP)
    if index != show.picture.at:
        show.walk(index - show.picture.at)
