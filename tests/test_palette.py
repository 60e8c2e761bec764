"""The palette finds every lesson and all scenes, knobs and figures of the open one, in each language."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import pytest
from lesson_checks import every_lesson

from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.page.column.knob_widgets import label_of
from observer_lab.page.screen.palette import fill_palette
from observer_lab.session.commands.commands import OpenLesson
from observer_lab.session.commands.guide import GoToScene, SetMode
from observer_lab.session.state.view import Picture, State
from observer_lab.text import languages


class Palette:
    """Keeps the commands that are registered."""

    def __init__(self) -> None:
        self.words: dict[str, str | None] = {}
        self.acts: dict[str, Callable[[Any], Any]] = {}
        self.gui = self

    def add_command(self, label: str, description: str | None) -> Any:
        self.words[label] = description

        def keep(act: Callable[[Any], Any]) -> None:
            self.acts[label] = act
        return SimpleNamespace(on_trigger=keep)

    def choose(self, label: str) -> None:
        asyncio.run(self.acts[label](None))


def filled(lesson_id: str, language: str, mode: str) -> tuple[Palette, list[Any]]:
    """The palette of a lesson in a view, and the edits that it posts."""
    lesson, palette, posted = LESSONS[lesson_id], Palette(), list[Any]()
    outcome = lesson.compute(lesson.start())
    picture = Picture(lesson, lesson.start(), outcome, lesson.figures(outcome), State(language=language, guided=mode == "guide"), True,
                      tuple(LESSONS.values()))
    fill_palette(cast(Any, palette), picture, posted.append, lambda figure: None)
    return palette, posted


@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize("lesson_id", ["separation", "kalman"])
def test_everything_is_found_in_every_language(lesson_id: str, language: str) -> None:
    palette, _ = filled(lesson_id, language, "lab")
    found = " | ".join(f"{label} {others or ''}" for label, others in palette.words.items())
    lesson = LESSONS[lesson_id]
    figures = lesson.figures(lesson.compute(lesson.start()))
    for code in languages():
        wanted = [each.words[code].title for each in LESSONS.values()]
        wanted += [lesson.words[code].scenes[scene.id].title for scene in lesson.path]
        wanted += [knob.label(code) for knob in lesson.knobs if not knob.hidden and lesson.shown(knob, lesson.start())]
        wanted += [figure.title(code) for figure in figures]
        assert [words for words in wanted if words not in found] == []


def test_what_is_chosen_is_opened_in_the_view_that_has_it() -> None:
    lesson = LESSONS["separation"]
    for mode, switch in (("lab", []), ("guide", [SetMode("lab")])):
        palette, posted = filled(lesson.id, "en", mode)
        palette.choose(f"Lesson: {LESSONS['kalman'].words['en'].title}")
        assert posted == [OpenLesson("kalman")]
        posted.clear()
        knob = lesson.knob("stiffness_error")
        palette.choose(f"Knob: {knob.label('en')}")
        assert posted[:-1] == switch and label_of(knob, "en") in posted[-1].do.args
        posted.clear()
        palette.choose(f"Scene: {lesson.words['en'].scenes[lesson.path[2].id].title}")
        assert posted == [*([] if mode == "guide" else [SetMode("guide")]), GoToScene(2)]


@every_lesson
def test_an_arrow_on_the_stage_is_seen_on_the_ground_of_either_theme(lesson: Lesson) -> None:
    stage = lesson.compute(lesson.start()).stage
    if stage is None or stage.u is None:
        return
    roles = {arrow.role for k in (0, -1) for arrow in stage.body.arrows(stage.x[k].tolist(), stage.u[k].tolist(), stage.body.gain)}
    assert not roles & {"reference", "label", "ink"}, "black is not seen in the dark"
