"""Take lessons whose files have changed; a broken one leaves the tab its last good picture."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from contextlib import suppress

from ...course.knobs import KnobError
from ...course.lesson import Design, Lesson
from ...text import text
from ..runtime.error_words import refusal_message
from . import guide
from .presenter import Presenter

log = logging.getLogger(__name__)
RELOADED = text("The files of this lesson have changed; the page shows the new lesson.")


def take_changed_lessons(show: Presenter, lessons: Mapping[str, Lesson]) -> None:
    """Show the open lesson anew if it has changed, with the values of its knobs that it still takes."""
    id = show.lesson.id
    before = show.lessons[id]
    for name, lesson in lessons.items():
        if not lesson.fault.id or name not in show.lessons or show.lessons[name].fault.id:
            show.lessons[name] = lesson
    if id in lessons and lessons[id].fault.id and not before.fault.id:
        show.view.say(lessons[id].fault, True)
    elif show.lessons[id] is not before and show.shown is not None:
        _reopen(show, before)


def _reopen(show: Presenter, before: Lesson) -> None:
    """Open the changed lesson; if its present design cannot be computed, say why and keep the one before."""
    lesson = show.lessons[before.id]
    design = with_kept_values(lesson, show.design)
    try:
        lesson.figures(lesson.compute(design))
    except BaseException as problem:  # code of a lesson may raise anything
        log.warning("the changed lesson %s cannot be computed: %s", lesson.id, problem)
        show.lessons[before.id] = before
        show.view.say(refusal_message(problem, command=False), True)
        return
    if show.job.running:
        show.cancel_job()
    show.forget_outcomes()
    show.lesson = lesson
    show.lesson_states.reset_lesson(lesson.id, design)
    show.open()
    guide.enter(show)
    show.view.say(RELOADED, False)


def with_kept_values(lesson: Lesson, design: Design) -> Design:
    """The lesson's start with each value of the design that a knob of the same name accepts."""
    kept = lesson.start()
    for name, value in design.values:
        with suppress(KnobError):
            kept = lesson.apply(kept, {name: value})
    return kept
