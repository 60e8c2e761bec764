"""Draw the questions of lesson 17: innovations, which sensor is named, how soon."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_bars, question_over_time
from observer_lab.text import text

from .observer_bank import DT, HORIZON, SAMPLE_COUNT

AVERAGED = 50  # samples over which the size of an innovation is averaged
FIRST_TIMES, FADES_S = 3.0, 1.0  # of its usual size at the start, and how soon it would fade, in the option that says so


def recall(asked: Asked) -> DrawnQuestion:
    """The size of an innovation over time: it fades, or it stays as large as S says."""
    t, whitened = DT * np.arange(SAMPLE_COUNT), asked.entry.study.record.residuals[:, -1]
    square = np.convolve(np.mean(whitened**2, axis=1), np.ones(AVERAGED), "full")[:SAMPLE_COUNT]
    size = np.sqrt(square / np.minimum(np.arange(SAMPLE_COUNT) + 1, AVERAGED))
    return question_over_time(text("size of an innovation, averaged over 1 s"), t, (),
                              (FIRST_TIMES * np.exp(-t / FADES_S), np.ones(SAMPLE_COUNT)),
                              Curve(text("the innovation"), size, "error"), "ν / √S")


def predict(asked: Asked) -> DrawnQuestion:
    """How long each is called faulty: HL alone, both by guessing, neither, or whichever reads more."""
    study = asked.after.study
    begin, decided = study.case.start, study.verdict.decided
    readings = np.abs(study.record.y[begin:, 2:4])
    more = float(np.mean(readings[:, 0] > readings[:, 1]))
    named = 0.0 if decided is None or study.verdict.who != "HL" else (SAMPLE_COUNT - decided) / (SAMPLE_COUNT - begin)
    wrong = 0.0 if decided is None or study.verdict.who != "HR" else (SAMPLE_COUNT - decided) / (SAMPLE_COUNT - begin)
    return question_of_bar_groups(text("share of the time after the fault in which a part is reported"), "", (),
                                  (text("HL"), text("HR"), text("no part")),
                                  ((1.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.0, 0.0, 1.0), (more, 1 - more, 0.0)),
                                  (named, wrong, 1 - named - wrong), "estimate", (text("from HL + HR alone"), (0.5, 0.5, 0.0)))


def surprise(asked: Asked) -> DrawnQuestion:
    """When HL is identified with the longer window: sooner, as the noise adds up more slowly; later, as it fills; or as before."""
    before, after = asked.entry, asked.after
    windows = [int(each.design["window"]) for each in (before, after)]
    delay, later = before.metrics["delay"], after.metrics["delay"]
    sooner, filled = delay * np.sqrt(windows[0] / windows[1]), delay + DT * (windows[1] - windows[0])
    longest = HORIZON - before.design["at"]  # of the run: a fault that is not identified is drawn there
    return question_of_bars(text("time from the fault to its identification"), "s",
                            ((text("{count} samples", count=windows[0]), min(delay, longest)),), text("{count} samples", count=windows[1]),
                            (min(sooner, longest), min(filled, longest), min(delay, longest)), min(later, longest), "estimate")


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise})
