"""Draw the figures of lesson 1: two signals, input, errors, innovation, poles over trust."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, Figure, LineFigure, PlaneFigure, Point
from observer_lab.course.lesson import Outcome
from observer_lab.text import NO_WORDS, Text, joined, same, text

from ..toolkit.diagram import Press, loop
from ..toolkit.figures import TIME_TAB
from .knobs import MOST_TRUST
from .study import Study, late_peak

ERROR_TAB = text("Error")
TRUST_TAB = text("Trust")
TRUE, COPY, OBSERVER_LABEL = text("true"), text("open-loop copy"), text("observer")
REDUCED = text("reduced-order observer")
Range = tuple[float, float]


@dataclass(frozen=True, eq=False)
class View:
    """What a figure shows: its title and axis, the values `of` states, errors or inputs (n_t, n), its caption, its least range."""

    title: Text
    axis: str
    of: Callable[[np.ndarray], np.ndarray]
    words: Callable[[Outcome[Study]], Text]
    window: Range | None = None

    def drawn(self, id: str, outcome: Outcome[Study], curves: tuple[Curve, ...], tab: Text, log_y: bool = False) -> LineFigure:
        """The figure with these curves, as far as the shortest goes."""
        t = outcome.study.run.t[:min(len(curve.y) for curve in curves)]
        return LineFigure(id, self.title, t, curves, self.axis, log_y=log_y, tab=tab, window=self.window, caption=self.words(outcome))


@dataclass(frozen=True, eq=False)
class Look:
    """How the figures show a plant: a signal that nothing measures, an output, the input and its name, the error, the innovation.

    `locus`: paths and points of the poles as trust grows, what is said of them, and the ranges. The readings of `sensor` are drawn.
    """

    core: View
    case: View
    power: View
    input: Text
    error: View
    innovation: View
    locus: Callable[[Outcome[Study]], tuple[tuple[Curve, ...], tuple[Point, ...], Text, Range, Range]]
    sensor: bool = False


def figures(look: Look, outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Two signals and the input over time; the errors and what the observer hears; the poles as trust grows; the loop."""
    seen, run, copy = outcome.study, outcome.study.run, outcome.study.copy
    last = min(len(run.t), len(copy.t))

    def reduced(of: Callable[[np.ndarray], np.ndarray], estimate: Callable[[np.ndarray], np.ndarray]) -> tuple[Curve, ...]:
        return () if seen.reduced is None else (Curve(REDUCED, of(estimate(seen.reduced)), "disturbance", "solid", 1.4),)

    def both(view: View) -> tuple[Curve, ...]:
        return (Curve(TRUE, view.of(run.x[:last])), Curve(COPY, view.of(copy.xhat[:last]), "second", "dot"),
                *reduced(view.of, lambda x: x), Curve(OBSERVER_LABEL, view.of(run.xhat[:last]), "estimate", "dash"))
    reading = (Curve(text("sensor"), run.y[:, 0], "muted", "solid", 1.0),) if look.sensor and outcome.design["noise"] else ()
    errors = (*reduced(look.error.of, lambda x: run.x - x), Curve(COPY, look.error.of(copy.e[:last]), "second", "dot"),
              Curve(OBSERVER_LABEL, look.error.of(run.e[:last]), "error"))
    return (
        look.core.drawn("core", outcome, both(look.core), TIME_TAB),
        look.case.drawn("case", outcome, (*reading, *both(look.case)), TIME_TAB),
        look.power.drawn("power", outcome, (Curve(look.input, look.power.of(run.u_applied), "force"),), TIME_TAB),
        look.error.drawn("error", outcome, errors, ERROR_TAB, True),
        look.innovation.drawn("innovation", outcome, (Curve(same("y − ŷ"), look.innovation.of(run.y - run.yhat), "error"),), ERROR_TAB),
        _locus(look, outcome), _loop(outcome))


def _locus(look: Look, outcome: Outcome[Study]) -> PlaneFigure:
    """The poles that copy and observer have, on the paths of the poles as trust grows."""
    curves, points, need, across, up = look.locus(outcome)
    points = (*points, *(Point(float(p.real), float(p.imag), "second", "circle") for p in outcome.poles["copy"]),
              *(Point(float(p.real), float(p.imag), "estimate") for p in outcome.poles["observer"]))
    return PlaneFigure("locus", text("poles of A − θL₁C as trust grows"), curves, points, "Re s", "Im s", across, up, unstable=True,
                       tab=TRUST_TAB, caption=text("Circles: θ = 0, the copy. Crosses: θ = {trust:g} now. {need}",
                                                   trust=outcome.design["trust"], need=need))


def _loop(outcome: Outcome[Study]) -> Figure:
    """The plant and its observer as a block diagram; a press on L opens the correction, or closes it again."""
    opened = outcome.design["trust"] == 0
    words = text("Close the correction: θ = 1") if opened else text("Open the correction: θ = 0")
    press = Press("L", {"trust": 1.0 if opened else 0.0}, words)
    return loop(outcome.study.here.belief, outcome.study.run, outcome.gains["L"], press=press)


def late_innovation(outcome: Outcome[Study]) -> float:
    """The largest innovation of the first sensor in the last tenth of the run."""
    return late_peak((outcome.study.run.y - outcome.study.run.yhat)[:, 0])


# --- the chip --------------------------------------------------------------------------------------------------------
def _at_most(value: float) -> Text:
    return (text("at most {value:.2g} K", value=value) if value >= 1e-3 else
            text("less than 0.001 K"))


def _core_words(outcome: Outcome[Study]) -> Text:
    m = outcome.metrics
    after = text("The observer's error in the core is below 1 K after {after:.2f} s.", after=m["known_after"])
    soon = text("The core error is below 1 K from {after:.2f} s to the end of this run, but it grows.", after=m["known_after"])
    known = (text("At the end the observer's error in the core is still above 1 K.") if np.isinf(m["known_after"]) else
             claim(_noisy(m) if m["core_sigma"] > 0 else after, m["slowest_observer"], below=0.0, otherwise=soon))
    copied = text("In the last tenth of the run the copy is off by up to {off:.2g} K.", off=m["copy_core_error"])
    return joined(known, copied, _of_both(m))


def _of_both(m: Mapping[str, float]) -> Text:
    """What the reduced-order observer makes of the core, beside the full one; no words where it is switched off."""
    if "reduced_error" not in m:
        return NO_WORDS
    if not m["core_sigma"] or not np.isfinite(m["reduced_sigma"] + m["core_sigma"]):
        return text("In the last tenth of the run the reduced-order observer's core is off by up to {off:.2g} K.", off=m["reduced_error"])
    return text("Through the reduced-order observer the same noise gives {sigma:.2g} K.", sigma=m["reduced_sigma"])


def _noisy(m: Mapping[str, float]) -> Text:
    """With noise one record tells a time by chance: the standard deviation says how large the error stays."""
    return text("Sensor noise alone gives the core error a standard deviation of {sigma:.2g} K. Here it stays below 1 K from "
                "{after:.2f} s to the end.", sigma=m["core_sigma"], after=m["known_after"])


def _chip_locus(outcome: Outcome[Study]) -> tuple[tuple[Curve, ...], tuple[Point, ...], Text, Range, Range]:
    path = text("path of a pole")
    curves = tuple(Curve(path, branch.imag, "muted", width=1.6, x=branch.real) for branch in outcome.study.poles.T)
    least, most = outcome.study.stable
    need = (text("No θ up to 2 is stable with these poles.") if least >= min(most, MOST_TRUST) or most <= 0 else
            text("With these poles θ must lie between {least:.3f} and {most:.3f}.", least=max(least, 0.0), most=most)
            if most <= MOST_TRUST else
            text("This chip needs θ above {least:.3f}.", least=least) if least >= 0 else
            text("On this chip the error decays even at θ = 0, slowly."))
    return curves, (), need, (-5.0, 1.0), (-2.2, 2.2)


CHIP_LOOK = Look(
    View(text("core temperature (nobody can measure it)"), "T₁ [K]", lambda x: x[:, 0], _core_words, (0.0, 25.0)),
    View(text("case temperature (the sensor sits here)"), "T₂ [K]", lambda x: x[:, 1], lambda outcome: text(
        "In the last tenth of the run the observer's case is off by {gap}.", gap=_at_most(outcome.metrics["case_error"])), (0.0, 15.0)),
    View(text("computing power, known to all three"), "P [W]", lambda u: u[:, 0], lambda outcome: text(
        "Bursts of {peak:g} W; a quarter of it in between.", peak=float(np.max(outcome.study.run.u_applied))), (0.0, 20.0)),
    text("power"),
    View(text("size of the core error"), "|e₁| [K]", lambda e: np.abs(e[:, 0]), lambda outcome: text(
        "Slowest modes: copy {theirs:+.3g}, observer {ours:+.3g} per second.", theirs=outcome.metrics["slowest_copy"],
        ours=outcome.metrics["slowest_observer"]), (1e-4, 100.0)),
    View(text("innovation y − ŷ"), "y − ŷ [K]", lambda d: d[:, 0], lambda outcome: text(
        "Sensor minus prediction, {tail} in the last tenth of the run; L carries it "
        "into both states.", tail=_at_most(late_innovation(outcome))), (-10.0, 20.0)),
    _chip_locus, sensor=True)
