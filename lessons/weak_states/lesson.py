"""Assemble lesson 12: ranks depend on units, Hankel values do not; the mode that was cut."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, knobs, own, questions, study, tasks
from .platform_figures import PLATFORM_SETTING

LESSON = Lesson.from_folder(code, derive, device, exams, figures, knobs, own, questions, study, tasks,
                            compute=partial(study.compute, PLATFORM_SETTING), figures=partial(figures.figures, PLATFORM_SETTING))
