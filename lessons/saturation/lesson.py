"""Assemble lesson 7: commanded or applied input for the observer, and the recovery map."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import derive, exams, figures, job, knobs, own, questions, study, tasks

LESSON = Lesson.from_folder(
    derive, exams, figures, job, knobs, own, questions, study, tasks, compute=partial(study.compute, study.CART),
    figures=partial(figures.figures, figures.CART_LOOK), pick=partial(job.pick, study.CART))
