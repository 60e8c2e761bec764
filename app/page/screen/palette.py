"""Fill the command palette with lessons, scenes, knobs and figures, in every language."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import viser

from ...course.knobs import Knob, Poles
from ...course.search.questions import AskedQuestion, questions
from ...session.commands.commands import Edit, OpenLesson, RunOnTabThread
from ...session.commands.guide import GoToScene, SetMode
from ...session.state.view import Picture
from ...text import Text, languages
from ..column.knob_widgets import label_of
from ..viser_private import page_scripts
from ..words import phrases

Post = Callable[[Edit], object]
Entry = tuple[Text, Callable[[str], str], tuple[Edit, ...]]  # of what kind it is, its name in a language, and what opens it


def fill_palette(client: viser.ClientHandle, picture: Picture, post: Post, open_figure: Callable[[str], object]) -> None:
    """One entry for each; it is found by its name in any language, and shown in the page's own."""
    language = picture.state.language
    for kind, name, edits in entries(client, picture, open_figure):
        others = " · ".join(dict.fromkeys(name(code) for code in languages() if code != language))
        handle = client.gui.add_command(f"{kind(language)}: {name(language)}", description=others or None)
        _bind(handle, edits, post)
    turn = RunOnTabThread(partial(page_scripts.turn_light, client))
    _bind(client.gui.add_command(phrases.SHADOWS(language), description=phrases.SHADOWS_SAY(language)), (turn,), post)
    scenes = {(lesson.id, scene.id) for lesson in picture.catalogue for scene in lesson.path}
    for question in questions()[language].entries:
        if (question.lesson, question.scene) in scenes:
            label = f"{phrases.QUESTION_KIND(language)}: {question.title}"
            handle = client.gui.add_command(label, description=" · ".join(question.phrases))
            _bind(handle, opening(question, picture), post)


def opening(question: AskedQuestion, picture: Picture) -> tuple[Edit, ...]:
    """The edits that open the scene which answers a question."""
    lesson = next(lesson for lesson in picture.catalogue if lesson.id == question.lesson)
    scene = [scene.id for scene in lesson.path].index(question.scene)
    there = () if lesson.id == picture.lesson.id else (OpenLesson(lesson.id),)
    return *there, *(() if picture.guided else (SetMode("guide"),)), GoToScene(scene)


def entries(client: viser.ClientHandle, picture: Picture, open_figure: Callable[[str], object]) -> Iterator[Entry]:
    """What can be looked for: every lesson; of the one that is open its scenes, knobs and figures."""
    lesson, to_lab = picture.lesson, (SetMode("lab"),) if picture.guided else ()
    for each in picture.catalogue:
        yield phrases.LESSON_KIND, lambda code, each=each: each.words[code].title, (OpenLesson(each.id),)
    for k, scene in enumerate(lesson.path):
        to_guide = () if picture.guided else (SetMode("guide"),)
        yield phrases.SCENE_KIND, lambda code, id=scene.id: lesson.words[code].scenes[id].title, (*to_guide, GoToScene(k))
    for knob in lesson.knobs:
        if not knob.hidden and lesson.shown(knob, picture.design):
            find = RunOnTabThread(partial(page_scripts.find_knob, client, *_place(knob, picture)))
            yield phrases.KNOB_KIND, knob.label, (*to_lab, find)
    for figure in picture.figures:
        show = RunOnTabThread(partial(open_figure, figure.id))
        yield phrases.FIGURE_KIND, figure.title, (*to_lab, show)


def _place(knob: Knob, picture: Picture) -> tuple[str, str]:
    """The words beside a knob's widget in the lab, and the head of the folder in which it may stand."""
    language = picture.state.language
    if isinstance(knob, Poles):
        return f"{knob.symbol}1", knob.label(language)
    return label_of(knob, language), (phrases.MORE_KNOBS if picture.state.lecture else phrases.MORE)(language)


def _bind(handle: viser.CommandHandle, edits: tuple[Edit, ...], post: Post) -> None:
    @handle.on_trigger
    async def _(_: object) -> None:
        for edit in edits:
            post(edit)
