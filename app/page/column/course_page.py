"""Show the page of all lessons, the line above the question, and where to go after the lesson."""

from __future__ import annotations

import html
from base64 import b64encode
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path

import viser

from ...course.course_map import Progress
from ...course.learning_paths import next_lessons, paths_with_lessons
from ...course.lectures import MAX_LECTURE_CHARS, prepared_lectures, words_in, write_lecture
from ...course.lesson import Lesson
from ...session.commands.commands import Edit, OpenLesson, ToggleCourse
from ...session.commands.files import UploadLessons
from ...session.commands.guide import OpenLecture
from ...session.state.own_lessons import MAX_ZIP_BYTES, OwnLessons
from ...session.state.view import Picture, progress_of
from ...text import Text, listed, same
from .. import web
from ..viser_private import viser_internals
from ..viser_private.hidden_input import hidden_input
from ..words import phrases
from .dialog import Dialog

Post = Callable[[Edit], int]
NO_PROGRESS = Progress()
HERE = "."  # what the large button says: the lesson that is open
OPENING, PICTURES = "opening", Path(web.__file__).parent / "pictures"  # the name of the first picture, no lesson's; its folder
COURSE = "*"  # what the button of the page of lessons says; no lesson is called that


class CourseGuide:
    """In the left column: the line above the question, and at the end what one might go on with."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Post) -> None:
        self._gui, self._lang = gui, picture.state.language
        self._hand = hidden_input(gui, lambda said: post(ToggleCourse() if said == COURSE else OpenLesson(said)))
        self._line = gui.add_html("")

    def show(self, picture: Picture) -> None:
        """The line, with the tasks solved so far."""
        lang, lesson, count = self._lang, picture.lesson, len(picture.catalogue)
        place = phrases.OF_COURSE.format(number=lesson.number, count=count)(lang)
        tasks = _tasks(progress_of(picture.state.predicted, picture.state.tasks), lesson, lang)
        content = (f'<div class="ol-course">{_button(self._hand, COURSE, html.escape(phrases.COURSE(lang)))}'
                   f"<span>{html.escape(place)}{' · ' + html.escape(tasks) if tasks else ''}</span></div>")
        if self._line.content != content:
            self._line.content = content

    def end(self, picture: Picture) -> None:
        """Where the lesson leads, under its last part."""
        lessons = next_lessons(picture.lesson, picture.catalogue)
        if lessons:
            titles = {each.id: html.escape(f"{each.number} · {each.words[self._lang].title}") for each in lessons}
            buttons = "".join(_button(self._hand, id, title) for id, title in titles.items())
            self._gui.add_html(f'<div class="ol-onward"><span>{html.escape(phrases.GO_ON(self._lang))}</span>{buttons}</div>')


class CourseDialog(Dialog):
    """The page of all lessons, a dialog that opens and closes."""

    def toggle(self, picture: Picture, progress: Mapping[str, Progress]) -> None:
        """Open it, or close it."""
        if self.close():
            return
        gui, lang, lessons = self._client.gui, picture.state.language, picture.catalogue
        with self.open(phrases.COURSE(lang)):
            self._hand = hidden_input(gui, self._open)
            gui.add_html(f"<style>{_stills(lessons)}</style>{self._begin(picture, progress)}")
            parts = gui.add_tab_group()
            with parts.add_tab(phrases.COURSE(lang)):
                gui.add_html(self._cards(lessons, picture, progress))
            for way, on_it in paths_with_lessons(lessons).items():
                with parts.add_tab(way.title(lang)):
                    gui.add_html(f'<p class="ol-note">{html.escape(way.said(lang))}</p>{self._cards(on_it, picture, progress)}')
            with parts.add_tab(phrases.LECTURES(lang)):
                self._offer_lectures(picture)
            if picture.state.own is not None:
                with parts.add_tab(phrases.OWN_LESSONS(lang)):
                    self._offer_own(picture.state.own, picture, progress)
            self.closed_by(gui.add_button(phrases.CLOSE(lang), color="gray"))
            gui.add_html(f"<style>{_loops(lessons)}</style>")  # behind all else: they are larger than the page

    def _offer_lectures(self, picture: Picture) -> None:
        """A button for each prepared lecture, and one that opens a file."""
        gui, lang = self._client.gui, picture.state.language
        gui.add_html(f'<p class="ol-note">{html.escape(phrases.LECTURE_HINT(lang))}</p>')
        for lecture in prepared_lectures({lesson.id: lesson for lesson in picture.catalogue}):
            told = phrases.LECTURE_STOPS.format(minutes=lecture.minutes, count=len(lecture.stops))(lang)
            self._give(gui.add_button(f"{words_in(lecture.title, lang)} · {told}"), write_lecture(lecture))
        upload = gui.add_upload_button(phrases.UPLOAD_LECTURE(lang), color="gray", mime_type=".toml,.txt")

        @upload.on_upload
        async def _(event: viser.GuiEvent) -> None:
            self.close_later()
            self._post(OpenLecture(event.target.value.content[:4 * MAX_LECTURE_CHARS + 1]))

    def _offer_own(self, own: OwnLessons, picture: Picture, progress: Mapping[str, Progress]) -> None:
        """The lessons that the person has brought, and a button that opens others in their place."""
        gui, lang = self._client.gui, picture.state.language
        lost = phrases.OWN_LESSONS_LOST.format(file=own.file)(lang) if own.lost else ""
        gui.add_html("".join(f'<p class="ol-note">{html.escape(words)}</p>' for words in (phrases.OWN_LESSONS_HINT(lang), lost) if words)
                     + self._cards([each for each in picture.catalogue if each.id in own.ids], picture, progress))
        upload = gui.add_upload_button(phrases.UPLOAD_LESSONS(lang), color="gray", mime_type=".zip")

        @upload.on_upload
        async def _(event: viser.GuiEvent) -> None:
            file = event.target.value
            self.close_later()
            self._post(UploadLessons(file.name, file.content[:MAX_ZIP_BYTES + 1]))

    def _give(self, button: viser.GuiButtonHandle, words: str) -> None:
        @button.on_click
        async def _(_: viser.GuiEvent) -> None:
            self.close_later()
            self._post(OpenLecture(words))

    def _begin(self, picture: Picture, progress: Mapping[str, Progress]) -> str:
        """One large button: into the first lesson, under a pole that falls and is caught, or on with the lesson that was open."""
        lang = picture.state.language
        begun = any(far.predicted or far.solved for far in progress.values()) or picture.state.done
        title = html.escape(f"{picture.lesson.number} · {picture.lesson.words[lang].title}")
        button = (f'<button type="button" class="ol-next" data-value="{HERE}" data-to="{viser_internals.node_id(self._hand)}">'
                  f"{html.escape((phrases.CONTINUE if begun else phrases.START)(lang))}</button><span>{title}</span>")
        if begun:
            return f'<div class="ol-begin">{button}</div>'
        return (f'<div class="ol-opening ol-shot-opening"><p>{html.escape(phrases.MOTTO(lang))}</p>'
                f'<div class="ol-begin">{button}</div></div>')

    def _open(self, lesson: str) -> None:
        self.close_later()
        if lesson != HERE:
            self._post(OpenLesson(lesson))

    def _cards(self, lessons: Sequence[Lesson], picture: Picture, progress: Mapping[str, Progress]) -> str:
        cards = (self._card(each, picture, progress.get(each.id, NO_PROGRESS)) for each in lessons)
        return f'<div class="ol-cards">{"".join(cards)}</div>'

    def _card(self, lesson: Lesson, picture: Picture, far: Progress) -> str:
        lang, words = picture.state.language, lesson.words[picture.state.language]
        done = [f"✓ {phrases.PREDICTED(lang)}"] if far.predicted else []
        done += [_tasks(far, lesson, lang)] if far.solved else []
        inner = (f'<i class="ol-shot ol-shot-{lesson.id}"></i><b>{lesson.number} · {html.escape(words.title)}</b>'
                 f"<span>{html.escape(words.question)}</span><small>{html.escape(_standing(lesson, picture)(lang))}</small>"
                 f'<small>{html.escape(" · ".join(done))}{_bar(far, lesson)}</small>')
        here = f' aria-current=page title="{html.escape(phrases.OPEN_NOW(lang), quote=True)}"'
        return _button(self._hand, lesson.id, inner, here if lesson.id == picture.lesson.id else "")


def _standing(lesson: Lesson, picture: Picture) -> Text:
    """How long a lesson takes and what comes before it; of a draft, that it is one."""
    if lesson.draft:
        return phrases.DRAFT
    needs = [same(str(each.number)) for each in picture.catalogue if each.id in lesson.place.needs]
    if not needs:
        return phrases.ON_ITS_OWN
    return phrases.AFTER_ONE.format(lesson=needs[0]) if len(needs) == 1 else phrases.AFTER_SOME.format(lessons=listed(needs))


def _button(answers: viser.GuiButtonGroupHandle, value: str, inner: str, look: str = "") -> str:
    return (f'<button type="button" class="ol-do" data-value="{html.escape(value, quote=True)}" '
            f'data-to="{viser_internals.node_id(answers)}"{look}>{inner}</button>')


def _tasks(far: Progress, lesson: Lesson, language: str) -> str:
    return phrases.SOLVED.format(solved=far.solved, count=len(lesson.tasks))(language) if lesson.tasks else ""


def _bar(far: Progress, lesson: Lesson) -> str:
    """How much of the lesson is done: the prediction and each task count as one."""
    whole = 1 + len(lesson.tasks)
    return f'<i class="ol-done" style="--ol-share:{(far.predicted + min(far.solved, whole - 1)) / whole:.3f}"></i>'


def _stills(lessons: Sequence[Lesson]) -> str:
    return "".join(f".ol-shot-{name}{{--ol-still:{_picture(path)}}}" for name, path in _pictures(lessons).items())


def _loops(lessons: Sequence[Lesson]) -> str:
    """What moves under the pointer, in the style sheet where motion is wanted."""
    loops = {name: path.with_name(path.name.replace("card.", "loop.").replace("opening.", "opening-loop."))
             for name, path in _pictures(lessons).items()}
    return "".join(f".ol-shot-{name}{{--ol-loop:{_picture(loop)}}}" for name, loop in loops.items() if loop.is_file())


def _pictures(lessons: Sequence[Lesson]) -> dict[str, Path]:
    """The still picture of the opening and of each lesson that has one."""
    found = {each.id: each.place.picture for each in lessons if each.place.picture is not None and each.place.picture.is_file()}
    return {OPENING: PICTURES / "opening.webp", **found}


@lru_cache(maxsize=64)
def _picture(path: Path) -> str:
    return f"url(data:image/webp;base64,{b64encode(path.read_bytes()).decode('ascii')})"
