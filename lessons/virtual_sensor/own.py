"""Fit lesson 1 to the user's own plant: open-loop copy beside an observer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from observer_lab.course.figures.records import Curve, Figure, LineFigure, PlaneFigure, Point
from observer_lab.course.knobs import Knob, Number, Poles
from observer_lab.course.lesson import Design, Lesson, Outcome
from observer_lab.engine import Plant
from observer_lab.engine.simulation import Run
from observer_lab.engine.systems import sorted_poles
from observer_lab.plants import Model, Signal
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import NO_WORDS, Text, joined, text

from ..toolkit.figures import TIME_TAB
from ..toolkit.gains import injection, sizes, sped
from ..toolkit.knobs import run_knobs
from .derive import derived_own
from .figures import errors_figure, innovation_figure, locus_figure, with_estimates
from .knobs import MOST_TRUST
from .study import outcome_of, tried_on

KNOWN_ERROR_SHARE = 0.05  # of the first error: below this a signal counts as known
FEW_POINTS, MANY_POINTS = 13, 41  # points of the locus, for many states and for few


@dataclass(frozen=True, eq=False)
class OwnStudy:
    """What the figures need beside the observer's run."""

    copy: Run
    poles: np.ndarray  # (n_trusts, n), sorted: no path is drawn between them
    secret: Signal


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """Trust, poles, first guess, a wrong model, an input and noise."""
    window = model.observer_window
    return (
        Number("trust", r"\theta", text("trust in the sensors θ"), low=0.0, high=MOST_TRUST, default=1.0,
               step=0.01, hint=text("The gain is θ times the one for the poles below; θ = 0 is the open-loop copy.")),
        Poles("observer_poles", "q", text("Observer poles at θ = 1"), "rad/s",
              default=model.observer_poles, re_low=window.re_low, re_high=window.re_high, im_high=window.im_high,
              role="estimate", hidden=not model.observer_poles,
              hint=text("The error dies as fast as the rightmost of these.")),
        Number("guess", r"\gamma", text("first guess, share of the true start"), low=-1.0, high=2.0,
               default=0.0, step=0.05, hint=text("0: copy and observer start at rest; 1: exactly where the plant "
                                                 "is.")),
        Number("mismatch", r"\delta", text("the plant is faster than its model by"), "%", low=-50.0, high=50.0,
               default=0.0, step=1.0, hint=text("A and B of the real plant are this much larger than those of both models.")),
        Number("push", "u", text("input, on and off"), model.input_unit, low=0.0, high=5 * model.u_max,
               default=model.u_max, hint=text("The first input is on for one half of each period; plant, copy and observer all get it.")),
        Number("noise", r"\sigma", text("sensor noise"), "%", low=0.0, high=20.0, default=0.0, step=0.5,
               hint=text("Standard deviation of a sample, as a share of the outputs at the start.")),
        *run_knobs(model.horizon),
    )


def compute(model: Model, design: Design) -> Outcome[OwnStudy]:
    """One run each of observer and copy; the copy's figures end where the observer's run does."""
    belief, full = model.plant, injection(model.plant, design["observer_poles"], model)
    count, unit = round(model.horizon / model.dt) + 1, sizes(model)
    push = np.zeros((count, belief.m))
    push[:, 0] = np.where((4 * np.arange(count) // count) % 2 == 0, design["push"], 0.0)
    tried = tried_on(
        model, design, (sped(belief, design["mismatch"]), belief), full, sorted_poles, [design["guess"] * v for v in model.x0], push,
        np.diag((design["noise"] / 100 * unit) ** 2) * model.dt if design["noise"] else None)
    seen = OwnStudy(tried.copy, _locus(belief, full), _secret(model))
    error, alone = (seen.secret.of(r.e) for r in (tried.run, tried.copy))
    metrics = {**tried.rates, "secret_error": _late(error), "copy_secret_error": _late(alone), "first_error": float(abs(error[0]))}
    return outcome_of(tried, model.observer_window, "L", metrics, _live(metrics), seen)


def _secret(model: Model) -> Signal:
    """The first watched signal that is no output, else the first output."""
    return next((s for s in model.watched if s.name("en").startswith("state")), model.watched[0])


def _late(values: np.ndarray) -> float:
    return float(np.abs(values[-max(len(values) // 10, 1):]).max())


def _size(values: np.ndarray) -> np.ndarray:
    return np.linalg.norm(values, axis=1)


def _locus(plant: Plant, full: np.ndarray) -> np.ndarray:
    trusts = np.linspace(0.0, MOST_TRUST, MANY_POINTS if plant.n <= 8 else FEW_POINTS)
    return sorted_poles(plant.A - trusts[:, None, None] * (full @ plant.C))


def _live(m: dict[str, float]) -> Text:
    ours, theirs = m["slowest_observer"], m["slowest_copy"]
    doubt = (text("Not every wrong start of the observer decays.") if m["slowest_observer"] >= 0 else NO_WORDS)
    return joined(text("Slowest modes of the error: copy {theirs:+.3g}, observer {ours:+.3g} per second.",
                       theirs=theirs, ours=ours), doubt)


def figures(model: Model, outcome: Outcome[OwnStudy]) -> tuple[Figure, ...]:
    """A signal that nothing measures, an output, the input; the errors and what the observer hears; poles over trust."""
    run, seen = outcome.run, outcome.study
    assert run is not None
    return (_signal("core", seen.secret, run, seen.copy), _signal("case", model.watched[0], run, seen.copy) if
            seen.secret is not model.watched[0] else _energy(run, seen.copy), _input(model, run), _errors(outcome, run),
            _heard(model, run), _plane(model, outcome))


def _signal(name: str, signal: Signal, run: Run, copy: Run) -> LineFigure:
    curves = with_estimates(run, copy, signal.of)
    true, other, guess = (curve.y for curve in curves)
    return LineFigure(name, signal.name, run.t[:len(true)], curves, f"[{signal.unit}]", tab=TIME_TAB,
                      caption=text("At the end of the run the observer is off by {true:.2g}, the copy by "
                                   "{true2:.2g} {unit}.",
                                   true=abs(true[-1] - guess[-1]), true2=abs(true[-1] - other[-1]),
                                   unit=signal.unit))


def _energy(run: Run, copy: Run) -> LineFigure:
    """The size of the state, for a plant all of whose states are measured."""
    curves = with_estimates(run, copy, _size)
    return LineFigure("case", text("size of the whole state"), run.t[:len(curves[0].y)], curves, "‖x‖", tab=TIME_TAB,
                      caption=text("Every state of this plant is measured."))


def _input(model: Model, run: Run) -> LineFigure:
    return LineFigure("power", text("first input, known to all three"), run.t,
                      (Curve(text("input"), run.u_applied[:, 0], "force"),), f"[{model.input_unit}]", tab=TIME_TAB,
                      window=(0.0, model.u_max), caption=text(
                          "On at {u_applied:.3g} {input_unit}, then off.", u_applied=np.max(run.u_applied), input_unit=model.input_unit))


def _errors(outcome: Outcome[OwnStudy], run: Run) -> LineFigure:
    copy = outcome.study.copy
    last = min(len(run.t), len(copy.t))
    ours = _size(run.e[:last])
    below = np.flatnonzero(ours > KNOWN_ERROR_SHARE * max(float(ours[0]), 1e-300))
    said = (text("The observer's error is not below a twentieth of its start at the end.")
            if len(below) and below[-1] == last - 1 else
            text("The observer's error is below a twentieth of its start after {t:.3g} s.",
                 t=run.t[below[-1] + 1] if len(below) else 0))
    return errors_figure(run, copy, _size, text("size of the error"), "‖e‖", said)


def _heard(model: Model, run: Run) -> LineFigure:
    name = model.plant.output_names[0]
    return innovation_figure(run, f"[{model.plant.unit(name)}]", lambda late: text(
        "Sensor {name} minus its prediction; up to {heard:.2g} in the last tenth of "
        "the run.",
        name=signal_name(model.plant, name), heard=late))


def _plane(model: Model, outcome: Outcome[OwnStudy]) -> PlaneFigure:
    window = model.observer_window
    points = tuple(Point(float(p.real), float(p.imag), "muted", "dot") for row in outcome.study.poles[1:] for p in row
                   if abs(p) < 3 * max(-window.re_low, window.im_high))
    stable = np.all(np.real(outcome.study.poles) < 0, axis=1)
    trusts = np.linspace(0.0, MOST_TRUST, len(stable))
    shaky = np.flatnonzero(~stable)
    need = (text("All trusts tried, up to 2, make every mode stable.") if not len(shaky) else
            text("No trust tried, up to 2, makes every mode stable.") if len(shaky) == len(stable) else
            text("Only a trust of {trust:.2g} is not stable among those tried.", trust=trusts[shaky[0]]) if len(shaky) == 1 else
            text("Some of the values of trust tried from {trusts:.2g} to {trusts2:.2g} are unstable.",
                 trusts=trusts[shaky[0]], trusts2=trusts[shaky[-1]]))
    high = max(window.re_high, 0.3 * -window.re_low)
    return locus_figure(outcome, (), points, need, (window.re_low, high), (-window.im_high, window.im_high))


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, which fits whatever it is; the tasks are about the chip and stay with it."""
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, model), figures=partial(figures, model), tasks=(),
                   derived=partial(derived_own, model))
