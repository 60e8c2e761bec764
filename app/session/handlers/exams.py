"""Handle the commands about exams: key, variants, answers in practice and in a withheld exam.

What was answered is kept as it was typed; whether it is right follows from the key and the variant. Withheld exams have a
variant of their own, which practice never shows.
"""

from __future__ import annotations

from dataclasses import replace

from ...course.exercises.exam import Exam, ExamItem, number_of, seed_of
from ...course.exercises.typed_answers import MAX_TYPED_CHARACTERS, UnreadableInput, explain_unreadable
from ...course.handin.course_file import CourseItem, Kind
from ...course.handin.hand_in import SOLVED, written_key
from ...course.handin.served_course import WITHHELD, ServedCourse
from ...course.knobs import KnobError
from ...course.lesson import Verdict
from ...text import text
from ..commands.exams import HandInReported
from ..state.view import MOST_ANSWERS, MOST_VARIANTS, ExamAnswer, ExamState, State
from .presenter import Presenter
from .tasks import check_task

SEALED = text("This server notes answers to exams and tells nothing of them; practise on one that was started without --exam.")
PLATFORM_DECIDES = text("Your learning platform gives your key.")
COURSE_DECIDES = text("The course file says which exams are for practice.")
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


def is_withheld(state: State, lesson: str, exam: Exam) -> bool:
    """Whether nothing is told of answers to an exam: the course file decides, or the person where there is none."""
    return state.withheld if state.course is None else not state.course.practised("exam", lesson, exam.id)


def present_variant(state: State, lesson: str, exam: Exam) -> int:
    """The variant that is asked now."""
    return WITHHELD if is_withheld(state, lesson, exam) else state.exams.get(exam.id, ExamState()).variant


def present_item(state: State, lesson: str, exam: Exam) -> ExamItem:
    """The numbers that are asked now."""
    variant = present_variant(state, lesson, exam)
    if state.course is not None:
        return state.course.exam_item(state.student, lesson, exam, variant)
    return exam.item(seed_of(state.student, lesson, exam.id, variant))


def last_answer(state: State, lesson: str, exam: Exam) -> str:
    """The last answer to what is asked now, "" where there is none."""
    now = state.student, present_variant(state, lesson, exam)
    answers = state.exams.get(exam.id, ExamState()).answers
    return next((a.said for a in reversed(answers) if (a.student, a.variant) == now), "")


def present_verdict(state: State, lesson: str, exam: Exam) -> Verdict | None:
    """What is told of the last answer; None without one, and where nothing is told."""
    said = last_answer(state, lesson, exam)
    if not said or is_withheld(state, lesson, exam):
        return None
    try:
        mine = number_of(said)
    except UnreadableInput:
        return None
    answer, digits = present_item(state, lesson, exam).answer, exam.digits
    if digits.accepts(answer, mine):
        return Verdict(True, text("Right."))
    if digits.accepts(answer, -mine):
        return Verdict(False, text("The size is right, the sign is not; compare with how it goes."))
    if digits.nearly(answer, mine):
        return Verdict(False, text("{said} is near it, but not to the digits asked for; compare with how it goes.", said=said))
    return Verdict(False, text("{said} is not it; compare with how it goes.", said=said))


def find_exam(show: Presenter, exam_id: object) -> Exam:
    """The exam of that id. Raises KnobError."""
    for exam in show.lesson.exams:
        if exam.id == exam_id:
            return exam
    raise KnobError(text("There is no exam {exam_id}.", exam_id=str(exam_id)[:40]))


def _seen(show: Presenter, exam: Exam) -> ExamState:
    return show.state.exams.get(exam.id, ExamState())


def _see(show: Presenter, exam: Exam, seen: ExamState) -> None:
    show.change(replace(show.state, exams={**show.state.exams, exam.id: seen}))


def note_answer(show: Presenter, exam: Exam, said: object) -> str:
    """Note an answer as it was typed; the words that were noted. Raises KnobError where they are no number."""
    words = said.strip()[:MAX_TYPED_CHARACTERS] if isinstance(said, str) else ""
    if not words:
        raise KnobError(text("Type an answer first."))
    try:
        number_of(words)
    except UnreadableInput as problem:
        raise KnobError(explain_unreadable(words, problem)) from None
    state, seen = show.state, _seen(show, exam)
    now = ExamAnswer(state.student, present_variant(state, show.lesson.id, exam), words)
    others = tuple(a for a in seen.answers if (a.student, a.variant) != (now.student, now.variant))
    _see(show, exam, replace(seen, answers=(*others, now)[-MOST_ANSWERS:]))
    return words


def answer_exam(show: Presenter, exam: str, said: object) -> None:
    """Note an answer to an exam. Raises KnobError."""
    note_answer(show, find_exam(show, exam), said)


def set_key(show: Presenter, key: object) -> None:
    """Take the student's key. Raises KnobError where a learning platform gives it."""
    if show.state.learner is not None:
        raise KnobError(PLATFORM_DECIDES)
    show.change(replace(show.state, key=key.strip()[:MAX_TYPED_CHARACTERS] if isinstance(key, str) else ""))


def set_word(show: Presenter, word: object) -> None:
    """Take the word that belongs to the student's key."""
    show.change(replace(show.state, word=word.strip()[:MAX_TYPED_CHARACTERS] if isinstance(word, str) else ""))


def withhold_results(show: Presenter, on: object) -> None:
    """Tell nothing of answers to exams, or tell it again. Raises KnobError where the server has settled that."""
    if show.state.sealed and on is not True:
        raise KnobError(SEALED if show.state.course is None else COURSE_DECIDES)
    show.change(replace(show.state, withheld=on is True))


def turn_variant(show: Presenter, exam: str) -> None:
    """Draw other numbers for an exam that is practised. Raises KnobError."""
    found = find_exam(show, exam)
    seen = _seen(show, found)
    if not is_withheld(show.state, show.lesson.id, found):
        _see(show, found, replace(seen, variant=seen.variant % MOST_VARIANTS + 1))


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
