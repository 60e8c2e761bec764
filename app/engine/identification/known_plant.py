"""Judge a known plant on a record: fit its noises to the first part, judge by the rest."""

from __future__ import annotations

import numpy as np

from ..systems.gates.argument_checks import BOOLEAN, count, instance, number, optional, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from .conditioning import delayed, without_outliers
from .gapped import fit_states
from .identified import RecordFit, filter_record, fit_noise
from .probe import outliers
from .records import MAX_ROWS, Record
from .regular import detrend, resample, split_record, trend_of
from .subspace import Subspace

__all__ = ["filter_plant"]


@takes(plant=PLANT, record=instance(Record), share=number(0.01, 0.99), delay=optional(count(0, MAX_ROWS)), robust=BOOLEAN)
def filter_plant(plant: Plant, record: Record, *, share: float = 0.5, delay: int | None = None, robust: bool = True) -> RecordFit:
    """The filter of a known plant on a record about its level: Q and R by likelihood from the first `share`, judged by the rest.

    The singular values are those of the record; the poles are the plant's, and known. `delay` and `robust` as in `identify`.
    Raises EngineError where plant and record do not fit.

    >>> y = np.random.default_rng(0).standard_normal(400)
    >>> filter_plant(Plant([[0.5]], [[1.0]], [[1.0]], None, 1.0), Record(np.arange(400), np.zeros(400), y)).judged.first
    200
    """
    regular, shift = delayed(resample(record), share, delay)
    first, _ = split_record(regular, share=share)
    marked = outliers(regular.u, regular.y, first.rows) if robust else np.zeros(regular.y.shape, dtype=bool)
    regular = without_outliers(regular, marked)
    trend = trend_of(split_record(regular, share=share)[0])
    flat = detrend(regular, trend)
    part = flat.part(0, first.rows)
    fitted = fit_noise(plant, part)
    model = fitted.plant
    poles = np.sort_complex(np.linalg.eigvals(model.A).astype(complex))
    n = len(poles)
    seen = fit_states(part.u, part.y, None)[0] if np.ptp(part.u, axis=0).all() else None
    values = (np.ones(n), 0.0, n, n) if seen is None else (seen.singular_values, seen.edge, seen.suggested, seen.by_information)
    found = _known(model.A, model.C, values, poles)
    return RecordFit(flat, trend, found, fitted, filter_record(fitted, flat, first.rows), shift, marked)


def _known(A: np.ndarray, C: np.ndarray, values: tuple[np.ndarray, float, int, int], poles: np.ndarray) -> Subspace:
    """The states of a known plant beside the singular values of the record."""
    n = len(poles)
    return Subspace(A, C, values[0], values[1], values[2], poles, np.zeros(n), np.zeros((n, 2, 2)), max(n, 2), values[3])
