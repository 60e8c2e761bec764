"""Lessons as data: a frozen design, what is computed from it, what must be shown, and what must be found out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ..engine.simulation import Run
from ..plants.body import Body
from ..plants.model import Model
from ..plants.own import own_model, plant_of, without_hold
from ..text.words import NO_WORDS, Text
from .figures import Figure
from .knobs import Knob, KnobError


@dataclass(frozen=True)
class Design:
    """Everything a person has chosen in a lesson: the one record that undo, share links, files and tests carry.

    `plant` is the user's own plant as canonical JSON (`app.plants.own.canonical`), empty for the lesson's own.
    """

    lesson: str
    values: tuple[tuple[str, Any], ...]
    plant: str = ""

    def __getitem__(self, name: str) -> Any:
        for key, value in self.values:
            if key == name:
                return value
        raise KeyError(name)

    def with_values(self, **changes: Any) -> Design:
        """The same design with some values changed; nothing is checked here, `Lesson.apply` does that."""
        return Design(self.lesson, tuple((key, changes.get(key, value)) for key, value in self.values), self.plant)

    def same_but_for(self, other: Design, names: Iterable[str]) -> bool:
        """Whether the other design differs from this one in the named values at most; names that it has not are passed over."""
        theirs = dict(other.values)
        return self.with_values(**{name: theirs[name] for name in names if name in theirs}) == other


@dataclass(frozen=True, eq=False)
class Board:
    """A pole board: the poles that `knob` holds, which of them can be dragged, and what part of the plane is shown.

    `reached` are the poles that the gain really gives; `fixed` poles are bolted: no gain moves them. A board with
    `knob` None only mirrors. `side` is where it stands, left or right of the plant.
    """

    id: str
    title: Text
    poles: tuple[complex, ...]
    knob: str | None = None
    fixed: tuple[complex, ...] = ()
    zeros: tuple[complex, ...] = ()
    role: str = "plant"
    side: str = "left"
    re_low: float = -10.0
    re_high: float = 2.0
    im_high: float = 8.0
    also: tuple[tuple[str, Any], ...] = ()  # knobs that dragging sets too
    disc: bool = False  # discrete time: stable is inside the unit circle
    landscape: np.ndarray | None = None  # matrix whose |det(sI − M)|⁻¹ is drawn in front, if any

    def hold(self, s: complex) -> complex:
        """The point of the window that is nearest to s: a pole beyond the board's edge stands on the edge."""
        return complex(min(max(s.real, self.re_low), self.re_high), min(max(s.imag, -self.im_high), self.im_high))

    @property
    def held(self) -> tuple[complex, ...]:
        """The poles where they stand on the board and can be dragged from."""
        return tuple(map(self.hold, self.poles))


@dataclass(frozen=True, eq=False)
class Stage:
    """What the 3-D stage plays: a body along the true trajectory and, as a ghost, along its estimate.

    A record of x or xhat is what `body.pose` takes: the plant's state, and after it whatever else a body shows that no
    equation moves (where sensors stand, which are on, an ellipsoid of states).
    `spread` is a radius per time (stage units) of the uncertainty at each anchor, if there is noise.
    """

    body: Body
    t: np.ndarray
    x: np.ndarray
    xhat: np.ndarray | None = None
    u: np.ndarray | None = None
    spread: np.ndarray | None = None


@dataclass(frozen=True)
class Check:
    """One machine-checked statement about the present design, with the number it rests on."""

    id: str
    text: Text
    holds: bool
    value: float = 0.0


@dataclass(frozen=True)
class Formula:
    """A live equation: LaTeX with the present entries. Entries marked `\\changed{…}` by `live_matrix` stand out."""

    id: str
    latex: str
    note: Text = NO_WORDS


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a design leads to. `live` says in one sentence what is seen now; `extra` is the lesson's own."""

    design: Design
    gains: Mapping[str, np.ndarray] = field(default_factory=dict)
    poles: Mapping[str, np.ndarray] = field(default_factory=dict)
    metrics: Mapping[str, float] = field(default_factory=dict)
    checks: tuple[Check, ...] = ()
    run: Run | None = None
    boards: tuple[Board, ...] = ()
    stage: Stage | None = None
    formulas: tuple[Formula, ...] = ()
    live: Text = NO_WORDS
    extra: Any = None


@dataclass(frozen=True)
class Verdict:
    """The answer to "check my design": solved or not, and one sentence why."""

    solved: bool
    text: Text


@dataclass(frozen=True)
class Task:
    """A task that the engine checks. It fails at the lesson's start and passes at its own `solution`."""

    id: str
    check: Callable[[Outcome], Verdict]
    solution: Mapping[str, Any]


@dataclass(frozen=True)
class ExamItem:
    """One exam item: numbers for the text's placeholders, the right answer, and how near an answer must be."""

    numbers: Mapping[str, str]
    answer: float
    tolerance: float


@dataclass(frozen=True)
class Job:
    """A longer computation that a person starts: a generator of (fraction, outcome), the last outcome being whole."""

    label: Text
    run: Callable[[Outcome], Iterator[tuple[float, Outcome]]]


@dataclass(frozen=True)
class Lesson:
    """One lesson: data and pure functions; its words are in `en.md` and `zh.md` beside it.

    `compute` is the draft: pure and within 20 ms. `job` is the longer, cancellable final tier. `pick` turns a click
    on the lesson's map into changed knob values. `carry(before, after)` hands what the job found for one design over
    to the next where it still holds, and returns `after` itself where it does not. `answer` is the index of the right
    prediction.
    """

    id: str
    number: int
    knobs: tuple[Knob, ...]
    compute: Callable[[Design], Outcome]
    figures: Callable[[Outcome], tuple[Figure, ...]]
    answer: int
    tasks: tuple[Task, ...]
    exam: Callable[[int], ExamItem]
    source: str
    words: Mapping[str, Any]  # language → Prose
    kick: bool = True
    job: Job | None = None
    pick: Callable[[Outcome, float, float], Mapping[str, Any]] | None = None
    carry: Callable[[Outcome, Outcome], Outcome] | None = None
    adapt: Callable[[Model], Lesson] | None = None
    universal: bool = False
    plant: str = ""

    def fit(self, plant: str) -> Lesson:
        """This lesson for the user's plant (canonical JSON), itself for "". Raises EngineError or KnobError."""
        if not plant:
            return self
        if self.adapt is None:
            raise KnobError(Text(f"Lesson {self.id} is about its own plant; open the sandbox with yours.",
                                 f"课程 {self.id} 只针对自带的对象；请在“沙盒”课中使用你的对象。"))
        return _fitted(self.adapt, self.universal, plant)

    def knob(self, name: str) -> Knob:
        """The knob of that name. Raises KnobError with the names that exist."""
        for knob in self.knobs:
            if knob.name == name:
                return knob
        names = ", ".join(k.name for k in self.knobs)
        raise KnobError(Text(f"Lesson {self.id} has no knob {name[:40]}; it has {names}.",
                             f"课程 {self.id} 没有名为 {name[:40]} 的旋钮；现有：{names}。"))

    def start(self) -> Design:
        """The design with every knob at its default."""
        return Design(self.id, tuple((k.name, k.check(k.default)) for k in self.knobs), self.plant)

    def apply(self, design: Design, changes: Mapping[str, Any]) -> Design:
        """The design with validated changes: the only gate to a design. Raises KnobError."""
        return design.with_values(**{name: self.knob(name).check(value) for name, value in changes.items()})

    def shown(self, knob: Knob, design: Design) -> bool:
        """Whether the knob matters now and its widget is shown: its condition holds, and that of the knob it names."""
        return not knob.hidden and self._matters(knob, design)

    def _matters(self, knob: Knob, design: Design) -> bool:
        if knob.when is None:
            return True
        name, values = knob.when
        return design[name] in values and self._matters(self.knob(name), design)


@lru_cache(maxsize=32)
def _fitted(adapt: Callable[[Model], Lesson], universal: bool, text: str) -> Lesson:
    """The lesson built for a plant, with a line at its head that says whose plant is shown and whose the text means."""
    plant = plant_of(text)
    model = own_model(plant if universal else without_hold(plant))
    lesson = adapt(model)
    kept = {task.id for task in lesson.tasks}
    words = {language: replace(
        prose, introduction=f"{_whose(model, universal, bool(plant.dt))(language)}\n\n{prose.introduction}",
        tasks={key: task for key, task in prose.tasks.items() if key in kept}) for language, prose in lesson.words.items()}
    return replace(lesson, words=words, plant=text, adapt=adapt, universal=universal)


def _whose(model: Model, universal: bool, sampled: bool) -> Text:
    p = model.plant
    name = Text(f"“{model.label.en}”" if p.name else model.label.en, f"“{model.label.zh}”" if p.name else model.label.zh)
    shown = Text(f"**This page shows {name.en}** (states {p.n}, inputs {p.m}, outputs {p.p}).",
                 f"**本页显示的是{name.zh}**（状态 {p.n}，输入 {p.m}，输出 {p.p}）。")
    if universal:
        return shown
    hold = (Text(" It came sampled; here it is the continuous plant that a held input turns into those samples.",
                 "它原是采样对象，这里用的是与之对应的连续对象（零阶保持的逆变换）。") if sampled else Text("", ""))
    return Text(f"{shown.en} Text, prediction and exam item speak of the lesson's own plant.{hold.en}",
                f"{shown.zh}文字、预测和考题讲的是本课自带的对象。{hold.zh}")
