"""A course about the toy lessons, its hand-ins, and a clock that stands."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

from fakes import toy

from observer_lab.course.exercises.exam import Exam, canonical_key
from observer_lab.course.handin.course_file import Course, read_course
from observer_lab.course.handin.hand_in import HandIn, write_hand_in
from observer_lab.course.handin.served_course import ServedCourse, student_item
from observer_lab.course.lesson import Lesson

SECRET = "a secret of a course, for tests alone"
DEADLINE = 1_790_000_000  # 2026-09-21 14:13:20 UTC
COURSE = """
course = "toys-2026"
title = "Toys"
secret = "a secret of a course, for tests alone"
deadline = 2026-09-21T16:13:20+02:00
tries = 2

[[lessons]]
lesson = "toy"
exams = ["twice"]
tasks = ["high"]
points = 5

[[lessons]]
lesson = "drill"
exams = "all"
tasks = ["high"]
mode = "practice"
"""
EXAM, TASK = "toy exam twice", "toy task high"


@lru_cache(maxsize=1)
def toys() -> Mapping[str, Lesson]:
    """A lesson that is handed in, one for practice, and one that the course does not name."""
    return MappingProxyType({name: toy(name) for name in ("toy", "drill", "other")})


def course_of(words: str = COURSE) -> Course:
    """The course of these words about the toy lessons."""
    return read_course(words, toys(), lambda name: "")


def served(now: float = DEADLINE - 3600, words: str = COURSE) -> ServedCourse:
    """That course on a server whose clock stands."""
    return ServedCourse(course_of(words), lambda: now)


def token(course: Course, student: str = "s1", answer: str = "1", item: str = EXAM, issued: int = DEADLINE - 60) -> str:
    """A hand-in that the course has signed."""
    return write_hand_in(course, HandIn(course.id, item, student, answer, issued))


def word(course: Course, student: str) -> str:
    """The word that belongs to a student's key."""
    return course.keys.word(canonical_key(student))


def right_answer(course: Course, student: str) -> str:
    """The answer to the exam that is handed in."""
    exam: Exam = toys()["toy"].exams[0]
    return exam.digits.written(student_item(course, student, "toy", exam).answer)
