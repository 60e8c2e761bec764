"""Show where an exam or a task of a course is handed in: button, signed token, copy and save."""

from __future__ import annotations

import html
from collections.abc import Callable

import viser

from ...course.handin.course_file import CourseItem, Kind, item_name
from ...session.commands.commands import Edit
from ...session.commands.exams import HandIn, SaveHandIn
from ...session.state.view import Picture
from ..words import phrases


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
