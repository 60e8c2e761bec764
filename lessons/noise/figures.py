"""Draw the figures of lesson 8: error over speed, one run, many runs against Lyapunov."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.diagram import DiagramFigure
from observer_lab.course.figures.records import Curve, Figure, LineFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lesson import Outcome
from observer_lab.engine import chi2_band
from observer_lab.text import Text, format_number, same, squared_unit, text

from ..toolkit.diagram import loop
from ..toolkit.figures import TIME_TAB
from ..toolkit.knobs import untouched
from ..toolkit.shares import percent
from .knobs import SPRING_PLANT
from .study import Study

SPEED_TAB, RUNS_TAB = text("Speed"), text("Many runs")
SIGNAL_NAMES = (text("position"), text("velocity"))
SIGNAL_UNITS = ("m", "m/s")
BAND_PROBABILITY = 0.95
PLANNED = 400  # runs for which the band is drawn before any has been made


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything on the right of the stage."""
    i = int(outcome.design["watch"] == "velocity")
    return (_valley(outcome, i), _peaks(outcome), _shares(outcome), _measured(outcome), _velocity(outcome), _error(outcome, i),
            _variance(outcome, i), _loop(outcome))


def _loop(outcome: Outcome[Study]) -> DiagramFigure:
    assert outcome.run is not None
    return loop(SPRING_PLANT, outcome.run, outcome.gains["L"])


def _log(values: np.ndarray) -> np.ndarray:
    return np.log10(np.maximum(values, 1e-12))


def _valley(outcome: Outcome[Study], i: int) -> PlaneFigure:
    study, m = outcome.study, outcome.metrics
    ray, x = study.ray, _log(study.ray.speed)
    total = _log(ray.process[:, i] + ray.sensor[:, i]) / 2
    least = float(_log(np.sqrt(study.kalman.solution[i, i])))
    low = np.floor(2 * least) / 2 - 0.5
    now = float(_log(np.sqrt(study.parts.total[i, i])))
    points = [Point(float(_log(np.array(m["kalman_speed"]))), least, "reference", "circle", text("Kalman")),
              Point(float(_log(np.array(m["speed"]))), now, "estimate", "cross", text("yours"))]
    if study.trials is not None:
        tried = float(_log(np.sqrt(study.trials.square[-1, i])))
        points.append(Point(float(_log(np.array(m["speed"]))), tried, "error", "dot", text("runs")))
    return PlaneFigure(
        "valley", text("{names} error over observer speed", names=SIGNAL_NAMES[i]),
        (Curve(text("both noises"), total, "error", x=x),
         Curve(text("force noise"), _log(ray.process[:, i]) / 2, "disturbance", "dash", 1.8, x),
         Curve(text("sensor noise"), _log(ray.sensor[:, i]) / 2, "second", "dot", 1.8, x),
         Curve(text("least possible"), np.full(2, least), "reference", "dash", 1.2, np.array([-0.5, 2.5]))),
        tuple(points), "|p| [rad/s]", f"σ [{SIGNAL_UNITS[i]}]", (-0.5, 2.5), (float(low), float(low) + 3.0), tab=SPEED_TAB, powers="xy",
        caption=_valley_words(outcome, i))


def _valley_words(outcome: Outcome[Study], i: int) -> Text:
    study, m = outcome.study, outcome.metrics
    now, least = (float(np.sqrt(P[i, i])) for P in (study.parts.total, study.kalman.solution))
    if now < 1.005 * least:
        return text("σ = {now:.3g} {units}: this is the bottom.", now=now, units=SIGNAL_UNITS[i])
    total = study.ray.process[:, i] + study.ray.sensor[:, i]
    best = float(study.ray.speed[np.argmin(total)])
    share = percent(m["sensor_share"])
    away, gain = float(np.log(m["speed"] / best)), 100 * (now / float(np.sqrt(total.min())) - 1)
    turned = claim(text("Slower would be better."), away, above=0.0, otherwise=claim(text("Faster would be better."), away, below=0.0))
    advice = claim(text("No other speed is half a per cent better; only another pattern is."), gain, below=0.5, otherwise=turned)
    return text("σ = {now:.3g} {units}, {share} % of σ² from the sensor; the least is {least:.3g} {units}. "
                "{advice}",
                now=now, units=SIGNAL_UNITS[i], share=share, least=least, advice=advice)


def _peaks(outcome: Outcome[Study]) -> PlaneFigure:
    ray, m, d = outcome.study.ray, outcome.metrics, outcome.design["error0"]
    said = (text("With {d:.2g} m of starting error and the kick or pull the velocity estimate is wrong by up to "
                 "{peak:.3g} m/s.",
                 d=d, peak=m["peak"]) if not untouched(outcome.design) else
            text("With {d:.2g} m of starting error the velocity estimate is wrong by up to {peak:.3g} m/s.",
                 d=d, peak=m["peak"]))
    x, y = _log(ray.speed), _log(ray.peak)
    at = float(np.interp(_log(np.array(m["speed"])), x, y))
    return PlaneFigure(
        "peaks", text("peak of the velocity error, without noise"),
        (Curve(text("for 1 m of starting error"), y, "error", x=x),),
        (Point(float(_log(np.array(m["speed"]))), at, "estimate", "cross", text("yours")),),
        "|p| [rad/s]", "max|e₂| [m/s]", (-0.5, 2.5), (-0.5, 2.5), tab=SPEED_TAB, powers="xy",
        caption=said)


def _shares(outcome: Outcome[Study]) -> TableFigure:
    study = outcome.study
    rows = []
    for i, name in enumerate(SIGNAL_NAMES):
        parts = (study.parts.process, study.parts.sensor, study.parts.total, study.kalman.solution)
        tried = "—" if study.trials is None else format_number(np.sqrt(study.trials.square[-1, i]), ".3g")
        rows.append((text("{name} [{units}]", name=name, units=SIGNAL_UNITS[i]),
                     *(format_number(np.sqrt(P[i, i]), ".3g") for P in parts), tried))
    gap = float(np.linalg.eigvalsh(study.parts.total - study.kalman.solution)[0])
    worst = float(np.abs(study.kalman.solution).max())
    return TableFigure(
        "shares", text("σ of the settled error"),
        (text("error in"), text("force noise"), text("sensor noise"), text(
            "both"),
         text("least"), text("runs")), tuple(rows), tab=SPEED_TAB,
        caption=claim(text("P − P_min has no negative eigenvalue: no combination of errors is smaller than the Kalman "
                           "filter's."), gap, above=-1e-9 * worst, otherwise=text("P − P_min has a negative eigenvalue by rounding.")))


def _measured(outcome: Outcome[Study]) -> LineFigure:
    run = outcome.run
    assert run is not None
    noise = float(np.sqrt(outcome.design["v"] / run.scenario.dt))
    return LineFigure(
        "measured", text("position"), run.t,
        (Curve(text("measured"), run.y[:, 0], "muted", width=1.0), Curve(text("true"), run.x[:, 0]),
         Curve(text("estimate"), run.xhat[:, 0], "estimate", "dash")), "q [m]", window=(-0.5, 0.5), tab=TIME_TAB,
        caption=text("A single reading is off by σ = {noise:.2g} m; the settled estimate by {position_rms:.2g} m.",
                     noise=noise, position_rms=outcome.metrics["position_rms"]))


def _velocity(outcome: Outcome[Study]) -> LineFigure:
    run = outcome.run
    assert run is not None
    return LineFigure(
        "velocity", text("velocity"), run.t,
        (Curve(text("true"), run.x[:, 1]), Curve(text("estimate"), run.xhat[:, 1], "estimate", "dash")),
        "v [m/s]", window=(-0.5, 0.5), tab=TIME_TAB,
        caption=text("Nobody measures the velocity; its settled estimate is off by σ = {velocity_rms:.2g} m/s.",
                     velocity_rms=outcome.metrics["velocity_rms"]))


def error_curves(e: np.ndarray, quiet: np.ndarray, spread: np.ndarray) -> tuple[Curve, ...]:
    """The error of a run, its course without noise, and `spread` about that."""
    return (Curve(text("error"), e, "error"), Curve(text("without noise"), quiet, "reference", "dash", 1.4),
            Curve(same("+ 2σ"), quiet + spread, "muted", "dot", 1.4), Curve(same("− 2σ"), quiet - spread, "muted", "dot", 1.4))


def variance_curves(promised: np.ndarray, tried: np.ndarray | None, count: int) -> tuple[tuple[Curve, ...], float]:
    """The promised variance and its band over `count` runs, beside what the runs gave; percent of the instants inside, NaN before any."""
    low, high = chi2_band(1, count=count, level=BAND_PROBABILITY)
    curves = (Curve(text("Lyapunov"), promised, "reference", "dash"),
              Curve(text("95 % band, {count} runs", count=count), high * promised, "muted", "dot", 1.4),
              Curve(text("lower edge"), low * promised, "muted", "dot", 1.4))
    if tried is None:
        return curves, np.nan
    inside = (tried[1:] >= low * promised[1:]) & (tried[1:] <= high * promised[1:])
    return (*curves, Curve(text("runs"), tried, "error")), 100 * float(np.mean(inside))


def _error(outcome: Outcome[Study], i: int) -> LineFigure:
    run, study = outcome.run, outcome.study
    assert run is not None
    spread = 2 * np.sqrt(np.maximum(study.grown[:, i, i], 0.0))
    inside = 100 * float(np.mean(np.abs(run.e[:, i] - study.quiet[:, i]) <= spread + 1e-12))
    return LineFigure(
        "error", text("error of the {names}", names=SIGNAL_NAMES[i]), run.t,
        error_curves(run.e[:, i], study.quiet[:, i], spread), f"e [{SIGNAL_UNITS[i]}]", window=(-0.2, 0.2), tab=TIME_TAB,
        caption=text("{inside:.0f} % of this run lies within 2σ of the noise-free error; 95 % are expected on "
                     "average.",
                     inside=inside))


def _variance(outcome: Outcome[Study], i: int) -> LineFigure:
    run, study = outcome.run, outcome.study
    assert run is not None
    promised = study.grown[:, i, i]
    tried, count = (None, PLANNED) if study.trials is None else (study.trials.square[:, i], study.trials.count)
    curves, inside = variance_curves(promised, tried, count)
    if tried is None:
        said = text("No runs yet: press the button under the knobs.")
    else:
        said = text("{count} runs: the variance lies within its 95 % band at {inside:.0f} % of the instants; at "
                    "the end it is {tried:.3f} times the predicted one.",
                    count=count, inside=inside, tried=tried[-1] / promised[-1])
    return LineFigure("variance", text("variance of the {names} error", names=SIGNAL_NAMES[i]), run.t, curves,
                      f"[{squared_unit(SIGNAL_UNITS[i])}]", window=(0.0, float(1.3 * promised[-1])), caption=said, tab=RUNS_TAB)
