"""What is true of every question's figure: it shows no answer, its options differ, and the right one is nearest to the run."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator
from functools import cache
from itertools import groupby, pairwise

import numpy as np
import pytest
from laws import each
from test_paths import Walker

from observer_lab.course.figures.records import Curve, PlaneFigure
from observer_lab.course.guiding.predictions import prediction_of
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, Part
from observer_lab.course.lesson import Lesson
from observer_lab.course.scenes import Choose, Question, Scene, entry_values
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.axes import H
from observer_lab.page.charts.print_sizes import Sizes
from observer_lab.page.charts.svg import axes_of_plane
from observer_lab.page.charts.text_layout import LARGE_PRINT_PX, text_width
from observer_lab.page.guide.scene_card import question_html, verdict_html
from observer_lab.page.words import phrases
from observer_lab.session.commands.guide import AnswerByHand, GoToScene
from observer_lab.text import languages

SAMPLED = ("virtual-sensor", "separation", "kalman")  # lessons in which a tab is answered by hand
LESSONS_BY_HAND = 8  # in which one answers by the hand itself, at least
LEAST_GAP = 0.04  # of the figure's size: how far two options lie apart somewhere
ASKING = [(lesson, k) for lesson in LESSONS.values() for k, scene in enumerate(lesson.path) if isinstance(scene.do, Choose)]
DRAWN = [(lesson, k) for lesson, k in ASKING if lesson.path[k].id in lesson.questions]


@cache
def question(lesson: Lesson, k: int) -> tuple[Scene, DrawnQuestion]:
    scene, start = lesson.path[k], lesson.start()
    entry = lesson.apply(start, entry_values(lesson.path, k, start))
    outcomes = [lesson.compute(design) for design in (entry, lesson.apply(entry, scene.play))]
    return scene, lesson.questions[scene.id](Asked(lesson, *outcomes))


def places(parts: tuple[Part, ...], figure: PlaneFigure) -> np.ndarray:
    """The points of what is drawn, in shares of the figure's width and height."""
    found = []
    for part in parts:
        if isinstance(part, Curve):
            x = np.asarray(part.x, dtype=float)
            y = np.asarray(part.y, dtype=float)
            found.append(np.column_stack([x, y]) if len(y) != 2 else np.array([[round(x[0]), y[1]]]))
        else:
            found.append(np.array([[part.x, part.y]]))
    at = np.vstack(found)
    low = np.array([figure.x_range[0], figure.y_range[0]])
    return np.clip((at - low) / (np.array([figure.x_range[1], figure.y_range[1]]) - low), -0.5, 1.5)


def apart(a: tuple[Part, ...], b: tuple[Part, ...], figure: PlaneFigure) -> float:
    """How far two drawings lie apart at most, on the mean of both ways."""
    p, q = places(a, figure), places(b, figure)
    if len(p) == len(q) and np.allclose(p[:, 0], q[:, 0]):
        return float(np.max(np.abs(p[:, 1] - q[:, 1])))
    gaps = np.linalg.norm(p[:, None] - q[None], axis=2)
    return float(max(gaps.min(axis=0).max(), gaps.min(axis=1).max()))


def mean_gap(a: tuple[Part, ...], b: tuple[Part, ...], figure: PlaneFigure) -> float:
    p, q = places(a, figure), places(b, figure)
    if len(p) == len(q) and np.allclose(p[:, 0], q[:, 0]):
        return float(np.mean(np.abs(p[:, 1] - q[:, 1])))
    gaps = np.linalg.norm(p[:, None] - q[None], axis=2)
    return float(gaps.min(axis=0).mean() + gaps.min(axis=1).mean())


def faults(lesson: Lesson, k: int) -> Iterator[str]:
    scene, drawn = question(lesson, k)
    asked = prediction_of(lesson, scene, "en")
    options, right = asked.options, asked.answer
    if len(drawn.options) != len(options):
        yield f"{len(drawn.options)} drawings for {len(options)} options"
        return
    for i in range(len(options)):
        for j in range(i):
            if apart(drawn.options[i], drawn.options[j], drawn.figure) < LEAST_GAP:
                yield f"options {j} and {i} look alike"
    gaps = [mean_gap(each, drawn.run, drawn.figure) for each in drawn.options]
    if int(np.argmin(gaps)) != right:
        yield f"the run is nearest to option {int(np.argmin(gaps))}, the right one is {right}: {np.round(gaps, 3)}"
    known = (*drawn.figure.curves, *drawn.figure.points)
    if any(apart((part,), drawn.run, drawn.figure) < LEAST_GAP / 4 for part in known if isinstance(part, Curve)) and any(
            word in str(part.name) for part in known for word in ("run",)):
        yield "what is known shows the answer"
    for part in drawn.run + tuple(p for option in drawn.options for p in option):
        if isinstance(part, Curve) and not np.all(np.isfinite(part.y)):
            yield "a curve that is not finite"


def test_every_question_stands_with_a_figure_and_most_take_a_drawing_by_hand() -> None:
    assert [f"{lesson.id} {lesson.path[k].id}" for lesson, k in ASKING if (lesson, k) not in DRAWN] == []
    assert len({lesson.id for lesson, k in DRAWN if question(lesson, k)[1].columns}) >= LESSONS_BY_HAND


@each("lesson, k", DRAWN)
def test_a_question_is_drawn_as_its_options_say(lesson: Lesson, k: int) -> None:
    assert not list(faults(lesson, k)), lesson.path[k].id


def shares(drawn: DrawnQuestion, option: tuple[Part, ...]) -> list[float]:
    """What a hand would send that draws an option exactly."""
    low, high = drawn.figure.y_range
    curves = [part for part in option if isinstance(part, Curve) and part.x is not None]
    heights = [float(curve.y[-1]) for curve in curves] if drawn.bars else np.interp(drawn.columns, curves[0].x, curves[0].y)  # type: ignore[arg-type]
    return [min(max((h - low) / (high - low), 0.0), 1.0) for h in heights]


@each("lesson, k", DRAWN)
def test_a_drawing_by_hand_answers_with_the_option_it_shows(lesson: Lesson, k: int) -> None:
    scene, drawn = question(lesson, k)
    if not drawn.columns:
        return
    right = prediction_of(lesson, scene, "en").answer
    for index, option in enumerate(drawn.options):
        assert drawn.nearest(shares(drawn, option)) == index, scene.id
        assert drawn.distance(shares(drawn, option), option) < 1e-3
    if lesson.id not in SAMPLED:
        return
    walker = Walker(lesson.id)
    walker.send(GoToScene(k), 0.5)
    for hostile in ("", "nan", "0.5," * (len(drawn.columns) + 1), "x" * 5000, ",".join(["inf"] * len(drawn.columns)), None):
        walker.send(AnswerByHand(hostile), 0.2)
        assert scene.id not in walker.session.picture.state.chosen  # type: ignore[union-attr]
    walker.send(AnswerByHand(",".join(f"{share:.3f}" for share in shares(drawn, drawn.options[right]))), 5.0)
    picture = walker.session.picture
    assert picture is not None and picture.state.chosen[scene.id] == right and scene.id in picture.state.done
    said = verdict_html(picture, "hand")
    assert "Your drawing is nearest to answer" in said and phrases.YOU_CHOSE_RIGHT.id in said
    assert "you" in question_html(picture, Sizes(picture.state), "hand")


def something_changes(lesson: Lesson, k: int) -> bool:
    """Whether a wrong option draws what the run would be if the page changed nothing, and the run is something else."""
    scene, drawn = question(lesson, k)
    entry = lesson.compute(lesson.apply(lesson.start(), entry_values(lesson.path, k, lesson.start())))
    unchanged = lesson.questions[scene.id](Asked(lesson, entry, entry)).run
    right = prediction_of(lesson, scene, "en").answer
    stays = [mean_gap(option, unchanged, drawn.figure) < LEAST_GAP / 4 for option in drawn.options]
    return any(stays) and not stays[right] and apart(drawn.run, unchanged, drawn.figure) > LEAST_GAP


def test_it_stays_as_it_is_does_not_answer_every_question_of_the_first_lessons() -> None:
    found = {f"{lesson.id} {lesson.path[k].id}" for lesson, k in DRAWN if 2 <= lesson.number <= 6 and something_changes(lesson, k)}
    assert found >= {"error-dynamics printed", "separation surprise", "duality surprise"}


@pytest.mark.parametrize("language", ["en", "zh"])
@each("lesson", LESSONS.values())
def test_the_right_option_is_not_told_by_its_length(lesson: Lesson, language: str) -> None:
    """It is at least 0.7 times as long as the shortest of the others, at most 1.6 times as long as the longest."""
    for scene in lesson.path:
        if isinstance(scene.do, Choose):
            asked = prediction_of(lesson, scene, language)
            long = [len(re.sub(r"\$[^$]*\$", "xxxxx", option)) + 8 for option in asked.options]
            right = long.pop(asked.answer)
            assert 0.7 * min(long) <= right <= 1.6 * max(long), f"{scene.id}: {right} beside {long}"


@each("lesson, k", DRAWN)
def test_the_names_below_a_question_do_not_touch(lesson: Lesson, k: int) -> None:
    figure = question(lesson, k)[1].figure
    for language in languages() if figure.names else ():
        axes = axes_of_plane(figure, language, H)
        spots = [axes.at(v, 0.0)[0] for v, _ in figure.names]
        drawn = re.findall(r'<text x="([\d.]+)" y="([\d.]+)" text-anchor="middle">([^<]*)</text>', axes.draw())
        lines = [(float(y), float(x), text_width(html.unescape(words), LARGE_PRINT_PX)) for x, y, words in drawn]
        assert len(lines) >= len(spots)
        for y, row in groupby(sorted(lines), key=lambda line: line[0]):
            assert y + 0.3 * LARGE_PRINT_PX <= axes.height, "the drawing is as high as its names need, tails of letters included"
            for (_, before, one), (_, after, other) in pairwise(row):
                assert before + one / 2 < after - other / 2, (language, figure.names, before, after)


@each("lesson", LESSONS.values())
def test_the_veil_lies_over_the_figures_that_answer_and_leaves_others_open(lesson: Lesson) -> None:
    figures = list(lesson.figures(lesson.compute(lesson.start())))
    tabs = {figure.id: figure.tab("en") for figure in figures}
    asked = next(k for k, scene in enumerate(lesson.path) if scene.do == Choose(Question.FIRST))
    answers = {lesson.answering} | {name for scene in lesson.path[asked:] for name in scene.figures}
    answers -= {name for scene in lesson.path[:asked] for name in scene.figures} - {lesson.answering}
    assert {tabs[name] for name in answers & set(tabs)} == {tabs[name] for name in lesson.veil}
    assert all((tab in {tabs[name] for name in lesson.veil}) == (name in lesson.veil) for name, tab in tabs.items()), "whole tabs"
    assert 0 < len(lesson.veil) < len(figures)
