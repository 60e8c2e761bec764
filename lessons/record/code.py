"""Write a design of lesson 21 as code: rows, fitted model, filter, smoother and tests."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtri

from observer_lab.course.lesson import Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue

from .study import Study

NOT_IN_SCRIPT_OF_GAPS = "The fit, the smoother and the tests of a record with missing readings"
NOT_IN_SCRIPT = "The search for the most likely Q and R, and B and D by least squares"


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    study, d = outcome.study, outcome.design
    record, s, fitted = study.found.record, study.found.subspace, study.found.fitted
    kf, judged = fitted.kalman(factor=study.factor), study.judged
    y, white = record.y, judged.whiteness
    gaps = study.gated or bool(np.isnan(y).any())
    shares = np.arange(1, record.y.shape[1] + 1)
    limits = chdtri(shares, 1 - float(d["gate"])) if study.gated else np.full(len(shares), np.inf)
    return Code(
        ("record_gaps",) if gaps else ("record",),
        (
            GivenValue("u", record.u, "inputs about their level, one row for each time"),
            GivenValue("y", y, "outputs about their level"),
            GivenValue("h", record.dt, "s"),
            GivenValue("delay", study.found.delay, "rows by which an input acts later"),
            GivenValue("t_start", study.found.trend.start, "s, where the drift is zero"),
            GivenValue("u_level", study.found.trend.u_level),
            GivenValue("u_drift", study.found.trend.u_slope, "per s"),
            GivenValue("y_level", study.found.trend.y_level),
            GivenValue("y_drift", study.found.trend.y_slope, "per s"),
            GivenValue("first", study.first, "rows that the fit used; the rest judges"),
            GivenValue("rows_fitted", fitted.rows),
            GivenValue("order", len(s.A)),
            GivenValue("horizon", s.horizon, "steps of past and of future"),
            GivenValue("A", kf.A, "the fitted model: x[k+1] = A x + B u + w, y = C x + D u + v"),
            GivenValue("B", kf.B),
            GivenValue("C", kf.C),
            GivenValue("D", kf.D),
            GivenValue("Q", kf.Q, "covariance of w, most likely, times the factor of the page"),
            GivenValue("R", kf.R, "covariance of v, most likely"),
            GivenValue("P_start", judged.track.schedule.prior[0], "covariance of the state before the first row"),
            GivenValue("biases", fitted.biases, "of the last states are biases of sensors, which no output of the plant has"),
            GivenValue("limits", limits, "largest NIS of 1, 2 ... readings that a row is used with; inf without a gate"),
        ),
        (ShownValue("means", judged.track.means), ShownValue("set_aside", float(judged.set_aside.sum()), 1.0)) if gaps else (
            ShownValue("singular_values", s.singular_values, 1.0),
            ShownValue("poles", s.poles, poles=True),
            ShownValue("means", judged.track.means),
            ShownValue("innovations", judged.track.innovations),
            ShownValue("smoothed", judged.smoothed.means),
            ShownValue("mean_nis", judged.mean_nis),
            ShownValue("nis_low", judged.band[0]),
            ShownValue("nis_high", judged.band[1]),
            *(() if white is None else (ShownValue("white_p", white.p_value, 1.0),)),
        ),
        NOT_IN_SCRIPT_OF_GAPS if gaps else NOT_IN_SCRIPT,
        (),
        record.dt,
    )
