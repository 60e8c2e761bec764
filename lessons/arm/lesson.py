"""Assemble lesson 20: an observer that estimates the load torque of an arm from its angle."""

from observer_lab.course.lesson import Lesson

from . import code, derive, exams, figures, job, knobs, questions, study, tasks

LESSON = Lesson.from_folder(code, derive, exams, figures, job, knobs, questions, study, tasks)
