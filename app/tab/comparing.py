"""Designs beside the present one: pinned, compared, opened again; and any step of the history at once."""

from __future__ import annotations

from dataclasses import replace
from typing import assert_never

from ..lesson.comparing import MOST, Pin, free_name
from ..lesson.knobs import KnobError
from ..text import text
from .gate import named, number
from .orders import Comparing, GoToStep, OpenPin, PinDesign, TurnGhost, Unpin
from .presenter import Presenter

FULL = text("{most} designs are pinned already; unpin one first.", most=MOST)
KNOWN = text("This design is pinned already, as {name}.")
NAMESAKE = text("There is a pin {name} already; choose another name.")
NO_PIN = text("There is no such pin any more.")
NO_STEP = text("There is no such step any more.")


def obey(show: Presenter, command: Comparing) -> None:
    """Do what a command about pins and steps asks. Raises KnobError and what a lesson raises."""
    match command:
        case PinDesign(name):
            _pin(show, named(name))
        case Unpin(place):
            gone = _at(show, place)
            show.change(replace(show.state, pins=tuple(pin for pin in show.state.pins if pin is not gone)))
        case OpenPin(place):
            show.adopt(_at(show, place).design)
        case TurnGhost(place):
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
            raise KnobError(KNOWN.format(name=pin.name))
        if pin.name == name:
            raise KnobError(NAMESAKE.format(name=name))
    if len(pins) >= MOST:
        raise KnobError(FULL)
    show.change(replace(show.state, pins=(*pins, Pin(name or free_name([pin.name for pin in pins]), show.picture.design))))


def _at(show: Presenter, place: object) -> Pin:
    index = int(number(place))
    if not 0 <= index < len(show.state.pins):
        raise KnobError(NO_PIN)
    return show.state.pins[index]


def _go(show: Presenter, place: object) -> None:
    index = int(number(place))
    if not 0 <= index < len(show.picture.steps):
        raise KnobError(NO_STEP)
    if index != show.picture.at:
        show.walk(index - show.picture.at)
