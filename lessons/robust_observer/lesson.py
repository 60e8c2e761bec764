"""Assemble lesson 15: estimate K x with one or two states, tolerant of model errors."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, job, knobs, loop, own, questions, study, tasks

LESSON = Lesson.from_folder(code, derive, device, exams, figures, job, knobs, own, questions, study, tasks,
                            compute=partial(loop.compute, study.PAPER))
