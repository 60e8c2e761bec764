"""What is true of a block diagram: its wires carry the signals of the run, L is off where nothing is corrected, presses go both ways."""

from __future__ import annotations

import re

import numpy as np
from laws import each
from test_paths import Walker

from observer_lab.course.figures.diagram import DIAGRAM, DiagramFigure
from observer_lab.course.lesson import Lesson, Outcome
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.svg import draw
from observer_lab.session.commands.commands import SetKnobs

IN_THE_GUIDE = ("virtual-sensor", "separation", "duality", "saturation", "kalman")
IN_THE_LAB = (*IN_THE_GUIDE, "error-dynamics", "hidden-modes", "noise", "sandbox", "lqg", "arm")
SAID = re.compile(r'data-said="([^"]*)" data-widths="([^"]*)"')


def diagram(lesson: Lesson, outcome: Outcome | None = None) -> DiagramFigure:
    found = [each for each in lesson.figures(outcome or lesson.compute(lesson.start())) if isinstance(each, DiagramFigure)]
    assert len(found) == 1
    return found[0]


@each("id", IN_THE_LAB)
def test_the_wires_carry_the_signals_of_the_run(id: str) -> None:
    outcome = LESSONS[id].compute(LESSONS[id].start())
    figure = diagram(LESSONS[id], outcome)
    wires = {wire.symbol: np.asarray(wire.values).reshape(len(figure.t), -1) for wire in figure.wires}
    np.testing.assert_allclose(wires["y"] - wires["ŷ"], wires["y − ŷ"], atol=1e-12)
    run = outcome.run if id != "saturation" else None
    if run is not None:
        np.testing.assert_array_equal(wires["u"], run.u_applied.reshape(len(figure.t), -1))
        np.testing.assert_array_equal(wires["x̂"], run.xhat.reshape(len(figure.t), -1))
    assert figure.tab == DIAGRAM and {block.id for block in figure.blocks} >= {"plant", "observer", "L"}


@each("id", IN_THE_LAB)
def test_a_drawn_wire_says_as_many_values_as_it_has_widths_and_is_thickest_where_its_signal_is_largest(id: str) -> None:
    figure = diagram(LESSONS[id])
    drawn = SAID.findall(draw(figure, "en"))
    assert len(drawn) == len(figure.wires)
    for wire, (said, widths) in zip(figure.wires, drawn, strict=True):
        assert len(said.split("|")) == len(widths.split("|")) == len(figure.moments)
        assert not re.search(r"\de[+-]?\d|nan|inf", said), "numbers as one writes them"
        shares = wire.shares
        assert shares.min() >= 0 and shares.max() <= 1
        if wire.sizes.max() > 0:
            assert shares[np.argmax((wire.sizes / wire.full).max(axis=1))] == shares.max() > 0.99


@each("id", IN_THE_GUIDE)
def test_the_guide_shows_the_diagram_in_a_scene(id: str) -> None:
    assert any("diagram" in scene.figures for scene in LESSONS[id].path)


def test_a_press_on_a_block_is_an_experiment_that_can_be_taken_back() -> None:
    pressed = 0
    for lesson in map(LESSONS.__getitem__, IN_THE_LAB):
        start = lesson.start()
        for block in diagram(lesson).blocks:
            if block.press:
                there = lesson.apply(start, block.press)
                other = diagram(lesson, lesson.compute(there))
                back = lesson.apply(there, other.pressed(block.id))
                words = {shown.pressed("en") for shown in (block, *(each for each in other.blocks if each.id == block.id))}
                assert there != start and back == start and len(words) == 2
                pressed += 1
    assert pressed >= 2


def test_the_correction_that_is_opened_leaves_a_copy() -> None:
    walker = Walker("virtual-sensor")
    picture = walker.session.picture
    assert picture is not None
    walker.send(SetKnobs(dict(diagram(picture.lesson, picture.outcome).pressed("L"))), 1.0)
    picture = walker.session.picture
    assert picture is not None
    figure = diagram(picture.lesson, picture.outcome)
    assert next(block for block in figure.blocks if block.id == "L").off
    assert 'stroke-dasharray="5 4"' in draw(figure, "en")
