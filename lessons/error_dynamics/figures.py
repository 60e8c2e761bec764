"""Draw the figures of lesson 2: signals, force, error with and without force, notes page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from observer_lab.course.figures.curves import UNDER
from observer_lab.course.figures.records import Curve, Figure, LineFigure, TableFigure
from observer_lab.course.lesson import Outcome
from observer_lab.engine.simulation import Run
from observer_lab.text import format_number, same, text

from ..toolkit.diagram import loop
from ..toolkit.figures import TIME_TAB, error_words, state_figures
from .knobs import POSITION
from .notes_page import PLANT, notes_figures
from .study import Setting, Study, gain, left_alone

ERROR_TAB = text("Error")
SETTLED, WINDOW_STEPS = 0.01, 15  # share of the largest error that is no longer seen; steps of the run in which its figure is longer


def figures(here: Setting, outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Signals and force; the error with and without the force; the page of the notes."""
    run, twin = outcome.run, outcome.study
    assert run is not None
    d = outcome.design
    page = notes_figures(d["line"], gain(d.with_values(sensor=POSITION)), twin.plant is PLANT) if here.notes else ()
    return (*state_figures(here.model, run, 2), _force(here, run), _size(outcome, run, twin.quiet),
            _components(here, outcome, run, twin.quiet), _proof(here, outcome, run, twin.quiet), *page,
            loop(twin.plant, run, outcome.gains["L"], model=twin.belief))


def _force(here: Setting, run: Run) -> LineFigure:
    peak, unit = float(np.max(np.abs(run.u_applied))), here.model.input_unit
    calm = 0.5 * here.model.u_max if here.model.controller is not None else 1.0
    return LineFigure("force", text("force on the block, given to the observer") if here.notes else
                      text("input, given to the observer"), run.t,
                      (Curve(text("force") if here.notes else text("input"), run.u_applied[:, 0], "force"),),
                      f"u [{unit}]", tab=TIME_TAB, window=(-calm, calm),
                      caption=text("Largest input: {peak:.3g} {unit}.", peak=peak, unit=unit))


def _beside(quiet: np.ndarray, count: int) -> np.ndarray:
    """The quiet run's curve on the time axis of the steered one: cut, or held where it ended early."""
    return quiet[:count] if len(quiet) >= count else np.concatenate([quiet, np.full(count - len(quiet), quiet[-1])])


def _size(outcome: Outcome[Study], run: Run, quiet: Run) -> LineFigure:
    after = outcome.metrics["settled_after"]
    said = error_words(run, after if np.isfinite(after) else None)
    unstruck = outcome.study.unstruck
    calm = () if unstruck is None else (
        Curve(text("without the kick or pull"), _beside(np.linalg.norm(unstruck.e, axis=1), len(run.t)), "muted", "dot"),)
    return LineFigure("error", text("size of the error"), run.t, (
        *calm, Curve(text("with this input"), np.linalg.norm(run.e, axis=1), "error", width=UNDER),
        Curve(text("without input"), _beside(np.linalg.norm(quiet.e, axis=1), len(run.t)), "reference", "dash", 1.6)),
        "‖e‖", log_y=True, tab=ERROR_TAB, window=(1e-6, 1.0), caption=said)


def _components(here: Setting, outcome: Outcome[Study], run: Run, quiet: Run) -> LineFigure:
    m, dashes = outcome.metrics, ("solid", "dash")
    curves, units = [], []
    for (name, unit), signal, dash in zip(here.parts, here.model.watched, dashes, strict=False):
        units.append(unit)
        curves += [Curve(name, signal.of(run.e), "error", dash),  # type: ignore[arg-type]
                   Curve(text("{name} without input", name=name), _beside(signal.of(quiet.e), len(run.t)),
                         "reference", "dot", 1.4)]
    title = (text("error in position e₁ and velocity e₂") if here.notes else
             text("error in two signals"))
    calm = (-1.0, 1.0) if here.notes else None
    seen = _until_settled(run.t, [curve.y for curve in curves])
    return LineFigure("components", title, run.t[:seen], tuple(replace(curve, y=curve.y[:seen]) for curve in curves),
                      f"e [{', '.join(units)}]", tab=ERROR_TAB, window=calm,
                      caption=text("Largest gap between the curves with and without input: {error_moved:.1e}.",
                                   error_moved=m["error_moved"]))


def _until_settled(t: np.ndarray, signals: Sequence[np.ndarray]) -> int:
    """How many samples reach a little beyond the last time at which a signal is above SETTLED of the largest, in steps of a 15th."""
    sizes = np.nan_to_num(np.max(np.abs(np.stack(signals)), axis=0))
    last = int(np.flatnonzero(sizes >= SETTLED * sizes.max())[-1])
    step = max((len(t) - 1) / WINDOW_STEPS, 1.0)
    return min(int(math.ceil(1.15 * last / step) * step) + 1, len(t))


def _proof(here: Setting, outcome: Outcome[Study], run: Run, quiet: Run) -> TableFigure:
    if outcome.metrics["state_moved"] == 0:
        said = text("no input acts, so nothing parts.")
    elif left_alone(outcome.metrics):
        said = text("the outputs part, the errors do not.")
    else:
        said = text("here the errors part as well.")
    last, signal = min(len(run.t), len(quiet.t)) - 1, here.model.watched[0]
    at = sorted({min(round(share * (round(here.horizon / here.dt))), last) for share in (0.0, 0.1, 0.2, 0.4, 0.7, 1.0)})
    q, q0, e, e0 = (signal.of(x) for x in (run.x, quiet.x, run.e, quiet.e))
    clock = 1 if here.horizon >= 5 else 1 - math.floor(math.log10(here.horizon))
    rows = tuple((f"{run.t[k]:.{clock}f}", _digits(q[k], 4), _digits(q0[k], 4), _digits(e[k], 6),
                  _digits(e0[k], 6), _order(abs(e[k] - e0[k]))) for k in at)
    name = "q" if here.notes else "y₁"
    return TableFigure("proof", text("the proof in numbers"), (
        same("t [s]"), text("{name}, input", name=name), text("{name}, none", name=name), text("e₁, input"),
        text("e₁, none"), text("gap in e₁")), rows, tab=ERROR_TAB,
        caption=text("Two runs from one start, with this input and with none: {said}", said=said))


def _digits(value: float, places: int) -> str:
    return f"{round(float(value), places) + 0.0:.{places}f}".replace("-", "−")  # + 0.0: no minus before a zero


def _order(value: float) -> str:
    return format_number(value, ".0e") if value else "0"
