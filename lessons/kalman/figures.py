"""Draw the figures of lesson 9: one step, gain, innovations, tests, spectra."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.diagram import DIAGRAM
from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, GaugeFigure, LineFigure, PlaneFigure, Point, TableFigure, over_frequency
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine import chi2_band, psd
from observer_lab.text import Text, same, text, text_in

from ..toolkit.figures import TIME_TAB
from ..toolkit.shares import apart
from .data_sheet import SHEET_TAB, estimators_figure, sheet_figure
from .figure_eleven import ELEVEN_TAB, eleven_figures
from .filters import COMPARED_STEPS, UNTESTED_SAMPLES
from .gauges import HEADS, gauges_of
from .knobs import CARRIED, DT
from .loop import loop_of
from .noise_identification import FIT_TAB, fit_figure
from .one_number import NUMBER_TAB, number_figure
from .p_values import coloured
from .report_lines import REPORT_TAB, report_figure
from .study import Study, bias_is_judged, expected, holds

STEP_TAB, GAIN_TAB, TEST_TAB = text("One step"), text("Gain"), text("Consistency")
INNOVATION_TAB, SPECTRUM_TAB = text("Innovations"), text("Spectrum")
STATE_UNITS = (("x", "mm"), ("z", "mm"), ("θ", "mrad"), ("vx", "mm/s"), ("vz", "mm/s"), ("ω", "mrad/s"))
CIRCLE_ANGLES_RAD = np.linspace(0, 2 * np.pi, 61)
UNIT_CIRCLE = np.column_stack([np.cos(CIRCLE_ANGLES_RAD), np.sin(CIRCLE_ANGLES_RAD)])


def figures(outcome: Outcome[Study]) -> FigureSet:
    """Everything on the right of the stage."""
    return FigureSet(
        tab_figures(STEP_TAB, lambda: (_ellipses(outcome), _step(outcome))),
        tab_figures(TIME_TAB, lambda: (_height(outcome), _pitch(outcome))),
        tab_figures(GAIN_TAB, lambda: (_gain(outcome), _distance(outcome))),
        tab_figures(GAIN_TAB, lambda: (_forms(outcome),)),
        tab_figures(INNOVATION_TAB, lambda: (_innovation(outcome), _correlation(outcome))),
        tab_figures(TEST_TAB, lambda: (_nis(outcome), _nees(outcome))),
        tab_figures(TEST_TAB, lambda: (_tests(outcome),)),
        tab_figures(SPECTRUM_TAB, lambda: (_tracking(outcome), _colour(outcome))),
        tab_figures(REPORT_TAB, lambda: (report_figure(outcome),)),
        tab_figures(ELEVEN_TAB, lambda: eleven_figures(outcome.design)),
        tab_figures(FIT_TAB, lambda: (fit_figure(outcome),)),
        tab_figures(SHEET_TAB, lambda: (estimators_figure(outcome), sheet_figure(outcome))),
        tab_figures(NUMBER_TAB, lambda: (number_figure(outcome),)),
        tab_figures(DIAGRAM, lambda: (loop_of(outcome),)),
    )


def _time(outcome: Outcome[Study]) -> np.ndarray:
    return DT * np.arange(len(outcome.study.nis))


# --- one step --------------------------------------------------------------------------------------------------------
def _ellipse(mean: np.ndarray, P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The 2σ ellipse of height and vertical speed in mm and mm/s."""
    at, part = 1e3 * mean[[1, 4]], 1e6 * P[np.ix_([1, 4], [1, 4])]
    values, vectors = np.linalg.eigh(part)
    ring = at + 2 * UNIT_CIRCLE @ (vectors * np.sqrt(np.maximum(values, 0.0))).T
    return ring[:, 0], ring[:, 1]


def _ellipses(outcome: Outcome[Study]) -> PlaneFigure:
    s, k = outcome.study, int(outcome.design["k"])
    plan, updated = s.watcher.schedule, outcome.design["phase"] == "update"
    before, at = int(plan.index[k - 1]), int(plan.index[k])
    prior = plan.prior[at]
    old, new = (_ellipse(s.track.predicted[k], P) for P in (plan.posterior[before], prior))
    middle = 1e3 * s.track.predicted[k][[1, 4]]
    half = [round_up_nicely(float(2.6e3 * np.sqrt(max(P[i, i] for P in (prior, plan.posterior[before]))))) for i in (1, 4)]
    curves = [Curve(text("last estimate, moved here"), old[1], "muted", "dot", 2.0, old[0]),
              Curve(text("prediction"), new[1], "disturbance", "dash", 2.0, new[0])]
    x = 1e3 * s.truth.x[k]
    points = [Point(float(x[1]), float(x[4]), "plant", "circle", text("true")),
              Point(float(middle[0]), float(middle[1]), "disturbance", "cross")]
    said = text("Prediction: σ(z) = {prior:.3g} mm, σ(vz) = {prior2:.3g} mm/s.",
                prior=1000.0 * np.sqrt(prior[1, 1]), prior2=1000.0 * np.sqrt(prior[4, 4]))
    if updated:
        after = plan.posterior[at]
        ring = _ellipse(s.track.means[k], after)
        read = 1e3 * float(s.truth.y[k, 0] + s.truth.y[k, 2]) / 2
        curves += [Curve(text("estimate"), ring[1], "estimate", "solid", 2.0, ring[0]),
                   Curve(text("reading (VL + VR)/2"), np.full(2, read), "second", "solid", 1.4,
                         middle[0] + half[0] * np.array([-1.0, 1.0]))]
        mean = 1e3 * s.track.means[k]
        points.append(Point(float(mean[1]), float(mean[4]), "estimate", "cross"))
        said = text("This sample shrinks σ(vz) from {prior:.3g} to {after:.3g} mm/s and σ(z) from {prior2:.3g} to "
                    "{after2:.3g} mm.",
                    prior=1000.0 * np.sqrt(prior[4, 4]), after=1000.0 * np.sqrt(after[4, 4]),
                    prior2=1000.0 * np.sqrt(prior[1, 1]), after2=1000.0 * np.sqrt(after[1, 1]))
    return PlaneFigure("ellipses", text("height and vertical speed, 2σ"), tuple(curves), tuple(points),
                       "z [mm]", "vz [mm/s]", (float(middle[0] - half[0]), float(middle[0] + half[0])),
                       (float(middle[1] - half[1]), float(middle[1] + half[1])), caption=said, tab=STEP_TAB)


def _step(outcome: Outcome[Study]) -> TableFigure:
    s, k = outcome.study, int(outcome.design["k"])
    plan, updated = s.watcher.schedule, outcome.design["phase"] == "update"
    at = int(plan.index[k])
    mean, P = (s.track.means[k], plan.posterior[at]) if updated else (s.track.predicted[k], plan.prior[at])
    rows = tuple((f"{name} [{unit}]", f"{1e3 * s.truth.x[k, i]:.3f}".replace("-", "−"), f"{1e3 * mean[i]:.3f}".replace("-", "−"),
                  f"{1e3 * np.sqrt(P[i, i]):.3f}") for i, (name, unit) in enumerate(STATE_UNITS))
    return TableFigure("step", text("sample {k}", k=k),
                       (text("state"), text("true"), text("estimate"), same("σ")), rows, tab=STEP_TAB,
                       caption=text("t = {k:.2f} s; NIS of this sample {nis:.2f}.", k=k * DT, nis=s.nis[k]))


def _state(outcome: Outcome[Study], name: str, title: Text, i: int, unit: str) -> LineFigure:
    s = outcome.study
    spread, mean, e = 2e3 * np.sqrt(s.track.variances[:, i]), 1e3 * s.track.means[:, i], s.truth.x[:, i] - s.track.means[:, i]
    inside = 100 * float(np.mean(1e3 * np.abs(e[UNTESTED_SAMPLES:]) <= spread[UNTESTED_SAMPLES:]))
    return LineFigure(name, title, _time(outcome),
                      (Curve(text("true"), 1e3 * s.truth.x[:, i]), Curve(text("estimate"), mean, "estimate", "dash"),
                       Curve(same("+ 2σ"), mean + spread, "muted", "dot", 1.2), Curve(same("− 2σ"), mean - spread, "muted", "dot", 1.2)),
                      f"[{unit}]", window=(-10.0, 10.0), tab=TIME_TAB,
                      caption=text("After 2 s the truth is within the filter's own 2σ for {inside:.0f} % of the "
                                   "time; 95 % are expected.",
                                   inside=inside))


def _height(outcome: Outcome[Study]) -> LineFigure:
    return _state(outcome, "height", text("height of the deck z"), 1, "mm")


def _pitch(outcome: Outcome[Study]) -> LineFigure:
    return _state(outcome, "pitch", text("pitch of the deck θ"), 2, "mrad")


# --- gain ------------------------------------------------------------------------------------------------------------
def _gain(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    M, goal = s.track.gains[:100], s.watcher.steady.filter_gain
    shown = ((4, 0, "vz ← VL", "estimate"), (1, 0, "z ← VL", "force"), (3, 1, "vx ← HL", "second"))
    curves = [curve for i, j, name, role in shown for curve in (
        Curve(same(name), M[:, i, j], role), Curve(same(f"{name} ∞"), np.full(100, goal[i, j]), "reference", "dot", 1.2))]
    return LineFigure("gain", text("entries of the gain M"), _time(outcome)[:100], tuple(curves), "M", tab=GAIN_TAB,
                      window=(-0.1, 0.6), caption=text("Dotted: the steady gain from the Riccati equation."))


def _distance(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    goal = s.watcher.steady.filter_gain
    away = np.abs(s.track.gains - goal).max(axis=(1, 2)) / np.abs(goal).max()
    late = np.flatnonzero(away > 0.01)
    after, left = DT * (late[-1] + 1) if len(late) else 0.0, 100 * float(away[-1])
    return LineFigure("distance", text("distance to the Riccati gain"), _time(outcome),
                      (Curve(text("relative distance"), np.maximum(away, 1e-12), "error"),), "‖M − M∞‖ / ‖M∞‖",
                      log_y=True, window=(1e-10, 1.0), tab=GAIN_TAB,
                      caption=claim(text("Within 1 % after {after:.2f} s. No reading has any part in this.", after=after), left, below=1.0,
                                    otherwise=text("At the end it still differs by {left}. No reading has any part in this.",
                                                   left=apart(left / 100))))


def _forms(outcome: Outcome[Study]) -> LineFigure:
    f = outcome.study.forms
    short_gap, joseph_gap = float(f.short.max()), float(f.joseph.max())
    single = outcome.design["arithmetic"] == "single"
    lost = (text("; neither is a covariance any more.") if f.least_joseph < 0 else
            text("; the short form is no covariance any more.") if f.least_short < 0 else
            text("."))
    said = (text("Single precision: the short form is off by up to {short_gap:.1e}, Joseph's by "
                 "{joseph_gap:.1e}{lost}",
                 short_gap=short_gap, joseph_gap=joseph_gap, lost=lost) if single else
            text("With the final gain from the start the short form is wrong by up to {short_gap:.1e}; Joseph's "
                 "is right for every gain.",
                 short_gap=short_gap))
    return LineFigure("forms", text("two updates of P, distance to the right one"), _time(outcome)[:COMPARED_STEPS],
                      (Curve(text("short form"), np.maximum(f.short, 1e-12), "error"),
                       Curve(text("Joseph's form"), np.maximum(f.joseph, 1e-12), "force", "dash")), "‖ΔP‖ / ‖P‖", log_y=True,
                      window=(1e-9, 1.0), caption=said, tab=GAIN_TAB)


# --- innovations -------------------------------------------------------------------------------------------------------
def _innovation(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    spread, nu = 2e3 * np.sqrt(s.track.S[:, 0, 0]), 1e3 * s.track.innovations[:, 0]
    inside = 100 * float(np.mean(np.abs(nu[UNTESTED_SAMPLES:]) <= spread[UNTESTED_SAMPLES:]))
    return LineFigure("innovation", text("innovation of sensor VL"), _time(outcome),
                      (Curve(same("ν"), nu, "error", width=1.4), Curve(same("+ 2√S"), spread, "muted", "dot", 1.4),
                       Curve(same("− 2√S"), -spread, "muted", "dot", 1.4)), "ν [mm/s]", window=(-5.0, 5.0), tab=INNOVATION_TAB,
                      caption=text("After 2 s, {inside:.0f} % within 2√S; mean {scores:+.2f} of its σ.",
                                   inside=inside, scores=s.test.scores[0]))


def _correlation(outcome: Outcome[Study]) -> PlaneFigure:
    w = outcome.study.test.whiteness
    lags = np.arange(1, len(w.correlation) + 1, dtype=float)
    dashes = (("VL", "estimate", "solid"), ("HL", "second", "solid"), ("VR", "disturbance", "dash"), ("HR", "plant", "dash"))
    curves = [Curve(same(name), w.correlation[:, i], role, dash, 1.8, lags)  # type: ignore[arg-type]
              for i, (name, role, dash) in enumerate(dashes)]
    ends = np.array([lags[0], lags[-1]])
    curves += [Curve(text("band"), np.full(2, sign * w.band), "reference", "dot", 1.2, ends) for sign in (1, -1)]
    said = (text("No correlation found: p = {p_value:.2g}.", p_value=w.p_value) if w.white else
            coloured(w.p_value))
    return PlaneFigure("correlation", text("autocorrelation of the innovations over lag k"), tuple(curves), (),
                       "k", "r", (0.0, float(lags[-1] + 1)), (-0.6, 1.0), caption=said, tab=INNOVATION_TAB)


def _squares(outcome: Outcome[Study], name: str, title: Text, dof: int, values: np.ndarray, tried: np.ndarray | None) -> LineFigure:
    trials = outcome.study.trials
    count = 1 if trials is None else trials.count
    low, high = chi2_band(dof, count=count)
    shown, n = values if tried is None else tried, len(values)
    inside = 100 * float(np.mean((shown[UNTESTED_SAMPLES:] >= low) & (shown[UNTESTED_SAMPLES:] <= high)))
    who = text("One run") if trials is None else text("Mean of {count} runs", count=count)
    whose = text("one run") if trials is None else text("mean of {count} runs", count=count)
    return LineFigure(name, title, _time(outcome),
                      (Curve(whose, np.maximum(shown, 1e-3), "error", width=1.4),
                       Curve(text("expected, {dof}", dof=dof), np.full(n, float(dof)), "reference", "dash", 1.4),
                       Curve(text("95 % band"), np.full(n, high), "muted", "dot", 1.4),
                       Curve(text("lower edge"), np.full(n, low), "muted", "dot", 1.4)),
                      name.upper(), log_y=True, window=(0.1, 100.0), tab=TEST_TAB,
                      caption=text("{who}: after 2 s, {inside:.0f} % of the samples lie in the χ² band "
                                   "[{low:.3g}, {high:.3g}].",
                                   who=who, inside=inside, low=low, high=high))


def _nis(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    return _squares(outcome, "nis", text("NIS of a sample of four readings"), 4, s.nis,
                    None if s.trials is None else s.trials.nis)


def _nees(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    return _squares(outcome, "nees", text("NEES, six states"), 6, s.nees, None if s.trials is None else s.trials.nees)


def _tests(outcome: Outcome[Study]) -> GaugeFigure:
    s = outcome.study
    held = holds(s.test, s.settled)
    return GaugeFigure("tests", text("tests after 2 s"), gauges_of(s.test, s.settled, held, bias_is_judged(s.test), ".3f"), HEADS,
                       _verdict(outcome, all(held[name] for name in ("nis", "nees", "white", "centred"))), TEST_TAB)


def _verdict(outcome: Outcome[Study], quiet: bool) -> Text:
    """What the tests of one record mean: a right filter is flagged now and then, and a wrong one may pass."""
    d = outcome.design
    away = expected(d["noise"], d["q"], d["r"]).away
    if quiet:
        return claim(text("No test flags this filter."), away, below=1.0, otherwise=text(
            "No test flags this record, yet over all records this filter is found out."))
    return claim(text("Flagged by chance: each test flags a right filter in a few records of a hundred."), away, below=1.0,
                 otherwise=text("Over all records, too, this filter is wrong about itself."))


# --- spectra -----------------------------------------------------------------------------------------------------------
def _tracking(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    clean = s.truth.clean[UNTESTED_SAMPLES:, 0]
    guess = s.track.means[UNTESTED_SAMPLES:, :6] @ s.watcher.filter.C[0, :6]
    both = psd(1e3 * np.column_stack([clean, clean - guess]), 1 / DT, segment=len(clean))
    f, floor = both.frequency[1:], np.maximum(both.density[1:], 1e-9)
    near = int(np.argmin(np.abs(f - 0.16)))
    drop = 10 * np.log10(floor[near, 0] / floor[near, 1])
    said = (text("At 0.16 Hz the error lies {drop:.0f} dB below the output.", drop=drop)
            if drop >= 0 else
            text("At 0.16 Hz the error lies {drop:.0f} dB above the output.", drop=-drop))
    return over_frequency("tracking", text("output VL and its error"), f,
                           (Curve(text("true output"), floor[:, 0]),
                            Curve(text("output error"), floor[:, 1], "error", "dash")), "(mm/s)²/Hz", tab=SPECTRUM_TAB,
                           window=(1e-4, 1e3), caption=said)


def _colour(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    seen = psd(1e3 * s.track.innovations[UNTESTED_SAMPLES:, 0], 1 / DT, segment=64)
    f, promised = seen.frequency[1:], 2e6 * DT * float(s.track.S[-1, 0, 0])
    carried = outcome.design["noise"] == CARRIED
    low, high = (float(np.mean(seen.density[1:][part])) for part in (f < 3.0, f > 6.0))
    said = text("Below 3 Hz {low:.2g} times as dense as above 6 Hz; white noise is flat.", low=low / high)
    if carried:
        said = text("{said} The converter's noise is carried as 16 states.", said=said)
    return over_frequency("colour", text("spectrum of the innovation of VL"), f,
                           (Curve(text_in("kalman", "seen"), np.maximum(seen.density[1:], 1e-9), "error"),
                            Curve(text("predicted by S"), np.full(len(f), promised), "reference", "dash", 1.4)),
                           "(mm/s)²/Hz", window=(1e-2, 10.0), caption=said, tab=SPECTRUM_TAB)
