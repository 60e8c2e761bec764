"""Draw the figures of lesson 1: core, case, power, errors, innovation, poles over trust."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, DiagramFigure, Figure, LineFigure, PlaneFigure, Point
from observer_lab.course.lesson import Outcome
from observer_lab.engine.simulation import Run
from observer_lab.plants import chip
from observer_lab.text import NO_WORDS, Text, joined, same, text

from ..toolkit.diagram import Press, loop
from ..toolkit.figures import TIME_TAB
from .knobs import MOST_TRUST
from .study import S, Study

ERROR_TAB = text("Error")
TRUST_TAB = text("Trust")
TRUE, COPY, OBSERVER_LABEL = text("true"), text("open-loop copy"), text("observer")
REDUCED = text("reduced-order observer")


def _at_most(value: float) -> Text:
    return (text("at most {value:.2g} K", value=value) if value >= 1e-3 else
            text("less than 0.001 K"))


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Core, case and power over time; the errors and what the observer hears; the poles as trust grows."""
    run, seen = outcome.run, outcome.study
    assert run is not None
    return (_core(outcome, run, seen.copy), _case(outcome, run, seen.copy), _power(run), _errors(outcome, run, seen.copy),
            innovation_figure(run, "y − ŷ [K]", _carried, (-10.0, 20.0)), _locus(outcome, seen), _loop(outcome, run))


def with_estimates(run: Run, copy: Run, of: Callable[[np.ndarray], np.ndarray], *between: Curve) -> tuple[Curve, ...]:
    """A signal of the states and both estimates of it, as far as both runs go."""
    last = min(len(run.t), len(copy.t))
    return (Curve(TRUE, of(run.x[:last])), Curve(COPY, of(copy.xhat[:last]), "second", "dot"), *between,
            Curve(OBSERVER_LABEL, of(run.xhat[:last]), "estimate", "dash"))


def errors_figure(run: Run, copy: Run, of: Callable[[np.ndarray], np.ndarray], title: Text, label: str, caption: Text, *further: Curve,
                  window: tuple[float, float] | None = None) -> LineFigure:
    """The size of both errors."""
    last = min(len(run.t), len(copy.t))
    return LineFigure("error", title, run.t[:last], (*further, Curve(COPY, of(copy.e[:last]), "second", "dot"),
                                                     Curve(OBSERVER_LABEL, of(run.e[:last]), "error")),
                      label, log_y=True, tab=ERROR_TAB, window=window, caption=caption)


def innovation_figure(run: Run, label: str, words: Callable[[float], Text], window: tuple[float, float] | None = None) -> LineFigure:
    """The first reading less its prediction; `words` of the largest in the last tenth of the run."""
    heard = (run.y - run.yhat)[:, 0]
    return LineFigure("innovation", text("innovation y − ŷ"), run.t, (Curve(same("y − ŷ"), heard, "error"),), label, tab=ERROR_TAB,
                      window=window, caption=words(float(np.max(np.abs(heard[-max(len(heard) // 10, 1):])))))


def locus_figure(outcome: Outcome[S], curves: tuple[Curve, ...], points: tuple[Point, ...], need: Text,
                 across: tuple[float, float], up: tuple[float, float]) -> PlaneFigure:
    """The poles that copy and observer have, on the paths of the poles as trust grows."""
    points = (*points, *(Point(float(p.real), float(p.imag), "second", "circle") for p in outcome.poles["copy"]),
              *(Point(float(p.real), float(p.imag), "estimate") for p in outcome.poles["observer"]))
    return PlaneFigure("locus", text("poles of A − θL₁C as trust grows"), curves, points, "Re s", "Im s", across, up, unstable=True,
                       tab=TRUST_TAB, caption=text("Circles: θ = 0, the copy. Crosses: θ = {trust:g} now. {need}",
                                                   trust=outcome.design["trust"], need=need))


def _core(outcome: Outcome[Study], run: Run, copy: Run) -> LineFigure:
    m = outcome.metrics
    after = text("The observer's error in the core is below 1 K after {after:.2f} s.", after=m["known_after"])
    soon = text("The core error is below 1 K from {after:.2f} s to the end of this run, but it grows.", after=m["known_after"])
    known = (text("At the end the observer's error in the core is still above 1 K.") if np.isinf(m["known_after"]) else
             claim(_noisy(m) if m["core_sigma"] > 0 else after, m["slowest_observer"], below=0.0, otherwise=soon))
    copied = text("In the last tenth of the run the copy is off by up to {off:.2g} K.", off=m["copy_core_error"])
    return LineFigure("core", text("core temperature (nobody can measure it)"), run.t,
                      with_estimates(run, copy, lambda x: x[:, 0], *_reduced(outcome.study, 0)), "T₁ [K]", tab=TIME_TAB,
                      window=(0.0, 25.0), caption=joined(known, copied, _of_both(m)))


def _reduced(seen: Study, state: int) -> tuple[Curve, ...]:
    """The estimate of the reduced-order observer, where it is switched on."""
    return () if seen.reduced is None else (Curve(REDUCED, seen.reduced[:, state], "disturbance", "solid", 1.4),)


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


def _case(outcome: Outcome[Study], run: Run, copy: Run) -> LineFigure:
    gap = _at_most(outcome.metrics["case_error"])
    reading = (Curve(text("sensor"), run.y[:, 0], "muted", "solid", 1.0),) if outcome.design["noise"] else ()
    return LineFigure("case", text("case temperature (the sensor sits here)"), run.t,
                      (*reading, *with_estimates(run, copy, lambda x: x[:, 1], *_reduced(outcome.study, 1))), "T₂ [K]", tab=TIME_TAB,
                      window=(0.0, 15.0), caption=text("In the last tenth of the run the observer's case is off by {gap}.", gap=gap))


def _power(run: Run) -> LineFigure:
    peak = float(np.max(run.u_applied))
    return LineFigure("power", text("computing power, known to all three"), run.t,
                      (Curve(text("power"), run.u_applied[:, 0], "force"),), "P [W]", tab=TIME_TAB,
                      window=(0.0, 20.0), caption=text("Bursts of {peak:g} W; a quarter of it in between.",
                                                       peak=peak))


def _errors(outcome: Outcome[Study], run: Run, copy: Run) -> LineFigure:
    ours, theirs = outcome.metrics["slowest_observer"], outcome.metrics["slowest_copy"]
    seen = outcome.study
    reduced = () if seen.reduced is None else (Curve(REDUCED, np.abs(run.x[:, 0] - seen.reduced[:, 0]), "disturbance", "solid", 1.4),)
    return errors_figure(run, copy, lambda e: np.abs(e[:, 0]), text("size of the core error"), "|e₁| [K]",
                         text("Slowest modes: copy {theirs:+.3g}, observer {ours:+.3g} per second.", theirs=theirs, ours=ours),
                         *reduced, window=(1e-4, 100.0))


def _carried(late: float) -> Text:
    return text("Sensor minus prediction, {tail} in the last tenth of the run; L carries it "
                "into both states.",
                tail=_at_most(late))


def _locus(outcome: Outcome[Study], seen: Study) -> PlaneFigure:
    path = text("path of a pole")
    curves = tuple(Curve(path, branch.imag, "muted", width=1.6, x=branch.real) for branch in seen.poles.T)
    least, most = seen.stable
    need = (text("No θ up to 2 is stable with these poles.") if least >= min(most, MOST_TRUST) or most <= 0 else
            text("With these poles θ must lie between {least:.3f} and {most:.3f}.", least=max(least, 0.0), most=most)
            if most <= MOST_TRUST else
            text("This chip needs θ above {least:.3f}.", least=least) if least >= 0 else
            text("On this chip the error decays even at θ = 0, slowly."))
    return locus_figure(outcome, curves, (), need, (-5.0, 1.0), (-2.2, 2.2))


def _loop(outcome: Outcome[Study], run: Run) -> DiagramFigure:
    """The chip and its observer as a block diagram; a press on L opens the correction, or closes it again."""
    opened = outcome.design["trust"] == 0
    words = text("Close the correction: θ = 1") if opened else text("Open the correction: θ = 0")
    return loop(chip.plant(), run, outcome.gains["L"], press=Press("L", {"trust": 1.0 if opened else 0.0}, words))
