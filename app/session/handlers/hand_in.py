"""Handle the commands that sign a hand-in for a course and give it as a file."""

from __future__ import annotations

from dataclasses import replace

from ...course.handin.course_file import CourseItem, Kind
from ...course.handin.hand_in import SOLVED, written_key
from ...course.handin.served_course import ServedCourse
from ...course.knobs import KnobError
from ...text import text
from ..commands.exams import HandInReported
from .exams import find_exam, note_answer
from .presenter import Presenter
from .tasks import check_task

NOT_IN_COURSE = text("This server collects no hand-in of this; a course file names what it collects.")
NEEDS_KEY = text("Type your key first: letters, digits, dots and dashes, as your lecturer lists you.")
NEEDS_WORD = text("This word does not belong to your key. Type both as your lecturer gave them to you.")
OWN_PLANT = text("Hand in with the lesson's own plant; choose it above.")
NOT_SOLVED = text("Solve the task first; then hand it in.")
NOTHING_SIGNED = text("There is no hand-in of this yet.")
SENDING = text("Signed. Your points are on their way to the learning platform.")
TOO_MANY_WAIT = text("Signed, but the learning platform is slow. Hand in again in a minute.")
SIGNED = text("Signed. Copy or save the hand-in, and give it to your lecturer.")
TRIES_USED = text("You have handed in as often as counts. The last hand-in stands.")
SIGNED_LATE = text("Signed after the deadline. Your lecturer sees that this hand-in is late.")


def save_hand_in(show: Presenter, item: str) -> None:
    """Give the last hand-in of an item as a file. Raises KnobError."""
    token = show.state.hand_ins.get(item)
    if token is None:
        raise KnobError(NOTHING_SIGNED)
    show.view.download(f"{item.replace(' ', '-')}.hand-in.txt", f"{token}\n".encode())


def hand_in(show: Presenter, kind: Kind, item: str, said: object) -> None:
    """Sign an answer to an exam, or a solved task. Raises KnobError and what a lesson raises."""
    course, asked = _asked(show, kind, item)
    student = written_key(show.state.key)
    if not student:
        raise KnobError(NEEDS_KEY)
    known = show.state.learner is not None
    if not known and not course.proves(student, show.state.word):
        raise KnobError(NEEDS_WORD)
    answer = note_answer(show, find_exam(show, item), said) if kind == "exam" else _solved(show, item, said)
    token = course.hand_in(asked, student, answer, known or course.course.words)
    if token is None:
        raise KnobError(TRIES_USED)
    show.change(replace(show.state, hand_ins={**show.state.hand_ins, asked.name: token}))
    if show.state.learner is not None and (report := show.state.learner.report) is not None:
        sent = show.background.send(lambda: HandInReported(report(token)))
        show.view.say(SENDING if sent else TOO_MANY_WAIT, not sent)
        return
    late = course.late(asked)
    show.view.say(SIGNED_LATE if late else SIGNED, late)


def _asked(show: Presenter, kind: Kind, id: str) -> tuple[ServedCourse, CourseItem]:
    course = show.state.course
    item = None if course is None else course.asked(kind, show.lesson.id, id)
    if course is None or item is None:
        raise KnobError(NOT_IN_COURSE)
    return course, item


def _solved(show: Presenter, task: str, said: object) -> str:
    """The answer of a task that the present design solves, on the lesson's own plant: on another it may be trivial."""
    if show.design.plant:
        raise KnobError(OWN_PLANT)
    show.complete()
    if not check_task(show, task, said).solved:
        raise KnobError(NOT_SOLVED)
    return SOLVED
