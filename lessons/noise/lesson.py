"""Assemble lesson 8: a very fast observer amplifies noise; find the best speed."""

from observer_lab.course.lesson import Lesson

from . import derive, exams, figures, job, knobs, own, questions, seeds, study, tasks

LESSON = Lesson.from_folder(derive, exams, figures, job, knobs, own, questions, seeds, study, tasks)
