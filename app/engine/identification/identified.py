"""Fit a plant and its noises to a record's first part; judge the filter by the rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field, replace

import numpy as np
from scipy.special import fdtri

from ..filters import KalmanFilter, SquaredError, Track, Whiteness, nis, whiteness
from ..systems.errors import EngineError, Phrase, phrase
from ..systems.gates.argument_checks import BOOLEAN, FUNCTION, SECONDS, choice, count, instance, number, optional, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record as a_record
from ..systems.sampling import discretise
from .conditioning import delayed, slow_outputs, without_outliers
from .evidence import Evidence, evidence_of, mean_below, partly_seen, whitened
from .gapped import fit_states, in_long_stretches, started
from .noise_fit import NoiseFit, fit_noise_to, part_of, silent
from .predictor import gapped_pieces, pieces_of
from .probe import drifts, outliers
from .records import MAX_ROWS, Record
from .regular import Trend, detrend, resample, split_record, trend_of
from .smoother import Smoothed, smooth
from .subspace import MAX_ORDER, Subspace

__all__ = ["FilteredRecord", "FittedFilter", "RecordFit", "SensorBias", "filter_record", "fit_noise", "identify"]

LEVEL = 0.99  # with which the NIS of a right filter lies in its band
MAX_LAGS = 20
STALE = 0.98  # |pole| above which the record is sampled much more finely than the plant needs


@a_record()
class FittedFilter:
    """A sampled plant with the Q (n×n) and R (p×p) that a record of `rows` rows makes most likely.

    parameters: how many were fitted. level: −2 log L for each row, less p log 2π. innovations (k, p): those of the fit. biases: how many
    of the last states are biases of sensors. tuned: whether Q was set by hand, not by likelihood.
    """

    plant: Plant
    Q: np.ndarray
    R: np.ndarray
    rows: int
    parameters: int
    level: float
    innovations: np.ndarray = field(repr=False)
    biases: int = 0
    tuned: bool = False

    @property
    def outputs(self) -> np.ndarray:
        """C (p×n) without the biases of sensors: what the plant itself gives.

        >>> FittedFilter(Plant([[0.5]], [[1.0]], [[2.0]], None, 1.0), np.eye(1), np.eye(1), 9, 1, 0.0, np.zeros((1, 1))).outputs
        array([[2.]])
        """
        own = np.arange(self.plant.n) < self.plant.n - self.biases
        return np.where(own, np.asarray(self.plant.C), 0.0)

    def kalman(self, *, factor: float = 1.0) -> KalmanFilter:
        """The Kalman filter; `factor` multiplies Q."""
        plant = self.plant
        return KalmanFilter(plant.A, plant.B, plant.C, factor * self.Q, self.R, plant.D, plant.dt)


@a_record()
class FilteredRecord:
    """A record through a filter, judged by the rows from `first` on, which were not used for the fit.

    nis: normalised innovations squared of these rows; of a row with k of its p readings times p/k. band: what its mean over p lies in
    with probability `level`: by an F distribution, as S is estimated too. whiteness: None where a measurement is missing. smoothed: by
    the whole record. fit (p,): share of each output's variation that one-step predictions give, 1 − |e|/|y − ȳ|. set_aside (n_t,):
    which rows a gate refused; they count as missing.
    """

    track: Track
    smoothed: Smoothed
    first: int
    nis: SquaredError
    mean_nis: float
    band: tuple[float, float]
    whiteness: Whiteness | None
    fit: np.ndarray
    evidence: Evidence
    set_aside: np.ndarray = field(default=None, repr=False)  # type: ignore[assignment]  # always an array after `filter_record`

    @property
    def nis_holds(self) -> bool:
        """Whether the mean NIS lies in its band."""
        return self.band[0] <= self.mean_nis <= self.band[1]

    @property
    def consistent(self) -> bool:
        """Whether every check of the unused rows passes."""
        return self.evidence.consistent


@a_record()
class SensorBias:
    """What `sensor_bias` decided: kind "none", "constant" or "drift", of which output.

    value, deviation: of the bias after the last row. gain: by how much its state lowers −2 log L of the unused rows; cost: what is needed.
    said: the decision in one sentence.
    """

    kind: str
    output: int
    value: float
    deviation: float
    gain: float
    cost: float
    said: Phrase


@a_record()
class RecordFit:
    """All that `identify` finds: the regular record, its trend, the subspace fit, the fitted filter, the judged record.

    bias: what `sensor_bias` decided, None where it was not asked.
    """

    record: Record
    trend: Trend
    subspace: Subspace
    fitted: FittedFilter
    judged: FilteredRecord
    delay: int = 0
    outliers: np.ndarray = field(default=None, repr=False)  # type: ignore[assignment]  # always an array after `identify`
    bias: SensorBias | None = None


@takes(record=instance(Record), order=optional(count(1, MAX_ORDER)), share=number(0.01, 0.99), degree=optional(choice(0, 1)),
       step=optional(SECONDS), delay=optional(count(0, MAX_ROWS)), robust=BOOLEAN, progress=optional(FUNCTION))
def identify(record: Record, *, order: int | None = None, share: float = 0.5, degree: int | None = None, step: float | None = None,
             delay: int | None = None, robust: bool = True, progress: Callable[[float], object] | None = None) -> RecordFit:
    """A filter from a record: resample, take the level out, fit A, B, C, D, Q and R to the first `share`, judge by the rest.

    order: None takes what the singular values suggest, or the next smaller one that has a filter. degree: 0 takes out a level, 1 a
    straight line, both of the first part; None takes the line where it is sure. step in s: None keeps the record's own. delay: rows by
    which the inputs act later; None estimates them. robust: outliers count as missing. Outputs that come at every r-th row alone give a
    model of that step. progress: called with the share that is done, from 0 to 1; what it raises ends the fit. Raises EngineError.

    >>> rng = np.random.default_rng(0)
    >>> u, y = rng.choice([-1.0, 1.0], 600), np.zeros(600)
    >>> for k in range(599): y[k + 1] = 0.8 * y[k] + u[k] + 0.1 * rng.standard_normal()
    >>> round(float(identify(Record(np.arange(600), u, y), order=1).subspace.poles[0].real), 2)
    0.8
    """
    tell = silent if progress is None else progress
    tell(0.0)
    regular = slow_outputs(resample(record, step=step))
    regular, shift = delayed(regular, share, delay)
    first, _ = split_record(regular, share=share)
    marked = outliers(regular.u, regular.y, first.rows) if robust else np.zeros(regular.y.shape, dtype=bool)
    regular = without_outliers(regular, marked)
    first, _ = split_record(regular, share=share)
    if degree is None:
        degree = int(drifts(first.u, first.y))
        if degree:
            regular = regular.noted(phrase("The outputs drift: a straight line of the first part was taken out."))
    trend = trend_of(first, degree=degree)
    flat = detrend(regular, trend)
    part = flat.part(0, first.rows)
    found, noises, pieces = fit_states(part.u, part.y, order, part_of(tell, 0.05, 0.85))
    n, m, p = len(found.A), part.u.shape[1], part.y.shape[1]
    if order is None and n < found.suggested:
        flat = flat.noted(phrase("No filter was found for the suggested order {suggested}; the model has order {order}.",
                                 suggested=found.suggested, order=n))
    plant = Plant(found.A, noises.B, found.C, noises.D, regular.dt, (), regular.input_names, regular.output_names,
                  tuple(pair for pair in regular.units if pair[1]), "fitted to a record")
    fitted = _fitted(plant, noises, pieces.rows, n * m + p * m + 2 * n * p)
    if np.abs(found.poles).min() > STALE:
        flat = flat.noted(phrase("Even the fastest pole moves little in one step of {step:.3g} s; a coarser step may fit better.",
                                 step=regular.dt))
    judged = filter_record(fitted, flat, first.rows)
    tell(1.0)
    return RecordFit(flat, trend, found, fitted, judged, shift, marked)


@takes(plant=PLANT, record=instance(Record))
def fit_noise(plant: Plant, record: Record) -> FittedFilter:
    """The most likely Q and R of a known plant, from a regular record about its level.

    Raises EngineError where the two do not fit.

    >>> y = np.random.default_rng(0).standard_normal(400)
    >>> fit_noise(Plant([[0.5]], [[1.0]], [[1.0]], None, 1.0), Record(np.arange(400), np.zeros(400), y)).R.round(1)
    array([[1.]])
    """
    if not record.dt:
        raise EngineError("The record has irregular steps; bring it to a regular one first.")
    if (plant.m, plant.p) != (record.u.shape[1], record.y.shape[1]):
        raise EngineError("The plant has {m} inputs and {p} outputs, the record {m2} and {p2}; choose the columns that belong to it.",
                          m=plant.m, p=plant.p, m2=record.u.shape[1], p2=record.y.shape[1])
    if plant.dt and abs(plant.dt - record.dt) > 1e-6 * plant.dt:
        raise EngineError("The plant is sampled every {dt:g} s, the record every {step:g} s; resample the record.",
                          dt=plant.dt, step=record.dt)
    sampled = plant if plant.dt else discretise(plant, record.dt)
    pieces = pieces_of(record.u, record.y, 4 * plant.n) if in_long_stretches(record.y) else gapped_pieces(record.u, record.y)
    noises = fit_noise_to(sampled.A, sampled.C, pieces, (sampled.B, sampled.D))
    return _fitted(sampled, noises, pieces.rows, plant.n * plant.p)


def _fitted(plant: Plant, noises: NoiseFit, rows: int, parameters: int) -> FittedFilter:
    """Q and R enlarged by (N + d)/(N − d), d parameters for each output: what to expect of rows that were not used.

    The fit makes its own errors smaller than those to come. Source: Akaike, Annals of the Institute of Statistical Mathematics 21
    (1969) 243–247, final prediction error.
    """
    each = min(parameters / plant.p, 0.5 * rows)
    larger = (rows + each) / (rows - each)
    return FittedFilter(plant, larger * noises.Q, larger * noises.R, rows, parameters, noises.level, noises.innovations)


@takes(fitted=instance(FittedFilter), record=instance(Record), first=count(0, MAX_ROWS), factor=number(0, 1e9),
       level=number(0.5, 0.9999), gate=optional(number(0.5, 1)))
def filter_record(fitted: FittedFilter, record: Record, first: int, *, factor: float = 1.0, level: float = LEVEL,
                  gate: float | None = None) -> FilteredRecord:
    """Filter and smooth a record about its level; the rows from `first` on judge. `factor` multiplies Q.

    gate: share of good readings that a gate lets through; a row with νᵀS⁻¹ν beyond that quantile of χ² counts as missing, and the mean
    NIS is divided by the mean of χ² below the quantile. Of a row the readings that came are used. Raises EngineError.
    """
    kf = fitted.kalman(factor=factor)
    if first > record.rows - 8:
        raise EngineError("At least 8 rows must be left to judge the filter by; {count} are.", count=max(record.rows - first, 0))
    p, aside, expected = record.y.shape[1], np.zeros(record.rows, dtype=bool), 1.0
    start, u = started(kf, record.y), record.u if record.u.shape[1] else None
    if gate is not None and gate < 1:
        track = kf.run(start, record.y, u, gate=np.full(record.rows, gate))
        aside = aside if track.rejected is None else np.array(track.rejected)
        record = record.noted(y=np.where(aside[:, None], np.nan, record.y))
        track = replace(track, innovations=np.where(aside[:, None], np.nan, track.innovations))
        expected = mean_below(np.isfinite(record.y[first:]).sum(axis=1), gate)
    else:
        track = kf.run(start, record.y, u)
    nu = track.innovations[first:]
    came = np.isfinite(nu)
    seen, readings = came.all(axis=1), int(came.sum())
    if partly_seen(came):
        each = came.sum(axis=1, keepdims=True)
        white_nu = np.where(each > 0, np.nan_to_num(whitened(nu, track.S[first:])) * np.sqrt(p / np.maximum(each, 1)), np.nan)
        size_test = nis(white_nu, np.eye(p))
        mean = float(np.nansum(size_test.values * each[:, 0]) / readings) / p / expected
    else:
        size_test = nis(nu, track.S[first:])
        mean = size_test.mean / p / expected
    tail = (1 - level) / 2
    degrees = readings, p * fitted.rows
    band = float(fdtri(*degrees, tail)), float(fdtri(*degrees, 1 - tail))
    lags = min(MAX_LAGS, len(nu) // 4)
    white = whiteness(nu, lags=lags) if seen.all() else None
    fit = np.array([_share(error[row], y[row]) for error, y, row in zip(nu.T, record.y[first:].T, came.T, strict=True)])
    evidence = evidence_of(kf, track, record, first, band[0] <= mean <= band[1], fit, fitted.tuned or factor != 1,
                           fitted.biases)
    return FilteredRecord(track, smooth(kf, track), first, size_test, mean, band, white, fit, evidence, aside)


def _share(error: np.ndarray, y: np.ndarray) -> float:
    """The share of an output's variation that leaves these errors, 1 − |e|/|y − ȳ|; without a reading 0."""
    return 1 - float(np.linalg.norm(error)) / max(float(np.linalg.norm(y - y.mean())), 1e-300) if len(y) else 0.0
