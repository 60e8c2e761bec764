"""Long jobs and clicks on maps of every lesson."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from lesson_checks import check_figures, contents, every_lesson, shown

from observer_lab.course.figures.records import MapFigure
from observer_lab.course.lesson import Lesson


@pytest.mark.slow
@every_lesson
def test_a_job_rises_to_its_end_and_leaves_its_start_alone(lesson: Lesson) -> None:
    if lesson.job is None:
        return
    outcome, figures = shown(lesson.start())
    before = contents(figures)
    fractions, last = [], outcome
    for fraction, better in lesson.job.outcomes(outcome):
        fractions.append(fraction)
        last = better
        assert len(fractions) < 100_000
    assert fractions and all(0 <= f <= 1 for f in fractions) and fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1.0)
    assert last.design == outcome.design
    check_figures(tuple(lesson.figures(last)))
    assert contents(tuple(lesson.figures(last))) != before, "a job that shows nothing new"
    found = [tuple(f for f in some if f.id == lesson.job.figure) for some in (figures, tuple(lesson.figures(last)))]
    assert found[1] and contents(found[1]) != contents(found[0]), "the figure that opens shows what was found"
    assert contents(tuple(lesson.figures(outcome))) == before


@every_lesson
def test_a_job_can_be_dropped_midway(lesson: Lesson) -> None:
    if lesson.job is None:
        return
    outcome, figures = shown(lesson.start())
    before = contents(figures)
    for steps in (0, 1, 3):
        job: Any = lesson.job.outcomes(outcome)
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
