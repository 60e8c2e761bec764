"""Walk a lesson's path as a person would and write down every state that a published page can show."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

from ..course.guiding.predictions import prediction_of
from ..course.knobs import ByHand, KnobError, Pull
from ..course.lesson import Lesson
from ..course.scenes import Choose, Move, Press, Scene, Solve
from ..engine import EngineError
from ..page.record.recorded_screen import Look, RecordedRun
from ..session.commands.commands import Kick, Play, SetKnobs
from ..session.handlers import design, guide, playback
from ..session.handlers.presenter import Presenter
from ..session.runtime.background_jobs import BackgroundJobs
from ..session.state.view import State
from .points import Points, value_for, values_of
from .screens import RecordedScreens, Values

PULLS = (-1.0, -0.5, 0.5, 1.0)  # shares of the largest force with which a hand pulls
HELD_S, HELD_SHARE, HELD_STEPS = 0.4, 0.2, 8  # s and share of a run for which it holds, and steps in which that is recorded
MAX_SOLUTION_KNOBS = 4  # knobs of a task whose steps toward its solution are recorded in every order
Held = tuple[tuple[str, int], ...]  # knobs away from where they were on entry, and the number of their value


@dataclass(frozen=True)
class RecordedState:
    """What stands on each screen; `steps` are shown on the way there, `runs` says that the run then plays from its start.

    `rest` is the moment at which a run that is over rests (s), `part` where its error lives, `done` whether the scene's action is done.
    """

    name: str
    values: tuple[Values, ...]
    run: RecordedRun | None
    told: tuple[Mapping[str, object], ...]
    t: float
    rest: float
    part: tuple[float, float] | None
    done: bool
    runs: bool = False
    steps: tuple[tuple[Values, ...], ...] = ()
    held: Held = ()


@dataclass(frozen=True)
class RecordedScene:
    """One scene: its states, on entry first, and why its action cannot be done here ("" where it can).

    `sketches` are the drawings of the options of a question that is answered by hand: shares of the frame's height at its columns.
    """

    id: str
    action: str
    states: tuple[RecordedState, ...]
    lacks: str = ""
    sketches: tuple[tuple[float, ...], ...] = ()


@dataclass
class Clock:
    """A clock that stands until it is set."""

    now: float = 0.0

    def __call__(self) -> float:
        return self.now


@dataclass
class Recorder:
    """A presenter of one lesson whose pictures stand on recorded screens."""

    lessons: Mapping[str, Lesson]
    lesson: str
    looks: Sequence[Look]
    points: Points = field(default_factory=Points)

    def __post_init__(self) -> None:
        self.clock, self.screens = Clock(), RecordedScreens(self.looks)
        self.show = Presenter(self.lessons, self.screens, self.lesson, State(mode="guide"), self.clock, BackgroundJobs(lambda _: 0), None)
        self.show.open()
        self._start = self.show.state
        self._entered = self._start, self.show.design  # state and design on entry to the scene whose knobs are moved

    @property
    def path(self) -> tuple[Scene, ...]:
        """The scenes of the lesson."""
        return tuple(self.show.lesson.path)

    def scene(self, index: int) -> RecordedScene:
        """All states of one scene."""
        scene = self.path[index]
        entry = self._enter(index)
        question = self.show.picture.question
        sketches = () if question is None or not question.columns else tuple(question.shares_of(option) for option in question.options)
        states = [entry, *self._actions(index, scene)]
        lacks = "" if any(state.done for state in states) else _why_not(scene)
        return RecordedScene(scene.id, _kind(scene), tuple(states), lacks, sketches)

    def overlays(self) -> Mapping[str, tuple[Values, ...]]:
        """What stands while each dialog is open: the page of lessons, the glossary, the list of keys."""
        screens, found = self.screens, dict[str, tuple[Values, ...]]()
        for name, toggle in (("course", lambda: screens.open_course({})), ("terms", screens.open_glossary), ("help", screens.open_help)):
            toggle()
            found[name] = screens.standing()
            toggle()
        return found

    # --- walking ---------------------------------------------------------------------------------------------------
    def begin(self, index: int) -> tuple[tuple[Values, ...], ...]:
        """Enter a scene as somebody who has done nothing yet; what stands on the way."""
        show = self.show
        show.state = replace(self._start, mode="guide", scene=index)
        show.lesson_states.reset_lesson(self.lesson, show.lesson.start())
        guide.enter_scene(show, index)
        return self._perform()

    def _enter(self, index: int) -> RecordedState:
        steps = self.begin(index)
        return self._written("entry", steps=steps)

    def _actions(self, index: int, scene: Scene) -> Iterator[RecordedState]:
        """The states after each thing that a person may do in a scene."""
        if isinstance(scene.do, Choose):
            for choice in range(len(prediction_of(self.show.lesson, scene, "en").options)):
                self.begin(index)
                guide.choose_option(self.show, choice)
                yield self._written(f"option:{choice}", steps=self._perform())
        if self.show.lesson.kick:
            yield self._pressed(index, "kick", lambda: playback.kick(self.show), Kick())
        if isinstance(scene.do, Press) and scene.do.button == "play":
            yield self._pressed(index, "play", lambda: playback.play(self.show), Play())
        if isinstance(scene.do, Press) and scene.do.button == "pull":
            yield from self._pulled(index)
        yield from self._moved(index, scene)

    def _pressed(self, index: int, name: str, press: Callable[[], object], command: Kick | Play) -> RecordedState:
        self.begin(index)
        press()
        guide.follow(self.show, command)
        return self._written(name, runs=True)

    def _pulled(self, index: int) -> Iterator[RecordedState]:
        """A hand that pulls with each of these forces for a while from the start of the run, and lets go."""
        self.begin(index)
        show = self.show
        stage = show.picture.outcome.stage
        held = min(HELD_S, HELD_SHARE * show.picture.horizon)
        for knob in [show.lesson.knob(grip.knob) for grip, _ in stage.held] if stage is not None else []:
            for share in PULLS:
                self.begin(index)
                assert isinstance(knob, Pull)
                for part in range(HELD_STEPS + 1):
                    show.state = replace(show.state, t=held * part / HELD_STEPS)
                    hand = ByHand(share * knob.most, part == HELD_STEPS)
                    edits = [SetKnobs({knob.name: hand}, 1)]
                    design.set_knobs(show, edits)
                guide.follow(show, edits)
                yield self._written(f"pull:{knob.name}:{share:g}", runs=True)

    def _moved(self, index: int, scene: Scene) -> Iterator[RecordedState]:
        """Each knob of the scene at each of its computed values, the others as on entry; and the ways to a task's solution."""
        self.begin(index)
        show, entry = self.show, self.show.design
        self._entered = show.state, entry
        solution = _solution(show.lesson, scene)
        names = dict.fromkeys((*scene.knobs, *(scene.do.knobs if isinstance(scene.do, Move) else ()), *solution))
        grids: dict[str, tuple[Any, ...]] = {}
        for name in names:
            knob = show.lesson.knob(name)
            wanted = [solution[name]] if name in solution else []
            if isinstance(scene.do, Move) and scene.do.goal is not None and name == scene.do.knobs[0]:
                wanted.append(value_for(knob, scene.do.goal))
            grids[name] = values_of(knob, entry[name], self.points, [value for value in wanted if value is not None])
        for name, values in grids.items():
            for number, value in enumerate(values):
                yield from self._moved_to(index, {name: value}, ((name, number),))
        steps = [(name, grids[name].index(value)) for name, value in solution.items() if value in grids.get(name, ())]
        if 1 < len(steps) <= MAX_SOLUTION_KNOBS:
            for taken in product((False, True), repeat=len(steps)):
                held = tuple(step for step, is_taken in zip(steps, taken, strict=True) if is_taken)
                if len(held) > 1:
                    yield from self._moved_to(index, {name: grids[name][number] for name, number in held}, held)

    def _moved_to(self, index: int, values: Mapping[str, Any], held: Held) -> Iterator[RecordedState]:
        show, edits = self.show, [SetKnobs({name: value}) for name, value in values.items()]
        show.state = self._entered[0]
        show.lesson_states.reset_lesson(self.lesson, self._entered[1])
        show.lesson_state.began = self._entered[1]
        try:
            design.set_knobs(self.show, edits)
        except (KnobError, EngineError):  # the lesson refuses this design: the page has no such point
            return
        guide.follow(self.show, edits)
        yield self._written("knob:" + ",".join(f"{name}={number}" for name, number in held), held=held)

    def _perform(self) -> tuple[tuple[Values, ...], ...]:
        """Let the page do what it does by itself; what stands after each step of it."""
        show, steps = self.show, list[tuple[Values, ...]]()
        while show.state.performance is not None:
            steps.append(self.screens.standing())
            self.clock.now = max(self.clock.now, show.state.performance.due)
            guide.tick(show, self.clock.now)
        return tuple(steps)

    def _written(self, name: str, runs: bool = False, steps: tuple[tuple[Values, ...], ...] = (), held: Held = ()) -> RecordedState:
        """The state that stands once the knobs rest and nothing plays."""
        show = self.show
        runs = runs or show.state.playing
        if not show.resting:
            show.rest()
            guide.follow(show, ())
        show.change(replace(show.state, playing=False, loop=None))
        show.view.pose(show.state.t)
        stage, scene = show.picture.outcome.stage, show.picture.scene
        alive = stage is not None and stage.xhat is not None
        part = playback.part_with_error(show) if alive else None
        screens = self.screens.screens
        return RecordedState(name, self.screens.standing(), screens[0].recorded_run(), tuple(screen.told_of_run() for screen in screens),
                             show.state.t, part.telling if part is not None else show.picture.end,
                             (part.begin, part.end) if part is not None else None, scene is not None and scene.id in show.state.done,
                             runs, steps, held)


def _solution(lesson: Lesson, scene: Scene) -> Mapping[str, Any]:
    """The knobs and values that solve the scene's task."""
    if not isinstance(scene.do, Solve):
        return {}
    task = next(task for task in lesson.tasks if task.id == scene.do.task)
    return {name: lesson.knob(name).check(value) for name, value in task.solution.items()}


def _kind(scene: Scene) -> str:
    return type(scene.do).__name__.lower()


def _why_not(scene: Scene) -> str:
    """Why no recorded state has the action of a scene done."""
    if isinstance(scene.do, Press) and scene.do.button == "pull":
        return "pull"
    return "grid"
