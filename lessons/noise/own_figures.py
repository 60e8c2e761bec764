"""Draw the figures of lesson 8 for an own plant."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import Curve, LineFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine.simulation import Run
from observer_lab.plants import Model, Signal
from observer_lab.text import format_number, squared_unit, text, text_in

from ..toolkit.figures import TIME_TAB
from ..toolkit.shares import percent
from .figures import RUNS_TAB, SPEED_TAB, error_curves, variance_curves
from .job import RUN_COUNT
from .own_study import ASSUMED_NOISE_RATIOS, BELIEF, Study, watched_signal

MAX_LIVE_STATES = 12  # states up to which the ladder of beliefs follows a hand; beyond, it follows when the hand pauses


# --- figures -----------------------------------------------------------------------------------------------------------
def figures(model: Model, outcome: Outcome[Study]) -> FigureSet:
    """The valley and the peak over belief, shares; one run; many runs."""
    run, signal = outcome.study.run, watched_signal(model, outcome.design)
    return FigureSet(
        tab_figures(SPEED_TAB, lambda: (_valley(outcome, signal), _peaks(outcome)), "open" if model.plant.n <= MAX_LIVE_STATES else "late"),
        tab_figures(SPEED_TAB, lambda: (_shares(model, outcome),)),
        tab_figures(TIME_TAB, lambda: (_seen(model, run), _hidden(signal, run), _error(outcome, signal, run))),
        tab_figures(RUNS_TAB, lambda: (_variance(outcome, signal, run),)),
    )


def _rms(P: np.ndarray, signal: Signal) -> float:
    row = np.array(signal.weights)
    return float(np.sqrt(max(row @ P @ row, 1e-300)))


def _now(outcome: Outcome[Study]) -> float | None:
    return float(np.log10(outcome.design["belief"])) if outcome.design["method"] == BELIEF else None


def _valley(outcome: Outcome[Study], signal: Signal) -> PlaneFigure:
    study, x, m = outcome.study, np.log10(ASSUMED_NOISE_RATIOS), outcome.metrics
    total, process, sensor = (np.log10([_rms(getattr(p, k), signal) for p in study.ladder.parts]) for k in ("total", "process", "sensor"))
    at = _now(outcome)
    here = (Point(2.2 if at is None else at, float(np.log10(max(m["rms"], 1e-150))), "estimate", "cross", text(
        "yours")),)
    low = float(np.floor(2 * total.min()) / 2 - 0.5)
    sensor_share = percent((_rms(study.parts.sensor, signal) / _rms(study.parts.total, signal)) ** 2)
    return PlaneFigure("valley", text("error of {name} over belief", name=signal.name), (
        Curve(text("both noises"), total, "error", x=x),
        Curve(text("process noise"), process, "disturbance", "dash", 1.8, x),
        Curve(text("sensor noise"), sensor, "second", "dot", 1.8, x)),
        (Point(0.0, float(total[len(x) // 2]), "reference", "circle", text("Kalman")), *here), "b",
        f"σ [{signal.unit}]",
        (-3.0, 3.0), (low, max(low + 2.0, float(total.max()) + 0.2)), tab=SPEED_TAB, powers="xy", caption=text(
            "σ = {rms:.3g} {unit}, {sensor_share} % of σ² from the sensor; the least is {least_rms:.3g}.",
            rms=m["rms"], unit=signal.unit, sensor_share=sensor_share, least_rms=m["least_rms"]))


def _peaks(outcome: Outcome[Study]) -> PlaneFigure:
    y, at = np.log10(np.maximum(outcome.study.peaks, 1e-150)), _now(outcome)
    points = () if at is None else (Point(at, float(np.interp(at, np.log10(ASSUMED_NOISE_RATIOS), y)), "estimate", "cross", text(
        "yours")),)
    return PlaneFigure("peaks", text("peak of the error from x(0), without noise"),
                       (Curve(text("start as wrong as x(0)"), y, "error", x=np.log10(ASSUMED_NOISE_RATIOS)),), points,
                       "b", "max|e|",
                       (-3.0, 3.0), (float(np.floor(y.min())) - 0.2, float(np.ceil(y.max())) + 0.2), tab=SPEED_TAB, powers="xy",
                       caption=text("In this run the estimate is wrong by up to {peak:.3g}, noise aside.",
                                    peak=outcome.metrics["peak"]))


def _shares(model: Model, outcome: Outcome[Study]) -> TableFigure:
    study = outcome.study
    rows = tuple((text("{name} [{unit}]", name=s.name, unit=s.unit), *(
        format_number(_rms(P, s), ".3g") for P in (study.parts.process, study.parts.sensor, study.parts.total, study.least.total)))
        for s in model.watched[:6])
    return TableFigure("shares", text("σ of the settled error"),
                       (text("error in"), text("process"), text_in("noise", "sensor"), text(
                           "both"),
                        text("least")), rows,
                       tab=SPEED_TAB, caption=text("No entry of the column both is below that of the column least."))


def _seen(model: Model, run: Run) -> LineFigure:
    signal = model.watched[0]
    return LineFigure("measured", signal.name, run.t, (
        Curve(text("measured"), run.y[:, 0], "muted", width=1.0), Curve(text("true"), signal.of(run.x)),
        Curve(text("estimate"), signal.of(run.xhat), "estimate", "dash")), f"[{signal.unit}]", tab=TIME_TAB,
        caption=text("Readings differ from the truth by up to {y:.2g}.",
                     y=np.abs(run.y[:, 0] - signal.of(run.x)).max()))


def _hidden(signal: Signal, run: Run) -> LineFigure:
    true, guess = signal.of(run.x), signal.of(run.xhat)
    return LineFigure("velocity", signal.name, run.t, (Curve(text("true"), true),
                                                       Curve(text("estimate"), guess, "estimate", "dash")),
                      f"[{signal.unit}]", tab=TIME_TAB, caption=text(
                          "Largest difference: {true:.2g} {unit}.",
                          true=np.abs(true - guess).max(), unit=signal.unit))


def _error(outcome: Outcome[Study], signal: Signal, run: Run) -> LineFigure:
    study = outcome.study
    count = len(study.grown)
    e, quiet, spread = signal.of(run.e)[:count], signal.of(study.quiet), 2 * np.sqrt(study.grown)
    inside = 100 * float(np.mean(np.abs(e - quiet) <= spread + 1e-300))
    return LineFigure("error", text("error of {name}", name=signal.name), run.t[:count],
                      error_curves(e, quiet, spread), f"[{signal.unit}]", tab=TIME_TAB,
                      caption=text("{inside:.0f} % of this run lies within 2σ of the noise-free error.",
                                   inside=inside))


def _variance(outcome: Outcome[Study], signal: Signal, run: Run) -> LineFigure:
    study = outcome.study
    grown, count = study.grown, RUN_COUNT if study.trials is None else study.trials.count
    curves, inside = variance_curves(grown, None if study.trials is None else study.trials.square[:, 0], count)
    if study.trials is None:
        said = text("No runs yet: press the button under the knobs.")
    else:
        said = text("{count} runs: the variance lies within its 95 % band at {inside:.0f} % of the instants.",
                    count=count, inside=inside)
    return LineFigure("variance", text("variance of the error of {name}", name=signal.name),
                      run.t[:len(grown)], curves, f"[{squared_unit(signal.unit)}]", caption=said, tab=RUNS_TAB)
