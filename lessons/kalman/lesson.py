"""Assemble lesson 9: a Kalman filter step by step, and tests of its consistency."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, job, knobs, own, questions, seeds, study, tasks
from .deck_figures import DECK_SETTING

LESSON = Lesson.from_folder(code, derive, device, exams, figures, job, knobs, own, questions, seeds, study, tasks,
                            compute=partial(study.compute, DECK_SETTING), figures=partial(figures.figures, DECK_SETTING))
