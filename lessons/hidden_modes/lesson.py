"""Assemble lesson 6: no gain moves an unobservable or uncontrollable mode."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import derive, exams, figures, knobs, own, questions, study, tasks

LESSON = Lesson.from_folder(
    derive, exams, figures, knobs, own, questions, study, tasks, compute=partial(study.compute, study.CASES_SETTING),
    figures=partial(figures.figures, figures.case_lines, figures.case_clouds))
