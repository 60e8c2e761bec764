"""Words and mathematics of every lesson: both languages, short steps, formulas that are drawn."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from laws import each
from lesson_checks import (
    CJK,
    MATH,
    check_markdown,
    check_mathml,
    complete,
    either,
    every_lesson,
    others,
    satisfied,
    shown,
    without_math,
)

import observer_lab
from observer_lab.course.figures.records import GaugeFigure, LineFigure, PlaneFigure, TableFigure, tab_names
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import PredictionWords, Prose
from observer_lab.engine import EngineError
from observer_lab.lessons import LESSONS, folder
from observer_lab.page.words import phrases
from observer_lab.page.words.prose import mathml
from observer_lab.text import Text, languages

MOST_WORDS, MOST_CHARACTERS = 120, 260  # of a step, in English and in Chinese
MOST_TOGETHER = 280  # words of all steps of a lesson
STILL_LONG = frozenset({"network", "nonlinear"})  # lessons whose steps are yet to be shortened
MOST_REVEALED = 80  # words of the reveal
MOST_REFUTING, MOST_SIGNS = 40, 90  # words of a refutation, and its characters in Chinese
FIGURE = re.compile(r"\d+\.\d+|\d\d+")  # a number that no language writes in letters


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
    assert not [k.name for k in lesson.knobs if not k.hidden and not k.hint("en").strip()]


@every_lesson
def test_every_chart_names_its_vertical_axis(lesson: Lesson) -> None:
    for values in ({}, *(task.solution for task in lesson.tasks)):
        _, figures = shown(lesson.apply(lesson.start(), values))
        assert not [f.id for f in figures if isinstance(f, (LineFigure, PlaneFigure)) and f.curves and not f.y_label]


@every_lesson
def test_no_knob_is_named_like_the_choice_of_the_plant_above_it(lesson: Lesson) -> None:
    assert not [k.name for k in lesson.knobs if k.label in (phrases.PLANT, phrases.LESSON)]


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
            if isinstance(figure, TableFigure | GaugeFigure):
                for cell in (*figure.columns, *(v for row in figure.rows for v in row if isinstance(v, Text))):
                    either(cell, f"cell of {figure.id}")
    if lesson.job is not None:
        complete(lesson.job.label, "job")


@every_lesson
def test_a_tab_holds_at_most_three_figures(lesson: Lesson) -> None:
    _, figures = shown(lesson.start())
    for tab in tab_names(figures):
        assert sum(f.tab == tab for f in figures) <= 3, tab("en")


@pytest.mark.slow
@every_lesson
def test_figures_keep_their_ids_when_knobs_move(lesson: Lesson) -> None:
    """The screen makes its charts once, from the ids of the first picture; a single knob's change of the start: test_all_knobs.py."""
    ids = {f.id for f in shown(lesson.start())[1]}
    for task in lesson.tasks:
        assert {f.id for f in shown(lesson.apply(lesson.start(), task.solution))[1]} == ids, task.id
    for knob in lesson.knobs:
        for base in (design for design in satisfied(lesson, knob, lesson.start()) if design != lesson.start()):
            for value in others(knob, base)[:2]:
                try:
                    drawn = shown(lesson.apply(base, {knob.name: value}))[1]
                except EngineError:
                    continue
                assert {f.id for f in drawn} == ids, (knob.name, value)


def predictions(prose: Prose) -> list[PredictionWords]:
    """The first prediction and the second."""
    first = PredictionWords(prose.predict, prose.options, prose.refutations, prose.reveal)
    return [first] if prose.again is None else [first, prose.again]


def texts(prose: Prose) -> Iterator[tuple[str, str]]:
    """Every piece of a lesson's prose with a name for it."""
    for name in ("title", "question", "introduction", "predict", "reveal", "source"):
        yield name, getattr(prose, name)
    yield from ((f"option {i}", option) for i, option in enumerate(prose.options))
    yield from ((f"refutation {i}", words) for i, words in enumerate(prose.refutations) if words)
    if prose.again is not None:
        yield from (("again", prose.again.question), ("its reveal", prose.again.reveal))
        yield from ((f"its {i}", words) for i, words in enumerate((*prose.again.options, *prose.again.refutations)) if words)
    for heading, text in prose.steps:
        yield f"heading {heading}", heading
        yield f"step {heading}", text
    for key, task in prose.tasks.items():
        yield from ((f"task {key} {name}", getattr(task, name)) for name in ("title", "statement", "solution"))
        yield from ((f"task {key} hint {i}", hint) for i, hint in enumerate(task.hints))


@every_lesson
def test_both_languages_are_complete(lesson: Lesson) -> None:
    en, zh = (lesson.words[language] for language in languages())
    assert set(lesson.words) == set(languages())
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
    for asked in predictions(lesson.words["en"]):
        assert len(without_math(asked.reveal).split()) <= MOST_REVEALED, asked.question


def test_the_steps_of_a_lesson_are_read_in_a_few_minutes() -> None:
    """The list of exceptions names those alone that break the law, so that it can only become shorter."""
    words = {id: sum(len(without_math(text).split()) for _, text in lesson.words["en"].steps) for id, lesson in LESSONS.items()}
    assert {id: count for id, count in words.items() if count > MOST_TOGETHER and id not in STILL_LONG} == {}
    assert {id: words[id] for id in STILL_LONG if words[id] <= MOST_TOGETHER} == {}


@every_lesson
def test_every_wrong_option_is_refuted_and_the_right_one_is_not(lesson: Lesson) -> None:
    """Shortly, and with the same formulas and figures in every language."""
    answers = [lesson.answer, *([lesson.again.answer] if lesson.again else [])]
    for language, prose in lesson.words.items():
        for asked, answer in zip(predictions(prose), answers, strict=True):
            wrong = [i for i in range(len(asked.options)) if i != answer]
            assert [i for i, words in enumerate(asked.refutations) if words] == wrong, language
            assert len(set(asked.refutations)) == len(asked.refutations) == len(asked.options), language
    for english, chinese in zip(*([words for asked in predictions(lesson.words[language]) for words in asked.refutations]
                                  for language in languages()), strict=True):
        assert len(without_math(english).split()) <= MOST_REFUTING, english
        assert len(re.sub(r"\s", "", without_math(chinese))) <= MOST_SIGNS, chinese
        assert set(MATH.findall(chinese)) == set(MATH.findall(english)), chinese
        assert sorted(FIGURE.findall(without_math(chinese))) == sorted(FIGURE.findall(without_math(english))), chinese


@every_lesson
@pytest.mark.parametrize("language", languages())
def test_the_mathematics_of_the_prose_is_drawn(lesson: Lesson, language: str) -> None:
    for name, text in texts(lesson.words[language]):
        check_markdown(text, f"{language} {name}")


@every_lesson
def test_live_formulas_are_drawn_for_every_design_that_the_tasks_lead_to(lesson: Lesson) -> None:
    for values in ({}, *(task.solution for task in lesson.tasks)):
        outcome, _ = shown(lesson.apply(lesson.start(), values))
        assert len({f.id for f in outcome.formulas}) == len(outcome.formulas)
        for formula in outcome.formulas:
            check_mathml(mathml(formula.latex, True), formula.id)
            for language in languages():
                check_markdown(formula.note(language), formula.id)


TERMS = {
    "virtual-sensor": ("state observer", "Luenberger observer", "peaking"), "error-dynamics": ("error dynamics", "pole placement"),
    "observability": ("observable",), "separation": ("separation principle",), "duality": ("duality",),
    "hidden-modes": ("detectable", "stabilizable"), "saturation": ("windup",), "noise": ("covariance",), "kalman": ("innovation",),
    "lqg": ("loop transfer recovery",), "decoupling": ("decoupling", "Diophantine equation"),
    "weak-states": ("Hankel singular value", "Gramian"), "showdown": ("crossover",),
    "nonlinear": ("extended Kalman filter", "unscented Kalman filter", "consistent"),
    "robust-observer": ("functional observer", "Sylvester equation"), "bilinear-observer": ("bilinear",),
    "fault-diagnosis": ("residual", "CUSUM"), "network": ("critical loss",), "sandbox": ("disk margin",),
    "arm": ("disturbance state", "backlash"), "record": ("subspace identification", "smoother")}


def chinese_files() -> list[tuple[str, str]]:
    """Name and words of each Chinese file, without the lists of other forms by which the glossary finds a term."""
    files = sorted((Path(observer_lab.__file__).parent / "locale" / "zh").iterdir())
    words = ((file.name, file.read_text("utf-8")) for file in files)
    return [(name, re.sub(r"^- .*$", "", said, flags=re.M) if name == "glossary.md" else said) for name, said in words]


def test_one_thing_has_one_chinese_word() -> None:
    """Each line of the list holds a word that is not used, and the one that is."""
    others = [line.split()[0] for line in Path(__file__).with_name("other_words.txt").read_text("utf-8").splitlines()]
    assert len(others) > 5 and [(name, word) for name, words in chinese_files() for word in others if word in words] == []


# Where a Latin letter, a number or a formula touches a Chinese sign, a half-width mark follows one, or one dash joins two.
CROWDED = re.compile(r"[\u4e00-\u9fff][A-Za-z0-9$,;:!?]|[A-Za-z0-9$%°,;:!?][\u4e00-\u9fff]|[\u4e00-\u9fff]—[\u4e00-\u9fff]")


def test_chinese_stands_apart_from_latin_and_has_its_own_marks() -> None:
    assert all(CROWDED.search(words) for words in ("就是Hankel", "秩为$n$", "成员数, 故障数", "卡尔曼—布西"))
    assert not CROWDED.search("秩为 $n$，离 −1 最近；卡尔曼–布西")
    assert [(name, found) for name, words in chinese_files() for found in CROWDED.findall(words)] == []


@every_lesson
def test_chinese_quotes_what_english_sets_apart_as_the_page_calls_it(lesson: Lesson) -> None:
    names = [words for knob in lesson.knobs for words in (knob.label, *(words for _, words in getattr(knob, "options", ())))]
    names += [words for figure in shown(lesson.start())[1] for words in (figure.tab, figure.title)]
    called: dict[str, set[str]] = {}
    for name in names:
        called.setdefault(name("en"), set()).add(f"\u201c{name('zh')}\u201d")
    pages = (folder(lesson.id) / "en.md", Path(observer_lab.__file__).parent / "locale" / "zh" / f"{lesson.id}.md")
    for english, chinese in zip(*(page.read_text("utf-8").splitlines() for page in pages), strict=True):
        for found in re.findall(r"(?<!\*)\*([^*]+)\*(?!\*)", MATH.sub("", english)):
            assert any(it in chinese for it in called.get(found, {""})), found


# Behind a rise the Chinese "times" is read as what is added, so that ten times would be eleven; behind a fall it says nothing.
RISE_OR_FALL = r"\u589e\u5927|\u5347\u9ad8|\u4e0b\u964d|\u964d\u4f4e|\u51cf\u5c0f|\u7f29\u5c0f|[\u4f4e\u5c11\u591a]"
NUMERALS = "\u4e00\u4e24\u4e8c\u4e09\u56db\u4e94\u516d\u4e03\u516b\u4e5d\u5341\u767e\u5343\u4e07\u51e0"
TIMES = re.compile(rf"(?<![\u6700\u81f3])(?:{RISE_OR_FALL})\u4e86?\s?(?!\u4e00\u500d)(?:\{{[^}}]*\}}|[{NUMERALS}\u221a\d./^$]+)\s?\u500d")
GAP = re.compile(r"[\u4e00-\u9fff\uff0c\u3002\uff1b\uff1a] +[\u4e00-\u9fff]")


def test_chinese_counts_no_fall_in_times_and_leaves_no_gap() -> None:
    texts = {file.name: file.read_text("utf-8") for file in sorted((Path(observer_lab.__file__).parent / "locale" / "zh").iterdir())}
    assert texts and [(name, found[0]) for name, text in texts.items() for law in (TIMES, GAP) for found in law.finditer(text)] == []


@each("id", TERMS)
def test_a_lesson_names_its_english_terms_once(id: str) -> None:
    chinese = (Path(observer_lab.__file__).parent / "locale" / "zh" / f"{id}.md").read_text("utf-8")
    english = (folder(id) / "en.md").read_text("utf-8").lower()
    for term in TERMS[id]:
        assert chinese.count(f"\uff08{term}\uff09") == 1 and term.lower() in english, term
