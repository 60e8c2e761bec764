"""Handle the commands about the page: lesson, language, large print, theme, camera."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...course.knobs import KnobError
from ...text import languages, text
from ..state.validate import check_number, check_pixels
from . import guide, lectures
from .presenter import Presenter

SAME_WINDOW = 0.01  # share of its size by which a window may differ without being another


def open_lesson(show: Presenter, lesson: object) -> None:
    """Open a lesson by its id. Raises KnobError and what the lesson raises."""
    if not isinstance(lesson, str) or lesson not in show.lessons:
        raise KnobError(text("There is no lesson {lesson}.", lesson=str(lesson)[:40]))
    show.open_lesson(lesson)
    guide.enter(show)


def turn_page(show: Presenter, steps: int) -> None:
    """Open the lesson so many places on; before a class turn its scenes, so that no key leaves it. Raises what the lesson raises."""
    if show.state.talk is not None or (show.state.mode == "present" and show.picture.scene is not None):
        lectures.turn_scene(show, steps)
        return
    ids = list(show.lessons)
    open_lesson(show, ids[(ids.index(show.lesson.id) + steps) % len(ids)])


def see_window(show: Presenter, across: object, up: object, night: object) -> None:
    """Lay the screen out anew where the window's size, in large print, or the theme asks for it. Raises KnobError."""
    window = check_pixels(across), check_pixels(up)
    before, state = show.state, replace(show.state, window=window, night=bool(check_number(night)))
    grown = max(abs(a - b) / b for a, b in zip(window, before.window, strict=True)) > SAME_WINDOW
    if state.is_dark != before.is_dark or (state.lecture and grown):
        show.rebuild(state)
    elif grown:
        show.change(state)
    else:
        show.state = replace(state, window=before.window)


def show_lines(show: Presenter, tab: int, done: Callable[[], object], whole: bool) -> None:
    """Show the running plant as it is now, beside the present design, or only move its body and its ghost there."""
    try:
        desk = show.lesson.live
        if desk is None or show.shown is None or show.unfinished is not None:
            return
        if not whole:
            stage = desk.stage(show.picture.outcome)
            if stage is not None:
                show.view.follow(stage)
        else:
            drawn = desk.shown(tab, show.picture.outcome)
            stage = drawn[0].stage
            show.state = replace(show.state, playing=False, loop=None, t=0.0 if stage is None else float(stage.t[-1]))
            show.present(drawn)
    finally:
        done()


def set_language(show: Presenter, code: object) -> None:
    """Speak the language that was asked for, the one after the present one if the lab does not speak it."""
    known = languages()
    following = known[(known.index(show.state.language) + 1) % len(known)]
    show.rebuild(replace(show.state, language=code if isinstance(code, str) and code in known else following))


def toggle_names(show: Presenter) -> None:
    """Take the names of the plant's parts away, or put them there."""
    show.change(replace(show.state, named=not show.picture.named))


def answer(show: Presenter, question: object) -> None:
    """Say that all that was asked before a question has been done. Raises KnobError."""
    show.view.answer(check_number(question))
