"""What tests over all lessons share: the lessons, what they show as plain numbers, and what must hold of it."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from observer_lab.colours import COLOURS
from observer_lab.course.figures.records import Figure, GaugeFigure, LineFigure, MapFigure, MatrixFigure, PlaneFigure, TableFigure
from observer_lab.course.knobs import Choice, Knob, Number, Poles, Switch, Track
from observer_lab.course.lesson import Design, Lesson, Outcome, Task
from observer_lab.lessons import LESSONS
from observer_lab.page.words.prose import mathml, render_markdown
from observer_lab.text import Text

CJK = re.compile(r"[\u4e00-\u9fff]")
WORD = re.compile(r"[A-Za-z]{4,}")
TIMES = frozenset({"settled_after", "known_after", "stopped_at", "found_after", "delay", "expected_delay"})  # metrics that may be never
MATH = re.compile(r"\$\$.+?\$\$|\$.+?\$", re.S)
every_lesson = pytest.mark.parametrize("lesson", LESSONS.values(), ids=LESSONS.keys())


# --- what a lesson shows, as plain numbers ------------------------------------------------------------------------
def arrays(figure: Figure) -> Iterator[np.ndarray]:
    """Every number of a figure."""
    if isinstance(figure, LineFigure):
        yield np.asarray(figure.x, dtype=float)
        yield from (np.asarray(c.y, dtype=float) for c in figure.curves)
    elif isinstance(figure, PlaneFigure):
        yield from (np.asarray(v, dtype=float) for c in figure.curves for v in (c.x, c.y) if v is not None)
        yield np.array([(p.x, p.y) for p in figure.points], dtype=float).ravel()
        yield np.array([*figure.x_range, *figure.y_range])
    elif isinstance(figure, GaugeFigure):
        yield np.array([(-9.0 if each.at is None else each.at, *each.band) for each in figure.gauges]).ravel()
    elif isinstance(figure, MatrixFigure):
        yield np.asarray(figure.matrix, dtype=float)
    elif isinstance(figure, MapFigure):
        yield from (np.asarray(v, dtype=float) for v in (figure.x, figure.y, figure.values))
        yield np.array(figure.marked if figure.marked is not None else (), dtype=float)


def contents(figures: tuple[Figure, ...]) -> tuple[Any, ...]:
    """What the figures hold, fit to compare: data, marks, names of curves, rows of tables; no titles or captions."""
    out: list[Any] = []
    for figure in figures:
        out.append((figure.id, *(a.round(12).tobytes() for a in arrays(figure))))
        out += [(c.name("en"), c.role) for c in getattr(figure, "curves", ())]
        if isinstance(figure, PlaneFigure):
            out += [(p.role, p.mark, p.name("en")) for p in figure.points]
        if isinstance(figure, TableFigure | GaugeFigure):
            out += [tuple(v if isinstance(v, str) else v("en") for v in row) for row in figure.rows]
    return tuple(out)


def boards_of(outcome: Outcome) -> tuple[Any, ...]:
    return tuple((b.id, b.poles, b.fixed, b.zeros, b.knob) for b in outcome.boards)


@lru_cache(maxsize=256)
def shown(design: Design) -> tuple[Outcome, tuple[Figure, ...]]:
    lesson = LESSONS[design.lesson]
    outcome = lesson.compute(design)
    return outcome, tuple(lesson.figures(outcome))


def check_figures(figures: tuple[Figure, ...]) -> None:
    """Finite data, matching lengths, sorted x, known roles, ranges that are ranges."""
    assert len({f.id for f in figures}) == len(figures)
    for figure in figures:
        for values in arrays(figure):
            assert np.all(np.isfinite(values)), f"{figure.id} is not finite"
        for thing in (*getattr(figure, "curves", ()), *getattr(figure, "points", ())):
            assert thing.role in COLOURS
        if isinstance(figure, LineFigure):
            x = figure.x
            assert len(x) >= 2 and np.all(np.diff(x) > 0), f"{figure.id} needs sorted x"
            assert all(np.shape(c.y) == np.shape(x) for c in figure.curves), figure.id
            assert figure.curves
            assert not figure.log_x or x[0] > 0
        if isinstance(figure, PlaneFigure):
            assert figure.x_range[0] < figure.x_range[1] and figure.y_range[0] < figure.y_range[1]
            assert all(c.x is None or np.shape(c.x) == np.shape(c.y) for c in figure.curves)
        if isinstance(figure, MatrixFigure):
            assert len(figure.rows) in (0, figure.matrix.shape[0]) and len(figure.columns) in (0, figure.matrix.shape[1])
        if isinstance(figure, MapFigure):
            assert np.shape(figure.values) == (len(figure.y), len(figure.x))
            assert np.min(figure.values) >= -1 and np.max(figure.values) < len(figure.categories)
            assert all(role in COLOURS for _, role in figure.categories)
        if isinstance(figure, GaugeFigure):
            assert all(each.role in COLOURS and 0 <= each.band[0] < each.band[1] <= 1 for each in figure.gauges)
        if isinstance(figure, TableFigure | GaugeFigure):
            assert figure.rows and all(len(row) == len(figure.columns) for row in figure.rows)


def numbers_of(outcome: Outcome) -> Iterator[tuple[str, np.ndarray]]:
    """Every number of an outcome that leaves it: gains, poles, metrics, run, boards. A time that never comes is infinite and left out."""
    yield from ((f"gain {k}", np.asarray(v)) for k, v in outcome.gains.items())
    yield from ((f"poles {k}", np.asarray(v)) for k, v in outcome.poles.items())
    yield "metrics", np.array([value for name, value in outcome.metrics.items() if not (name in TIMES and value == np.inf)], dtype=float)
    if outcome.stage is not None:
        yield from ((f"stage {k}", np.asarray(v)) for k in ("t", "x", "xhat", "u", "spread")
                    if (v := getattr(outcome.stage, k)) is not None)
    for board in outcome.boards:
        yield f"board {board.id}", np.array([*board.poles, *board.fixed, *board.zeros], dtype=complex)


# --- knobs ---------------------------------------------------------------------------------------------------------
def by_knobs(tasks: Iterable[Task[Any]]) -> list[Task[Any]]:
    """Those of the tasks that a design solves, and not an expression found with a pencil."""
    return [task for task in tasks if task.typed is None or not task.typed.letters]


def others(knob: Knob, design: Design) -> list[Any]:
    """A few valid values of a knob that differ from the present one."""
    now = design[knob.name]
    if isinstance(knob, Number):
        shares = (0.35, 0.65, 0.9, 0.1, 1.0, 0.0)
        found = [knob.low * (knob.high / knob.low) ** s if knob.scale == "log" else knob.low + (knob.high - knob.low) * s
                 for s in shares]
        values = [knob.check(min(max(v, knob.low), knob.high)) for v in found]
    elif isinstance(knob, Choice):
        values = [name for name, _ in knob.options]
    elif isinstance(knob, Switch):
        values = [True, False]
    elif isinstance(knob, Poles):
        values = [knob.check([complex(max(p.real * s, knob.re_low), p.imag) if p.real < 0 else p - 0.1 * s for p in now])
                  for s in (1.2, 0.8)]
    elif isinstance(knob, Track):
        values = [((0.1, knob.high), (1.0, knob.low)), ((0.0, knob.high),)]
    else:
        raise TypeError(type(knob).__name__)
    return [v for v in values if v != now]


def satisfied(lesson: Lesson, knob: Knob, design: Design) -> Iterator[Design]:
    """Designs near this one in which the knob is shown: one for each value that its condition names."""
    if knob.when is None:
        yield design
        return
    other = lesson.knob(knob.when[0])
    for base in satisfied(lesson, other, design):
        for value in knob.when[1]:
            yield lesson.apply(base, {other.name: value})


# --- words ---------------------------------------------------------------------------------------------------------
def complete(text: Text, where: str) -> None:
    """Something in both languages, and Chinese in the Chinese."""
    assert isinstance(text, Text), where
    assert text("en").strip() and text("zh").strip(), f"{where} is empty"
    assert not CJK.search(text("en")), f"{where}: Chinese in the English text: {text('en')}"
    assert CJK.search(text("zh")) or not WORD.search(without_math(text("en"))), f"{where} is not translated: {text('en')}"


def either(text: Text, where: str) -> None:
    """Empty in both languages or complete in both."""
    assert bool(text("en").strip()) == bool(text("zh").strip()), f"{where} lacks a language"
    if text("en").strip():
        complete(text, where)


def without_math(text: str) -> str:
    return MATH.sub("x", text)


# --- mathematics on the page -----------------------------------------------------------------------------------------
def check_mathml(drawn: str, where: str) -> None:
    assert "<code>" not in drawn, f"{where}: the converter refused {drawn[:80]}"
    assert "\\" not in drawn, f"{where}: a command was left over in {drawn[-200:]}"
    ElementTree.fromstring(re.sub(r"&(?!#|amp;|lt;|gt;)", "&amp;", drawn))


def check_markdown(text: str, where: str) -> None:
    """Every formula of a text becomes MathML and no dollar sign is left."""
    for formula in MATH.findall(text):
        check_mathml(mathml(formula.strip("$").strip(), formula.startswith("$$")), f"{where}: {formula}")
    drawn = render_markdown(text)
    assert "$" not in drawn and "<code>" not in drawn, f"{where}: {drawn[:120]}"
    assert not re.search(r"\{\w*\}", re.sub(r"<math.*?</math>", "", drawn, flags=re.S)), f"{where}: a placeholder is left"


def carried(lesson: Lesson, design: Design, found: Any, after: Outcome) -> Outcome:
    """What the frame shows for `after` once the job has found this for `design`: results are kept by key."""
    assert lesson.job is not None
    return lesson.job.shown(after, found) if lesson.job.key(design) == lesson.job.key(after.design) else after
