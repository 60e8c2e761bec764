"""Assemble lesson 3: which sensors determine the state, by O, distances and data."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import code, derive, exams, figures, knobs, own, questions, study, tasks

LESSON = Lesson.from_folder(
    code, derive, exams, figures, knobs, own, questions, study, tasks, compute=partial(study.compute, study.cases_setting))
