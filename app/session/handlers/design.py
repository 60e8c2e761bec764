"""Handle the commands that change the design: knobs, undo, reset, drawn input, own plants."""

from __future__ import annotations

from dataclasses import replace

from ...course.design import Design
from ...course.knobs import ByHand, KnobError, Pull, Track
from ...plants.examples import example
from ...plants.own_plant import read_plant_file
from ...text import Text, text
from ..commands.commands import SetKnobs
from ..runtime.error_words import kept_for_others
from ..state.validate import check_number
from .playback import play_for_hand
from .presenter import Presenter

YOURS = "yours"
NOTHING_TO_UNDO = text("Nothing to undo.")
SCENE_BEGAN = text("The scene began like this. Undo stops here; open the lab to go back farther.")
ASKS_AGAIN = text("Before you look: what will this knob do? The question stands under the knobs; choose, or skip it.")
NOTHING_TO_REDO = text("Nothing to redo.")


def set_knobs(show: Presenter, edits: list[SetKnobs], moving: bool = False) -> None:
    """Change knobs: validate, compute once, show, remember. A refused edit does not take a good one with it.

    While a knob is `moving`, what is looked at is shown first, and the rest is left to `Presenter.complete`.
    """
    design, keys, refused, grip = show.design, set[str](), None, None
    if any(pulls(edit) for edit in edits) and not play_for_hand(show):
        return
    for edit in edits:
        try:
            design = show.lesson.apply(design, {name: _recorded(show, design, name, edit) for name in edit.values})
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


def pulls(edit: SetKnobs) -> bool:
    """Whether an edit is a hand that pulls the plant."""
    return any(isinstance(value, ByHand) for value in edit.values.values())


def _recorded(show: Presenter, design: Design, name: str, edit: SetKnobs) -> object:
    """The value of an edit; what a hand does to the plant is added to its record at the present time. Raises KnobError."""
    value = edit.values[name]
    if not isinstance(value, ByHand):
        return value
    knob = show.lesson.knob(name)
    if not isinstance(knob, Pull):
        raise KnobError(text("{name} is not drawn by hand.", name=name))
    if abs(value.force) > knob.most * (1 + 1e-9) and edit.grip != show.limited_grip:
        show.limited_grip = edit.grip
        show.view.say(text("A hand pulls with at most {most:g} {unit}.", most=knob.most, unit=knob.unit), False)
    return knob.take(design[name], show.state.t, value)


def start(show: Presenter, plant: str) -> None:
    """Open the lesson at its start with a plant, as one step of undo."""
    show.adopt_design(show.lessons[show.lesson.id].fit(plant).start())
    show.change(replace(show.state, playing=False, loop=None, stopped=False, t=0.0))
    show.view.pose(0.0)


def reset(show: Presenter) -> None:
    """Set every knob to its default."""
    start(show, show.lesson.plant)


def choose_plant(show: Presenter, which: str) -> None:
    """Show the lesson's own plant for "", the one that was brought for YOURS, else an example."""
    start(show, "" if not which else show.state.plant if which == YOURS else example(which))


def undo(show: Presenter) -> None:
    """Go back to the design before."""
    if show.picture.guided and show.design == show.lesson_state.began:
        show.view.say(SCENE_BEGAN, False)
    elif not show.walk(-1):
        show.view.say(NOTHING_TO_UNDO, False)


def redo(show: Presenter) -> None:
    """Go on to the design that was undone."""
    if not show.walk(+1):
        show.view.say(NOTHING_TO_REDO, False)


def refuse(show: Presenter, why: Text) -> None:
    """Say why something that came from the browser is not taken. Raises KnobError."""
    raise KnobError(why)


def upload_plant(show: Presenter, name: object, data: object) -> None:
    """Show the lesson with the plant in a file. Raises KnobError and what a lesson raises."""
    if not isinstance(data, bytes):
        raise KnobError(text("The browser did not send a file; nothing was changed."))
    plant = read_plant_file(str(name), data)
    try:
        start(show, plant)
    except Exception as problem:
        show.state = replace(show.state, plant=plant)
        raise KnobError(kept_for_others(problem)) from problem
    show.change(replace(show.state, plant=plant))


def draw_by_hand(show: Presenter, knob: str, value: object) -> None:
    """Record a hand-drawn input from the present time on. Raises KnobError."""
    track = show.lesson.knob(knob)
    if not isinstance(track, Track):
        raise KnobError(text("{name} is not drawn by hand.", name=knob))
    set_knobs(show, [SetKnobs({knob: track.record(show.design[knob], show.state.t, check_number(value))})])


def pick_point(show: Presenter, x: object, y: object) -> None:
    """Set the knobs that belong to a point of the map, and play the run from its start. Raises KnobError."""
    point = check_number(x), check_number(y)
    if show.lesson.pick is None:
        return
    set_knobs(show, [SetKnobs(show.lesson.pick(show.picture.outcome, *point))])
    if show.state.predicted is not None:
        show.change(replace(show.state, playing=True, loop=None, stopped=False, t=0.0))
