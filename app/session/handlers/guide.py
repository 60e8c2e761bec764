"""Lead along a lesson's path: open scenes, perform predictions, notice what was done."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any  # the values of knobs are of any kind, as `Any` says

from ...course.guiding.goals import judge_move
from ...course.guiding.predictions import prediction_of
from ...course.knobs import ByHand, KnobError, Number, Pull
from ...course.lesson import Design, Lesson
from ...course.scenes import MODES, Choose, Move, Press, Question, Read, Scene, Solve, entry_values
from ...text import text
from ..commands.commands import Kick, Play
from ..state.validate import check_number
from ..state.view import Performance
from .playback import telling_moment
from .presenter import Presenter

MAX_SKETCH_CHARACTERS = 1000  # of a prediction that was drawn by hand
STEP_S, STEPS = 0.1, 16  # between two moves of a knob that the page performs, and how many they are


def set_mode(show: Presenter, mode: object) -> None:
    """Show the lesson as a guide, as a lab, or for a hall. Raises KnobError."""
    if mode not in MODES:
        raise KnobError(text("There is no view {mode}; there are {modes}.", mode=str(mode)[:40], modes=", ".join(MODES)))
    if mode != show.state.mode:
        stop(show)
        show.rebuild(replace(show.state, mode=mode, lecture=mode == "present"))


def enter(show: Presenter) -> None:
    """Open the path's scene where it has not been begun; a path that was left, or came by a link, stands as it was."""
    if show.picture.guided and not show.state.done and not show.state.chosen and not show.lesson_state.entered:
        enter_scene(show, show.state.scene)
    elif show.lesson_state.entered:
        begin_opened(show)


def begin_opened(show: Presenter) -> None:
    """Begin a scene that a link brought: its run rests where it tells most, and what is read of is performed where it begins."""
    scene = show.picture.scene
    if scene is None or scene.id in show.state.done or show.design.plant:
        return
    if scene_rests(scene) and show.state.t == 0.0 and not show.state.moving:
        show.change(replace(show.state, t=telling_moment(show)))
        show.view.pose(show.state.t)
    elif isinstance(scene.do, Read) and scene.play and show.design == entry_design(show, show.state.scene):
        _perform(show, scene)


def scene_rests(scene: Scene) -> bool:
    """Whether a scene begins in the midst of its run: it asks for no answer, presses and performs nothing, or names a moment."""
    return scene.moment is not None or (not isinstance(scene.do, Choose | Press) and not scene.play)


def greet(show: Presenter) -> None:
    """Show a newcomer the page of lessons, once."""
    if show.state.newcomer:
        show.state = replace(show.state, newcomer=False)
        show.view.open_course(show.lesson_states.progress(show.lesson.id, show.state))


def enter_scene(show: Presenter, index: int) -> None:
    """Show a scene: its values on the knobs, its run where it shows most. A question and a press begin at the start of the run.

    Beyond the ends of the path nothing happens.
    """
    path = show.lesson.path
    if not show.picture.guided or not 0 <= index < len(path):
        return
    scene = path[index]
    kept = show.state.done.get(scene.id) if scene.answers else None
    show.state = replace(show.state, scene=index, performance=None, t=0.0, playing=False, loop=None, stopped=False)
    show.adopt_design(kept or entry_design(show, index))
    show.lesson_state.began = show.design
    show.view.camera(scene.view)
    if kept is not None or scene_rests(scene):
        show.state = replace(show.state, t=telling_moment(show))
    show.view.pose(show.state.t)
    if kept is None and isinstance(scene.do, Read) and scene.play:
        _perform(show, scene)
    elif kept is None and isinstance(scene.do, Read):
        _mark_done(show, scene)
    else:
        show.change(show.state)
    show.remember()


def entry_design(show: Presenter, index: int) -> Design:
    """The design with which a scene begins: what the path has set, and all else as the person left it."""
    start = show.lesson.start()
    values = entry_values(show.lesson.path, index, start)
    for knob in show.lesson.knobs:
        if knob.name == "kick" or isinstance(knob, Pull):
            values.setdefault(knob.name, start[knob.name])
    return show.lesson.apply(show.design, values)


def restart_scene(show: Presenter) -> None:
    """Begin the open scene anew: what was answered or done in it is forgotten."""
    scene = show.picture.scene
    if scene is not None:
        show.state = replace(show.state, done=_without(show.state.done, scene.id), chosen=_without(show.state.chosen, scene.id),
                             sketches=_without(show.state.sketches, scene.id))
        if isinstance(scene.do, Solve):  # knobs that the path does not set still stand where they have solved it
            asked, start = scene.do.task, show.lesson.start()
            solution = next(task.solution for task in show.lesson.tasks if task.id == asked)
            show.adopt_design(show.lesson.apply(show.design, {name: start[name] for name in solution}))
        enter_scene(show, show.state.scene)


def show_kept_run(show: Presenter) -> None:
    """Show the run again that the verdict of the open scene speaks of."""
    scene = show.picture.scene
    if scene is not None and scene.id in show.state.done:
        show.adopt_design(show.state.done[scene.id])
        show.change(replace(show.state, playing=False, loop=None, t=telling_moment(show)))
        show.view.pose(show.state.t)


def _without(found: Mapping[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in found.items() if key != name}


def choose_option(show: Presenter, index: object) -> None:
    """Note the option, perform what was asked about, and say the verdict when that is done. Raises KnobError."""
    scene, choice = show.picture.scene, int(check_number(index))
    if scene is None or not isinstance(scene.do, Choose) or scene.id in show.state.chosen:
        return
    options = prediction_of(show.lesson, scene, show.state.language).options
    if not -1 <= choice < len(options):
        raise KnobError(text("There are {count} predictions.", count=len(options)))
    state = replace(show.state, chosen={**show.state.chosen, scene.id: choice})
    if scene.do.question is Question.FIRST:
        state = replace(state, predicted=choice, revealed=True)
    elif scene.do.question is Question.SECOND:
        state = replace(state, again=choice, predicted=-1 if state.predicted is None else state.predicted)
    show.change(state)
    _perform(show, scene)


def answer_by_hand(show: Presenter, heights: object) -> None:
    """Note a drawing as the answer: the option that it is nearest to is chosen. Raises KnobError where it cannot be read."""
    scene, drawn = show.picture.scene, show.picture.question
    if scene is None or drawn is None or not drawn.columns or scene.id in show.state.chosen:
        return
    parts = str(heights).split(",") if len(str(heights)) <= MAX_SKETCH_CHARACTERS else []
    try:
        shares = tuple(min(max(check_number(float(part)), 0.0), 1.0) for part in parts)
    except ValueError:
        shares = ()
    nearest = drawn.nearest(shares)
    show.state = replace(show.state, sketches={**show.state.sketches, scene.id: shares})
    choose_option(show, nearest)


def perform_answer(show: Presenter) -> None:
    """Do what the open scene's question asks about, where nobody has chosen in this tab: the class has."""
    scene = show.picture.scene
    if scene is not None and isinstance(scene.do, Choose) and scene.id not in show.state.chosen:
        choose_option(show, -1)


def _perform(show: Presenter, scene: Scene) -> None:
    """Move the knobs of a scene's `play` visibly, then play the run from its start."""
    frames = _frames(show, scene.play) if scene.play else ()
    if show.state.calm:
        frames = frames[-1:]
    show.change(replace(show.state, performance=Performance(frames, show.clock())))
    tick(show, show.clock())


def _frames(show: Presenter, play: Mapping[str, Any]) -> tuple[Mapping[str, Any], ...]:
    return tuple({name: _between(show.lesson, name, show.design[name], value, (k + 1) / STEPS) for name, value in play.items()}
                 for k in range(STEPS))


def _between(lesson: Lesson, name: str, before: Any, after: Any, share: float) -> Any:
    """A value on the way from one to another; what is no number changes half-way."""
    knob = lesson.knob(name)
    after = knob.check(after)
    if share >= 1.0:
        return after
    if isinstance(knob, Number):
        if knob.scale == "log":
            return knob.check(math.exp((1 - share) * math.log(before) + share * math.log(after)))
        return knob.check((1 - share) * before + share * after)
    if isinstance(after, tuple) and len(after) == len(before) and all(isinstance(v, complex) for v in after):
        mixed = tuple((1 - share) * a + share * b for a, b in zip(before, after, strict=True))
        try:
            return knob.check(mixed)
        except KnobError:  # pairs that meet on the real axis on the way
            return before
    return before if share < 0.5 else after


def tick(show: Presenter, now: float) -> None:
    """What is due of a performance at `now`; when it is over the run plays and the scene is done."""
    performance = show.state.performance
    if performance is None or now < performance.due - 1e-9:
        return
    scene = show.picture.scene
    if scene is None:
        stop(show)
        return
    if performance.frames:
        show.state = replace(show.state, performance=Performance(performance.frames[1:], now + STEP_S))
        show.adopt_design(show.lesson.apply(show.design, performance.frames[0]), key=("performance", scene.id), held=True, moving=True)
        show.complete()
        return
    runs = scene.runs and show.picture.horizon > 0 and not show.state.calm
    show.last_tick = show.clock()
    show.state = replace(show.state, performance=None, playing=runs, t=0.0 if runs else telling_moment(show), loop=None)
    show.rest()
    show.view.pose(show.state.t)
    _mark_done(show, scene)


def wait(show: Presenter, now: float) -> float | None:
    """Seconds until the performance goes on, None while there is none."""
    return None if show.state.performance is None else max(0.0, show.state.performance.due - now)


def stop(show: Presenter) -> None:
    """Break a performance off: its last step is taken at once."""
    performance = show.state.performance
    if performance is not None:
        show.state = replace(show.state, performance=None)
        if performance.frames:
            show.adopt_design(show.lesson.apply(show.design, performance.frames[-1]))


def follow(show: Presenter, edits: object) -> None:
    """Notice whether the person has just done what the scene asks for.

    A move and a task are judged where the knobs rest. As long as they hold after further changes, the latest run is the one that is kept.
    """
    scene = show.picture.scene
    if scene is None or show.state.performance is not None:
        return
    match scene.do:
        case Move():
            began = show.lesson_state.began or entry_design(show, show.state.scene)
            if show.resting and judge_move(show.lesson, scene.do, began, show.design)[0]:
                _mark_done(show, scene)
        case Press(button):
            if scene.id not in show.state.done and _pressed(button, edits):
                _mark_done(show, scene)
        case Solve(task):
            found = next(t for t in show.lesson.tasks if t.id == task)
            if show.resting and found.judge(show.picture.outcome).solved:
                _mark_done(show, scene)
        case _:
            pass


def _pressed(button: str, edits: object) -> bool:
    """Whether edits are what a scene asks for: play, kick, or a pull that has been let go."""
    if button == "pull":
        hands = [value for edit in edits for value in edit.values.values()] if isinstance(edits, list) else []
        return any(isinstance(value, ByHand) and value.released for value in hands)
    return isinstance(edits, Kick if button == "kick" else Play)


def _mark_done(show: Presenter, scene: Scene) -> None:
    if show.state.done.get(scene.id) != show.design:
        show.change(replace(show.state, done={**show.state.done, scene.id: show.design}))
