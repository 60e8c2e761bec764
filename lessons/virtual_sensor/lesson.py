"""Assemble lesson 1: an open-loop copy of the chip beside a Luenberger observer."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import derive, device, exams, figures, knobs, own, questions, study, tasks

LESSON = Lesson.from_folder(
    derive, device, exams, figures, knobs, own, questions, study, tasks, compute=partial(study.compute, study.chip_setting),
    figures=partial(figures.figures, figures.CHIP_LOOK))
