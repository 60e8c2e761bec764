"""Draw the questions of lesson 14: P, errors, NEES and NIS."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_over_time
from observer_lab.text import same, text

from ..toolkit.questions import question_of_decades
from .cases import EKF, KF, judged

SAMPLES, SEED = 40, 14
DRIFT, NOISE = 0.1, 1.0  # variances of the walk and of a reading in the recall
JUDGED_AT_S = 20.0
STATED, TWICE, DIVERGED, MEASURED = 15.0, 30.0, 1e4, 160.0  # 10⁻³ per km: the errors that the options name
TENFOLD = 10.0


def recall(asked: Asked) -> DrawnQuestion:
    """P of a random walk read with noise: larger after unexpected readings, a smooth curve, or the squared error."""
    rng = np.random.default_rng(SEED)
    x, estimate, P = 0.0, 0.0, 2.0
    rows = []
    for _ in range(SAMPLES):
        x, prior = x + np.sqrt(DRIFT) * rng.standard_normal(), P + DRIFT
        innovation = x + np.sqrt(NOISE) * rng.standard_normal() - estimate
        gain = prior / (prior + NOISE)
        estimate, P = estimate + gain * innovation, (1 - gain) * prior
        rows.append((P, P * innovation**2 / (prior + NOISE), (x - estimate) ** 2))
    stated, surprised, squared = np.array(rows).T
    return question_over_time(text("covariance P of one run"), np.arange(1.0, SAMPLES + 1),
                              (Curve(text("squared error of this run"), squared, "muted"),), (surprised, stated, squared),
                              Curve(text("stated by the filter"), stated, "estimate"), "P", text("sample"))


def predict(asked: Asked) -> DrawnQuestion:
    """The error of the drag coefficient after 20 s beside what the EKF states: the same, twice, without bound, or ten times."""
    study = asked.after.study
    at = int(np.argmin(np.abs(study.t - JUDGED_AT_S)))
    error = 1e6 * float(study.rms[EKF][at, judged(study.case)])
    return question_of_decades(text("drag coefficient after 20 s"), text("10⁻³ per km"), ((text("σ that the EKF states"), STATED),),
                               (text("RMS error"),), ((STATED,), (TWICE,), (DIVERGED,), (MEASURED,)), (error,), "error")


def surprise(asked: Asked) -> DrawnQuestion:
    """NEES of the linear filter with a radar of a tenth of the noise: lower, the same, or higher."""
    before, after = (outcome.metrics[f"nees_{KF}"] for outcome in (asked.entry, asked.after))
    return question_of_decades(text("NEES per state of the KF"), "NEES", ((text("radar now"), before),), (text("better radar"),),
                               ((before / TENFOLD**2,), (before,), (before * 2 * TENFOLD,)), (after,), "error")


def readings(asked: Asked) -> DrawnQuestion:
    """NIS of the EKF where NEES is in the thousands: as large, about two, or below a half."""
    nees, nis = (asked.entry.metrics[f"{name}_{EKF}"] for name in ("nees", "nis"))
    return question_of_decades(text("two tests of the EKF, 1 is right"), text("per state or reading"), ((same("NEES"), nees),),
                               (same("NIS"),), ((nees,), (2.0,), (0.4,)), (nis,), "error")


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise, "readings": readings})
