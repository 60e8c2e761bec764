"""Handle the commands about a record that a person brings: look at it, name its columns, use it."""

from __future__ import annotations

from dataclasses import replace

from ...course.knobs import KnobError
from ...text import text
from ..state.record_file import RecordFile, open_record, told_again, with_role
from .presenter import Presenter

NO_FILE = text("Upload a record first.")


def upload_record(show: Presenter, name: object, data: object) -> None:
    """Show what a file holds; the lesson and the file before stay where it cannot be read. Raises KnobError, EngineError."""
    if show.lessons[show.lesson.id].take_record is None:
        raise KnobError(text("This lesson takes no record; open the lesson Record."))
    show.change(replace(show.state, record_file=open_record(name, data)))


def set_column_role(show: Presenter, place: object, role: object) -> None:
    """Read the file with another role for one column. Raises KnobError, EngineError."""
    show.change(replace(show.state, record_file=with_role(_present(show), place, role)))


def tell_of_record(show: Presenter, name: str, value: object) -> None:
    """Read the file with what a person says about it. Raises KnobError, EngineError."""
    show.change(replace(show.state, record_file=told_again(_present(show), {name: value})))


def use_record(show: Presenter) -> None:
    """Open the lesson on the record; if it cannot be computed, the last picture stays. Raises KnobError, EngineError."""
    file = _present(show)
    origin = show.lessons[show.lesson.id]
    if origin.take_record is None or file.preview.record is None:
        raise KnobError(text("The record cannot be used yet; answer the question above its columns."))
    lesson = origin.take_record(origin, file.preview.record)
    design = lesson.start()
    lesson.figures(lesson.compute(design))
    if show.job.running:
        show.cancel_job()
    show.forget_outcomes()
    show.lesson = show.lessons[lesson.id] = lesson
    show.lesson_states.lay(lesson.id, design, show.clock())
    show.state = replace(show.state, record_file=None, playing=False, loop=None, stopped=False, t=0.0)
    show.open()


def drop_record(show: Presenter) -> None:
    """Leave the file out."""
    show.change(replace(show.state, record_file=None))


def _present(show: Presenter) -> RecordFile:
    if show.state.record_file is None:
        raise KnobError(NO_FILE)
    return show.state.record_file
