"""Draw the questions of lesson 21: NIS, singular values, a larger Q, a gate, a second sensor."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_bars, question_over_time
from observer_lab.engine.identification import filter_record
from observer_lab.text import same, text

from .fusion import EVERY

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
    return question_of_bar_groups(text("singular values of past and future"), "", (), tuple(same(str(k + 1)) for k in range(len(values))),
                                  (above(1), above(states), above(len(values)), above(0)), tuple(values), "estimate",
                                  (text("most of noise alone"), (edge,) * len(values)))


def surprise(asked: Asked) -> DrawnQuestion:
    """Mean NIS with a hundred times Q: far above, as before, or less as S grows with the root of Q."""
    now, gains = asked.entry.metrics["mean_nis"], asked.entry.gains
    factor = asked.after.design["factor"] / asked.entry.design["factor"]
    S, R = float(gains["S"][0, 0]), float(gains["R"][0, 0])
    return question_of_bars(text("mean NIS on the unused part"), "NIS", ((text("Q as fitted"), now),), text("a hundred times Q"),
                            (FAR_ABOVE * now, now, now * S / ((S - R) * np.sqrt(factor) + R)), asked.after.metrics["mean_nis"], "estimate")


def faulty(asked: Asked) -> DrawnQuestion:
    """The error of the filter where jumps and bias are taken from the readings, where the jumps are, and where nothing is.

    Beside the true output, or the measured one where nobody knows the true one.
    """
    study = asked.entry.study
    true = np.nan_to_num(study.measured if study.clean is None else study.clean)[:, 0]
    given, found, first = study.given, study.found, study.first
    jumps, bias = (np.zeros_like(found.record.y) if added is None else added for added in (given.jumps, given.bias))

    def error(removed: np.ndarray) -> np.ndarray:
        judged = filter_record(found.fitted, found.record.noted(y=found.record.y - removed), first)
        return (judged.track.means @ found.fitted.plant.C.T)[first:, 0] + found.trend.y_level[0] - true
    away = asked.after.study.estimate(False)[:, 0] - true
    now = Curve(text("without a gate"), study.estimate(False)[:, 0] - true, "muted")
    return question_over_time(text("estimate less true output"), study.t, (now,), (error(jumps + bias), error(jumps), error(0 * jumps)),
                              Curve(text("with the gate"), away, "estimate"), "y")


def clocks(asked: Asked) -> DrawnQuestion:
    """σ of the estimate: as with one sensor, small at each exact reading and back within some rows, or small all along."""
    study, now = asked.entry.study, asked.after.study.fusion
    kf = study.found.fitted.kalman()
    slowest = float(np.abs(np.linalg.eigvals(kf.A - kf.A @ asked.entry.gains["M"] @ kf.C)).max())
    rows = np.arange(len(now.alone))
    left = np.where(rows < EVERY, 0.0, slowest ** (2 * (rows % EVERY)))
    alone, exact = now.alone[-1], now.exact
    options = (np.full(len(rows), alone), np.sqrt(alone**2 - (alone**2 - exact**2) * left), np.where(rows < EVERY, alone, exact))
    return question_over_time(text("standard deviation of the estimated output"), study.found.record.dt * rows,
                              (Curve(text("one sensor"), now.alone, "muted"),), options,
                              Curve(text("two sensors"), now.both, "estimate"), "y", span=(0.0, 1.3 * alone))


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise, "faulty": faulty, "clocks": clocks})
