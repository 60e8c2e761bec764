"""A session's surroundings, made to be watched: a view that records, a clock that stands still, a lesson that obeys, a job in steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from observer_lab.course.course_map import Progress
from observer_lab.course.exercises.exam import Exam, ExamItem, SeededDraws, decimals
from observer_lab.course.figures.records import Curve as Line
from observer_lab.course.figures.records import LineFigure
from observer_lab.course.knobs import Choice, Number, Poles, Track
from observer_lab.course.lesson import Design, Job, Lesson, Outcome, Stage, Task, Verdict
from observer_lab.course.prose import parse_prose
from observer_lab.engine import EngineError
from observer_lab.plants import MODELS
from observer_lab.session.commands.commands import Command, LookFrom, SetKnobs
from observer_lab.session.handlers.playback import FRAME_S
from observer_lab.session.session import FINAL_PICTURE_DELAY_S, Session
from observer_lab.session.state.view import Picture
from observer_lab.text import Text, same, text

MODEL = MODELS["chip"]
FORBIDDEN, BROKEN, UNDRAWABLE, UNSHOWABLE = 7.0, 8.0, 9.0, 9.5  # values of `gain` at which something goes wrong
WORDS = """# {title}
> question
introduction
## predict
what happens
- this
  > never this
- that
- neither
  > one of them
### reveal
that
## step one
text
## task high: High
statement
- hint
- hint
### solution
because
## task low: Low
statement
- hint
- hint
### solution
because
## exam twice: Twice
twice $[[a]]$
### derivation
$$2\\cdot[[a]]=[[answer]]$$
## source
source
"""


class Clock:
    """Time that passes only when told to."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now

    def advance(self, seconds: float) -> None:
        self.now += seconds


class FakeView:
    """Records every call in order as (name, argument). Refuses to show a gain of UNSHOWABLE."""

    def __init__(self, kept: str | None = None, answers: bool = True) -> None:
        self.calls: list[tuple[str, Any]] = []
        self.kept = kept
        self.zipped = ""  # the .zip of lessons that it keeps
        self.answers = answers  # whether it says at once what it kept
        self.asked: list[Callable[..., object]] = []
        self.addresses: list[tuple[str, str, int]] = []
        self.looks: tuple[float, ...] | None = None
        self.plays = 0.0  # s for which it moves by itself

    def build(self, picture: Picture) -> None:
        self.calls.append(("build", picture))

    def show(self, picture: Picture) -> None:
        if dict(picture.design.values).get("gain") == UNSHOWABLE:
            raise RuntimeError("the screen cannot draw this")
        self.calls.append(("show", picture))

    def pose(self, t: float) -> None:
        self.calls.append(("pose", t))

    def follow(self, stage: Stage) -> None:
        self.calls.append(("follow", stage))

    def play(self, t: float, end: float, rate: float, every: float) -> float:
        if not self.plays:
            self.pose(t)
            return every
        self.calls.append(("play", (t, end, rate)))
        return min(self.plays, (end - t) / rate)

    def progress(self, fraction: float | None, label: Text | None) -> None:
        self.calls.append(("progress", fraction))

    def say(self, text: Text, bad: bool) -> None:
        self.calls.append(("say", (text, bad)))

    def camera(self, preset: str) -> None:
        self.calls.append(("camera", preset))

    def open_figure(self, figure: str) -> None:
        self.calls.append(("figure", figure))

    def open_glossary(self) -> None:
        self.calls.append(("glossary", None))

    def open_help(self) -> None:
        self.calls.append(("help", None))

    def open_course(self, progress: Mapping[str, Progress]) -> None:
        self.calls.append(("course", progress))

    def answer(self, question: float) -> None:
        self.calls.append(("answer", question))

    def look(self, camera: tuple[float, ...] | None) -> None:
        self.looks = camera

    def eye(self) -> tuple[float, ...] | None:
        return self.looks

    def address(self, token: str, lesson: str, asked: int) -> None:
        self.addresses.append((token, lesson, asked))

    def offer(self, token: str) -> None:
        self.calls.append(("offer", token))

    def download(self, name: str, content: bytes) -> None:
        self.calls.append(("file", (name, content)))

    def replay(self, picture: Picture, token: str, camera: tuple[float, ...] | None) -> bytes:
        return f"{token} {camera}".encode()

    def recall(self, answer: Callable[..., object]) -> None:
        self.asked.append(answer)
        if self.answers:
            answer(self.kept, *(("", False, None, None, None, self.zipped) if self.zipped else ()))

    def remember(self, text: str) -> None:
        self.kept = text

    def save_design(self, name: str, words: str) -> None:
        self.calls.append(("shelve", (name, words)))

    def keep_lessons(self, words: str) -> None:
        self.zipped = words

    def clear_storage(self) -> None:
        self.kept = None
        self.calls.append(("wipe", None))

    # --- questions -------------------------------------------------------------------------------------------------
    def of(self, name: str) -> list[Any]:
        """The arguments of all calls of one name."""
        return [argument for call, argument in self.calls if call == name]

    def sentences(self) -> list[Text]:
        """What was said."""
        return [text for text, _ in self.of("say")]

    def scolded(self) -> list[Text]:
        """What was said about something bad."""
        return [text for text, bad in self.of("say") if bad]

    def clear(self) -> None:
        self.calls.clear()


def toy(name: str = "toy", **changes: Any) -> Lesson:
    """A lesson of a few microseconds: x(t) = gain · e^{−t} + offset over `length` seconds."""
    knobs = (
        Number("gain", "g", text("gain"), low=0.0, high=10.0, default=1.0),
        Number("offset", "o", text("offset"), low=-1.0, high=1.0, default=0.0),
        Number("length", "T", text("length"), "s", low=1.0, high=4.0, default=2.0, hidden=True),
        Number("kick", "t_k", text("kick"), "s", low=-1.0, high=4.0, default=-1.0, hidden=True),
        Choice("mode", "", text("mode"), options=(("a", same("a")), ("b", same("b"))), default="a"),
        Poles("poles", "p", text("poles"), default=(-1 + 1j, -1 - 1j)),
        Track("hand", "h", text("hand")),
    )
    lesson = Lesson(
        name, 1, knobs, toy_compute, toy_figures, answer=1,
        tasks=(Task("high", _at_least, {"gain": 5.0}), Task("low", _at_most, {"gain": 0.5})),
        exams=(Exam("twice", decimals(2), toy_exam),), source="none",
        words={lang: parse_prose(WORDS.format(title=f"{name} {lang}")) for lang in ("en", "zh")})
    return replace(lesson, **changes)


def toy_compute(design: Design) -> Outcome:
    gain = design["gain"]
    if gain == FORBIDDEN:
        raise EngineError("Seven is not a gain; choose another.")
    if gain == BROKEN:
        raise ZeroDivisionError("division by zero")
    t = np.linspace(0.0, design["length"], 41)
    x = np.column_stack([gain * np.exp(-t) + design["offset"], 0 * t])
    return Outcome(design, metrics={"gain": gain}, stage=Stage(MODEL.body, t, x), words=same(f"{gain:g}"))


def toy_figures(outcome: Outcome) -> tuple[LineFigure, ...]:
    assert outcome.stage is not None
    if outcome.design["gain"] == UNDRAWABLE or outcome.study == "undrawable":
        raise ValueError("nothing to draw")
    return (LineFigure("x", same("x"), outcome.stage.t, (Line(same("x"), outcome.stage.x[:, 0]),)),)


def toy_exam(lot: SeededDraws) -> ExamItem:
    a = lot.part(1, 900, 100)
    return ExamItem({"a": a}, 2 * a)


def _at_least(outcome: Outcome) -> Verdict:
    return Verdict(outcome.metrics["gain"] >= 5, text("at least 5"))


def _at_most(outcome: Outcome) -> Verdict:
    return Verdict(outcome.metrics["gain"] <= 0.5, text("at most 0.5"))


def job_of(run: Callable[[Outcome], Iterator[tuple[float, Outcome]]]) -> Job:
    """A job that finds whole outcomes, each for its own design."""
    return Job(text("long"), run, key=lambda design: design, shown=lambda outcome, found: found)


class Tab:
    """A session with its view and clock, opened, and worked by hand: no thread, no waiting."""

    def __init__(self, lessons: Mapping[str, Lesson] | None = None, lesson: str | None = None, **options: Any) -> None:
        self.lessons = dict(lessons) if lessons is not None else {"toy": toy()}
        self.view, self.clock = FakeView(), Clock()
        self.session = Session(self.lessons, self.view, lesson or next(iter(self.lessons)), clock=self.clock, **options)
        self.session.restore(None)
        self.session.open()
        self.view.clear()

    # --- doing -----------------------------------------------------------------------------------------------------
    def set(self, **values: Any) -> None:
        """Post new values and work on them."""
        self.session.post(SetKnobs(values))
        self.session.step(0.0)

    def do(self, command: Command) -> None:
        """Post a command and work on it."""
        self.session.post(command)
        self.session.step(0.0)

    def rest(self) -> None:
        """Let the knobs rest until the final picture is drawn."""
        self.clock.advance(FINAL_PICTURE_DELAY_S + 0.01)
        self.session.step(0.0)

    def run_for(self, seconds: float) -> None:
        """Let frames pass."""
        for _ in range(round(seconds / FRAME_S)):
            self.clock.advance(FRAME_S)
            self.session.step(0.0)

    # --- seeing ----------------------------------------------------------------------------------------------------
    @property
    def picture(self) -> Picture:
        """What the session holds to be the last good picture."""
        assert self.session.picture is not None
        return self.session.picture

    @property
    def shown(self) -> Picture:
        """What the view showed last."""
        return self.view.of("show")[-1]

    def __getitem__(self, knob: str) -> Any:
        return self.picture.design[knob]


class Worker:
    """A job of `steps` steps; a command put into the mailbox after each makes the session look up once a step."""

    def __init__(self, steps: int = 4, fail_at: int | None = None, problem: Exception | None = None,
                 study: Callable[[int], object] = lambda i: i) -> None:
        self.steps, self.fail_at, self.problem, self.study = steps, fail_at, problem, study
        self.started = self.ended = self.done = 0
        self.tab = Tab({"toy": toy(job=job_of(self.run)), "other": toy("other")})

    def run(self, outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
        self.started += 1
        try:
            for i in range(1, self.steps + 1):
                if i == self.fail_at and self.problem is not None:
                    raise self.problem
                self.done = i
                self.tab.session.post(LookFrom("all"))
                yield i / self.steps, replace(outcome, study=self.study(i))
        finally:
            self.ended += 1

    def step(self, count: int = 1) -> Tab:
        for _ in range(count):
            self.tab.session.step(0.0)
        return self.tab
