"""Draw the figures of lesson 9 on any plant: one step, gain, innovations, tests."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.gauges import MIDDLE, UPPER, Gauge, place_of
from observer_lab.course.figures.records import Curve, GaugeFigure, LineFigure, PlaneFigure, TableFigure
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine import chi2_band
from observer_lab.engine.filters import InnovationTest, SquaredError
from observer_lab.plants import Signal
from observer_lab.text import Text, format_number, same, text, text_in

from ..toolkit.figures import TIME_TAB
from ..toolkit.latex import apart
from .knobs import UPDATE
from .study import Look, S, Setting, Study, bias_is_judged, holds

STEP_TAB, GAIN_TAB, TEST_TAB = text("One step"), text("Gain"), text("Consistency")
INNOVATION_TAB = text("Innovations")
GAIN_ROLES = ("estimate", "force", "second")
SENSOR_CURVES = (("estimate", "solid"), ("second", "solid"), ("disturbance", "dash"), ("plant", "dash"))
LEAST_P = 0.05 / 3  # three tests of one record share five percent
HEADS = (text_in("kalman", "test"), text("value"), text("band"), text("verdict"))
MIN_P_VALUE = 1e-300  # below it floating point runs out


def figures(here: Setting[S], outcome: Outcome[S]) -> FigureSet:
    """Everything on the right of the stage."""
    look, study = here.look, outcome.study
    return FigureSet(
        tab_figures(STEP_TAB, lambda: (*here.planes(outcome), _step(look, outcome))),
        tab_figures(TIME_TAB, lambda: (_state(look, study, "height", look.signals[0]), _state(look, study, "pitch", look.signals[1]))),
        tab_figures(GAIN_TAB, lambda: (_gain(look, study), _distance(study))),
        tab_figures(INNOVATION_TAB, lambda: (_innovation(look, study), _correlation(look, study))),
        tab_figures(TEST_TAB, lambda: (
            _squares(look, study, "nis", look.squares[0], study.truth.y.shape[1], (study.trials or study).nis),
            _squares(look, study, "nees", look.squares[1], study.truth.x.shape[1], (study.trials or study).nees))),
        tab_figures(TEST_TAB, lambda: (_tests(look, outcome),)),
        *here.more(outcome),
    )


def _step(look: Look, outcome: Outcome[S]) -> TableFigure:
    s, k = outcome.study, int(outcome.design["k"])
    plan, updated = s.watcher.schedule, outcome.design["phase"] == UPDATE
    at = int(plan.index[k])
    mean, P = (s.track.means[k], plan.posterior[at]) if updated else (s.track.predicted[k], plan.prior[at])

    def written(value: float) -> str:
        return format_number(look.scale * float(value), look.digits)
    rows = tuple((name, written(s.truth.x[k, i]), written(mean[i]), written(np.sqrt(max(P[i, i], 0.0))))
                 for i, name in enumerate(look.states))
    return TableFigure("step", text("sample {k}", k=k), (text("state"), text("true"), text("estimate"), same("σ")), rows, tab=STEP_TAB,
                       caption=text("t = {t:.3g} s, {updated} the sample is taken in; its NIS {nis:.3g}.",
                                    t=s.truth.t[k], updated=text("after") if updated else text("before"), nis=s.nis[k]))


def _state(look: Look, s: Study, name: str, signal: Signal) -> LineFigure:
    first, t, row = s.watcher.first, s.truth.t, signal.scale * np.array(signal.weights)
    true, mean = signal.of(s.truth.x), signal.of(s.means)
    spread = 2 * np.sqrt(np.maximum(np.einsum("i,kij,j->k", row, s.covariances, row), 0.0))
    inside = 100 * float(np.mean(np.abs(true - mean)[first:] <= spread[first:] + 1e-300))
    return LineFigure(name, signal.name, t, (
        Curve(text("true"), true), Curve(text("estimate"), mean, "estimate", "dash"),
        Curve(same("+ 2σ"), mean + spread, "muted", "dot", 1.2), Curve(same("− 2σ"), mean - spread, "muted", "dot", 1.2)),
        f"[{signal.unit}]", window=look.windows.get(name), tab=TIME_TAB, caption=text(
            "From {first:.3g} s on the truth is within the filter's own 2σ for {inside:.0f} % of the time; 95 % are "
            "expected.",
            first=t[first], inside=inside))


def _gain(look: Look, s: Study) -> LineFigure:
    M, goal, t = s.track.gains, s.watcher.steady.filter_gain, s.truth.t[:look.early]
    curves = [curve for (i, j, name), role in zip(look.entries(goal), GAIN_ROLES, strict=False) for curve in (
        Curve(same(name), M[:look.early, i, j], role), Curve(same(f"{name} ∞"), np.full(len(t), goal[i, j]), "reference", "dot", 1.2))]
    return LineFigure("gain", look.gain, t, tuple(curves), "M", tab=GAIN_TAB, window=look.windows.get("gain"),
                      caption=text("Dotted: the steady gain from the Riccati equation."))


def _distance(s: Study) -> LineFigure:
    t, late = s.truth.t, np.flatnonzero(s.distance > 0.01)
    after, left = float(t[min(late[-1] + 1, len(t) - 1)]) if len(late) else 0.0, 100 * float(s.distance[-1])
    return LineFigure("distance", text("distance to the Riccati gain"), t,
                      (Curve(text("relative distance"), np.maximum(s.distance, 1e-12), "error"),), "‖M − M∞‖ / ‖M∞‖",
                      log_y=True, window=(1e-10, 1.0), tab=GAIN_TAB,
                      caption=claim(text("Within 1 % after {after:.3g} s. No reading has any part in this.", after=after), left, below=1.0,
                                    otherwise=text("At the end it still differs by {left}. No reading has any part in this.",
                                                   left=apart(left / 100))))


def _innovation(look: Look, s: Study) -> LineFigure:
    first, (name, unit) = s.watcher.first, look.innovation
    nu, spread = look.scale * s.track.innovations[:, 0], 2 * look.scale * np.sqrt(s.track.S[:, 0, 0])
    inside = 100 * float(np.mean(np.abs(nu[first:]) <= spread[first:]))
    return LineFigure("innovation", text("innovation of {name}", name=name), s.truth.t, (
        Curve(same("ν"), nu, "error", width=1.4), Curve(same("+ 2√S"), spread, "muted", "dot", 1.4),
        Curve(same("− 2√S"), -spread, "muted", "dot", 1.4)), f"ν [{unit}]", window=look.windows.get("innovation"), tab=INNOVATION_TAB,
        caption=text("From {first:.3g} s on {inside:.0f} % lie within 2√S; their mean is {score:+.2f} of its σ.",
                     first=s.truth.t[first], inside=inside, score=s.test.scores[0]))


def _correlation(look: Look, s: Study) -> PlaneFigure:
    w = s.test.whiteness
    lags = np.arange(1, len(w.correlation) + 1, dtype=float)
    ends = np.array([lags[0], lags[-1]])
    curves = [Curve(name, w.correlation[:, i], role, dash, 1.8, lags)  # type: ignore[arg-type]
              for i, (name, (role, dash)) in enumerate(zip(look.sensors, SENSOR_CURVES, strict=False))]
    curves += [Curve(text("band"), np.full(2, sign * w.band), "reference", "dot", 1.2, ends) for sign in (1, -1)]
    said = text("No correlation found: p = {p_value:.2g}.", p_value=w.p_value) if w.white else coloured(w.p_value)
    return PlaneFigure("correlation", text("autocorrelation of the innovations"), tuple(curves), (),
                       text("lag [samples]"), "r", (0.0, float(lags[-1] + 1)), (-0.6, 1.0), caption=said, tab=INNOVATION_TAB)


def _squares(look: Look, s: Study, name: str, title: Text, dof: int, shown: np.ndarray) -> LineFigure:
    first, n, t = s.watcher.first, len(shown), s.truth.t[:len(shown)]
    count = 1 if s.trials is None else s.trials.count
    low, high = chi2_band(dof, count=count)
    inside = 100 * float(np.mean((shown[first:] >= low) & (shown[first:] <= high)))
    who = text("One run") if s.trials is None else text("Mean of {count} runs", count=count)
    whose = text("one run") if s.trials is None else text("mean of {count} runs", count=count)
    return LineFigure(name, title, t, (
        Curve(whose, np.maximum(shown, 1e-4), "error", width=1.4),
        Curve(text("expected, {dof}", dof=dof), np.full(n, float(dof)), "reference", "dash", 1.4),
        Curve(text("95 % band"), np.full(n, high), "muted", "dot", 1.4),
        Curve(text("lower edge"), np.full(n, low), "muted", "dot", 1.4)), name.upper(), log_y=True, window=look.windows[name],
        tab=TEST_TAB,
        caption=text("{who}: from {first:.3g} s on {inside:.0f} % of the samples lie in the χ² band [{low:.3g}, "
                     "{high:.3g}].",
                     who=who, first=t[first], inside=inside, low=low, high=high))


def _tests(look: Look, outcome: Outcome[S]) -> GaugeFigure:
    s = outcome.study
    held = holds(s.test, s.settled)
    return GaugeFigure("tests", text("tests of this record from {first:.3g} s on", first=s.truth.t[s.watcher.first]),
                       gauges_of(s.test, s.settled, held, bias_is_judged(s.test), look.gauge_digits), HEADS,
                       look.verdict(outcome.design, all(held.values())), TEST_TAB)


def gauges_of(test: InnovationTest, settled: SquaredError, held: Mapping[str, bool], bias_judged: bool,
              digits: str = ".3g") -> tuple[Gauge, ...]:
    """Means of NIS and NEES between the ends of their bands, and two p-values above the least; `digits` are those of NIS."""
    return (
        _mean(text("mean of NIS"), test.nis, held["nis"], digits),
        _mean(text("mean of NEES"), settled, held["nees"], ".3g"),
        _chance(text("whiteness, p"), test.whiteness.p_value, held["white"]),
        _chance(text("bias, p"), test.bias_p_value, held["centred"] if bias_judged else None),
    )


def _mean(name: Text, found: SquaredError, held: bool, digits: str) -> Gauge:
    low, high = found.mean_band
    ends = format(low, digits), format(high, digits)
    return Gauge(name, place_of(found.mean, low, high), MIDDLE, format_number(found.mean, digits), ends,
                 f"{ends[0]} … {ends[1]}", _verdict(held), "right" if held else "wrong")


def _chance(name: Text, p: float, held: bool | None) -> Gauge:
    verdict = text("not judged: it assumes white innovations of covariance S") if held is None else _verdict(held)
    role = "muted" if held is None else "right" if held else "wrong"
    return Gauge(name, place_of(p, LEAST_P, 1.0, UPPER), UPPER, chance(p), ("0.017", "1"), "≥ 0.017", verdict, role)


def _verdict(held: bool) -> Text:
    return text("passes") if held else text("flagged")


def chance(p: float) -> str:
    """A p-value for a table."""
    return "< 10⁻³⁰⁰" if p < MIN_P_VALUE else format_number(p, ".2g")


def coloured(p: float) -> Text:
    """What is said of innovations that are not white."""
    if p < MIN_P_VALUE:
        return text("Coloured: p is below 10⁻³⁰⁰; each sample foretells the next.")
    return text("Coloured: p = {p_value:.1e}; each sample foretells the next.", p_value=p)
