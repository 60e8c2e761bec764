"""Record: from a recording to an observer, and the part of the recording that judges it."""

from functools import partial

from observer_lab.course.lesson import Lesson

from . import code, derive, device, estimates, exams, figures, knobs, own, questions, study, tasks

LESSON = Lesson.from_folder(code, derive, device, estimates, exams, figures, knobs, own, questions, study, tasks,
                            compute=partial(study.compute, study.from_knobs))
