"""Assemble lesson 13: which controller isolates best, by which measure, on real hardware."""

from observer_lab.course.lesson import Lesson

from . import code, derive, device, exams, figures, job, knobs, questions, seeds, study, tasks

LESSON = Lesson.from_folder(code, derive, device, exams, figures, job, knobs, questions, seeds, study, tasks)
