"""Assemble lesson 5: the observer of (A, C) is the controller of (Aᵀ, Cᵀ), transposed."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import derive, exams, figures, knobs, own, questions, study, tasks

LESSON = Lesson.from_folder(
    derive, exams, figures, knobs, own, questions, study, tasks, compute=partial(study.compute, study.BLOCK_SETTING),
    figures=partial(figures.figures, study.BLOCK_SETTING), derived=partial(derive.derived, study.BLOCK_SETTING))
