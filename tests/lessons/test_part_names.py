"""What is true of the names that a plant's parts have on the stage: few, at parts that stand there, gone after the first action."""

from __future__ import annotations

import math
import re

from laws import each
from test_paths import Walker

from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.plants import MODELS
from observer_lab.plants.bodies.body import MOST_NAMES, Body
from observer_lab.session.commands.commands import ToggleNames
from observer_lab.session.commands.guide import GoToScene
from observer_lab.text import languages

LEAST_NAMES, LONGEST, LEAST_WAY = 2, 32, 0.25  # names; letters; stage units from a part to its name


def bodies(lesson: Lesson) -> list[tuple[Body, list[float]]]:
    """The body of a lesson's stage, and those of its plants, each with a state that it takes."""
    stage = lesson.compute(lesson.start()).stage
    assert stage is not None
    return [(stage.body, stage.x[0].tolist())]


@each("lesson", LESSONS.values())
def test_a_plant_has_few_names_each_at_a_part_that_is_there(lesson: Lesson) -> None:
    for body, x in bodies(lesson):
        poses, twins = body.pose(x, body.gain), {part.name for part in body.parts if part.twin}
        assert LEAST_NAMES <= len(body.names) <= MOST_NAMES
        for name in body.names:
            assert name.part in poses and (name.part in twins or not name.ghost), name.part
            assert math.hypot(*name.away) >= LEAST_WAY
            assert all(0 < len(name.words(code)) <= LONGEST for code in languages())
        for code in languages():
            assert len({name.words(code) for name in body.names}) == len(body.names)


def test_every_built_in_plant_names_its_parts_too() -> None:
    for model in MODELS.values():
        poses = model.body.pose(model.x0, model.body.gain)
        assert LEAST_NAMES <= len(model.body.names) <= MOST_NAMES and all(name.part in poses for name in model.body.names), model.id


@each("id", LESSONS)
def test_the_names_go_with_the_first_action_and_come_back_by_their_key(id: str) -> None:
    walker = Walker(id)

    def named() -> bool:
        assert walker.session.picture is not None
        return walker.session.picture.named

    assert named()
    walker.do()
    assert not named()
    walker.send(GoToScene(2))
    assert not named()
    walker.send(ToggleNames())
    assert named()
    walker.send(GoToScene(0))
    walker.send(ToggleNames())
    assert not named()


def has_error_bar(lesson: Lesson) -> bool:
    (body, x), *_ = bodies(lesson)
    return body.marks is not None and len(body.marks(x, x, body.gain).bars) > 0


@each("lesson", [lesson for lesson in LESSONS.values() if has_error_bar(lesson)])
def test_the_error_on_the_stage_is_the_error_of_the_run(lesson: Lesson) -> None:
    """The first number is x₁ − x̂₁ of the sample; the bar goes from where the plant stands to where its ghost does."""
    stage = lesson.compute(lesson.start()).stage
    assert stage is not None and stage.xhat is not None and stage.body.marks is not None
    count = len(stage.body.marks(stage.x[0].tolist(), stage.xhat[0].tolist(), stage.body.gain).words)
    for k in range(0, len(stage.t), max(len(stage.t) // 20, 1)):
        x, xhat = stage.x[k].tolist(), stage.xhat[k].tolist()
        marks = stage.body.marks(x, xhat, stage.body.gain)
        number, unit = re.fullmatch(r"e₁ = (−?[\d.]+) (\w+)", marks.words[0][0]).groups()  # type: ignore[union-attr]
        digits = len(number.partition(".")[2])
        assert abs(float(number.replace("−", "-")) - (x[0] - xhat[0])) <= 0.5 * 10.0**-digits + 1e-9 and unit in ("m", "K")
        assert len(marks.words) == count and max(map(ord, "".join(words for words, *_ in marks.words))) < 2**15  # as frames pack them
        apart = math.dist(*marks.bars[0])
        assert abs(apart - math.dist(stage.body.anchors(x, stage.body.gain)[0], stage.body.anchors(xhat, stage.body.gain)[0])) < 1e-9
        same = stage.body.marks(x, x, stage.body.gain)
        assert math.dist(*same.bars[0]) == 0.0
