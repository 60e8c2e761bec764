"""What holds for every lesson, whoever wrote it."""

from __future__ import annotations

import json
import math
import re
import string
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from strategies import designs, values_of

from app.engine import EngineError
from app.figures import (
    COLOURS,
    Figure,
    FrequencyFigure,
    MapFigure,
    MatrixFigure,
    PlaneFigure,
    TableFigure,
    TimeFigure,
    tabs,
)
from app.knobs import Choice, Knob, KnobError, Number, Poles, Switch, Track
from app.lesson import Design, ExamItem, Lesson, Outcome
from app.prose import Prose
from app.view.prose import mathml, render
from app.words import LANGUAGES, Text
from lessons import LESSONS, OPENING

EXAMPLES = 25  # random designs of each lesson
SEEDS = range(1, 13)
MOST_WORDS, MOST_CHARACTERS = 120, 260  # of a step, in English and in Chinese
MOST_REVEALED = 80  # words of the reveal
CJK = re.compile(r"[\u4e00-\u9fff]")
WORD = re.compile(r"[A-Za-z]{4,}")
MATH = re.compile(r"\$\$.+?\$\$|\$.+?\$", re.S)

every_lesson = pytest.mark.parametrize("lesson", LESSONS.values(), ids=LESSONS.keys())


# --- what a lesson shows, as plain numbers ------------------------------------------------------------------------
def arrays(figure: Figure) -> Iterator[np.ndarray]:
    """Every number of a figure."""
    if isinstance(figure, TimeFigure | FrequencyFigure):
        yield np.asarray(figure.t if isinstance(figure, TimeFigure) else figure.f, dtype=float)
        yield from (np.asarray(c.y, dtype=float) for c in figure.curves)
    elif isinstance(figure, PlaneFigure):
        yield from (np.asarray(v, dtype=float) for c in figure.curves for v in (c.x, c.y) if v is not None)
        yield np.array([(p.x, p.y) for p in figure.points], dtype=float).ravel()
        yield np.array([*figure.x_range, *figure.y_range])
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
        out += [(c.name.en, c.role) for c in getattr(figure, "curves", ())]
        if isinstance(figure, PlaneFigure):
            out += [(p.role, p.mark, p.name.en) for p in figure.points]
        if isinstance(figure, TableFigure):
            out += [tuple(v if isinstance(v, str) else v.en for v in row) for row in figure.rows]
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
        if isinstance(figure, TimeFigure | FrequencyFigure):
            x = figure.t if isinstance(figure, TimeFigure) else figure.f
            assert len(x) >= 2 and np.all(np.diff(x) > 0), f"{figure.id} needs sorted x"
            assert all(np.shape(c.y) == np.shape(x) for c in figure.curves), figure.id
            assert figure.curves
        if isinstance(figure, FrequencyFigure):
            assert figure.f[0] > 0
        if isinstance(figure, PlaneFigure):
            assert figure.x_range[0] < figure.x_range[1] and figure.y_range[0] < figure.y_range[1]
            assert all(c.x is None or np.shape(c.x) == np.shape(c.y) for c in figure.curves)
        if isinstance(figure, MatrixFigure):
            assert len(figure.rows) in (0, figure.matrix.shape[0]) and len(figure.columns) in (0, figure.matrix.shape[1])
        if isinstance(figure, MapFigure):
            assert np.shape(figure.values) == (len(figure.y), len(figure.x))
            assert np.min(figure.values) >= -1 and np.max(figure.values) < len(figure.categories)
            assert all(role in COLOURS for _, role in figure.categories)
        if isinstance(figure, TableFigure):
            assert figure.rows and all(len(row) == len(figure.columns) for row in figure.rows)


def numbers_of(outcome: Outcome) -> Iterator[tuple[str, np.ndarray]]:
    """Every number of an outcome that leaves it: gains, poles, metrics, run, boards."""
    yield from ((f"gain {k}", np.asarray(v)) for k, v in outcome.gains.items())
    yield from ((f"poles {k}", np.asarray(v)) for k, v in outcome.poles.items())
    yield "metrics", np.array(list(outcome.metrics.values()), dtype=float)
    if outcome.stage is not None:
        yield from ((f"stage {k}", np.asarray(v)) for k in ("t", "x", "xhat", "u", "spread")
                    if (v := getattr(outcome.stage, k)) is not None)
    for board in outcome.boards:
        yield f"board {board.id}", np.array([*board.poles, *board.fixed, *board.zeros], dtype=complex)


# --- designs -------------------------------------------------------------------------------------------------------
@every_lesson
def test_defaults_are_valid_and_in_the_knobs_own_form(lesson: Lesson) -> None:
    start = lesson.start()
    assert [name for name, _ in start.values] == [k.name for k in lesson.knobs]
    assert len({k.name for k in lesson.knobs}) == len(lesson.knobs)
    assert lesson.apply(start, dict(start.values)) == start
    assert hash(start) == hash(lesson.start())


@every_lesson
def test_the_start_travels_as_json_and_as_words(lesson: Lesson) -> None:
    start = lesson.start()
    sent = json.dumps(dict(start.values), default=lambda z: [z.real, z.imag], allow_nan=False)
    assert lesson.apply(start, json.loads(sent)) == start
    for knob in lesson.knobs:
        assert knob.parse(knob.show(start[knob.name])) == start[knob.name], knob.name


@every_lesson
def test_conditions_of_knobs_name_knobs_and_values_that_exist(lesson: Lesson) -> None:
    for knob in lesson.knobs:
        if knob.when is not None:
            other = lesson.knob(knob.when[0])
            assert knob.when[1] and all(other.check(v) == v for v in knob.when[1]), knob.name


@every_lesson
def test_compute_is_pure(lesson: Lesson) -> None:
    design, written = lesson.start(), repr(lesson.start())
    first = lesson.compute(design)
    before = [(name, value.copy()) for name, value in numbers_of(first)], contents(tuple(lesson.figures(first)))
    for knob in lesson.knobs:  # something else in between
        for value in others(knob, design)[:1]:
            try:
                lesson.figures(lesson.compute(lesson.apply(design, {knob.name: value})))
            except EngineError:
                continue
    second = lesson.compute(design)
    assert repr(design) == written and second.design == design
    for (name, a), (_, b), (_, old) in zip(numbers_of(first), numbers_of(second), before[0], strict=True):
        assert np.array_equal(a, b), name
        assert np.array_equal(a, old), f"{name} was changed afterwards"
    assert contents(tuple(lesson.figures(second))) == before[1] == contents(tuple(lesson.figures(first)))
    assert (first.live, first.formulas, first.checks) == (second.live, second.formulas, second.checks)


@every_lesson
def test_the_draft_is_finite(lesson: Lesson) -> None:
    outcome, figures = shown(lesson.start())
    assert outcome.design == lesson.start() and figures
    check_figures(figures)
    for name, values in numbers_of(outcome):
        assert np.all(np.isfinite(values)), name


@every_lesson
def test_the_stage_fits_its_body_and_the_run_its_knobs(lesson: Lesson) -> None:
    outcome, _ = shown(lesson.start())
    stage = outcome.stage
    if stage is None:
        assert not lesson.kick
        return
    assert stage.t[0] == 0 and np.all(np.diff(stage.t) > 0)
    for record in (stage.x, stage.xhat, stage.u):
        assert record is None or len(record) == len(stage.t)
    assert stage.xhat is None or stage.xhat.shape == stage.x.shape
    poses = stage.body.pose(stage.x[0].tolist(), stage.body.gain)
    assert {p.name for p in stage.body.parts} <= set(poses)
    if lesson.kick:
        lesson.apply(lesson.start(), {"kick": float(stage.t[-1])})


@every_lesson
def test_a_kick_changes_the_run(lesson: Lesson) -> None:
    if not lesson.kick:
        assert "kick" not in {k.name for k in lesson.knobs}
        return
    start = lesson.start()
    outcome, figures = shown(start)
    assert outcome.stage is not None
    assert contents(shown(lesson.apply(start, {"kick": float(outcome.stage.t[-1]) / 3}))[1]) != contents(figures)


# --- knobs ---------------------------------------------------------------------------------------------------------
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


def visible_knobs() -> list[Any]:
    return [pytest.param(lesson, knob, id=f"{lesson.id}-{knob.name}")
            for lesson in LESSONS.values() for knob in lesson.knobs if not knob.hidden]


@pytest.mark.parametrize("lesson, knob", visible_knobs())
def test_every_knob_changes_what_is_seen(lesson: Lesson, knob: Knob) -> None:
    tried = 0
    for base in satisfied(lesson, knob, lesson.start()):
        assert lesson.shown(knob, base)
        try:
            outcome, figures = shown(base)
        except EngineError:
            continue
        for value in others(knob, base):
            try:
                new, drawn = shown(lesson.apply(base, {knob.name: value}))
            except EngineError:
                continue
            tried += 1
            if contents(drawn) != contents(figures) or boards_of(new) != boards_of(outcome):
                return
    pytest.fail(f"{knob.name} changed nothing in {tried} tries")


@every_lesson
def test_boards_are_dragged_through_knobs_that_hold_poles(lesson: Lesson) -> None:
    outcome, _ = shown(lesson.start())
    assert len({b.id for b in outcome.boards}) == len(outcome.boards)
    for board in outcome.boards:
        assert board.side in ("left", "right", "middle")
        assert board.role in COLOURS
        assert board.re_low < board.re_high and board.im_high > 0
        dragged = dict(board.also)
        if board.knob is not None:
            knob = lesson.knob(board.knob)
            assert isinstance(knob, Poles)
            assert (board.re_low, board.re_high, board.im_high) == (knob.re_low, knob.re_high, knob.im_high)
            dragged[board.knob] = board.poles
        after = lesson.apply(outcome.design, dragged)  # what a drag posts is valid
        shown(after)
        for pole in (*board.poles, *board.fixed):
            assert board.re_low <= pole.real <= board.re_high and abs(pole.imag) <= board.im_high


@every_lesson
@settings(max_examples=EXAMPLES, deadline=None, derandomize=True, database=None,
          suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(data=st.data())
def test_any_valid_design_gives_a_finite_picture_or_one_sentence(lesson: Lesson, data: st.DataObject) -> None:
    design = data.draw(designs(lesson))
    try:
        outcome = lesson.compute(design)
        figures = tuple(lesson.figures(outcome))
    except (EngineError, KnobError) as problem:
        assert str(problem).strip() and "\n" not in str(problem)
        return
    check_figures(figures)
    for board in outcome.boards:
        assert np.all(np.isfinite(np.array([*board.poles, *board.fixed, *board.zeros], dtype=complex)))
    if outcome.stage is not None:
        assert np.all(np.isfinite(outcome.stage.t))
        assert outcome.stage.xhat is None or outcome.stage.xhat.shape == outcome.stage.x.shape
    assert outcome.live.en and outcome.live.zh


@every_lesson
def test_a_change_of_one_knob_from_the_start_is_never_worse_than_a_sentence(lesson: Lesson) -> None:
    for knob in lesson.knobs:
        for value in others(knob, lesson.start()):
            try:
                _, figures = shown(lesson.apply(lesson.start(), {knob.name: value}))
            except (EngineError, KnobError) as problem:
                assert str(problem).strip()
                continue
            check_figures(figures)


# --- tasks, prediction, exam -----------------------------------------------------------------------------------------
def every_task() -> list[Any]:
    return [pytest.param(lesson, task, id=f"{lesson.id}-{task.id}") for lesson in LESSONS.values() for task in lesson.tasks]


@pytest.mark.parametrize("lesson, task", every_task())
def test_a_task_fails_at_the_start_and_passes_at_its_own_solution(lesson: Lesson, task: Any) -> None:
    start = lesson.start()
    before = task.check(shown(start)[0])
    after = task.check(shown(lesson.apply(start, task.solution))[0])
    assert not before.solved, before.text.en
    assert after.solved, after.text.en
    for verdict in (before, after):
        complete(verdict.text, "verdict")


@every_lesson
def test_there_are_tasks_and_a_right_prediction(lesson: Lesson) -> None:
    assert 2 <= len(lesson.tasks) <= 4
    assert len({t.id for t in lesson.tasks}) == len(lesson.tasks)
    for language in LANGUAGES:
        options = lesson.words[language].options
        assert 3 <= len(options) <= 4 and len(set(options)) == len(options)
        assert 0 <= lesson.answer < len(options)
    assert lesson.source.strip()


@every_lesson
def test_exam_items_differ_between_students_and_fit_the_text(lesson: Lesson) -> None:
    items: list[ExamItem] = [lesson.exam(seed) for seed in SEEDS]
    assert len({item.answer for item in items}) > len(items) // 3
    assert all(math.isfinite(item.answer) and math.isfinite(item.tolerance) and item.tolerance > 0 for item in items)
    for seed, item in zip(SEEDS, items, strict=True):
        assert lesson.exam(seed) == item
        drawn = [lesson.words[language].exam.format(**item.numbers) for language in LANGUAGES]
        for language, text in zip(LANGUAGES, drawn, strict=True):
            check_markdown(text, f"exam {language}")
            assert "None" not in text and "nan" not in text


@every_lesson
def test_the_exam_text_uses_the_same_numbers_in_both_languages(lesson: Lesson) -> None:
    used = {lang: {name for _, name, _, _ in string.Formatter().parse(lesson.words[lang].exam) if name} for lang in LANGUAGES}
    assert used["en"] == used["zh"] == set(lesson.exam(1).numbers)


# --- words ---------------------------------------------------------------------------------------------------------
def complete(text: Text, where: str) -> None:
    """Something in both languages, and Chinese in the Chinese."""
    assert isinstance(text, Text), where
    assert text.en.strip() and text.zh.strip(), f"{where} is empty"
    assert not CJK.search(text.en), f"{where}: Chinese in the English text: {text.en}"
    assert CJK.search(text.zh) or not WORD.search(without_math(text.en)), f"{where} is not translated: {text.en}"


def either(text: Text, where: str) -> None:
    """Empty in both languages or complete in both."""
    assert bool(text.en.strip()) == bool(text.zh.strip()), f"{where} lacks a language"
    if text.en.strip():
        complete(text, where)


def without_math(text: str) -> str:
    return MATH.sub("x", text)


@every_lesson
def test_knobs_speak_both_languages(lesson: Lesson) -> None:
    for knob in lesson.knobs:
        complete(knob.label, f"label of {knob.name}")
        either(knob.hint, f"hint of {knob.name}")
        if knob.group is not None:
            complete(knob.group, f"group of {knob.name}")
        for name, label in getattr(knob, "options", ()):
            complete(label, f"{knob.name}={name}")


@every_lesson
def test_every_visible_knob_has_a_hint(lesson: Lesson) -> None:
    assert not [k.name for k in lesson.knobs if not k.hidden and not k.hint.en.strip()]


@every_lesson
def test_what_is_shown_speaks_both_languages(lesson: Lesson) -> None:
    for values in ({}, *(task.solution for task in lesson.tasks)):
        outcome, figures = shown(lesson.apply(lesson.start(), values))
        complete(outcome.live, "live")
        for check in outcome.checks:
            complete(check.text, f"check {check.id}")
        for board in outcome.boards:
            complete(board.title, f"board {board.id}")
        for formula in outcome.formulas:
            either(formula.note, f"formula {formula.id}")
        for figure in figures:
            complete(figure.title, f"title of {figure.id}")
            complete(figure.caption, f"caption of {figure.id}")
            complete(figure.tab, f"tab of {figure.id}")
            for curve in getattr(figure, "curves", ()):
                complete(curve.name, f"curve of {figure.id}")
            for point in getattr(figure, "points", ()):
                either(point.name, f"point of {figure.id}")
            for name, _ in getattr(figure, "categories", ()):
                complete(name, f"category of {figure.id}")
            if isinstance(figure, TableFigure):
                for cell in (*figure.columns, *(v for row in figure.rows for v in row if isinstance(v, Text))):
                    either(cell, f"cell of {figure.id}")
    if lesson.job is not None:
        complete(lesson.job.label, "job")


@every_lesson
def test_a_tab_holds_at_most_three_figures(lesson: Lesson) -> None:
    _, figures = shown(lesson.start())
    for tab in tabs(figures):
        assert sum(f.tab == tab for f in figures) <= 3, tab.en


@every_lesson
def test_figures_keep_their_ids_when_knobs_move(lesson: Lesson) -> None:
    """The screen makes its charts once, from the ids of the first picture."""
    ids = {f.id for f in shown(lesson.start())[1]}
    for task in lesson.tasks:
        assert {f.id for f in shown(lesson.apply(lesson.start(), task.solution))[1]} == ids, task.id
    for knob in lesson.knobs:
        for base in satisfied(lesson, knob, lesson.start()):
            for value in others(knob, base)[:2]:
                try:
                    drawn = shown(lesson.apply(base, {knob.name: value}))[1]
                except EngineError:
                    continue
                assert {f.id for f in drawn} == ids, (knob.name, value)


def texts(prose: Prose) -> Iterator[tuple[str, str]]:
    """Every piece of a lesson's prose with a name for it."""
    for name in ("title", "question", "introduction", "predict", "reveal", "exam", "source"):
        yield name, getattr(prose, name)
    yield from ((f"option {i}", option) for i, option in enumerate(prose.options))
    for heading, text in prose.steps:
        yield f"heading {heading}", heading
        yield f"step {heading}", text
    for key, task in prose.tasks.items():
        yield from ((f"task {key} {name}", getattr(task, name)) for name in ("title", "statement", "solution"))
        yield from ((f"task {key} hint {i}", hint) for i, hint in enumerate(task.hints))


@every_lesson
def test_both_languages_are_complete(lesson: Lesson) -> None:
    en, zh = (lesson.words[language] for language in LANGUAGES)
    assert set(lesson.words) == set(LANGUAGES)
    assert len(en.options) == len(zh.options)
    assert len(en.steps) == len(zh.steps) >= 3
    assert list(en.tasks) == list(zh.tasks) == [t.id for t in lesson.tasks]
    for prose in (en, zh):
        assert all(len(task.hints) == 2 for task in prose.tasks.values())
        assert not [name for name, text in texts(prose) if not text.strip()]
    for name, text in texts(zh):
        assert CJK.search(text), f"zh {name} is not Chinese: {text[:60]}"
    for name, text in texts(en):
        assert not CJK.search(text), f"en {name} holds Chinese: {text[:60]}"


@every_lesson
def test_steps_are_short(lesson: Lesson) -> None:
    for heading, text in lesson.words["en"].steps:
        assert len(without_math(text).split()) <= MOST_WORDS, heading
    for heading, text in lesson.words["zh"].steps:
        assert len(re.sub(r"\s", "", without_math(text))) <= MOST_CHARACTERS, heading
    assert len(without_math(lesson.words["en"].reveal).split()) <= MOST_REVEALED


# --- mathematics on the page -----------------------------------------------------------------------------------------
def check_mathml(drawn: str, where: str) -> None:
    assert "<code>" not in drawn, f"{where}: the converter refused {drawn[:80]}"
    assert "\\" not in drawn, f"{where}: a command was left over in {drawn[-200:]}"
    ElementTree.fromstring(re.sub(r"&(?!#|amp;|lt;|gt;)", "&amp;", drawn))


def check_markdown(text: str, where: str) -> None:
    """Every formula of a text becomes MathML and no dollar sign is left."""
    for formula in MATH.findall(text):
        check_mathml(mathml(formula.strip("$").strip(), formula.startswith("$$")), f"{where}: {formula}")
    drawn = render(text)
    assert "$" not in drawn and "<code>" not in drawn, f"{where}: {drawn[:120]}"
    assert not re.search(r"\{\w*\}", re.sub(r"<math.*?</math>", "", drawn, flags=re.S)), f"{where}: a placeholder is left"


@every_lesson
@pytest.mark.parametrize("language", LANGUAGES)
def test_the_mathematics_of_the_prose_is_drawn(lesson: Lesson, language: str) -> None:
    for name, text in texts(lesson.words[language]):
        if name != "exam":
            check_markdown(text, f"{language} {name}")


@every_lesson
def test_live_formulas_are_drawn_for_every_design_that_the_tasks_lead_to(lesson: Lesson) -> None:
    for values in ({}, *(task.solution for task in lesson.tasks)):
        outcome, _ = shown(lesson.apply(lesson.start(), values))
        assert len({f.id for f in outcome.formulas}) == len(outcome.formulas)
        for formula in outcome.formulas:
            check_mathml(mathml(formula.latex, True), formula.id)
            for language in LANGUAGES:
                check_markdown(formula.note(language), formula.id)


# --- jobs ----------------------------------------------------------------------------------------------------------
@every_lesson
def test_a_job_rises_to_its_end_and_leaves_its_start_alone(lesson: Lesson) -> None:
    if lesson.job is None:
        return
    outcome, figures = shown(lesson.start())
    before = contents(figures)
    fractions, last = [], outcome
    for fraction, better in lesson.job.run(outcome):
        fractions.append(fraction)
        last = better
        assert len(fractions) < 100_000
    assert fractions and all(0 <= f <= 1 for f in fractions) and fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1.0)
    assert last.design == outcome.design
    check_figures(tuple(lesson.figures(last)))
    assert contents(tuple(lesson.figures(last))) != before, "a job that shows nothing new"
    assert contents(tuple(lesson.figures(outcome))) == before


@every_lesson
def test_a_job_can_be_dropped_midway(lesson: Lesson) -> None:
    if lesson.job is None:
        return
    outcome, figures = shown(lesson.start())
    before = contents(figures)
    for steps in (0, 1, 3):
        job: Any = lesson.job.run(outcome)
        for _ in range(steps):
            _, partial = next(job)
            check_figures(tuple(lesson.figures(partial)))
        job.close()
    assert contents(tuple(lesson.figures(lesson.compute(lesson.start())))) == before


@every_lesson
def test_a_click_on_the_map_gives_a_valid_design(lesson: Lesson) -> None:
    maps = [f for f in shown(lesson.start())[1] if isinstance(f, MapFigure)]
    if lesson.pick is None:
        return
    assert maps, "a lesson with `pick` shows a map"
    outcome = shown(lesson.start())[0]
    for x in (maps[0].x[0], maps[0].x[-1], float(np.mean(maps[0].x))):
        for y in (maps[0].y[0], maps[0].y[-1], float(np.mean(maps[0].y))):
            design = lesson.apply(outcome.design, lesson.pick(outcome, float(x), float(y)))
            picked = next(f for f in shown(design)[1] if isinstance(f, MapFigure))
            assert picked.marked == pytest.approx((float(x), float(y)), rel=0.05, abs=0.05)


# --- all together ----------------------------------------------------------------------------------------------------
def test_lessons_are_in_order_and_the_opening_is_one_of_them() -> None:
    numbers = [lesson.number for lesson in LESSONS.values()]
    assert numbers == sorted(set(numbers))
    assert all(key == lesson.id and re.fullmatch(r"[a-z]+(-[a-z]+)*", key) for key, lesson in LESSONS.items())
    assert OPENING in LESSONS
    for language in LANGUAGES:
        titles = [lesson.words[language].title for lesson in LESSONS.values()]
        assert len(set(titles)) == len(titles)


@every_lesson
@settings(max_examples=40, deadline=None, derandomize=True, database=None)
@given(data=st.data())
def test_random_values_pass_the_gate_unchanged(lesson: Lesson, data: st.DataObject) -> None:
    """A strategy that a knob refuses would make the random tests above say nothing."""
    knob = data.draw(st.sampled_from(lesson.knobs))
    value = knob.check(data.draw(values_of(knob)))
    assert knob.check(value) == value
    assert hash(value) == hash(knob.check(value))
