"""Table what the filter and the smoother find along a record, with their bands."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.figure_record import Sheet
from observer_lab.course.lesson import Outcome

from .study import Study


def estimates(outcome: Outcome[Study]) -> Sheet:
    """A row a sample: t in s, inputs, each output as measured, estimated with its σ and smoothed, then the states with σ.

    The estimate of a row uses the readings up to it; the smoothed one uses all. A missing reading is NaN, and so is one
    that the gate set aside. The bias of a sensor is the last state and in no estimate of an output. Units are those of the
    record.
    """
    study = outcome.study
    record, judged, trend = study.found.record, study.judged, study.found.trend
    C, D = study.found.fitted.outputs, np.asarray(study.found.fitted.plant.D)
    after = (record.t - trend.start)[:, None]
    about = record.u @ D.T + trend.y_level + after * trend.y_slope
    track, smoothed = judged.track, judged.smoothed
    sigma = np.sqrt(np.maximum(np.einsum("pi,tij,pj->tp", C, track.covariances, C), 0.0))
    columns = [("t [s]", record.t)]
    columns += zip(record.input_names, (record.u + trend.u_level + after * trend.u_slope).T, strict=True)
    for k, name in enumerate(record.output_names):
        columns += [(name, (study.used + trend.y_level + after * trend.y_slope)[:, k]),
                    (f"estimate {name}", (track.means @ C.T + about)[:, k]), (f"sigma of estimate {name}", sigma[:, k]),
                    (f"smoothed {name}", (smoothed.means @ C.T + about)[:, k])]
    for kind, means, variances in (("", track.means, track.variances), ("smoothed ", smoothed.means, smoothed.variances)):
        for i, (mean, variance) in enumerate(zip(means.T, variances.T, strict=True), start=1):
            columns += [(f"{kind}x{i}", mean), (f"sigma of {kind}x{i}", np.sqrt(np.maximum(variance, 0.0)))]
    return [name for name, _ in columns], [tuple(map(float, row)) for row in np.column_stack([values for _, values in columns])]
