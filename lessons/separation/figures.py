"""Draw the figures of lesson 4: signals, error, input, spectrum, block matrix, isolation."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.diagram import DIAGRAM
from observer_lab.course.figures.records import Curve, LineFigure, MatrixFigure, PlaneFigure, Point, over_frequency
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine import Plant, autonomous_error
from observer_lab.engine.systems import amplitude_response
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import NO_WORDS, Text, joined, text

from ..toolkit.diagram import loop
from ..toolkit.figures import ERROR_TAB, TIME_TAB, block_colours, error_figure, input_figure, state_figures
from ..toolkit.knobs import by_hand
from .study import Setting, Study

SPECTRUM_TAB = text("Poles")
COMMAND_TAB = text("Command")
FREQUENCY_TAB = text("Frequency")


def figures(here: Setting, outcome: Outcome[Study]) -> FigureSet:
    """Signals, error and input over time; the spectrum and the block-triangular matrix."""
    run, model, m = outcome.run, outcome.study.driven.model, outcome.study.driven.m
    assert run is not None
    limit = outcome.design["u_max"] if outcome.design["limited"] else None
    return FigureSet(tab_figures(TIME_TAB, lambda: state_figures(model, run)),
                 tab_figures(ERROR_TAB, lambda: (error_figure(run, autonomous_error(run)), input_figure(run, model, limit, m))),
                 tab_figures(COMMAND_TAB, lambda: (_command(here, outcome),)),
                 tab_figures(SPECTRUM_TAB, lambda: (_spectrum(outcome), _blocks(outcome.study))),
                 tab_figures(FREQUENCY_TAB, lambda: (_isolation(here, outcome),)),
                 tab_figures(DIAGRAM, lambda: (loop(model.plant, run, outcome.gains["L"], outcome.gains["K"]),)))


def _command(here: Setting, outcome: Outcome[Study]) -> LineFigure:
    """The commanded signal over time; with integral action beside the run without it, all else as it is."""
    target, study, truth = here.target, outcome.study, here.truth(outcome.design)
    r, refused, integral = target.value(outcome.design) * target.scale, study.driven.refused, study.driven.integral
    assert outcome.run is not None
    runs = study.runs.value[:2] if integral else (outcome.run,)
    t = min((run.t for run in runs), key=len)  # the shorter one, where a run has left every bound
    without, *rest = (target.along(run, truth)[:len(t)] for run in runs)
    gap = float(without[-1]) - r
    gaps = text("At the end of the run the error y − r is {without:.2g} {unit} without integral action and {with_integral:.2g} {unit} "
                "with it.", without=gap, with_integral=float(rest[0][-1]) - r, unit=target.unit) if integral else text(
                    "At the end of the run the error y − r is {without:.2g} {unit}.", without=gap, unit=target.unit)
    lost = [run for run in runs if run.diverged_at is not None]
    caption = refused if refused != NO_WORDS else text("A run is unstable and ends early.") if lost else gaps
    return LineFigure("command", text("command and output"), t,
                      (Curve(text("command"), np.full(len(t), r), "reference", "dot"),
                       Curve(text("without integral action"), without, "muted" if integral else "plant", "dash" if integral else "solid"),
                       *(Curve(text("with integral action"), each, "plant") for each in rest)),
                      target.axis, tab=COMMAND_TAB, caption=caption)


def _isolation(here: Setting, outcome: Outcome[Study]) -> LineFigure:
    """From a disturbance to an output: untouched, steered by the state, steered by the estimate."""
    truth = outcome.study.driven.truth
    K, n, loop = outcome.gains["K"], truth.n, outcome.study.loop
    more = n - len(here.ground)  # the integrator: no disturbance reaches it at once, and it is not seen
    A, B, C = truth.A, truth.B, np.pad(here.heard, ((0, 0), (0, more)))
    zg, w = np.pad(here.ground, ((0, more), (0, 0))), 2 * np.pi * here.frequencies

    def gain(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
        return np.clip(amplitude_response(a, b, c, [[0.0]], w)[:, 0, 0], 1e-12, 1e9)
    bare, state = gain(A, zg, C), gain(A - B @ K, zg, C)
    whole = gain(loop.A_xxhat, np.vstack([zg, np.zeros((n, 1))]), np.hstack([C, np.zeros((1, n))]))
    peak = 20 * np.log10(float(bare.max()) / float(whole.max()))
    return over_frequency(
        "isolation", here.heading[0], here.frequencies,
        (Curve(text("no control"), bare, "muted"),
         Curve(text("by the state"), state, "plant", "dash"),
         Curve(text("by the estimate"), whole, "estimate")), here.heading[1], tab=FREQUENCY_TAB,
        caption=_peak_words(outcome.study, here.truth(outcome.design), peak))


def _peak_words(study: Study, truth: Plant, peak: float) -> Text:
    """What steering by the estimate does to the peak, where there is a loop that settles and a peak to compare with."""
    if float(np.max(study.loop.poles.real)) >= 0:
        return text("This loop is unstable: it settles to no response, and its curve says nothing.")
    if not study.whole:
        return study.left_out()
    if float(np.max(np.real(truth.poles))) >= 0:
        return text("Without control the plant does not settle, so there is no peak to compare with.")
    lower = text("Feedback of the estimate lowers the peak by {peak:.1f} dB; the gap to the dashed line is the observer's share.",
                 peak=peak)
    return claim(lower, peak, above=0.0, otherwise=text("Feedback of the estimate raises the peak by {peak:.1f} dB.", peak=-peak))


def _spectrum(outcome: Outcome[Study]) -> PlaneFigure:
    groups = (("controller", "plant", "cross"), ("observer", "estimate", "cross"), ("loop", "reference", "circle"),
              ("compensator", "force", "dot"))
    points = tuple(Point(float(p.real), float(p.imag), role, mark)  # type: ignore[arg-type]
                   for key, role, mark in groups for p in outcome.poles[key])
    low = min(-1.0, *(p.x for p in points))
    high = max(2.0, *(abs(p.y) for p in points))
    return PlaneFigure(
        "spectrum", text("spectrum of the whole loop"), (), points, "Re s", "Im s",
        (1.1 * max(low, -60.0), max(3.0, 1.1 * min(60.0, max(p.x for p in points)))),
        (-1.1 * min(high, 60.0), 1.1 * min(high, 60.0)), unstable=True, tab=SPECTRUM_TAB,
        caption=joined(text("Crosses: chosen on the boards.") if by_hand(outcome.design) else text("Crosses: poles that the weights give."),
                       text("Circles: poles of the {count}-state loop. Green dots: the compensator's own.",
                            count=len(outcome.poles["loop"])), outcome.study.left_out()))


def _blocks(study: Study) -> MatrixFigure:
    loop, plant = study.loop, study.driven.truth
    n = loop.A_xe.shape[0] // 2
    names = [*(signal_name(plant, name) for name in plant.state_names), *(f"e{i + 1}" for i in range(n))]
    corner = float(np.max(np.abs(loop.A_xe[n:, :n])))
    zero = (text("The lower left block is zero: the error drives the state, never the other way round.") if study.whole else
            text("The lower left block of this matrix is zero."))
    said = claim(zero, corner / float(np.max(np.abs(loop.A_xe))), below=1e-9, otherwise=text(
        "The lower left block is no longer zero (largest entry {corner:.2g}): the state drives the error.", corner=corner))
    return MatrixFigure("blocks", text("the loop in (x, e) coordinates"), loop.A_xe, tuple(names), tuple(names), (n,), joined(
        said, study.left_out()), SPECTRUM_TAB, *block_colours(n, corner / float(np.max(np.abs(loop.A_xe))) < 1e-9))
