"""Lead along a lesson's path: open scenes, perform predictions, notice what was done."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, assert_never  # the values of knobs are of any kind, as `Any` says

from ...course.knobs import KnobError, Number
from ...course.lesson import Lesson
from ...course.scenes import MODES, Choose, Move, Press, Question, Read, Scene, Solve, entry_values
from ...text import text
from ..commands.commands import Kick, Play
from ..commands.guide import ChooseOption, GoToScene, SetMode, TurnScene
from ..state.validate import check_number
from ..state.view import Performance
from .presenter import Presenter

STEP_S, STEPS = 0.1, 16  # between two moves of a knob that the page performs, and how many they are


def obey(show: Presenter, command: SetMode | GoToScene | TurnScene | ChooseOption) -> None:
    """Do what a command of the guide asks. Raises KnobError."""
    match command:
        case SetMode(mode):
            _set_mode(show, mode)
        case GoToScene(index):
            enter_scene(show, int(check_number(index)))
        case TurnScene(steps):
            enter_scene(show, show.state.scene + steps)
        case ChooseOption(index):
            _choose(show, int(check_number(index)))
        case _:
            assert_never(command)


def _set_mode(show: Presenter, mode: object) -> None:
    if mode not in MODES:
        raise KnobError(text("There is no view {mode}; there are {modes}.", mode=str(mode)[:40], modes=", ".join(MODES)))
    if mode != show.state.mode:
        stop(show)
        show.rebuild(replace(show.state, mode=mode, lecture=mode == "present"))


def enter(show: Presenter) -> None:
    """Open the path's scene where it has not been begun; a path that was left, or came by a link, stands as it was."""
    if show.picture.guided and not show.state.done and not show.state.chosen and not show.desk.entered:
        enter_scene(show, show.state.scene)


def greet(show: Presenter) -> None:
    """Show a newcomer the page of lessons, once."""
    if show.state.newcomer:
        show.state = replace(show.state, newcomer=False)
        show.view.open_course(show.desks.progress(show.lesson.id, show.state))


def enter_scene(show: Presenter, index: int) -> None:
    """Show a scene: its values on the knobs, the run at its start. Beyond the ends of the path nothing happens."""
    path = show.lesson.path
    if not show.picture.guided or not 0 <= index < len(path):
        return
    scene = path[index]
    values = entry_values(path, index, show.lesson.start())
    if any(knob.name == "kick" for knob in show.lesson.knobs):
        values.setdefault("kick", show.lesson.start()["kick"])
    show.state = replace(show.state, scene=index, performance=None, t=0.0, playing=False, loop=None, stopped=False)
    show.adopt_design(show.lesson.apply(show.design, values))
    show.view.camera(scene.view)
    show.view.pose(0.0)
    if isinstance(scene.do, Read) and scene.play:
        _perform(show, scene)
    elif isinstance(scene.do, Read):
        _mark_done(show, scene)
    else:
        show.change(show.state)


def options_of(lesson: Lesson, scene: Scene, language: str) -> tuple[tuple[str, ...], tuple[str, ...], int]:
    """The options of a scene's question, what refutes each, and the index of the right one."""
    words = lesson.words[language]
    if not isinstance(scene.do, Choose):
        return (), (), 0
    if scene.do.question is Question.FIRST:
        return words.options, words.refutations, lesson.answer
    if scene.do.question is Question.SECOND:
        assert words.again is not None and lesson.again is not None
        return words.again.options, words.again.refutations, lesson.again.answer
    own = words.scenes[scene.id]
    return own.options, own.refutations, scene.do.answer


def _choose(show: Presenter, index: int) -> None:
    """Note the option, perform what was asked about, and say the verdict when that is done."""
    scene = show.picture.scene
    if scene is None or not isinstance(scene.do, Choose) or scene.id in show.state.chosen:
        return
    options, _, _ = options_of(show.lesson, scene, show.state.language)
    if not -1 <= index < len(options):
        raise KnobError(text("There are {count} predictions.", count=len(options)))
    state = replace(show.state, chosen={**show.state.chosen, scene.id: index})
    if scene.do.question is Question.FIRST:
        state = replace(state, predicted=index, revealed=True)
    elif scene.do.question is Question.SECOND:
        state = replace(state, again=index, predicted=-1 if state.predicted is None else state.predicted)
    show.change(state)
    _perform(show, scene)


def perform_answer(show: Presenter) -> None:
    """Do what the open scene's question asks about, where nobody has chosen in this tab: the class has."""
    scene = show.picture.scene
    if scene is not None and isinstance(scene.do, Choose) and scene.id not in show.state.chosen:
        _choose(show, -1)


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
    show.state = replace(show.state, performance=None, playing=runs, t=0.0, loop=None)
    show.rest()
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
    """Notice whether the person has just done what the scene asks for."""
    scene = show.picture.scene
    if scene is None or scene.id in show.state.done:
        return
    match scene.do:
        case Move(knobs):
            entry = entry_values(show.lesson.path, show.state.scene, show.lesson.start())
            if isinstance(edits, list) and any(show.design[name] != show.lesson.knob(name).check(entry[name]) for name in knobs):
                _mark_done(show, scene)
        case Press(button):
            if isinstance(edits, Kick if button == "kick" else Play):
                _mark_done(show, scene)
        case Solve(task):
            found = next(t for t in show.lesson.tasks if t.id == task)
            if show.resting and found.judge(show.picture.outcome).solved:
                _mark_done(show, scene)
        case _:
            pass


def _mark_done(show: Presenter, scene: Scene) -> None:
    show.change(replace(show.state, done=show.state.done | {scene.id}))
