"""Assemble lesson 14: extended and unscented filters, judged by their consistency."""

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, job, knobs, questions, seeds, study, tasks

LESSON = Lesson.from_folder(code, derive, device, exams, figures, job, knobs, questions, seeds, study, tasks)
