"""Assemble lesson 12: ranks depend on units, Hankel values do not; the mode that was cut."""

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, knobs, own, questions, study, tasks

LESSON = Lesson.from_folder(code, derive, device, exams, figures, knobs, own, questions, study, tasks)
