"""Everything that a page says of a design, as sentences with the place where each stands."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from ..engine import EngineError
from ..text import Text, error_words, label_in_language
from .figures.figure_record import Part, numbered
from .figures.records import Figure
from .knobs import Choice, Knob, KnobError
from .lesson import Lesson, Outcome, Stage, Task
from .prose import PredictionWords, Prose

LETTERS = re.compile(r"[^\W\d_]{2}|[\u4e00-\u9fff]")  # a number, a symbol or a sign says nothing to be read


@dataclass(frozen=True)
class Sentence:
    """What a page says at one place, in one language; `where` names the place, such as "figure.poles.caption"."""

    where: str
    text: str
    lang: str


def sentences(lesson: Lesson, outcome: Outcome, language: str) -> tuple[Sentence, ...]:
    """Everything that the page says of a design in a language, the prose last. Raises what the lesson's figures raise."""
    parts = (*live_parts(lesson, outcome), *prose_parts(lesson.words[language]))
    return tuple(Sentence(where, said, language) for where, words in parts if LETTERS.search(said := label_in_language(words, language)))


def live_parts(lesson: Lesson, outcome: Outcome) -> Iterator[Part]:
    """What depends on the design: the live sentence, checks, notes of formulas, boards, stage, figures, knobs in sight, verdicts."""
    yield "live", outcome.live
    yield from ((f"check.{check.id}", check.text) for check in outcome.checks)
    yield from ((f"formula.{formula.id}", formula.note) for formula in outcome.formulas)
    yield from ((f"board.{board.id}", board.title) for board in outcome.boards)
    if outcome.stage is not None:
        yield from _stage(outcome.stage)
    yield from figure_parts(lesson.figures(outcome))
    for knob in lesson.knobs:
        if lesson.shown(knob, outcome.design):
            yield from _knob(knob)
    if lesson.job is not None:
        yield "job", lesson.job.label
    yield from ((f"task.{task.id}.verdict", _verdict(task, outcome)) for task in lesson.tasks)


def figure_parts(figures: Iterable[Figure]) -> Iterator[Part]:
    """Tab, title, caption, axes, names of curves and marks, heads and cells of every figure."""
    return ((f"figure.{figure.id}.{name}", words) for figure in figures for name, words in figure.words())


def _stage(stage: Stage) -> Iterator[Part]:
    yield "stage", stage.body.caption
    yield from numbered("stage.label", (words for words, _ in stage.body.labels))
    if stage.body.marks is not None and stage.xhat is not None:
        marks = stage.body.marks(stage.x[0].tolist(), stage.xhat[0].tolist(), stage.body.gain)
        yield from numbered("stage.mark", (words for words, *_ in marks.words if not isinstance(words, str)))
    if stage.u is not None:
        arrows = stage.body.arrows(stage.x[0].tolist(), stage.u[0].tolist(), stage.body.gain)
        yield from numbered("stage.arrow", (arrow.called[0] for arrow in arrows if arrow.called is not None))
    yield from numbered("stage.note", stage.note)


def _knob(knob: Knob) -> Iterator[Part]:
    yield from ((f"knob.{knob.name}", knob.label), (f"knob.{knob.name}.hint", knob.hint))
    if knob.group is not None:
        yield f"knob.{knob.name}.group", knob.group
    if isinstance(knob, Choice):
        yield from ((f"knob.{knob.name}.option.{name}", words) for name, words in knob.options)


def _verdict(task: Task, outcome: Outcome) -> Text:
    """What "check my design" answers now, or why it cannot be answered."""
    try:
        return task.check(outcome).text
    except (EngineError, KnobError) as problem:
        return error_words(problem)


def prose_parts(prose: Prose) -> Iterator[tuple[str, str]]:
    """The texts of a lesson's prose in Markdown, in the order of the page, each with its place, such as "task.one.hint.2"."""
    yield from (("title", prose.title), ("question", prose.question), ("introduction", prose.introduction))
    yield from _asked("predict", PredictionWords(prose.predict, prose.options, prose.refutations, prose.reveal))
    if prose.again is not None:
        yield from _asked("again", prose.again)
    for number, (heading, words) in enumerate(prose.steps, 1):
        yield from ((f"step.{number}.title", heading), (f"step.{number}", words))
    for number, step in enumerate(prose.derivation, 1):
        yield from ((f"derive.{number}.title", step.heading), (f"derive.{number}", step.text), (f"derive.{number}.why", step.why))
    for key, task in prose.tasks.items():
        yield from ((f"task.{key}.title", task.title), (f"task.{key}", task.statement))
        yield from ((f"task.{key}.hint.{number}", hint) for number, hint in enumerate(task.hints, 1))
        yield f"task.{key}.solution", task.solution
    for key, exam in prose.exams.items():
        yield from ((f"exam.{key}.title", exam.title), (f"exam.{key}", exam.statement), (f"exam.{key}.derivation", exam.derivation))
    yield "source", prose.source
    yield from ((f"reference.{number}", words) for number, words in enumerate(prose.references, 1))


def _asked(where: str, asked: PredictionWords) -> Iterator[tuple[str, str]]:
    """A prediction: the question, each option with what refutes it, and what is shown afterwards."""
    yield where, asked.question
    for number, (option, refutation) in enumerate(zip(asked.options, asked.refutations, strict=True), 1):
        yield f"{where}.option.{number}", option
        yield f"{where}.option.{number}.refutation", refutation
    yield f"{where}.reveal", asked.reveal
