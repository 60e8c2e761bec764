"""Assemble lesson 4: the loop's 2n poles are the union of controller and observer poles."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import derive, exams, figures, knobs, own, questions, study, tasks

LESSON = Lesson.from_folder(
    derive, exams, figures, knobs, own, questions, study, tasks, compute=partial(study.compute, study.DECK_SETTING),
    figures=partial(figures.figures, study.DECK_SETTING))
