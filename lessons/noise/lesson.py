"""Assemble lesson 8: a very fast observer amplifies noise; find the best speed."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import derive, exams, figures, job, knobs, own, questions, seeds, study, tasks
from .block import BLOCK_SETTING

LESSON = Lesson.from_folder(derive, exams, figures, job, knobs, own, questions, seeds, study, tasks,
                            compute=partial(study.compute, BLOCK_SETTING), figures=partial(figures.figures, BLOCK_SETTING))
