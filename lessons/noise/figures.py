"""Draw the figures of lesson 8: error of other observers, one run, many runs against Lyapunov."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import Curve, LineFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine import chi2_band
from observer_lab.plants import Signal
from observer_lab.text import format_number, same, squared_unit, text

from ..toolkit.figures import TIME_TAB
from .job import RUN_COUNT
from .study import Setting, Study

SPEED_TAB, RUNS_TAB = text("Speed"), text("Many runs")
BAND_PROBABILITY = 0.95
BESIDE = 2.2  # decade at which an observer stands that is none of the sweep


def figures(here: Setting, outcome: Outcome[Study]) -> FigureSet:
    """Everything on the right of the stage."""
    s = outcome.study
    return FigureSet(
        tab_figures(SPEED_TAB, lambda: (_valley(s), _peaks(s)), "late" if here.heavy else "open"),
        tab_figures(SPEED_TAB, lambda: (_shares(s),)),
        tab_figures(TIME_TAB, lambda: (
            _over_time(s, "measured", here.signals[0], Curve(text("measured"), s.run.y[:, 0], "muted", width=1.0)),
            _over_time(s, "velocity", here.signals[s.hidden]), _error(s))),
        tab_figures(RUNS_TAB, lambda: (_variance(s),)),
        *here.more(outcome),
    )


def _log(values: np.ndarray | float) -> np.ndarray:
    return np.log10(np.maximum(values, 1e-150))


def _unit(s: Study) -> str:
    return s.here.signals[s.judged].unit


def _valley(s: Study) -> PlaneFigure:
    look, i, x = s.here.look, s.judged, _log(s.sweep.along)
    process, sensor = s.sweep.process[:, i], s.sweep.sensor[:, i]
    total, least, now = _log(process + sensor) / 2, float(_log(s.deviation(s.least, i))), float(_log(s.deviation(s.parts.total, i)))
    at, kalman = look.places(s)
    at = BESIDE if at is None else at
    points = [Point(kalman, least, "reference", "circle", text("Kalman")), Point(at, now, "estimate", "cross", text("yours"))]
    if s.trials is not None:
        points.append(Point(at, float(_log(s.trials.square[-1, i])) / 2, "error", "dot", text("runs")))
    low = float(np.floor(2 * least) / 2 - 0.5)
    return PlaneFigure(
        "valley", look.over.format(name=s.here.signals[i].name),
        (Curve(text("both noises"), total, "error", x=x),
         Curve(look.process, _log(process) / 2, "disturbance", "dash", 1.8, x),
         Curve(text("sensor noise"), _log(sensor) / 2, "second", "dot", 1.8, x),
         Curve(text("least possible"), np.full(2, least), "reference", "dash", 1.2, np.array(look.ends))),
        tuple(points), look.axis, f"σ [{_unit(s)}]", look.ends, (low, low + float(np.clip(total.max() + 0.2 - low, *look.decades))),
        tab=SPEED_TAB, powers="xy", caption=look.captions["valley"](s))


def _peaks(s: Study) -> PlaneFigure:
    look, x, y = s.here.look, _log(s.sweep.along), _log(s.sweep.peak)
    at, (title, name, label) = look.places(s)[0], look.peak
    points = () if at is None else (Point(at, float(np.interp(at, x, y)), "estimate", "cross", text("yours")),)
    return PlaneFigure("peaks", title, (Curve(name, y, "error", x=x),), points, look.axis, label, look.ends,
                       look.peak_ends or (float(np.floor(y.min())) - 0.2, float(np.ceil(y.max())) + 0.2),
                       tab=SPEED_TAB, powers="xy", caption=look.captions["peaks"](s))


def _shares(s: Study) -> TableFigure:
    parts = (s.parts.process, s.parts.sensor, s.parts.total, s.least)
    rows = tuple((text("{name} [{unit}]", name=signal.name, unit=signal.unit),
                  *(format_number(s.deviation(P, i), ".3g") for P in parts),
                  "—" if s.trials is None else format_number(np.sqrt(s.trials.square[-1, i]), ".3g"))
                 for i, signal in enumerate(s.here.signals))
    return TableFigure(
        "shares", text("σ of the settled error"),
        (text("error in"), s.here.look.process, text("sensor noise"), text("both"), text("least"), text("runs")), rows, tab=SPEED_TAB,
        caption=s.here.look.captions["shares"](s))


def _over_time(s: Study, id: str, signal: Signal, *curves: Curve) -> LineFigure:
    look, both = s.here.look, (Curve(text("true"), signal.of(s.run.x)), Curve(text("estimate"), signal.of(s.run.xhat), "estimate", "dash"))
    return LineFigure(id, signal.name, s.run.t, (*curves, *both), look.labels.get(id, f"[{signal.unit}]"), window=look.windows.get(id),
                      tab=TIME_TAB, caption=look.captions[id](s))


def _error(s: Study) -> LineFigure:
    look, signal, spread = s.here.look, s.here.signals[s.judged], 2 * np.sqrt(np.maximum(s.grown[:, s.judged, s.judged], 0.0))
    e, quiet = signal.of(s.run.e)[:len(spread)], signal.of(s.quiet)
    inside = 100 * float(np.mean(np.abs(e - quiet) <= spread + 1e-12 * float(np.abs(e).max())))
    return LineFigure(
        "error", text("error of {name}", name=signal.name), s.run.t[:len(spread)],
        (Curve(text("error"), e, "error"), Curve(text("without noise"), quiet, "reference", "dash", 1.4),
         Curve(same("+ 2σ"), quiet + spread, "muted", "dot", 1.4), Curve(same("− 2σ"), quiet - spread, "muted", "dot", 1.4)),
        f"e [{signal.unit}]", window=look.windows.get("error"), tab=TIME_TAB,
        caption=text("{inside:.0f} % of this run lies within 2σ of the noise-free error; 95 % are expected on "
                     "average.",
                     inside=inside))


def _variance(s: Study) -> LineFigure:
    """The promised variance and its band over many runs, beside what the runs gave."""
    signal, i = s.here.signals[s.judged], s.judged
    promised, count = np.maximum(s.grown[:, i, i], 0.0), RUN_COUNT if s.trials is None else s.trials.count
    low, high = chi2_band(1, count=count, level=BAND_PROBABILITY)
    curves = [Curve(text("Lyapunov"), promised, "reference", "dash"),
              Curve(text("95 % band, {count} runs", count=count), high * promised, "muted", "dot", 1.4),
              Curve(text("lower edge"), low * promised, "muted", "dot", 1.4)]
    said = text("No runs yet: press the button under the knobs.")
    if s.trials is not None:
        tried = s.trials.square[:, i]
        curves.append(Curve(text("runs"), tried, "error"))
        inside = 100 * float(np.mean((tried[1:] >= low * promised[1:]) & (tried[1:] <= high * promised[1:])))
        said = text("{count} runs: the variance lies within its 95 % band at {inside:.0f} % of the instants.", count=count, inside=inside)
        if promised[-1] > 0:
            said = text("{count} runs: the variance lies within its 95 % band at {inside:.0f} % of the instants; at "
                        "the end it is {tried:.3f} times the predicted one.",
                        count=count, inside=inside, tried=tried[-1] / promised[-1])
    return LineFigure("variance", text("variance of the error of {name}", name=signal.name), s.run.t[:len(promised)], tuple(curves),
                      f"[{squared_unit(signal.unit)}]", window=(0.0, float(1.3 * promised[-1])) if promised[-1] > 0 else None,
                      caption=said, tab=RUNS_TAB)
