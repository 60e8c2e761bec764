"""Assemble lesson 19: all analyses of lessons 1 to 10 on the user's own plant."""

from observer_lab.course.lesson import Lesson

from . import derive, exams, own, questions, tasks

LESSON = Lesson.from_folder(derive, exams, own, questions, tasks, **own.fields_on(own.EXAMPLE))
