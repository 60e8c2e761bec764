"""Draw figures that many lessons share: signals with estimates, error, inputs."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, LineFigure
from observer_lab.engine.simulation import Run
from observer_lab.plants.model import Model, Signal
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import Text, joined, same, symbol, text, text_in

TIME_TAB = text("Time")
ERROR_TAB = text("Error and input")
INPUTS = MappingProxyType({"force": text("force"), "force 1": text("force 1"), "force 2": text("force 2"),
                           "voltage": text_in("signal", "voltage")})


BEYOND = text("Points beyond the scale are drawn at its edge.")


def state_figures(model: Model, run: Run, count: int = 3) -> tuple[LineFigure, ...]:
    """The watched signals with their estimates, one figure each."""
    figures = []
    for i, signal in enumerate(model.watched[:count]):
        true, guess = signal.of(run.x), signal.of(run.xhat)
        gap = float(np.max(np.abs(true[-max(len(true) // 10, 1):] - guess[-max(len(true) // 10, 1):])))
        figures.append(LineFigure(
            f"state{i}", signal.name, run.t,
            (Curve(text("true"), true), Curve(text("estimate"), guess, "estimate", "dash")),
            axis_name(signal), tab=TIME_TAB,
            caption=_agreement(gap, float(np.max(np.abs(true), initial=0.0)), signal.unit, rate_of_error(run) >= 0)))
    return tuple(figures)


def axis_name(signal: Signal) -> str:
    """The symbol at the end of a signal's name with its unit, or the unit alone."""
    last = signal.name("en").split()[-1]
    unit = f"[{signal.unit}]" if signal.unit else ""
    return f"{last} {unit}".strip() if len(last) <= 2 else unit


def _agreement(gap: float, size: float, unit: str, growing: bool) -> Text:
    """How well an estimate agrees with the truth in the last tenth of a run; an error that does not die out is not caught up."""
    apart = text("In the last tenth of the run they differ by up to {gap:.2g} {unit}.", gap=gap, unit=unit)
    met = text("The estimate has caught up with the truth.")
    return apart if growing and gap > 0 else claim(met, gap / max(size, 1e-300), below=1e-3, otherwise=apart)


def error_figure(run: Run, promised: np.ndarray | None = None) -> LineFigure:
    """The norm of the estimation error on a logarithmic axis, beside what ė = (A − LC)e promises."""
    size = np.linalg.norm(run.e, axis=1)
    curves = [Curve(same("‖e‖"), size, "error")]
    if promised is not None:
        curves.append(Curve(text("promised by A − LC"), np.linalg.norm(promised, axis=1), "reference",
                            "dash", 1.6))
    caption = no_error(run) or settled_words(settle_time(run.t, size), rate_of_error(run))
    return LineFigure("error", text("estimation error"), run.t, tuple(curves), "‖x − x̂‖", log_y=True,
                      caption=caption, tab=ERROR_TAB)


def rate_of_error(run: Run) -> float:
    """Below 0 where the error dies out: the rightmost eigenvalue of A − LC of the model, ln |z| where it is sampled.

    An error that the state drives (another model, a delay, an input clipped unknown to the observer) dies out with the state only.
    """
    s = run.scenario
    model = s.plant if s.model is None else s.model
    rate = _rate(model.A if s.L is None else model.A - s.L @ model.C, model.dt)
    if model is s.plant and not s.delay and (s.fed == "applied" or not run.saturated):
        return rate
    if s.K is None or not np.any(s.K):
        return np.inf  # whatever pushes the plant pushes the error too
    size = np.linalg.norm(run.x, axis=1)
    late = float(size[-max(len(size) // 10, 1):].max())
    return max(rate, _rate_of_loop(run), float(np.log(2 * max(late, 1e-300) / max(float(size.max()), 1e-300))))


def _rate(A: np.ndarray, dt: float) -> float:
    poles = np.linalg.eigvals(A)
    return float(np.log(max(np.max(np.abs(poles)), 1e-300)) if dt else np.max(np.real(poles)))


def _rate_of_loop(run: Run) -> float:
    """Of plant and observer together, without the limit; a state that is quiet for a while may be pushed again by an unstable loop."""
    s, K, L = run.scenario, run.scenario.K, run.scenario.L
    plant, model = s.plant, s.plant if s.model is None else s.model
    if K is None or L is None or s.delay:
        return -np.inf
    A, B, C, D = plant.A, plant.B, plant.C, plant.D - model.D
    return _rate(np.block([[A, -B @ K], [L @ C, model.A - model.B @ K - L @ model.C - L @ D @ K]]), plant.dt)


NOTHING = 1e-10  # of the largest state and estimate: an error below it is rounding


def no_error(run: Run) -> Text | None:
    """That the error is zero, where all of it is rounding; a share of its peak says nothing then."""
    scale = max(float(np.abs(run.x).max()), float(np.abs(run.xhat).max()), 1e-300)
    return text("The error is zero to rounding in the whole run.") if float(np.abs(run.e).max()) <= NOTHING * scale else None


def settled_words(after: float | None, rate: float) -> Text:
    """When the error is down to 2 % of its peak: for good only where the poles of the observer say so."""
    if after is None:
        return text("The error does not settle within this run.")
    return claim(text("The error stays below 2 % of its peak after {small:.2f} s.", small=after), rate, below=0.0, otherwise=text(
        "From {small:.2f} s to the end of this run the error is below 2 % of its peak, but nothing keeps it there.", small=after))


def input_figure(run: Run, model: Model, limit: float | None = None, count: int | None = None) -> LineFigure:
    """Inputs asked (dashed) and applied (solid), with the limits; of several inputs the first `count`."""
    curves = []
    for j, name in enumerate(run.scenario.plant.input_names[:count]):
        role = ("force", "disturbance", "second")[j % 3]
        applied, asked = run.u_applied[:, j] * model.input_scale, run.u_asked[:, j] * model.input_scale
        shown = (text("input {name}", name=signal_name(model.plant, name)) if model.controller is not None else
                 INPUTS.get(name, same(symbol(name))))
        curves.append(Curve(shown, applied, role))
        if not np.array_equal(applied, asked):
            curves.append(Curve(text("{shown} asked", shown=shown), asked, role, "dash", 1.6))
    if limit is not None:
        flat = np.full(len(run.t), limit * model.input_scale)
        curves += [Curve(text("limit"), sign * flat, "reference", "dot", 1.4) for sign in (1, -1)]
    peak = float(np.max(np.abs(run.u_applied[:, :count]))) * model.input_scale
    return LineFigure("input", text("input, asked and applied"), run.t, tuple(curves),
                      f"u [{model.input_unit}]", tab=ERROR_TAB,
                      caption=text("Largest input applied: {peak:.3g} {input_unit}.",
                                   peak=peak, input_unit=model.input_unit))


def within(figure: LineFigure, edge: float) -> LineFigure:
    """The figure with values beyond ±edge drawn at the edge, which its caption then says: a lost loop leaves every scale."""
    if all(np.all(np.abs(c.y) <= edge) for c in figure.curves):
        return figure
    return replace(figure, curves=tuple(replace(c, y=np.clip(c.y, -edge, edge)) for c in figure.curves),
                   caption=joined(figure.caption, BEYOND))


def settle_time(t: np.ndarray, size: np.ndarray, share: float = 0.02) -> float | None:
    """When `size` goes below a share of its peak for good; None if it does not, or only in the last twentieth of the run."""
    above = np.flatnonzero(size > share * float(np.max(size, initial=0.0)))
    if not len(above):
        return 0.0
    return None if above[-1] >= 0.95 * (len(t) - 1) else float(t[above[-1] + 1])
