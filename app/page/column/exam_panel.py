"""Show the exams in the left column: key, statement, answer field, result, and where one is handed in."""

from __future__ import annotations

import html
import re
from collections.abc import Callable
from typing import Any

import viser

from ...course.exercises.derivation import fill_placeholders
from ...course.exercises.exam import Exam
from ...course.handin.course_file import CourseItem, Kind, item_name
from ...session.commands.commands import Edit
from ...session.commands.exams import AnotherVariant, AnswerExam, HandIn, SaveHandIn, SetKey, SetWord, WithholdResults
from ...session.handlers.exams import is_withheld, last_answer, present_item, present_verdict
from ...session.state.view import Picture
from ...text import joined, same
from ..viser_private.widget_values import ReadBack
from ..words import phrases
from ..words.prose import equation_html, judged_html, render_markdown, with_minus

EQUATION = re.compile(r"\$\$(.+?)\$\$", re.S)


class ExamPanel:
    """A folder with one for each exam of the lesson; what is told of an answer stands under it."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Callable[[Edit], int]) -> None:
        self._lang, self._lesson, self._post = picture.state.language, picture.lesson, post
        self._modes = {phrases.PRACTICE(self._lang): False, phrases.WITHHELD(self._lang): True}
        self._forms: dict[str, _Form] = {}
        listed = [exam for exam in self._lesson.exams if is_listed(picture, "exam", exam.id)]
        if not listed:
            return
        launched = picture.state.learner is not None
        with gui.add_folder(phrases.EXAM(self._lang), expand_by_default=launched):
            course, learner = picture.state.course, picture.state.learner
            key = gui.add_text(phrases.KEY(self._lang), picture.state.key, hint=phrases.KEY_HINT(self._lang), visible=learner is None)
            word = gui.add_text(phrases.WORD(self._lang), picture.state.word, hint=phrases.WORD_HINT(self._lang),
                                visible=learner is None and course is not None and course.course.words)
            if course is not None:
                note = phrases.COURSE_NOTE if learner is None else phrases.LEARNER_NOTE
                told = note.format(title=course.course.title)(self._lang)
                gui.add_html(f'<p class="ol-note">{html.escape(told)}</p>')
            elif picture.state.sealed:
                gui.add_html(f'<p class="ol-note">{phrases.NOTES_ALONE(self._lang)}</p>')
            mode = gui.add_dropdown(phrases.MODE(self._lang), tuple(self._modes), initial_value=self._mode(picture),
                                    visible=not picture.state.sealed, hint=phrases.MODE_HINT(self._lang))
            for count, exam in enumerate(listed, 1):
                title = self._lesson.words[self._lang].exams[exam.id].title
                with gui.add_folder(f"{count} {title}", expand_by_default=launched and len(listed) == 1):
                    self._forms[exam.id] = _Form(gui, picture, exam, post)
        self._key = ReadBack(key, lambda words: post(SetKey(words)))
        self._word = ReadBack(word, lambda words: post(SetWord(words)))
        self._choice = ReadBack(mode, lambda words: post(WithholdResults(self._modes.get(words, False))))

    def _mode(self, picture: Picture) -> str:
        return next(words for words, withheld in self._modes.items() if withheld == picture.state.withheld)

    def show(self, picture: Picture) -> None:
        """The numbers of the key and the variant, and what is told of the last answer to them."""
        if not self._forms:
            return
        self._key.show(picture.state.key, picture)
        self._word.show(picture.state.word, picture)
        self._choice.show(self._mode(picture), picture)
        for form in self._forms.values():
            form.show(picture)


class _Form:
    """One exam."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, exam: Exam, post: Callable[[Edit], int]) -> None:
        self._exam, self._lang = exam, picture.state.language
        self._words = picture.lesson.words[self._lang].exams[exam.id]
        self._statement = gui.add_markdown("")
        self._answer = gui.add_text(phrases.ANSWER(self._lang), last_answer(picture.state, picture.lesson.id, exam))
        row = gui.add_button_group("", (phrases.CHECK_BUTTON(self._lang), phrases.ANOTHER(self._lang)))
        note = gui.add_button(phrases.NOTE(self._lang))
        self._buttons: tuple[Any, Any] = row, note
        self._told = gui.add_html("")
        self._hand_in = HandInBox(gui, picture, "exam", exam.id, post, lambda: self._answer.value)
        if picture.state.course is not None and not self._hand_in.asked:
            gui.add_html(f'<p class="ol-note">{phrases.NOT_HANDED_IN(self._lang)}</p>')

        @row.on_click
        async def _(event: viser.GuiEvent) -> None:
            if event.target.value == phrases.CHECK_BUTTON(self._lang):
                post(AnswerExam(exam.id, self._answer.value))
            else:
                post(AnotherVariant(exam.id))

        @note.on_click
        async def _(_: viser.GuiEvent) -> None:
            post(AnswerExam(exam.id, self._answer.value))

    def show(self, picture: Picture) -> None:
        state, exam = picture.state, self._exam
        item = present_item(state, picture.lesson.id, exam)
        statement = render_markdown(joined(same(fill_placeholders(self._words.statement, item.given)), exam.digits.asked)(self._lang))
        if self._statement.content != statement:
            said = last_answer(state, picture.lesson.id, exam)
            if self._statement.content and self._answer.value != said:  # other numbers, another answer
                self._answer.value = said
            self._statement.content = statement
        withheld = is_withheld(state, picture.lesson.id, exam)
        for handle, seen in zip(self._buttons, (not withheld, withheld and not self._hand_in.asked), strict=True):
            if handle.visible != seen:
                handle.visible = seen
        self._hand_in.show(picture)
        told = self._told_of(picture)
        if self._told.content != told:
            self._told.content = told

    def _told_of(self, picture: Picture) -> str:
        state, lesson = picture.state, picture.lesson.id
        said, verdict = last_answer(state, lesson, self._exam), present_verdict(state, lesson, self._exam)
        if verdict is None:
            noted = is_withheld(state, lesson, self._exam) and said and not self._hand_in.asked
            return f'<div class="ol-note">{with_minus(html.escape(phrases.NOTED.format(said=said)(self._lang)))}</div>' if noted else ""
        if picture.state.predicted is None:  # formulas would answer the prediction
            return judged_html(verdict.solved, verdict.text(self._lang)) + f'<p class="ol-note">{phrases.HOW_LATER(self._lang)}</p>'
        return (judged_html(verdict.solved, verdict.text(self._lang)) + f'<p class="ol-caption">{phrases.HOW(self._lang)}</p>'
                + derived(self._exam.derived(self._words.derivation, present_item(picture.state, picture.lesson.id, self._exam))))


def derived(words: str) -> str:
    """A derivation as the page shows it: words as paragraphs, equations on lines of their own."""
    parts = EQUATION.split(words)
    return "".join(equation_html(part.strip()) if index % 2 else f'<p class="ol-note">{render_markdown(part.strip())}</p>'
                   for index, part in enumerate(parts) if part.strip())


def is_listed(picture: Picture, kind: Kind, id: str) -> bool:
    """Whether an exam or a task has a place in the column.

    Of a lesson's exams those that the course file names, and beside what a launch opens nothing else of its lesson.
    """
    course, learner, lesson = picture.state.course, picture.state.learner, picture.lesson.id
    opened = "" if course is None or learner is None else learner.item
    if course is not None and opened and course.course.items[opened].lesson == lesson:
        return opened == item_name(kind, lesson, id)
    return course is None or kind == "task" or course.course.item(kind, lesson, id) is not None


class HandInBox:
    """The rule, the button and the last token of one item; nothing at all where the course does not ask for it."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, kind: Kind, id: str, post: Callable[[Edit], int],
                 said: Callable[[], object]) -> None:
        """`said` gives what is typed at the moment of handing in."""
        self._lang, course = picture.state.language, picture.state.course
        self._item = None if course is None else course.asked(kind, picture.lesson.id, id)
        if self._item is None:
            return
        name = self._item.name
        gui.add_html(f'<p class="ol-note">{html.escape(self._rule(self._item))}</p>')
        sign = gui.add_button(phrases.HAND_IN(self._lang))
        self._token = gui.add_html("")
        self._save = gui.add_button(phrases.SAVE_HAND_IN(self._lang), color="gray", visible=False)

        @sign.on_click
        async def _(_: viser.GuiEvent) -> None:
            post(HandIn(kind, id, said()))

        @self._save.on_click
        async def _(_: viser.GuiEvent) -> None:
            post(SaveHandIn(name))

    @property
    def asked(self) -> bool:
        """Whether the item is handed in."""
        return self._item is not None

    def _rule(self, item: CourseItem) -> str:
        tries = phrases.TRIES.format(count=item.tries)(self._lang)
        if item.deadline is None:
            return tries
        return f"{phrases.DEADLINE.format(time=item.deadline.isoformat(' ', 'minutes'))(self._lang)} {tries}"

    def show(self, picture: Picture) -> None:
        """The last token of the item, and what it holds."""
        if self._item is None:
            return
        token = picture.state.hand_ins.get(self._item.name, "")
        shown = self._shown(picture, token) if token else ""
        if self._token.content != shown:
            self._token.content = shown
            self._save.visible = bool(token)

    def _shown(self, picture: Picture, token: str) -> str:
        assert picture.state.course is not None and self._item is not None
        hand_in = picture.state.course.handed(self._item.name, token)
        if hand_in is None:
            return ""
        held = phrases.SIGNED_TASK if self._item.kind == "task" else phrases.SIGNED_ANSWER
        words = held.format(student=hand_in.student, answer=hand_in.answer, time=f"{hand_in.time:%Y-%m-%d %H:%M}")(self._lang)
        copy, done = (html.escape(said(self._lang), quote=True) for said in (phrases.COPY_HAND_IN, phrases.COPIED))
        return (f'<p class="ol-note">{html.escape(words)}</p>'
                f'<div class="ol-take"><input class="ol-link" readonly aria-label="{copy}" value="{token}">'
                f'<button type="button" class="ol-copy" data-text="{token}" data-done="{done}">{copy}</button></div>')
