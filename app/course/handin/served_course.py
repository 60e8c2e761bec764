"""Draw a student's numbers and sign hand-ins for the course that a server offers."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from ..exercises.exam import Exam, ExamItem, canonical_key
from .course_file import Course, CourseItem, Kind, item_name
from .hand_in import HandIn, HandInError, read_hand_in, write_hand_in

WITHHELD = 0  # the variant that is handed in; practice shows those from 1 on

log = logging.getLogger(__name__)


class SignedHandIns(Protocol):
    """What all workers of a server have signed for students whom it knows."""

    failing: bool

    def choose(self, student: str, pick: Callable[[Sequence[str]], str | None]) -> str | None:
        """Keep the token that `pick` gives for those kept of a student, None for none; no other is kept meanwhile. Raises OSError."""
        ...


@dataclass(frozen=True, eq=False)
class ServedCourse:
    """A course and the clock of its server, in seconds since 1970. It stays on the server; no text shows its keys.

    With `signed`, a student whom the server knows gets no more signatures of an item than count.
    """

    course: Course
    clock: Callable[[], float] = field(repr=False)
    signed: SignedHandIns | None = field(default=None, repr=False)

    def practised(self, kind: Kind, lesson: str, id: str) -> bool:
        """Whether results and solutions are shown: only where the course file says so."""
        item = self.course.item(kind, lesson, id)
        return item is not None and item.practice

    def asked(self, kind: Kind, lesson: str, id: str) -> CourseItem | None:
        """The item that can be handed in, None where the course does not name it or gives it for practice."""
        item = self.course.item(kind, lesson, id)
        return None if item is None or item.practice else item

    def exam_item(self, student: str, lesson: str, exam: Exam, variant: int) -> ExamItem:
        """A student's numbers. They follow from the course's secret, so that nobody else can compute them."""
        return student_item(self.course, student, lesson, exam, variant)

    def proves(self, student: str, word: str) -> bool:
        """Whether a typed word shows that the key is the student's own; always so in a course without words."""
        return not self.course.words or self.course.keys.knows(canonical_key(student), word)

    def hand_in(self, item: CourseItem, student: str, answer: str, known: bool = False) -> str | None:
        """The token of an answer, signed now; None where a student whom the server knows has used all tries.

        The same answer again gives the same token. Where nothing can be kept it is signed all the same: `grade` counts the tries.
        """
        if not known or self.signed is None or self.late(item):
            return self._written(item, student, answer)
        try:
            return self.signed.choose(canonical_key(student), lambda kept: self._next(item, student, answer, kept))
        except OSError as problem:
            log.error("hand-ins are signed and cannot be kept: %s", problem)
            return self._written(item, student, answer)

    def _next(self, item: CourseItem, student: str, answer: str, kept: Sequence[str]) -> str | None:
        held = [(hand_in.answer, token) for token in kept if (hand_in := self.handed(item.name, token)) is not None]
        same = next((token for said, token in held if said == answer), None)
        if same is not None or len(held) >= item.tries:
            return same
        return self._written(item, student, answer)

    def _written(self, item: CourseItem, student: str, answer: str) -> str:
        return write_hand_in(self.course, HandIn(self.course.id, item.name, student, answer, int(self.clock())))

    def late(self, item: CourseItem) -> bool:
        """Whether a hand-in that is signed now is late."""
        return item.deadline is not None and int(self.clock()) > item.deadline.timestamp()

    def handed(self, name: str, token: str) -> HandIn | None:
        """What a token of an item holds, None where it is none of this course and item."""
        try:
            hand_in = read_hand_in(self.course, token)
        except HandInError:
            return None
        return hand_in if hand_in.item == name else None


def student_item(course: Course, student: str, lesson: str, exam: Exam, variant: int = WITHHELD) -> ExamItem:
    """The numbers and the answer of an exam for a student's key."""
    return exam.item(course.keys.seed(canonical_key(student), item_name("exam", lesson, exam.id), variant))
