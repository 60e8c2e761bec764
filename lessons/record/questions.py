"""Draw the questions of lesson 21: tuned NIS, singular values, a hundred times Q."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_bars
from observer_lab.text import same, text

SHOWN_VALUES = 5  # singular values that are asked about
SIGNAL, BELOW = 0.9, 0.7  # a singular value of a state; of the noise edge, one of noise alone
FAR_ABOVE = 3.0  # times the mean NIS now


def recall(asked: Asked) -> DrawnQuestion:
    """Mean NIS of a tuned filter with one sensor: one, or zero."""
    return question_of_bars(text("mean NIS of the fitted filter"), "NIS", (), text("unused part"), (1.0, 0.0),
                            asked.after.metrics["mean_nis"], "estimate")


def predict(asked: Asked) -> DrawnQuestion:
    """Singular values above what noise gives: one, one for each state, all, or none."""
    found, edge = asked.after.study.found.subspace, asked.after.metrics["edge"]
    values = np.asarray(found.singular_values[:SHOWN_VALUES])
    states = 2 if asked.after.study.true_poles is None else len(asked.after.study.true_poles)

    def above(count: int) -> tuple[float, ...]:
        return tuple(SIGNAL if k < count else BELOW * edge for k in range(len(values)))
    return question_of_bar_groups(text("singular values of past and future"), "", ((text("most of noise alone"), edge),),
                                  tuple(same(str(k + 1)) for k in range(len(values))),
                                  (above(1), above(states), above(len(values)), above(0)), tuple(values), "estimate")


def surprise(asked: Asked) -> DrawnQuestion:
    """Mean NIS with a hundred times Q: far above, as before, or less as S grows with the root of Q."""
    now, gains = asked.entry.metrics["mean_nis"], asked.entry.gains
    factor = asked.after.design["factor"] / asked.entry.design["factor"]
    S, R = float(gains["S"][0, 0]), float(gains["R"][0, 0])
    return question_of_bars(text("mean NIS on the unused part"), "NIS", ((text("Q as fitted"), now),), text("a hundred times Q"),
                            (FAR_ABOVE * now, now, now * S / ((S - R) * np.sqrt(factor) + R)), asked.after.metrics["mean_nis"], "estimate")


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise})
