"""What moves and what scales: the clock's cursor and its slider, numbers on logarithmic axes, longer arrows."""

from __future__ import annotations

import html

import numpy as np
import pytest
from laws import each

from observer_lab.course.figures.records import Curve, LineFigure, over_frequency
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.charts import decades, is_over_run_time
from observer_lab.page.charts.svg import draw
from observer_lab.page.replay.transport import end_of, step_of
from observer_lab.plants.bodies.body import with_longer_arrows
from observer_lab.plants.platform import model
from observer_lab.text import languages, same


@each(("low", "high"), [(0.3, 3.0), (0.1, 10.0), (10.0, 100.0), (2e-4, 9e-4), (3.0, 300.0), (0.9, 1.4e3)])
def test_a_narrow_logarithmic_axis_has_more_than_one_number(low: float, high: float) -> None:
    values, names = decades(low, high)
    assert 2 <= len(values) <= 8 and len(set(names)) == len(values)
    assert all(low <= v * (1 + 1e-9) and v <= high * (1 + 1e-9) for v in values)


def test_the_numbers_of_a_logarithmic_axis_are_written_as_one_writes_them() -> None:
    assert decades(2e-4, 1e-3)[1] == ("2·10⁻⁴", "5·10⁻⁴", "10⁻³")
    assert decades(0.2, 2.0)[1] == ("0.2", "0.5", "1", "2")
    assert decades(1e-6, 1e3)[1][-1] == "10³"


def test_no_cursor_stands_in_a_chart_whose_time_is_not_the_runs() -> None:
    def chart(end: float) -> LineFigure:
        return LineFigure("t", same("t"), np.linspace(0.0, end, 11), (Curve(same("y"), np.zeros(11)),))
    assert is_over_run_time(chart(2.4), 2.4) and is_over_run_time(chart(8.0), 7.9)
    assert not is_over_run_time(chart(20.0), 2.4) and not is_over_run_time(chart(6.0), 2.4)
    assert not is_over_run_time(over_frequency("f", same("f"), np.ones(2), ()), 1.0)


@each("horizon", [0.002, 0.35, 2.0, 2.4, 6.0, 7.9, 12.0, 16.0, 600.0])
def test_the_clock_stands_at_numbers_that_fit_their_field(horizon: float) -> None:
    step = step_of(horizon)
    assert horizon / 1300 < step <= horizon / 499
    assert len(f"{777 * step:.9g}".lstrip("0.").replace(".", "")) <= 4
    assert end_of(float(np.nextafter(horizon, np.inf))) == end_of(horizon) == horizon


def test_how_much_longer_arrows_are_is_the_bodys_to_say() -> None:
    plain = model.body()
    longer = with_longer_arrows(plain, 50.0, 3)
    x, u = [0.0] * 10, [0.01, 0.02, -0.01, 1e-5, 0.0]
    assert longer.forces == 50.0 and plain.forces == 1.0
    assert longer.arrows(x, u, 20.0) == plain.arrows(x, [0.5, 1.0, -0.5, 1e-5, 0.0], 20.0)


@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize("lesson", LESSONS.values(), ids=lambda lesson: lesson.id)
def test_every_picture_of_a_lesson_can_be_drawn(lesson: Lesson, language: str) -> None:
    for figure in lesson.figures(lesson.compute(lesson.start())):
        if not isinstance(figure, LineFigure):
            assert figure.title(language)[:12] in html.unescape(draw(figure, language))
