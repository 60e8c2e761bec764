"""Fit a model to a record's first part and judge its filter by the rest."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from observer_lab.course.figures.latex import matrix
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Check, Design, Formula, Outcome, Stage
from observer_lab.engine.identification import FilteredRecord, RecordFit, filter_plant, filter_record, identify, sensor_bias
from observer_lab.engine.identification.evidence import INPUT, LEAST_FIT, MOST_FREE, WHITE
from observer_lab.plants.bodies.own_body import tubes_body
from observer_lab.text import NO_WORDS, Text, error_words, joined, text

from .below import shown_below
from .data import Given, record_of
from .fusion import EVERY, Fusion, fused
from .knobs import MAX_ORDER, NO_BIAS, NO_GATE, ONE_SENSOR, OPENING_SHARE
from .trace import Trace, body_with_trace, panel, panel_foot

DEVIATIONS = 3.0  # of a pole: within them the true one is expected


@dataclass(frozen=True, eq=False)
class Study:
    """The record, what was fitted, and the filter with the Q of the design, judged by the rows from `first` on.

    true_poles: of the plant behind a simulated record, each beside the nearest fitted one in `away` (in standard deviations).
    """

    given: Given
    found: RecordFit
    judged: FilteredRecord
    true_poles: np.ndarray | None
    away: float
    gated: bool = False
    second: str = ONE_SENSOR
    factor: float = 1.0

    @cached_property
    def fusion(self) -> Fusion:
        """What a second sensor gains, from the first row that judges on."""
        return fused(self.found.fitted.kalman(factor=self.factor), self.judged.track.schedule.prior[-1], self.second)

    @property
    def deviation(self) -> tuple[np.ndarray, float]:
        """σ of the estimated output along the rows that are shown, with the sensors of the design; the largest with one sensor."""
        return self.fusion.alone if self.second == ONE_SENSOR else self.fusion.both, float(self.fusion.alone.max())

    @property
    def first(self) -> int:
        """The first row that judges."""
        return self.judged.first

    @property
    def clean(self) -> np.ndarray | None:
        """The true output of the rows that judge, None where nobody knows it."""
        return None if self.given.clean is None else self.given.clean[self.found.delay + self.first:]

    @property
    def t(self) -> np.ndarray:
        """Times of the rows that judge, in s."""
        return self.found.record.t[self.first:]

    def level(self, rows: np.ndarray) -> np.ndarray:
        """Outputs of the rows that judge, about their level, as they were measured."""
        return rows + self.found.trend.y_level

    def estimate(self, smoothed: bool, fitted_q: bool = False) -> np.ndarray:
        """The estimated output of the rows that judge, without a sensor's bias: by what came before and now, or by the whole record.

        fitted_q: with the Q of the fit and no gate.
        """
        fitted, judged = self.found.fitted, self.found.judged if fitted_q else self.judged
        means = judged.smoothed.means if smoothed else judged.track.means
        return self.level((means @ fitted.outputs.T + self.found.record.u @ fitted.plant.D.T)[self.first:])

    @property
    def predicted(self) -> np.ndarray:
        """The one-step prediction of each output in the rows that judge, also where nothing was measured."""
        plant, record = self.found.fitted.plant, self.found.record
        return self.level((self.judged.track.predicted @ plant.C.T + record.u @ plant.D.T)[self.first:])

    @property
    def used(self) -> np.ndarray:
        """The outputs of all rows about their level, NaN where the gate set a row aside."""
        return np.where(self.judged.set_aside[:, None], np.nan, self.found.record.y)

    @property
    def measured(self) -> np.ndarray:
        """The outputs of the rows that judge."""
        return self.level(self.found.record.y[self.first:])


Source = Callable[[Design], Given]


def from_knobs(design: Design) -> Given:
    """The record that the knobs name."""
    return record_of(design["data"], int(design["seed"]))


@lru_cache(maxsize=32)
def _fitted(given: Given, order: int, share: float, delay: int) -> RecordFit:
    own = given.own
    if given.plant is not None:
        return filter_plant(given.plant, given.record, share=share, delay=delay)
    opening = given.opening
    if opening is not None and (order, share, delay) == (len(opening.subspace.A), OPENING_SHARE, opening.delay):
        return opening
    return identify(given.record, order=order, share=share, delay=delay, degree=None if own else 0, robust=own)


@lru_cache(maxsize=32)
def _biased(found: RecordFit, kind: str, factor: float, gate: float | None) -> RecordFit:
    return sensor_bias(found, kind=kind, factor=factor, gate=gate)


def compute(source: Source, design: Design) -> Outcome[Study]:
    """Fit the model and its noises to the first share of the record, filter the whole, judge by the rest."""
    given = source(design)
    found = _fitted(given, int(design["order"]), design["share"] / 100, int(design["delay"]))
    gate = None if design["gate"] == NO_GATE else float(design["gate"])
    factor = float(design["factor"])
    if design["bias"] != NO_BIAS:
        found = _biased(found, design["bias"], factor, gate)
    if found.fitted.biases:
        judged, factor = found.judged, 1.0  # its Q holds the factor
    elif factor == 1 and gate is None:
        judged = found.judged
    else:
        judged = filter_record(found.fitted, found.record, found.judged.first, factor=factor, gate=gate)
    study = Study(given, found, judged, *_beside(given, found), gate is not None, design["second"], factor)
    plant = found.fitted.plant
    metrics = LazyMap(lambda: _metrics(study, gains["M"]))
    came = np.isfinite(judged.track.innovations).sum(axis=1)
    last = len(came) - 1 - int(came[::-1].argmax())  # the last row with all readings; those that are missing have the gain 0
    gains = {"M": judged.track.gains[last], "R": found.fitted.R, "Q": factor * found.fitted.Q, "S": judged.track.S[last]}
    return Outcome(
        design, gains, {"model": np.log(found.subspace.poles.astype(complex) + 1e-300) / plant.dt}, metrics,
        LazySequence(lambda: _checks(study)), None, (), _stage(study, bool(design["smoother"]), design["below"]),
        LazySequence(lambda: _formulas(study, gains)), LazyValue(lambda: _live(study)), study)


def _beside(given: Given, found: RecordFit) -> tuple[np.ndarray | None, float]:
    """The true poles, and how far the farthest true one is from its nearest fitted one in standard deviations; 0 where unknown."""
    if given.truth is None:
        return None, 0.0
    true = np.sort_complex(given.truth.plant.poles)
    gap = np.abs(true[:, None] - found.subspace.poles)
    near = gap.argmin(axis=1)
    return true, float((gap.min(axis=1) / np.maximum(found.subspace.deviations[near], 1e-12)).max())


def _metrics(study: Study, M: np.ndarray) -> dict[str, float]:
    s, judged, fitted = study.found.subspace, study.judged, study.found.fitted
    known = {
        "mean_nis": judged.mean_nis, "nis_low": judged.band[0], "nis_high": judged.band[1], "fit": 100 * float(judged.fit[0]),
        "white_p": judged.evidence.white, "suggested": float(min(s.suggested, MAX_ORDER)), "information": float(s.by_information),
        "input_p": judged.evidence.input, "feedback_p": judged.evidence.feedback, "same_row_p": judged.evidence.same_row,
        "outliers": float(study.found.outliers.sum()), "delay": float(study.found.delay),
        "edge": s.edge, "last_value": float(s.singular_values[len(s.A) - 1]), "deviation": float(s.deviations.max()),
        "away": study.away, "sensor": float(np.sqrt(fitted.R[0, 0])), "horizon": float(s.horizon),
        "slowest": float(np.abs(s.poles).max()), "gain": float(np.linalg.norm(fitted.plant.C @ M)),
        "set_aside": float(judged.set_aside.sum()), "bias": 0.0 if study.found.bias is None else study.found.bias.value,
        "sigma": float(study.fusion.alone[-1]),
        "sigma_least": float(study.fusion.period.min()), "sigma_most": float(study.fusion.period.max())}
    clean = study.clean
    if clean is not None:
        for name, smoothed in (("filter_error", False), ("smoother_error", True)):
            known[name] = float(np.sqrt(np.mean((study.estimate(smoothed) - clean) ** 2)))
    return known


def _checks(study: Study) -> tuple[Check, ...]:
    judged, evidence = study.judged, study.judged.evidence
    checks = [Check("nis", text("the mean NIS of the unused rows is in its band"), judged.nis_holds, judged.mean_nis),
              Check("white", text("the innovations of the unused rows are white"), evidence.white >= WHITE, evidence.white),
              Check("stable", text("the fitted model is stable"), evidence.stable, evidence.radius),
              Check("fit", text("the predictions explain a part of the output"), evidence.fit >= LEAST_FIT, evidence.fit)]
    if study.found.record.u.shape[1]:
        checks += [Check("input", text("the innovations do not depend on earlier inputs"), evidence.input >= INPUT, evidence.input),
                   Check("open", text("the inputs do not depend on the outputs (open loop)"), evidence.open_loop, evidence.feedback),
                   Check("free", text("without measurements the model errs about as much as it expects"),
                         evidence.free_size <= MOST_FREE, evidence.free_size)]
    if study.true_poles is not None:
        checks.append(Check("poles", text("every true pole is within three standard deviations of a fitted one"),
                            study.away <= DEVIATIONS, study.away))
    return tuple(checks)


def _stage(study: Study, smoothed: bool, kind: str) -> Stage:
    """One tube for each output: what was measured (or is true), and as the ghost what the filter estimates."""
    record, first = study.found.record, study.first
    shown = study.measured if study.clean is None else study.clean
    seen = np.isfinite(shown)
    shown = np.where(seen, shown, study.predicted)
    level = study.found.trend.y_level
    size = np.maximum(np.abs(shown - level).max(axis=0), 1e-12)
    strongest = np.abs(record.u[first:]).max(axis=0, initial=1e-12)
    count, trace = record.y.shape[1], _trace(study)
    others = None if count == 1 else tubes_body(record.output_names[1:], size[1:].tolist(), tuple(range(count - 1)), ())
    t, split = study.t - study.t[0], trace.share(first)
    share = split + (1 - split) * t / t[-1]
    x, xhat = (np.column_stack([y - level, share]) for y in (shown, study.estimate(smoothed)))
    below = shown_below(kind, study.found, study.judged, _errors(study, smoothed), lambda: study.deviation)
    return Stage(body_with_trace(trace, count, strongest.tolist(), others, below), t, x, xhat, record.u[first:],
                 picture=panel(trace, panel_foot(count), below))


def _errors(study: Study, smoothed: bool) -> list[np.ndarray]:
    """Errors of the first output in the rows that judge: filter as fitted, filter, and smoother if it is on."""
    beside = (study.measured if study.clean is None else study.clean)[:, 0]
    ways = ((False, True), (False, False), *([(True, False)] if smoothed else []))
    return [np.nan_to_num(study.estimate(*way)[:, 0] - beside) for way in ways]


def _trace(study: Study) -> Trace:
    """The first output of the whole record about its level, with the readings that are faulty, set aside or of a second sensor."""
    given, found, judged = study.given, study.found, study.judged
    record, delay = found.record, found.delay
    predicted = judged.track.predicted @ found.fitted.plant.C.T + record.u @ found.fitted.plant.D.T
    readings = np.where(np.isfinite(record.y), record.y, predicted)[:, 0]
    y = readings if given.clean is None else given.clean[delay:, 0] - found.trend.y_level[0]
    jumping, biased = (np.array([], dtype=int) if each is None else np.flatnonzero(each[delay:, 0]) for each in (given.jumps, given.bias))
    exact = np.array([], dtype=int)
    if study.second != ONE_SENSOR and given.clean is not None:
        exact = np.arange(study.first + EVERY, record.rows, EVERY)
    aside = np.flatnonzero(judged.set_aside)
    return Trace(y, readings, study.first, predicted[:, 0], np.sqrt(judged.track.S[:, 0, 0]), jumping, aside[aside >= study.first], exact,
                 int(biased[0]) if len(biased) else None)


def _formulas(study: Study, gains: dict[str, np.ndarray]) -> tuple[Formula, ...]:
    plant = study.found.fitted.plant
    return (
        Formula("model", r"x_{k+1}=Ax_k+Bu_k+w_k,\quad y_k=Cx_k+Du_k+v_k", text("Fitted to the first part of the record.")),
        Formula("A", "A=" + matrix(plant.A)),
        Formula("C", "C=" + matrix(plant.C)),
        Formula("Q", "Q=" + matrix(gains["Q"])),
        Formula("R", "R=" + matrix(gains["R"])),
    )


def _live(study: Study) -> Text:
    judged, order, suggested = study.judged, len(study.found.subspace.A), min(study.found.subspace.suggested, MAX_ORDER)
    failures = judged.evidence.failures
    fit = text("The filter predicts {fit:.3g} % of the output's variation one step ahead.", fit=100 * float(judged.fit[0]))
    if judged.mean_nis > judged.band[1]:
        nis = text("Mean NIS {nis:.3g}, above its band ({low:.2f} to {high:.2f}): the filter is over-confident.",
                   nis=judged.mean_nis, low=judged.band[0], high=judged.band[1])
    elif failures and judged.nis_holds:
        nis = text("Mean NIS {nis:.3g}, inside its band ({low:.2f} to {high:.2f}), but another check fails: the filter is not "
                   "consistent.", nis=judged.mean_nis, low=judged.band[0], high=judged.band[1])
    elif judged.mean_nis < judged.band[0]:
        nis = text("Mean NIS {nis:.3g}, below its band ({low:.2f} to {high:.2f}): the filter is under-confident.",
                   nis=judged.mean_nis, low=judged.band[0], high=judged.band[1])
    else:
        nis = text("Mean NIS {nis:.3g}, inside its band ({low:.2f} to {high:.2f}): the filter is consistent.",
                   nis=judged.mean_nis, low=judged.band[0], high=judged.band[1])
    free = judged.evidence.free_run
    alone = NO_WORDS if math.isnan(free) else (
        text("From the inputs alone the model gives {free:.3g} % of it.", free=100 * free) if free > 0 else
        text("From the inputs alone the model gives none of it."))
    bias = NO_WORDS if study.found.bias is None else error_words(study.found.bias.said)
    mine = NO_WORDS if study.given.plant is None else text("The model is your own plant; only Q and R were fitted.")
    aside = NO_WORDS if not study.gated else text(
        "The gate set {count} of {rows} rows aside; they count as missing.", count=int(judged.set_aside.sum()), rows=len(judged.set_aside))
    other = NO_WORDS if order == suggested else text("The singular values suggest order {suggested}, not {order}.",
                                                     suggested=suggested, order=order)
    information = study.found.subspace.by_information
    criterion = NO_WORDS if information == suggested else text("An information criterion suggests order {order}.", order=information)
    return joined(*map(error_words, failures[:1] if not judged.evidence.stable else ()), nis,
                  *map(error_words, failures[1:] if not judged.evidence.stable else failures), aside, bias, mine, fit, alone, other,
                  criterion,
                  error_words(study.given.record.size), *map(error_words, study.found.record.notes))
