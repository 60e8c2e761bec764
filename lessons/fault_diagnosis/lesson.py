"""Assemble lesson 17: observer bank, noise-based thresholds, and a loop that reacts."""

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, job, knobs, questions, study, tasks

LESSON = Lesson.from_folder(code, derive, device, exams, figures, job, knobs, questions, study, tasks)
