"""Handle the commands about the page: lesson, language, large print, theme, camera."""

from __future__ import annotations

from dataclasses import replace
from typing import assert_never

from ...course.knobs import KnobError
from ...text import languages, text
from ..commands.commands import (
    Answer,
    LookFrom,
    MemoryRecalled,
    OpenLesson,
    Paging,
    RunOnTabThread,
    SetLanguage,
    ToggleCourse,
    ToggleHelp,
    ToggleLandscape,
    ToggleLecture,
    ToggleTheme,
    TurnPage,
    WindowChanged,
)
from ..commands.files import LessonsChanged
from ..commands.guide import ToggleGlossary
from ..state.validate import check_number, check_pixels
from . import guide
from .lesson_reload import take_changed_lessons
from .presenter import Presenter
from .reload import restore_memory

SAME_WINDOW = 0.01  # share of its size by which a window may differ without being another


def obey(show: Presenter, command: Paging) -> None:
    """Do what a command about the page asks. Raises KnobError and what a lesson raises."""
    match command:
        case OpenLesson(lesson):
            if not isinstance(lesson, str) or lesson not in show.lessons:
                raise KnobError(text("There is no lesson {lesson}.", lesson=str(lesson)[:40]))
            show.open_lesson(lesson)
            guide.enter(show)
        case TurnPage(steps):
            ids = list(show.lessons)
            show.open_lesson(ids[(ids.index(show.lesson.id) + steps) % len(ids)])
            guide.enter(show)
        case LessonsChanged(lessons):
            take_changed_lessons(show, lessons)
        case SetLanguage(code):
            show.rebuild(replace(show.state, language=_language(code, show.state.language)))
        case ToggleLecture():
            show.rebuild(replace(show.state, lecture=not show.state.lecture))
        case ToggleTheme():
            show.rebuild(replace(show.state, dark=not show.state.is_dark))
        case WindowChanged(across, up, night):
            _see(show, (check_pixels(across), check_pixels(up)), bool(check_number(night)))
        case ToggleLandscape():
            show.change(replace(show.state, landscape=not show.state.landscape))
        case LookFrom(place):
            show.view.camera(place)
        case ToggleHelp():
            show.view.open_help()
        case ToggleGlossary():
            show.view.open_glossary()
        case ToggleCourse():
            show.view.open_course(show.desks.progress(show.lesson.id, show.state))
        case Answer(question):
            show.view.answer(check_number(question))
        case RunOnTabThread(do):
            do()
        case MemoryRecalled():
            restore_memory(show, command)
        case _:
            assert_never(command)


def _see(show: Presenter, window: tuple[float, float], night: bool) -> None:
    """Lay the screen out anew where the window's size, in large print, or the theme asks for it."""
    before, state = show.state, replace(show.state, window=window, night=night)
    grown = max(abs(a - b) / b for a, b in zip(window, before.window, strict=True)) > SAME_WINDOW
    if state.is_dark != before.is_dark or (state.lecture and grown):
        show.rebuild(state)
    elif grown:
        show.change(state)
    else:
        show.state = replace(state, window=before.window)


def _language(asked: object, present: str) -> str:
    """The language that was asked for, the one after the present one if the lab does not speak it."""
    if isinstance(asked, str) and asked in languages():
        return asked
    return languages()[(languages().index(present) + 1) % len(languages())]
