"""Define a lesson as data: design, computation, figures, checks and tasks."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from types import MappingProxyType, ModuleType
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from ..devices import DeviceDesign
from ..engine.simulation import Run
from ..plants.model import Model
from ..plants.own_plant import model_of, plant_of
from ..text import NO_WORDS, Text, joined, text
from .course_map import NO_PLACE, CoursePlace
from .design import Design as Design
from .design import missing_knob
from .exercises.derivation import Value, no_numbers
from .exercises.exam import Exam
from .exercises.second_prediction import SecondPrediction
from .exercises.typed_answers import Typed
from .figures.figure_record import Sheet
from .figures.records import Figure
from .figures.scene import RUN_LOST as RUN_LOST
from .figures.scene import Board as Board
from .figures.scene import Stage as Stage
from .figures.veil import veiled_figures
from .knobs import Knob, KnobError, Poles
from .lazy import LazyValue
from .many_seeds import SeedTrial
from .own_plant_banner import write_banner
from .reading.lesson_data import read_folder
from .scenes import NO_PATH, Scene
from .script_record import Code

S = TypeVar("S")  # a lesson's study: what it computes of its own
Found = TypeVar("R")  # what a lesson's job finds
KEYS = 3  # knobs that large print keeps in sight
NO_STUDY: Any = None  # of a lesson that computes nothing of its own


@dataclass(frozen=True)
class Check:
    """One machine-checked statement about the present design, with the number it rests on.

    An `informative` one is a finding: which of several cases the design is, or what the lesson shows on purpose; that it does not hold
    is no failure.
    """

    id: str
    text: Text
    holds: bool
    value: float = 0.0
    informative: bool = False


@dataclass(frozen=True)
class Formula:
    """A live equation: LaTeX with the present entries. Entries marked `\\changed{…}` stand out."""

    id: str
    latex: str
    note: Text = NO_WORDS


@dataclass(frozen=True, eq=False)
class Outcome(Generic[S]):
    """What a design leads to. `live` says in one sentence what is seen now; `study` is the lesson's own record.

    What nobody looks at while a knob moves, numbers, checks, formulas and that sentence, may be made `later`.
    """

    design: Design
    gains: Mapping[str, np.ndarray] = field(default_factory=dict)
    poles: Mapping[str, np.ndarray] = field(default_factory=dict)
    metrics: Mapping[str, float] = field(default_factory=dict)
    checks: Sequence[Check] = ()
    run: Run | None = None
    boards: tuple[Board, ...] = ()
    stage: Stage | None = None
    formulas: Sequence[Formula] = ()
    words: Text | LazyValue[Text] = NO_WORDS
    study: S = NO_STUDY

    @property
    def live(self) -> Text:
        """What is seen now, in one sentence."""
        return self.words.value if isinstance(self.words, LazyValue) else self.words

    def complete(self) -> None:
        """Make what was left for later. Raises what the lesson raises."""
        _ = self.live, *map(len, (self.gains, self.poles, self.metrics, self.checks, self.formulas))


@dataclass(frozen=True)
class Verdict:
    """The answer to "check my design": solved or not, and one sentence why."""

    solved: bool
    text: Text


@dataclass(frozen=True)
class Task(Generic[S]):
    """A task that the engine checks. It fails at the lesson's start and passes at its own `solution`.

    `check` asks the design, `typed` a result found with a pencil; a task has one of them or both. `easy` says why a task
    may be solved by a single stop or click; the others are attacked by a test.
    """

    id: str
    check: Callable[[Outcome[S]], Verdict]
    solution: Mapping[str, Any]
    typed: Typed | None = None
    easy: str = ""

    def judge(self, outcome: Outcome[S], said: str = "") -> Verdict:
        """The verdict on a design and on what was typed."""
        found = self.check(outcome)
        if self.typed is None or not found.solved:
            return found
        right, why = self.typed.judge(outcome, said)
        return Verdict(right, joined(why, found.text) if right and found.text.id else why)


def typed_task(id: str, typed: Typed, check: Callable[[Outcome[Any]], Verdict] = lambda _: Verdict(True, NO_WORDS),
           solution: Mapping[str, Any] = MappingProxyType({})) -> Task[Any]:
    """A task whose result is found with a pencil and typed in, on any design that passes `check`."""
    return Task(id, check, solution, typed)


@dataclass(frozen=True)
class Job(Generic[S, Found]):
    """A longer computation that a person starts, and on what its result depends.

    `run(outcome)` yields (fraction, result so far), None while there is none. `key(design)` is what of a design the result rests on:
    the frame keeps results by key and shows one in every design of that key by `shown(outcome, result)`. `figure` is the id
    of the figure that shows what was found. One that `follows` is started by the frame wherever the knobs rest, once a person has
    started it; until it is through, `rough(outcome)` is shown, a coarse result that comes at once, None where none does.
    """

    label: Text
    run: Callable[[Outcome[S]], Iterator[tuple[float, Found | None]]]
    key: Callable[[Design], Hashable]
    shown: Callable[[Outcome[S], Found], Outcome[S]]
    figure: str = ""
    follows: bool = False
    rough: Callable[[Outcome[S]], Found | None] | None = None

    def outcomes(self, outcome: Outcome[S]) -> Iterator[tuple[float, Outcome[S]]]:
        """Run it from an outcome to its end: (fraction, the outcome that shows what is found so far)."""
        last = outcome
        for fraction, found in self.run(outcome):
            last = last if found is None else self.shown(outcome, found)
            yield fraction, last


class LiveDesk(Protocol):
    """What a page beside a running plant asks: pictures and words for a tab, and what its buttons do."""

    recording: Any
    driving: Any
    can_drive: Any
    shown: Callable[[Hashable, Outcome[Any]], tuple[Outcome[Any], Sequence[Figure]]]
    said: Callable[[Hashable], Sequence[Text]]
    toggle_record: Callable[[], object]
    toggle_drive: Callable[[Hashable], object]
    hear: Callable[[Hashable, int], object]
    number: Callable[[Hashable], int]


@dataclass(frozen=True, eq=False)
class Lesson(Generic[S]):
    """One lesson: data and pure functions.

    `compute` is the draft: pure and within 20 ms, its `figures` a `FigureSet` where those of hidden tabs cost much. `job` is the
    longer, cancellable final tier. `pick` turns a click on the lesson's map into changed knob values.
    `adapt(lesson, model)` makes the lesson for a person's own plant;
    `origin` is the lesson that it was made from. `answer` is the index of the right prediction, `answering` the id of
    the figure that shows why. `aside` names the knobs that are turned rarely: the page keeps them behind "more". `key` names
    those that a hall needs, at most KEYS of which matter at once: in large print all others are behind "more knobs".
    `code` says what a script of a design starts from and finds again, where the run is no plain loop.
    `device` says what a device computes, and every how many seconds, where the run is no plain loop; `device_parts` are its parts, by
    their names, that a device can compute alone.
    `take_record(lesson, record, progress=…)` makes the lesson for a person's own record, and tells `progress` the share that is done;
    `estimates` is the table of what a filter finds along a person's record.
    `derived` gives the numbers of the derivation's places, `place` its place in the course, `again` its second prediction,
    `path` its scenes, which are told on the lesson's own plant. `seeds` runs one design on many seeds.
    A `draft` may lack derivation, exams, second prediction and
    translation. `fault` says what is wrong with the files of a lesson that could not be read.
    """

    id: str
    number: int
    knobs: tuple[Knob, ...]
    compute: Callable[[Design], Outcome[S]]
    figures: Callable[[Outcome[S]], Sequence[Figure]]
    answer: int
    tasks: tuple[Task[S], ...]
    source: str
    words: Mapping[str, Any]  # language → Prose
    exams: tuple[Exam, ...] = ()
    answering: str = ""
    kick: bool = True
    aside: tuple[str, ...] = ()
    key: tuple[str, ...] = ()
    job: Job[S, Any] | None = None
    seeds: SeedTrial | None = None
    pick: Callable[[Outcome[S], float, float], Mapping[str, Any]] | None = None
    adapt: Callable[[Lesson, Model], Lesson] | None = None
    universal: bool = False
    bilinear: bool = False
    code: Callable[[Outcome[S]], Code] | None = None
    plant: str = ""
    origin: Lesson | None = None
    derived: Callable[[Outcome[S]], Mapping[str, Value]] = no_numbers
    place: CoursePlace = NO_PLACE
    again: SecondPrediction | None = None
    path: tuple[Scene, ...] = NO_PATH
    questions: Mapping[str, Callable[[Any], Any]] = field(default_factory=dict)  # of scenes: how it is drawn, as `questions.Draw`
    draft: bool = False
    fault: Text = NO_WORDS
    device: Callable[[Outcome[S], float | None], DeviceDesign] | None = None
    estimates: Callable[[Outcome[S]], Sheet] | None = None
    take_record: Callable[..., Lesson] | None = None
    live: LiveDesk | None = None  # of a page beside a running plant
    device_parts: Mapping[str, Callable[[Outcome[S], float | None], DeviceDesign]] = field(default_factory=dict)

    @classmethod
    def from_folder(cls, *modules: ModuleType, **given: Any) -> Lesson[Any]:
        """The lesson of a folder: its data from `lesson.toml` and `path.md`, its words from `en.md`, its functions from its modules.

        `PARTS` says where each is found; `given` are those that have no such place. Raises LessonFileError or ProseError.
        """
        return cls(**read_folder(modules, given))

    @cached_property
    def veil(self) -> tuple[str, ...]:
        """The figures that are veiled until the first question is answered."""
        return veiled_figures(self.path, self.answering, self.figures(self.compute(self.start())))

    def fit(self, plant: str) -> Lesson:
        """This lesson for the user's plant (canonical JSON), itself for "". Raises EngineError or KnobError."""
        if self.origin is not None:
            return self.origin.fit(plant)
        if not plant:
            return self
        if self.adapt is None:
            raise KnobError(text("Lesson {id} is about its own plant; open the sandbox with yours.", id=self.id))
        return _fitted(self, plant)

    def knob(self, name: str) -> Knob:
        """The knob of that name. Raises KnobError with the names that exist."""
        for knob in self.knobs:
            if knob.name == name:
                return knob
        raise missing_knob(name, self.id, self.plant, (k.name for k in self.knobs))

    def start(self) -> Design:
        """The design with every knob at its default."""
        return Design(self.id, tuple((k.name, k.check(k.default)) for k in self.knobs), self.plant)

    def apply(self, design: Design, changes: Mapping[str, Any]) -> Design:
        """The design with validated changes: the only gate to a design. Raises KnobError."""
        return design.with_values(**{name: self.knob(name).check(value) for name, value in changes.items()})

    @property
    def keys(self) -> tuple[str, ...]:
        """The knobs that large print keeps in sight: the `key` ones that a person's own plant still has, else the first three."""
        seen = {k.name for k in self.knobs if self.shown(k, self.start()) and not isinstance(k, Poles)}
        first = [k.name for k in self.knobs if k.name in seen and k.name not in self.aside][:KEYS]
        return tuple(k.name for k in self.knobs if k.name in self.key and not k.hidden) or tuple(first)

    def shown(self, knob: Knob, design: Design) -> bool:
        """Whether the knob matters now and its widget is shown: its condition holds, and that of the knob it names."""
        return not knob.hidden and self._matters(knob, design)

    def _matters(self, knob: Knob, design: Design) -> bool:
        if knob.when is None:
            return True
        name, values = knob.when
        return design[name] in values and self._matters(self.knob(name), design)


@lru_cache(maxsize=32)
def _fitted(origin: Lesson, text: str) -> Lesson:
    """The lesson built for a plant, with a line at its head that says whose plant is shown and whose the text means."""
    assert origin.adapt is not None
    model = model_of(text, held=origin.universal)
    lesson = origin.adapt(origin, model)
    head = write_banner(model, origin.universal, origin.bilinear, bool(plant_of(text).dt))
    kept = {task.id for task in lesson.tasks}
    words = {language: replace(
        prose, introduction=f"{head(language)}\n\n{prose.introduction}",
        tasks={key: task for key, task in prose.tasks.items() if key in kept}) for language, prose in lesson.words.items()}
    derived = no_numbers if lesson.derived is origin.derived else lesson.derived  # made for the lesson's own study
    return replace(lesson, words=words, plant=text, origin=origin, derived=derived, again=None, path=NO_PATH, seeds=None)
