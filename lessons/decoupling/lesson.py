"""Assemble lesson 11: three channels, a mixing, three SISO loops, the published pair and ours."""

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, knobs, questions, study, tasks

LESSON = Lesson.from_folder(code, derive, device, exams, figures, knobs, questions, study, tasks, pick=figures.pick)
