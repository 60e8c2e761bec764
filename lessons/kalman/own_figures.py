"""Draw the figures of lesson 9 for an own plant: one step, gain, innovations, tests."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import Curve, GaugeFigure, LineFigure, PlaneFigure, TableFigure
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine import chi2_band
from observer_lab.plants import Model, Signal
from observer_lab.plants.signal_names import signal_name, with_unit
from observer_lab.text import Text, format_number, same, symbol, text

from ..toolkit.figures import TIME_TAB
from ..toolkit.shares import apart
from .figures import GAIN_TAB, INNOVATION_TAB, STEP_TAB, TEST_TAB
from .gauges import HEADS, gauges_of
from .knobs import UPDATE
from .own_study import UNTESTED_SAMPLES, Study
from .p_values import coloured
from .study import bias_is_judged, holds

MAX_TABLE_STATES = 10  # rows of the table of one step


def figures(model: Model, outcome: Outcome[Study]) -> FigureSet:
    """One step; two signals; the gain; innovations; consistency."""
    second = next((s for s in model.watched if s.name("en").startswith("state")), model.watched[-1])
    return FigureSet(
        tab_figures(STEP_TAB, lambda: (_step(model, outcome),)),
        tab_figures(TIME_TAB, lambda: (_state(outcome, "height", model.watched[0]), _state(outcome, "pitch", second))),
        tab_figures(GAIN_TAB, lambda: (_gain(outcome), _distance(outcome))),
        tab_figures(INNOVATION_TAB, lambda: (_innovation(model, outcome), _correlation(model, outcome))),
        tab_figures(TEST_TAB, lambda: (_squares(outcome, "nis", text("NIS of a sample"), model.plant.p, 0),
                                _squares(outcome, "nees", text("NEES of the states"), model.plant.n, 1), _tests(outcome))))


def _step(model: Model, outcome: Outcome[Study]) -> TableFigure:
    study, k, plant = outcome.study, int(outcome.design["k"]), model.plant
    track, updated = study.found.track, outcome.design["phase"] == UPDATE
    at = int(track.schedule.index[k])
    mean, P = (track.means[k], track.schedule.posterior[at]) if updated else (track.predicted[k], track.schedule.prior[at])

    def digits(value: float) -> str:
        return format_number(value, ".4g")
    rows = tuple((with_unit(plant, name), digits(study.found.run.x[k, i]), digits(mean[i]),
                  digits(float(np.sqrt(max(P[i, i], 0.0))))) for i, name in enumerate(plant.state_names[:MAX_TABLE_STATES]))
    return TableFigure("step", text("sample {k}", k=k),
                       (text("state"), text("true"), text("estimate"), same("σ")), rows, tab=STEP_TAB,
                       caption=text("t = {t:.3g} s, {updated} the sample is taken in; its NIS {nis:.3g}.",
                                    t=study.found.run.t[k], updated=text("after") if updated else text("before"),
                                    nis=study.nis[k]))


def _state(outcome: Outcome[Study], name: str, signal: Signal) -> LineFigure:
    found, row = outcome.study.found, np.array(signal.weights)
    true, mean = signal.of(found.run.x), signal.of(found.track.means)
    spread = 2 * np.sqrt(np.maximum(np.einsum("i,kij,j->k", row, found.track.covariances, row), 0.0))
    inside = 100 * float(np.mean(np.abs(true - mean)[UNTESTED_SAMPLES:] <= spread[UNTESTED_SAMPLES:] + 1e-300))
    return LineFigure(name, signal.name, found.run.t, (
        Curve(text("true"), true), Curve(text("estimate"), mean, "estimate", "dash"),
        Curve(same("+ 2σ"), mean + spread, "muted", "dot", 1.2), Curve(same("− 2σ"), mean - spread, "muted", "dot", 1.2)),
        f"[{signal.unit}]", tab=TIME_TAB, caption=text(
            "From {first:.3g} s on the truth is within the filter's own 2σ for {inside:.0f} % of the time; 95 % are "
            "expected.",
            first=found.run.t[UNTESTED_SAMPLES], inside=inside))


def _gain(outcome: Outcome[Study]) -> LineFigure:
    found = outcome.study.found
    M, goal, count = found.track.gains, found.steady.filter_gain, min(len(found.run.t), 80)
    largest = np.argsort(np.abs(goal).ravel())[::-1][:3]
    curves = []
    for place, role in zip(largest, ("estimate", "force", "second"), strict=False):
        i, j = divmod(int(place), goal.shape[1])
        curves += [Curve(same(symbol(f"M{i + 1}{j + 1}")), M[:count, i, j], role),
                   Curve(same(symbol(f"M{i + 1}{j + 1}") + " ∞"), np.full(count, goal[i, j]), "reference", "dot", 1.2)]
    return LineFigure("gain", text("largest entries of the gain M"), found.run.t[:count], tuple(curves),
                      "M", tab=GAIN_TAB,
                      caption=text("Dotted: the steady gain from the Riccati equation."))


def _distance(outcome: Outcome[Study]) -> LineFigure:
    found = outcome.study.found
    late = np.flatnonzero(found.distance > 0.01)
    after = format_number(found.run.t[min(late[-1] + 1, len(found.run.t) - 1)], ".3g") if len(late) else "0"
    left = 100 * float(found.distance[-1])
    return LineFigure("distance", text("distance to the Riccati gain"), found.run.t,
                      (Curve(text("relative distance"), np.maximum(found.distance, 1e-12), "error"),),
                      "‖M − M∞‖ / ‖M∞‖", log_y=True,
                      window=(1e-10, 1.0), tab=GAIN_TAB,
                      caption=text("Within 1 % after {after} s. No reading has any part in this.", after=after) if left <= 1 else
                      text("At the end it still differs by {left}. No reading has any part in this.", left=apart(left / 100)))


def _innovation(model: Model, outcome: Outcome[Study]) -> LineFigure:
    found, name = outcome.study.found, model.plant.output_names[0]
    nu, spread = found.track.innovations[:, 0], 2 * np.sqrt(found.track.S[:, 0, 0])
    inside = 100 * float(np.mean(np.abs(nu[UNTESTED_SAMPLES:]) <= spread[UNTESTED_SAMPLES:]))
    return LineFigure("innovation", text("innovation of {name}", name=signal_name(model.plant, name)), found.run.t, (
        Curve(same("ν"), nu, "error", width=1.4), Curve(same("+ 2√S"), spread, "muted", "dot", 1.4),
        Curve(same("− 2√S"), -spread, "muted", "dot", 1.4)), f"ν [{model.plant.unit(name)}]", tab=INNOVATION_TAB,
        caption=text("From {first:.3g} s on {inside:.0f} % lie within 2√S.", first=found.run.t[UNTESTED_SAMPLES], inside=inside))


def _correlation(model: Model, outcome: Outcome[Study]) -> PlaneFigure:
    w = outcome.study.test.whiteness
    lags = np.arange(1, len(w.correlation) + 1, dtype=float)
    roles, ends = ("estimate", "second", "disturbance", "plant"), np.array([lags[0], lags[-1]])
    curves = [Curve(signal_name(model.plant, name), w.correlation[:, i], roles[i % 4], "solid", 1.8, lags)
              for i, name in enumerate(model.plant.output_names[:4])]
    curves += [Curve(text("band"), np.full(2, sign * w.band), "reference", "dot", 1.2, ends) for sign in (1, -1)]
    said = (text("No correlation found: p = {p_value:.2g}.", p_value=w.p_value) if w.white else
            coloured(w.p_value))
    return PlaneFigure("correlation", text("autocorrelation of the innovations"), tuple(curves), (),
                       text("lag [samples]"), "r", (0.0, float(lags[-1] + 1)), (-0.6, 1.0), caption=said, tab=INNOVATION_TAB)


def _squares(outcome: Outcome[Study], name: str, title: Text, dof: int, which: int) -> LineFigure:
    study = outcome.study
    trials = study.trials
    count, shown = ((1, (study.nis, study.nees)[which]) if trials is None else
                    (trials.count, (trials.nis, trials.nees)[which]))
    t, (low, high) = study.found.run.t[:len(shown)], chi2_band(dof, count=count)
    inside = 100 * float(np.mean((shown[UNTESTED_SAMPLES:] >= low) & (shown[UNTESTED_SAMPLES:] <= high)))
    who = text("One run") if trials is None else text("Mean of {count} runs", count=count)
    whose = text("one run") if trials is None else text("mean of {count} runs", count=count)
    n = len(t)
    return LineFigure(name, title, t, (
        Curve(whose, np.maximum(shown, 1e-4), "error", width=1.4),
        Curve(text("expected, {dof}", dof=dof), np.full(n, float(dof)), "reference", "dash", 1.4),
        Curve(text("95 % band"), np.full(n, high), "muted", "dot", 1.4),
        Curve(text("lower edge"), np.full(n, low), "muted", "dot", 1.4)), name.upper(), log_y=True, window=(0.05 * dof, 20.0 * dof),
        tab=TEST_TAB,
        caption=text("{who}: from {first:.3g} s on {inside:.0f} % of the samples lie in the χ² band [{low:.3g}, "
                     "{high:.3g}].",
                     who=who, first=t[UNTESTED_SAMPLES], inside=inside, low=low, high=high))


def _tests(outcome: Outcome[Study]) -> GaugeFigure:
    study = outcome.study
    gauges = gauges_of(study.test, study.settled, holds(study.test, study.settled), bias_is_judged(study.test))
    return GaugeFigure("tests", text("tests of this record from {first:.3g} s on", first=study.found.run.t[UNTESTED_SAMPLES]), gauges,
                       HEADS, text("Each test flags a right filter in a few records of a hundred."), TEST_TAB)
