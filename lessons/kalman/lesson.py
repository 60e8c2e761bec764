"""Assemble lesson 9: a Kalman filter step by step, and tests of its consistency."""

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, job, knobs, own, questions, seeds, study, tasks

LESSON = Lesson.from_folder(code, derive, device, exams, figures, job, knobs, own, questions, seeds, study, tasks)
