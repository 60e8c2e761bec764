"""Assemble lesson 10: LQG is optimal on average, yet has no guaranteed margins."""

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, job, own, questions, tasks

LESSON = Lesson.from_folder(code, derive, device, exams, figures, job, own, questions, tasks, **own.fields_on(own.CASES))
