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

from .loop_rates import loop_rate, observer_rate

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
    met = text("At the end of the run the estimate has caught up with the truth.")
    return apart if growing and gap > 0 else claim(met, gap / max(size, 1e-300), below=1e-3, otherwise=apart)


def block_colours(n: int, triangular: bool) -> tuple[tuple[tuple[Text, str], ...], np.ndarray]:
    """The categories of a loop's matrix in (x, e), and the category of each cell: plant, observer, or effect of the error."""
    names = (same("A − BK"), same("BK"), *((same("A − LC"),) if triangular else (text("from e"), text("from x"))))
    kinds = np.array([[0, 1], [-1 if triangular else 3, 2]])
    return tuple(zip(names, ("plant", "force", "estimate", "error"), strict=False)), np.kron(kinds, np.ones((n, n), dtype=int))


def error_figure(run: Run, promised: np.ndarray | None = None) -> LineFigure:
    """The norm of the estimation error on a logarithmic axis, beside what ė = (A − LC)e promises."""
    size = np.linalg.norm(run.e, axis=1)
    curves = [Curve(same("‖e‖"), size, "error")]
    if promised is not None:
        curves.append(Curve(text("predicted by A − LC"), np.linalg.norm(promised, axis=1), "reference",
                            "dash", 1.6))
    caption = error_words(run, settle_time(*error_with_jumps(run)))
    return LineFigure("error", text("estimation error"), run.t, tuple(curves), "‖x − x̂‖", log_y=True,
                      caption=caption, tab=ERROR_TAB)


def error_with_jumps(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """t and ‖e‖ at the samples of a run and just after each kick, which may be over before the next sample."""
    t, size = run.t, np.linalg.norm(run.e, axis=1)
    for time, jump in run.scenario.impulses:
        k = int(np.searchsorted(t, time))
        if 0 < k < len(t) and t[k] > time and len(jump) == run.e.shape[1]:
            at = int(np.searchsorted(run.t, time)) - 1
            t, size = np.insert(t, k, time), np.insert(size, k, np.linalg.norm(run.e[at] + jump))
    return t, size


def rate_of_error(run: Run) -> float:
    """Below 0 where the error decays: by the poles of the observer, and by those of the loop where the state drives the error.

    The state drives the error through another model, a delay, or an input that is clipped unknown to the observer.
    """
    rate = observer_rate(run)
    if not _driven(run):
        return rate
    if run.scenario.K is None or not np.any(run.scenario.K):
        return np.inf  # whatever pushes the plant pushes the error too
    return max(rate, loop_rate(run))


def _driven(run: Run) -> bool:
    s = run.scenario
    return (s.model is not None and s.model is not s.plant) or bool(s.delay) or (s.fed != "applied" and run.saturated)


NOTHING = 1e-10  # of the largest state and estimate: an error below it is rounding


def no_error(run: Run) -> Text | None:
    """That the error is zero, where all of it is rounding; a share of its peak says nothing then."""
    scale = max(float(np.abs(run.x).max()), float(np.abs(run.xhat).max()), 1e-300)
    return text("The error is zero to rounding in the whole run.") if float(np.abs(run.e).max()) <= NOTHING * scale else None


def error_words(run: Run, after: float | None) -> Text:
    """What is said of the size of the error: zero; below 2 % of its peak after `after` s, for good or so far; or how it ends."""
    rate, dt = rate_of_error(run), run.scenario.plant.dt
    if (zero := no_error(run)) is not None:
        return zero
    if after is None:
        return (_growing(observer_rate(run), dt) if observer_rate(run) >= 0 else
                text("The error grows with the state: the loop is unstable.") if 0 < rate < np.inf else
                text("In the last twentieth of this run the error exceeds 2 % of its peak."))
    noisy, wound = run.scenario.V is not None or run.scenario.W is not None, _driven(run) and run.saturated
    if rate >= 0:
        return text("From {small:.2f} s to the end of this run the error is below 2 % of its peak, but nothing keeps it there.",
                    small=after)
    if noisy or wound:
        return text("From {small:.2f} s to the end of this run the error is below 2 % of its peak.", small=after)
    return claim(text("The error stays below 2 % of its peak after {small:.2f} s.", small=after), rate, below=0.0)


def _growing(rate: float, dt: float) -> Text:
    if rate == 0:
        return (text("The error does not decay: an observer pole is on the unit circle.") if dt else
                text("The error does not decay: an observer pole is on the imaginary axis."))
    return (text("The error grows: an observer pole is outside the unit circle.") if dt else
            text("The error grows: an observer pole is not in the left half plane."))


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
