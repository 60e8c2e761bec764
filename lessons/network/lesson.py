"""Assemble lesson 18: how much packet loss and delay a loop tolerates."""

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, job, knobs, questions, study, tasks

LESSON = Lesson.from_folder(code, derive, device, exams, figures, job, knobs, questions, study, tasks)
