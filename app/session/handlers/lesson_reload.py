"""Take lessons whose files have changed, or that a person brings as a .zip."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace

from ...course.knobs import KnobError
from ...course.lesson import Design, Lesson
from ...engine import EngineError
from ...text import text
from ..commands.files import LessonsRead
from ..runtime.error_words import refusal_message
from ..state.own_lessons import MAX_KEPT_ZIP_BYTES, MAX_NAME_CHARACTERS, MAX_ZIP_BYTES, OwnLessons, read_zip, write_zip
from . import guide
from .downloads import TOO_MANY
from .presenter import Presenter

log = logging.getLogger(__name__)
RELOADED = text("The files of this lesson have changed; the page shows the new lesson.")
NOT_TAKEN = text("This server opens no lessons from a page; whoever runs it can start it with --allow-lessons.")
BEING_READ = text("Another .zip of lessons is being read; wait until it is open.")
TOO_LARGE = text("A .zip of lessons may have at most {most:g} MB.", most=MAX_ZIP_BYTES / 1e6)
OPENED = text("{file} is open in this tab alone; lessons: {count}.")
ONE_BROKEN = text("{id} in {file} cannot be read. {why}")
SOME_BROKEN = text("{broken} of {count} lessons in {file} cannot be read; open each to see why.")
NOT_KEPT = text("{file} is larger than {most:g} kB; after a reload open it here again.")
LOST = text("Open {file} again: your browser has not kept its lessons. Your work in them comes back then.")


def take_changed_lessons(show: Presenter, lessons: Mapping[str, Lesson]) -> None:
    """Show the open lesson anew if it has changed, with the values of its knobs that it still takes."""
    id = show.lesson.id
    before = show.lessons[id]
    for name, lesson in lessons.items():
        if show.state.own is not None and name in show.state.own.ids:  # the person's own one stays
            continue
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


# --- lessons that a person brings ----------------------------------------------------------------------------------
def upload_lessons(show: Presenter, name: object, data: object) -> None:
    """Read a .zip of lessons beside the tab's worker, which then opens the first of them. Raises KnobError."""
    if show.state.own is None:
        raise KnobError(NOT_TAKEN)
    if not isinstance(name, str) or not isinstance(data, bytes):
        raise KnobError(text("The browser did not send a file; nothing was changed."))
    if len(data) > MAX_ZIP_BYTES:
        raise KnobError(TOO_LARGE)
    file = name[:MAX_NAME_CHARACTERS]
    if show.state.own.reading:
        raise KnobError(BEING_READ)
    if not _send(show, show.state.own, file, data, lambda read: read and _open_own(show, file, data)):
        raise KnobError(TOO_MANY)


def read_kept_lessons(show: Presenter, words: str, then: Callable[[], object]) -> bool:
    """Read the .zip that the browser's tab kept through a reload, then go on; False where it cannot be read here."""
    kept, own = read_zip(words), show.state.own
    return kept is not None and own is not None and _send(show, own, *kept, lambda _: then())


def _send(show: Presenter, own: OwnLessons, file: str, data: bytes, then: Callable[[bool], object]) -> bool:
    taken, reading = tuple(id for id in show.lessons if id not in own.ids), replace(own, reading=True)
    if own.reading or not show.background.send(lambda: _read(reading, file, data, taken, then)):
        return False
    show.state = replace(show.state, own=reading)
    return True


def _read(own: OwnLessons, file: str, data: bytes, taken: tuple[str, ...], then: Callable[[bool], object]) -> LessonsRead:
    """Every lesson of the file, each judged alone."""
    try:
        return LessonsRead(own, file, data, {lesson.id: lesson for lesson in own.read(file, data, taken)}, None, then)
    except (KnobError, EngineError) as problem:
        return LessonsRead(own, file, data, None, problem, then)
    except BaseException as problem:
        log.exception("a .zip of lessons cannot be read")
        return LessonsRead(own, file, data, None, problem, then)


def take_read_lessons(show: Presenter, own: object, file: str, content: bytes, lessons: Mapping[str, Lesson] | None,
                      problem: BaseException | None, then: Callable[[bool], object]) -> None:
    """Offer the lessons of a file in place of those of the file before, or say what is wrong with it."""
    if not isinstance(own, OwnLessons) or show.state.own is not own:
        return
    show.state = replace(show.state, own=replace(own, reading=False))
    if problem is not None or lessons is None:
        show.tell(refusal_message(problem or KnobError(NOT_TAKEN), command=True), True)
        then(False)
        return
    if show.shown is not None:
        show.remember()
    show.lesson_states.judge_anew(own.ids)
    for id in own.ids:
        del show.lessons[id]
    show.lessons.update(lessons)
    show.forget_outcomes()
    show.state = replace(show.state, own=OwnLessons(own.read, file, tuple(lessons)))
    then(True)


def _open_own(show: Presenter, file: str, content: bytes) -> None:
    """Open a lesson of the file that was just read: the one that was open, or the first whole one."""
    assert show.state.own is not None
    lessons = {id: show.lessons[id] for id in show.state.own.ids}
    broken = {id: lesson.fault for id, lesson in lessons.items() if lesson.fault.id}
    first = show.lesson.id if show.lesson.id in lessons else next((id for id in lessons if id not in broken), next(iter(lessons)))
    kept = write_zip(file, content)
    show.view.keep_lessons(kept)
    if show.lesson.id in show.lessons and show.lesson.id not in lessons:
        show.open_lesson(first)
    else:  # what was open is gone, or another one now
        _open_in_place(show, first)
    if not show.picture.guided:
        show.view.look(None)
    guide.enter(show)
    show.view.say(OPENED.format(file=file, count=len(lessons)), False)
    if len(broken) == 1:
        show.view.say(ONE_BROKEN.format(id=next(iter(broken)), file=file, why=next(iter(broken.values()))), True)
    elif broken:
        show.view.say(SOME_BROKEN.format(broken=len(broken), count=len(lessons), file=file), True)
    elif not kept:
        show.view.say(NOT_KEPT.format(file=file, most=MAX_KEPT_ZIP_BYTES / 1e3), False)


def _open_in_place(show: Presenter, lesson: str) -> None:
    """Open a lesson where the one that was open is no longer there."""
    if show.job.running:
        show.cancel_job()
    show.lesson = show.lessons[lesson]
    try:
        show.open()
    except BaseException:
        show.lesson = next(iter(show.lessons.values()))
        show.open()
        raise


def note_lost_lessons(show: Presenter, file: str, ids: tuple[str, ...]) -> None:
    """Say that a .zip of lessons must be given again, where its lessons have not come back."""
    own = show.state.own
    if own is None:
        show.tell(NOT_TAKEN, False)
    elif not own.ids:
        show.state = replace(show.state, own=replace(own, file=file[:MAX_NAME_CHARACTERS], lost=ids))
        show.tell(LOST.format(file=file[:MAX_NAME_CHARACTERS]), False)


def drop_own_lessons(show: Presenter) -> None:
    """Take the person's own lessons out; where one is open, the first lesson takes its place."""
    own = show.state.own
    if own is None:
        return
    for id in own.ids:
        del show.lessons[id]
    show.state = replace(show.state, own=OwnLessons(own.read))
    if show.lesson.id not in show.lessons:
        show.lesson = next(iter(show.lessons.values()))
