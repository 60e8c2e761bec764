"""Handle the commands about a record that a person brings: look at it, name its columns, use it."""

from __future__ import annotations

import logging
from dataclasses import replace

from ...course.knobs import KnobError
from ...course.lesson import Lesson
from ...engine import EngineError
from ...engine.identification import Record
from ...text import text
from ..commands.records import FitEnded, FitGoesOn
from ..state.record_file import FitStopped, RecordFile, RecordFitting, open_record, told_again, with_role
from .downloads import TOO_MANY
from .presenter import Presenter
from .tasks import CANCELLED

log = logging.getLogger(__name__)

NO_FILE = text("Upload a record first.")


def upload_record(show: Presenter, name: object, data: object) -> None:
    """Show what a file holds; the lesson and the file before stay where it cannot be read. Raises KnobError, EngineError."""
    if show.lessons[show.lesson.id].take_record is None:
        raise KnobError(text("This lesson takes no record; open the lesson Record."))
    file = open_record(name, data)
    stop_fit(show)
    show.change(replace(show.state, record_file=file))


def set_column_role(show: Presenter, place: object, role: object) -> None:
    """Read the file with another role for one column. Raises KnobError, EngineError."""
    _read_anew(show, with_role(_present(show), place, role))


def tell_of_record(show: Presenter, name: str, value: object) -> None:
    """Read the file with what a person says about it. Raises KnobError, EngineError."""
    _read_anew(show, told_again(_present(show), {name: value}))


def use_record(show: Presenter) -> None:
    """Fit the record beside the tab's worker, which then opens the lesson on it. Raises KnobError."""
    file, origin = _present(show), show.lessons[show.lesson.id]
    record = file.preview.record
    if origin.take_record is None or record is None:
        raise KnobError(text("The record cannot be used yet; answer the question above its columns."))
    if file.fitting is not None:
        return
    fitting = RecordFitting(lambda it: show.background.tell(FitGoesOn(it)))
    if not show.background.send(lambda: _fitted(origin, record, fitting)):
        raise KnobError(TOO_MANY)
    show.change(replace(show.state, record_file=replace(file, fitting=fitting)))


def _fitted(origin: Lesson, record: Record, fitting: RecordFitting) -> FitEnded:
    """The lesson on a record, with all that its first picture needs."""
    assert origin.take_record is not None
    try:
        lesson = origin.take_record(origin, record, progress=fitting.hear)
        lesson.figures(lesson.compute(lesson.start()))
        return FitEnded(fitting, lesson, None)
    except FitStopped:
        return FitEnded(fitting, None, None)
    except (KnobError, EngineError) as problem:
        return FitEnded(fitting, None, problem)
    except BaseException as problem:
        log.exception("the fit of a record failed")
        return FitEnded(fitting, None, problem)


def stop_fit(show: Presenter) -> None:
    """End the fit at its next word; the last picture stays."""
    file = show.state.record_file
    if file is not None and file.fitting is not None:
        file.fitting.stop()


def follow_fit(show: Presenter, fitting: object) -> None:
    """Show how far a fit is that is still wanted."""
    file = show.state.record_file
    if file is not None and file.fitting is fitting:
        show.change(replace(show.state, record_file=replace(file)))


def end_fit(show: Presenter, fitting: object, lesson: Lesson | None, problem: BaseException | None) -> None:
    """Open the lesson on the record, or say why not; the last picture stays where there is none."""
    file = show.state.record_file
    if file is None or file.fitting is not fitting:
        return
    show.change(replace(show.state, record_file=replace(file, fitting=None)))
    if problem is not None:
        show.report_refusal(problem)
    elif lesson is None:
        show.view.say(CANCELLED, False)
    elif lesson.id == show.lesson.id:
        _open(show, lesson)


def _open(show: Presenter, lesson: Lesson) -> None:
    if show.job.running:
        show.cancel_job()
    show.forget_outcomes()
    show.lesson = show.lessons[lesson.id] = lesson
    show.lesson_states.lay(lesson.id, lesson.start(), show.clock())
    show.state = replace(show.state, record_file=None, playing=False, loop=None, stopped=False, t=0.0)
    show.open()


def drop_record(show: Presenter) -> None:
    """Leave the file out."""
    stop_fit(show)
    show.change(replace(show.state, record_file=None))


def _read_anew(show: Presenter, file: RecordFile) -> None:
    """Show a file that was read with other words; a fit of what was read before is ended."""
    stop_fit(show)
    show.change(replace(show.state, record_file=replace(file, fitting=None)))


def _present(show: Presenter) -> RecordFile:
    if show.state.record_file is None:
        raise KnobError(NO_FILE)
    return show.state.record_file
