"""Assemble lesson 16: a functional observer of a bilinear plant in eight steps."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, knobs, own, questions, study, tasks

LESSON = Lesson.from_folder(
    code, derive, device, exams, figures, knobs, own, questions, study, tasks, compute=partial(study.compute, study.paper_setting),
    figures=partial(figures.figures, figures.paper_steps, figures.paper_cases, figures.paper_tabs))
