"""Draw the figures of lesson 14: one run, consistency, nonlinear laws, Algorithm 3."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.figures.records import Curve, LineFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.plants import cart_pendulum
from observer_lab.plants.bodies import falling_body
from observer_lab.plants.platform import model
from observer_lab.text import NO_WORDS, Text, format_number, joined, listed, same, text

from ..toolkit.figures import TIME_TAB
from .cases import EKF, FALL_CASE, KF, LENGTH, PENDULUM_CASE, PLATFORM, UKF, judged
from .cramer_rao import is_kalman, words
from .report_algorithms import NONE, REPORT_LINES, finding, linear_spreads
from .runs import FILTERS, Study
from .study import band_of, verdict

CONSISTENCY_TAB = text("Consistency")
LAW_TAB = text("Laws")
REPORT_TAB = text("Algorithm 3")
CURVE_STYLES = ((KF, "second", "dot"), (EKF, "estimate", "dash"), (UKF, "force", "solid"))
LOG_AXIS_FLOOR, LOG_AXIS_CEILING = 1e-3, 1e9
SHOWN_ERROR = 980.0  # m, largest error of the altitude that is drawn


def name_of(filter_: str) -> Text:
    """KF, EKF or UKF."""
    return same(filter_.upper())


def figures(outcome: Outcome[Study]) -> FigureSet:
    """Every figure of the lesson."""
    return FigureSet(tab_figures(TIME_TAB, lambda: (_state(outcome), _errors(outcome))),
                 tab_figures(CONSISTENCY_TAB, lambda: (_nees(outcome), _nis(outcome), _verdicts(outcome))),
                 tab_figures(LAW_TAB, lambda: (_law(outcome), _second_law(outcome))),
                 tab_figures(REPORT_TAB, lambda: (_algorithm(outcome), _lines(outcome))))


# --- one run ---------------------------------------------------------------------------------------------------------
def _state(outcome: Outcome[Study]) -> LineFigure:
    s, who = outcome.study, outcome.design["filter"]
    signal, falls = s.case.watched[0], s.case.id == FALL_CASE
    true, mean, sigma = signal.of(s.x), signal.of(s.means[who]), 3 * s.sigmas[who][:, s.case.state] * signal.scale
    inside = 100 * float(np.mean(np.abs(true - mean) <= sigma))
    if falls:  # metres against tens of kilometres: only the error can be seen
        true, mean = np.zeros_like(true), mean - true
    bound = SHOWN_ERROR if falls else 4 * float(np.max(np.abs(true))) + 1e-9
    title = text("error of the altitude in this run") if falls else signal.name
    return LineFigure("state", title, s.t, (
        Curve(text("true"), true),
        Curve(text("estimate, {who}", who=who.upper()), np.clip(mean, -bound, bound), "estimate", "dash"),
        Curve(same("+ 3σ"), np.clip(mean + sigma, -bound, bound), "muted", "dot", 1.2),
        Curve(same("− 3σ"), np.clip(mean - sigma, -bound, bound), "muted", "dot", 1.2)), f"[{signal.unit}]", tab=TIME_TAB,
        caption=text("In this run the truth is inside the {who}'s own 3σ for {inside:.0f} % of the time.",
                     who=who.upper(), inside=inside))


def _errors(outcome: Outcome[Study]) -> LineFigure:
    s, who = outcome.study, outcome.design["filter"]
    at = judged(s.case)
    signal = s.case.watched[at]
    state = int(np.argmax(np.abs(signal.weights)))
    curves = [Curve(name_of(n), np.clip(signal.scale * s.rms[n][:, at], 1e-9, LOG_AXIS_CEILING), role, dash)  # type: ignore[arg-type]
              for n, role, dash in CURVE_STYLES]
    claimed = np.clip(signal.scale * s.sigmas[who][:, state], 1e-9, LOG_AXIS_CEILING)
    curves.append(Curve(text("σ that the {who} computes", who=who.upper()), claimed, "muted", "dot", 1.6))
    curves.append(Curve(text("Cramér–Rao bound"), np.clip(signal.scale * s.bound.rms, 1e-9, LOG_AXIS_CEILING), "reference", "solid", 1.6))
    kicked = outcome.design["kick"] >= 0 and round(outcome.design["kick"] / s.case.step) < len(s.t)
    last = float(signal.scale * s.rms[who][-1, at] / max(claimed[-1], 1e-12))
    return LineFigure("errors", text("rms error: {name}", name=signal.name), s.t, tuple(curves),
                      f"[{signal.unit}]", log_y=True, tab=TIME_TAB,
                      caption=joined(text("Over {runs} runs. At the end the {who}'s errors are {last:.2g} times the σ that it computes "
                                          "in the run shown.",
                                          runs=s.runs, who=who.upper(), last=last),
                                     words(who, s.bound, s.runs, s.fallen + s.lost[who], kicked, is_kalman(outcome.design))))


# --- consistency -------------------------------------------------------------------------------------------------------
def shares(values: np.ndarray, band: tuple[float, float]) -> tuple[float, float]:
    """Shares of the samples inside a band and above it."""
    return float(np.mean((values >= band[0]) & (values <= band[1]))), float(np.mean(values > band[1]))


def _squares(outcome: Outcome[Study], id: str, title: Text, dof: int, values: Mapping[str, np.ndarray]) -> LineFigure:
    s = outcome.study
    band = band_of(dof, s.runs)
    curves = [Curve(name_of(n), np.clip(values[n], LOG_AXIS_FLOOR, LOG_AXIS_CEILING), role, dash) for n, role, dash in CURVE_STYLES]  # type: ignore[arg-type]
    curves += [Curve(text("expected: {dof}", dof=dof), np.full(len(s.t), float(dof)), "reference", "dash", 1.4),
               *(Curve(text("95 % band"), np.full(len(s.t), edge), "muted", "dot", 1.4) for edge in reversed(band))]
    inside = listed(same(f"{n.upper()} {100 * shares(values[n], band)[0]:.0f} %") for n in FILTERS)
    return LineFigure(id, title, s.t, tuple(curves), id.upper(), log_y=True, window=(0.1, 1e3), tab=CONSISTENCY_TAB,
                      caption=text("Mean of {runs} runs; samples inside [{low:.3g}, {high:.3g}]: {inside}.", runs=s.runs, low=band[0],
                                   high=band[1], inside=inside))


def _nees(outcome: Outcome[Study]) -> LineFigure:
    n = outcome.study.x.shape[1]
    return _squares(outcome, "nees", text("NEES, {n} states", n=n), n, outcome.study.nees)


def _nis(outcome: Outcome[Study]) -> LineFigure:
    p = len(outcome.study.case.R)
    return _squares(outcome, "nis", text("NIS, {p} readings", p=p) if p > 1 else text("NIS, 1 reading"), p,
                    outcome.study.nis)


def _verdicts(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study
    n = s.x.shape[1]
    rows = tuple((name_of(f), _short(float(np.mean(s.nees[f]))), _short(float(np.max(s.nees[f]))), f"{100 * s.honest[f]:.0f} %",
                  verdict(s.nees[f], n, s.runs)) for f in FILTERS)
    fell = (text("The pole fell in {fallen} of {runs} runs; they count until then.", fallen=s.fallen, runs=s.runs)
            if s.case.id == PENDULUM_CASE else NO_WORDS)
    lost = sum(s.lost.values())
    gone = (text("Filters given up because their covariance broke down: {lost}.", lost=lost)
            if lost else NO_WORDS)
    few = (text("Few runs say little about rare failures; the button tries many.")
           if s.runs < 50 else
           text("In 99 %: runs whose NEES ends below the 99 % point of χ²."))
    return TableFigure("verdicts", text("NEES over {runs} runs, {n} expected", runs=s.runs, n=n),
                       (text("filter"), text("mean"), text("largest"), text("in "
                                                                                                             "99 %"),
                        text("verdict")), rows, tab=CONSISTENCY_TAB,
                       caption=joined(few, fell, gone))


def _short(value: float) -> str:
    return format_number(value, ".3g") if value < 1e4 else f"{value:.1e}"


# --- laws ---------------------------------------------------------------------------------------------------------------
def _law(outcome: Outcome[Study]) -> PlaneFigure:
    s, d = outcome.study, outcome.design
    if s.case.id == PLATFORM:
        k = model.Parameters()
        e = np.linspace(-12, 12, 97)
        sigma = 1e3 * d["size"] * float(np.hypot(s.case.spread[1], k.a * s.case.spread[2]))
        bend = 1 + d["hardening"] * (1e-3 * e / LENGTH)**2
        at = 1 + d["hardening"] * (1e-3 * sigma / LENGTH)**2
        return _plane("law", text("pull of a vertical spring"), "e [mm]", "N", e, 1e-3 * k.kz * e * bend,
                      1e-3 * k.kz * e, sigma,
                      text("Stretched by the start's σ of {sigma:.2g} mm the spring pulls {at:.2f} times as hard as "
                           "the line says.",
                           sigma=sigma, at=at), (-25.0, 25.0))
    if s.case.id == PENDULUM_CASE:
        angle = np.linspace(-90, 90, 91)
        sigma = float(np.degrees(d["size"] * s.case.spread[1]))
        return _plane("law", text("pull of gravity on the pole"), "θ [°]", "m/s²", angle,
                      9.81 * np.sin(np.radians(angle)), 9.81 * np.radians(angle), sigma,
                      text("At the start's σ of {sigma:.3g}° the line is off by {sigma2:.2g} %.",
                           sigma=sigma, sigma2=100 * _sine_gap(sigma)), (-16.0, 16.0))
    k = falling_body.PARAMETERS
    h = np.linspace(0, 95, 96)
    seen = 1e-3 * np.hypot(k.side, 1e3 * h - k.height)
    start = float(s.case.guess[0])
    line = 1e-3 * (np.hypot(k.side, start - k.height)
                   + (start - k.height) / np.hypot(k.side, start - k.height) * (1e3 * h - start))
    return _plane("law", text("distance that the radar sees"), "h [km]", "km", h, seen, line, None,
                  text("At the radar's own height, 30.5 km, the distance has no slope: it says nothing about the "
                       "altitude."), (0.0, 80.0))


def _sine_gap(degrees: float) -> float:
    angle = np.radians(degrees)
    return float(angle / np.sin(angle) - 1)


def _plane(id: str, title: Text, x_label: str, y_label: str, x: np.ndarray, true: np.ndarray, line: np.ndarray,
           sigma: float | None, caption: Text, y_range: tuple[float, float]) -> PlaneFigure:
    points = () if sigma is None else tuple(
        Point(sign * sigma, float(np.interp(sign * sigma, x, true)), "estimate", "dot", same("σ" if sign < 0 else ""))
        for sign in (1.0, -1.0) if sigma <= float(x[-1]))
    bent, straight = ((y >= y_range[0]) & (y <= y_range[1]) for y in (true, line))
    curves = (Curve(text("law"), true[bent], "plant", "solid", 2.0, x[bent]),
              Curve(text("as the KF takes it"), line[straight], "reference", "dash", 1.4, x[straight]))
    return PlaneFigure(id, title, curves, points,
                       x_label, y_label, (float(x[0]), float(x[-1])), y_range, caption=caption, tab=LAW_TAB)


def _second_law(outcome: Outcome[Study]) -> PlaneFigure:
    s, d = outcome.study, outcome.design
    if s.case.id == PLATFORM:
        x = np.linspace(-12, 12, 97)
        factor = np.exp(-d["weakening"] * 1e-3 * x / LENGTH)
        low, high = 100 * (np.exp(-d["weakening"] * 0.002 / LENGTH) - 1), 100 * (np.exp(d["weakening"] * 0.002 / LENGTH) - 1)
        return _plane("law2", text("force constant of a coil"), "d [mm]", "k(d)/k(0)", x, factor, np.ones_like(x), None,
                      text("The coil is as strong at any gap.") if high < 0.5 else
                      text("The gap opening or closing by 2 mm changes the force by −{low:.0f} % or +{high:.0f} %.",
                           low=-low, high=high), (0.0, 3.0))
    if s.case.id == PENDULUM_CASE:
        k, angle = cart_pendulum.Parameters(), np.linspace(-90, 90, 91)
        push = np.cos(np.radians(angle)) / (k.cart + k.ball * np.sin(np.radians(angle))**2)
        return _plane("law2", text("how much a force on the cart turns the pole"), "θ [°]", "rad/s²/N", angle, push,
                      np.ones_like(angle), None, text("When the pole is horizontal, the cart can no longer turn it."), (0.0, 1.6))
    h = np.linspace(0, 95, 96)
    air = np.exp(-falling_body.PARAMETERS.density * 1e3 * h)
    return _plane("law2", text("density of the air"), "h [km]", "ρ/ρ₀", h, air, np.full_like(h, air[-1]), None,
                  text("Above 60 km the readings hardly depend on β. Below that height β becomes known "
                       "quickly."), (0.0, 1.0))


# --- the report ----------------------------------------------------------------------------------------------------------
def _algorithm(outcome: Outcome[Study]) -> LineFigure:
    s, d = outcome.study, outcome.design
    right, believed, real, _ = linear_spreads(s.case.id, d["wind"], d["sensor"])
    signal = s.case.watched[0]
    scale, t = signal.scale, s.case.step * np.arange(len(right))
    worse = float(real[-1] / right[-1] - 1)
    more = float(believed[-1] / right[-1] - 1)
    said = (text("The falling body has no process noise, so there is nothing to redraw for. Choose the platform.")
            if s.case.id == FALL_CASE else
            text("On the linear plant the σ of Algorithm 3 is {more:.1f} % above the Kalman filter's, and its error is {worse:.1f} % "
                 "larger.",
                 more=100 * more, worse=100 * worse))
    return LineFigure("algorithm", text("σ of: {name}", name=signal.name), t, (
        Curve(text("Kalman filter"), scale * right, "plant"),
        Curve(text("Algorithm 3, assumed"), scale * believed, "estimate", "dash"),
        Curve(text("Algorithm 3, real"), scale * real, "error", "dot")), f"[{signal.unit}]", log_y=True,
        caption=said, tab=REPORT_TAB)


def _lines(outcome: Outcome[Study]) -> TableFigure:
    chosen, s = outcome.design["line"], outcome.study
    gap = s.apart[UKF] if not outcome.design["redraw"] else linear_spreads(PLATFORM, 1.0, 1.0)[3]
    rows = tuple((label, finding(name, gap) if name == chosen else same("?")) for name, label in REPORT_LINES if name != NONE)
    return TableFigure("lines", text("lines of the report in doubt"),
                       (text("line"), text("what the engine finds")), rows, tab=REPORT_TAB,
                       caption=text("Choose a line with the knob; one of them makes a wrong filter of a linear "
                                    "plant."))
