"""Build the left column: question, prediction, knobs, explanation, tasks, exams."""

from __future__ import annotations

import html
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import viser

from ...session.commands.commands import CheckTask, Edit, OpenLesson, ShowHint, ShowSolution
from ...session.commands.guide import SetMode
from ...session.state.view import Picture, TaskState
from ..charts.print_sizes import Sizes
from ..replay.pull_sliders import PullSliders
from ..viser_private import viser_internals
from ..viser_private.hidden_input import hidden_input
from ..viser_private.widget_values import ReadBack
from ..votes.room_card import RoomPanel, room_command
from ..words import phrases
from ..words.menu import menu_edit, menu_html, mode_switch
from ..words.prose import explained_html, formula_html, judged_html, render_markdown, with_minus
from .compare_panel import ComparePanel
from .course_page import CourseGuide
from .derivation_panel import DerivationPanel
from .exam_panel import ExamPanel, HandInBox, is_listed
from .knob_rows import KnobRows
from .live_panel import LivePanel
from .plant_picker import PlantRow
from .pole_sliders import PoleSliders
from .prediction_panel import PredictionPanel, SecondPredictionPanel
from .record_picker import RecordPicker

Post = Callable[[Edit], int]


class Panel:
    """The column of one lesson in one language."""

    def __init__(self, client: viser.ClientHandle, picture: Picture, post: Post) -> None:
        gui = self._gui = client.gui
        self._post = post
        self._lang = picture.state.language
        self._lesson = picture.lesson
        self._step = picture.state.step
        self._words = picture.lesson.words[self._lang]
        self._formulas: dict[str, viser.GuiHtmlHandle] = {}
        self._tasks: dict[str, tuple[viser.GuiMarkdownHandle, viser.GuiButtonGroupHandle]] = {}
        self._hand_ins: list[HandInBox] = []
        self._plants: PlantRow | None = None
        self._hand = viser_internals.node_id(hidden_input(gui, self._heard))
        self._head(picture)
        self._room = RoomPanel(client, picture, self._hand)
        self._running = None if self._lesson.live is None else LivePanel(client, picture)
        self._prediction = PredictionPanel(gui, picture, post)
        self._part("knobs")
        self._rows = KnobRows(gui, picture, post)
        self._pulls = PullSliders(client, picture, post)
        self._poles = PoleSliders(client, picture, post)
        self._again = SecondPredictionPanel(gui, picture, post)
        if self._lesson.adapt is not None:
            self._plants = PlantRow(gui, picture, post)
        self._records = None if self._lesson.take_record is None else RecordPicker(gui, picture, post)
        self._beside = ComparePanel(gui, picture, post)
        self._part("why")
        self._numbers(picture)
        self._explain()
        self._derivation = DerivationPanel(gui, picture)
        self._part("tasks")
        self._make_tasks(picture)
        self._exams = ExamPanel(gui, picture, post)
        self._guide.end(picture)
        if self._words.source:
            gui.add_markdown(f"*{phrases.SOURCE(self._lang)}: {render_markdown(self._words.source)}*")
        if self._words.references:
            gui.add_html(f'<details class="ol-note ol-others"><summary>{phrases.READ_ON(self._lang)}</summary>'
                         + "".join(f"<p>{html.escape(item)}</p>" for item in self._words.references) + "</details>")

    @property
    def fields(self) -> dict[str, dict[str, object]]:
        """The number fields beside the knobs' sliders."""
        return self._rows.fields

    # --- building --------------------------------------------------------------------------------------------------
    def _head(self, picture: Picture) -> None:
        gui, lang = self._gui, self._lang
        titles = {lesson.id: lesson.words[lang].title for lesson in picture.catalogue}
        keys = {title: lesson_id for lesson_id, title in titles.items()}
        question = f'<h1 class="ol-question">{self._words.question}</h1>'
        if picture.state.lecture:
            gui.add_html(question)
        modes = mode_switch("lab", lang, self._hand) if self._lesson.path else ""
        menu = menu_html(picture, self._hand, keys=Sizes(picture.state).lists_keys)
        gui.add_html(f'<div class="ol-head">{modes}<span class="ol-lesson"></span>{menu}</div>')
        self._choice = gui.add_dropdown(phrases.LESSON(lang), tuple(titles.values()),
                                        initial_value=titles[self._lesson.id])
        self._guide = CourseGuide(gui, picture, self._post)
        if not picture.state.lecture:
            gui.add_html(question)
        self._introduce(picture.state.lecture)
        self._catalogue = ReadBack(self._choice, lambda title: self._post(OpenLesson(keys.get(title, ""))))

    def _heard(self, said: str) -> None:
        """What a button of the head or of the room asks for."""
        kind, _, value = said.partition(":")
        edit = SetMode(value) if kind == "mode" else menu_edit(kind, value) or room_command(kind, value)
        if edit is not None:
            self._post(edit)

    def _introduce(self, lecture: bool) -> None:
        """What the question is about; folded in a hall, where somebody tells it."""
        if not lecture:
            self._gui.add_markdown(explained_html(self._words, render_markdown(self._words.introduction)))
            return
        with self._gui.add_folder(phrases.SETTING(self._lang), expand_by_default=False):
            self._gui.add_markdown(explained_html(self._words, render_markdown(self._words.introduction)))

    def _part(self, name: str) -> None:
        """Where a part of the column begins, for the style sheet."""
        self._gui.add_html(f'<i class="ol-part-{name}" hidden></i>')

    def _numbers(self, picture: Picture) -> None:
        if not picture.outcome.formulas and not picture.outcome.live(self._lang):
            return
        with self._gui.add_folder(phrases.NUMBERS(self._lang), expand_by_default=not picture.state.lecture):
            self._live = self._gui.add_html("")
            for formula in picture.outcome.formulas:
                self._formulas[formula.id] = self._gui.add_html("")

    def _explain(self) -> None:
        for index, (heading, text) in enumerate(self._words.steps):
            with self._gui.add_folder(heading, expand_by_default=index == self._step):
                self._gui.add_markdown(explained_html(self._words, render_markdown(text)))

    def _make_tasks(self, picture: Picture) -> None:
        listed = [task for task in self._lesson.tasks if is_listed(picture, "task", task.id)]
        if not listed:
            return
        lang, launched = self._lang, picture.state.learner is not None and bool(picture.state.learner.item)
        with self._gui.add_folder(phrases.TASKS(lang), expand_by_default=launched):
            for task in listed:
                text = self._gui.add_markdown("")
                typed = picture.state.tasks.get(task.id, TaskState()).typed
                field = None if task.typed is None else self._gui.add_text(phrases.RESULT(lang), typed)
                offered = (phrases.CHECK_BUTTON, phrases.HINT) if not picture.state.offers_solution(self._lesson.id, task.id) else (
                    phrases.CHECK_BUTTON, phrases.HINT, phrases.SOLUTION)
                row = self._gui.add_button_group("", tuple(word(lang) for word in offered))
                self._tasks[task.id] = text, row
                self._listen(row, task.id, field)
                self._hand_ins.append(HandInBox(self._gui, picture, "task", task.id, self._post, partial(_typed, field)))

    def _listen(self, row: viser.GuiButtonGroupHandle, task_id: str, field: viser.GuiInputHandle[str] | None) -> None:
        commands: dict[str, Edit] = {phrases.HINT(self._lang): ShowHint(task_id), phrases.SOLUTION(self._lang): ShowSolution(task_id)}

        @row.on_click
        async def _(event: viser.GuiEvent) -> None:
            word = event.target.value
            if word == phrases.CHECK_BUTTON(self._lang):
                self._post(CheckTask(task_id, _typed(field)))
            elif word in commands:
                self._post(commands[word])

    # --- showing ---------------------------------------------------------------------------------------------------
    def show(self, picture: Picture) -> None:
        """Everything in the column that may have changed."""
        self._catalogue.show(self._words.title, picture)
        self._guide.show(picture)
        self._room.show(picture)
        self._rows.show(picture)
        if self._running is not None:
            self._running.show(picture)
        self._pulls.show(picture)
        self._poles.show(picture)
        if self._plants is not None:
            self._plants.show(picture)
        if self._records is not None:
            self._records.show(picture)
        self._beside.show(picture)
        if picture.resting:
            self._show_numbers(picture)
        self._derivation.show(picture)
        self._prediction.show(picture)
        self._again.show(picture)
        for task_id in self._tasks:
            task = picture.state.tasks.get(task_id, TaskState())
            offered = task.solution and picture.state.offers_solution(self._lesson.id, task_id)
            self._show_task(task_id, replace(task, solution=offered), task.is_stale(picture.design))
        for box in self._hand_ins:
            box.show(picture)
        self._exams.show(picture)

    def _show_numbers(self, picture: Picture) -> None:
        if self._formulas or hasattr(self, "_live"):
            _write(self._live, f'<p class="ol-note ol-live">{with_minus(picture.outcome.live(self._lang))}</p>')
        for formula in picture.outcome.formulas:
            if formula.id in self._formulas:
                note = formula.note(self._lang)
                _write(self._formulas[formula.id], formula_html(formula.latex)
                       + (f'<p class="ol-caption">{note}</p>' if note else ""))

    def _show_task(self, task_id: str, state: TaskState, stale: bool) -> None:
        words, lang = self._words.tasks[task_id], self._lang
        parts = [f"**{words.title}**", render_markdown(words.statement)]
        parts += [f"*{phrases.HINT(lang)}:* {render_markdown(hint)}" for hint in words.hints[: state.hints]]
        if state.solution:
            parts.append(f"*{phrases.SOLUTION(lang)}:* {render_markdown(words.solution)}")
        if state.verdict is not None:
            parts.append(judged_html(state.verdict.solved, state.verdict.text(lang), phrases.DESIGN_CHANGED(lang) if stale else ""))
        text = "\n\n".join(parts)
        if self._tasks[task_id][0].content != text:
            self._tasks[task_id][0].content = text

    def progress(self, fraction: float | None) -> None:
        """How far the long job is."""
        self._rows.progress(fraction)


def _typed(field: viser.GuiInputHandle[str] | None) -> str:
    """What is typed in the field of a task, "" where it has none."""
    return "" if field is None else field.value


def _write(handle: Any, content: str) -> None:
    if handle.content != content:
        handle.content = content
