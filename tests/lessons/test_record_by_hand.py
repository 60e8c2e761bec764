"""Q set by hand beside a sensor's bias: the innovations are judged without the errors of a fit."""

from __future__ import annotations

import numpy as np
from scipy import stats

from observer_lab.engine.identification.evidence import WHITE
from observer_lab.lessons import LESSONS

LAGS = 10


def test_innovations_that_are_not_white_are_called_so_beside_a_bias() -> None:
    lesson = LESSONS["record"]
    design = lesson.apply(lesson.start(), {"data": "tanks", "share": 35.77, "delay": 19, "factor": 0.0247, "gate": "0.999",
                                           "bias": "drift", "seed": 1232})
    study = lesson.compute(design).study
    nu = study.judged.track.innovations[study.first:, 0]
    e = nu[np.isfinite(nu)] - nu[np.isfinite(nu)].mean()
    r = np.array([e[lag:] @ e[:-lag] for lag in range(1, LAGS + 1)]) / (e @ e)
    assert stats.chi2(LAGS).sf(len(e) * np.sum(r**2)) < 1e-3  # Box and Pierce, rows that were set aside left out
    assert study.judged.evidence.white < WHITE and study.found.fitted.tuned
    usual = lesson.compute(lesson.apply(design, {"factor": 1.0})).study
    assert not usual.found.fitted.tuned
