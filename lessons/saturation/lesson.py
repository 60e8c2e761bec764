"""Assemble lesson 7: commanded or applied input for the observer, and the recovery map."""

from observer_lab.course.lesson import Lesson

from . import derive, exams, figures, job, knobs, own, questions, study, tasks

LESSON = Lesson.from_folder(derive, exams, figures, job, knobs, own, questions, study, tasks)
