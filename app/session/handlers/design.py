"""Handle the commands that change the design: knobs, undo, reset, drawn input, own plants."""

from __future__ import annotations

from dataclasses import replace
from typing import assert_never

from ...course.knobs import KnobError, Track
from ...plants.examples import example
from ...plants.own_plant import read_plant_file
from ...text import text
from ..commands.commands import ChoosePlant, Designing, DrawByHand, PickPoint, Redo, Refuse, Reset, SetKnobs, Undo, UploadPlant
from ..runtime.error_words import kept_for_others
from ..state.validate import check_number
from .presenter import Presenter

YOURS = "yours"
NOTHING_TO_UNDO = text("Nothing to undo.")
ASKS_AGAIN = text("Before you look: what will this knob do? The question stands under the knobs; choose, or skip it.")
NOTHING_TO_REDO = text("Nothing to redo.")


def obey(show: Presenter, command: Designing) -> None:
    """Do what a command about the design asks. Raises KnobError, EngineError and what a lesson raises."""
    match command:
        case Undo():
            if not show.walk(-1):
                show.view.say(NOTHING_TO_UNDO, False)
        case Redo():
            if not show.walk(+1):
                show.view.say(NOTHING_TO_REDO, False)
        case Reset():
            _start(show, show.lesson.plant)
        case DrawByHand(knob, value):
            _draw(show, knob, value)
        case PickPoint(x, y):
            _pick(show, check_number(x), check_number(y))
        case UploadPlant(name, data):
            _upload(show, str(name), data)
        case ChoosePlant(which):
            _start(show, "" if not which else show.state.plant if which == YOURS else example(which))
        case Refuse(why):
            raise KnobError(why)
        case _:
            assert_never(command)


def set_knobs(show: Presenter, edits: list[SetKnobs], moving: bool = False) -> None:
    """Change knobs: validate, compute once, show, remember. A refused edit does not take a good one with it.

    While a knob is `moving`, what is looked at is shown first, and the rest is left to `Presenter.complete`.
    """
    design, keys, refused, grip = show.design, set[str](), None, None
    for edit in edits:
        try:
            design = show.lesson.apply(design, edit.values)
            keys |= edit.values.keys()
            grip = edit.grip if edit.grip is not None else grip
        except KnobError as problem:
            refused = problem
    if keys:
        asked, again = show.picture.asks_second_prediction, show.lesson.again
        if again is not None and show.state.predicted is not None and not keys.isdisjoint(again.knobs):
            show.state = replace(show.state, asked=True)
        show.adopt_design(design, (frozenset(keys), grip), grip is not None, moving)
        if show.picture.asks_second_prediction and not asked:
            show.view.say(ASKS_AGAIN, False)
            show.change(replace(show.state, playing=False, loop=None, stopped=False, t=0.0))  # the stage would answer
            show.view.pose(0.0)
    if refused is not None:
        raise refused


def _start(show: Presenter, plant: str) -> None:
    """Open the lesson at its start with a plant, as one step of undo."""
    show.adopt_design(show.lessons[show.lesson.id].fit(plant).start())
    show.change(replace(show.state, playing=False, loop=None, stopped=False, t=0.0))
    show.view.pose(0.0)


def _upload(show: Presenter, name: str, data: object) -> None:
    if not isinstance(data, bytes):
        raise KnobError(text("The browser did not send a file; nothing was changed."))
    plant = read_plant_file(name, data)
    try:
        _start(show, plant)
    except Exception as problem:
        show.state = replace(show.state, plant=plant)
        raise KnobError(kept_for_others(problem)) from problem
    show.change(replace(show.state, plant=plant))


def _draw(show: Presenter, name: str, value: object) -> None:
    """Record a hand-drawn input from the present time on."""
    knob = show.lesson.knob(name)
    if not isinstance(knob, Track):
        raise KnobError(text("{name} is not drawn by hand.", name=name))
    set_knobs(show, [SetKnobs({name: knob.record(show.design[name], show.state.t, check_number(value))})])


def _pick(show: Presenter, x: float, y: float) -> None:
    """The knobs that belong to a point of the map, and the run from its start."""
    if show.lesson.pick is None:
        return
    set_knobs(show, [SetKnobs(show.lesson.pick(show.picture.outcome, x, y))])
    if show.state.predicted is not None:
        show.change(replace(show.state, playing=True, loop=None, stopped=False, t=0.0))
