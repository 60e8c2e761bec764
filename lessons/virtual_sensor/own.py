"""Fit lesson 1 to the user's own plant, in its own measures."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.figures.records import Curve, Point
from observer_lab.course.knobs import Knob, Number
from observer_lab.course.lesson import Design, Lesson, Outcome
from observer_lab.engine.systems import sorted_poles
from observer_lab.plants import Model, Signal
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import NO_WORDS, Text, joined, text

from ..toolkit.gains import injection, judged, sizes, sped
from ..toolkit.knobs import pole_knobs, run_knobs
from .derive import derived_own
from .figures import Look, Range, View, figures, late_innovation
from .knobs import MOST_TRUST
from .study import Setting, Study, compute, late_peak

KNOWN_ERROR_SHARE = 0.05  # of the first error: below this a signal counts as known
FEW_POINTS, MANY_POINTS = 13, 41  # points of the locus, for many states and for few


def own_knobs(lesson: Lesson, model: Model) -> tuple[Knob, ...]:
    """Trust, poles, first guess, a wrong model, an input and noise."""
    return (
        replace(lesson.knob("trust"), label=text("trust in the sensors θ")),
        replace(pole_knobs(model)[1], label=text("Observer poles at θ = 1"), when=None,
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


def own_setting(model: Model, design: Design) -> Setting:
    """A person's own plant: it may be faster than observer and copy believe."""
    belief, count = model.plant, round(model.horizon / model.dt) + 1
    push = np.zeros((count, belief.m))
    push[:, 0] = np.where((4 * np.arange(count) // count) % 2 == 0, design["push"], 0.0)
    return Setting(
        model, (sped(belief, design["mismatch"]), belief), injection(belief, design["observer_poles"], model), "L",
        [design["guess"] * v for v in model.x0], push,
        np.diag((design["noise"] / 100 * sizes(model)) ** 2) * model.dt if design["noise"] else None,
        np.linspace(0.0, MOST_TRUST, MANY_POINTS if belief.n <= 8 else FEW_POINTS), sorted_poles,
        partial(_numbers, judged(model)[1]), _live)


def _numbers(secret: Signal, rates: dict[str, float], seen: Study) -> dict[str, float]:
    error, alone = (secret.of(run.e) for run in (seen.run, seen.copy))
    return {**rates, "secret_error": late_peak(error), "copy_secret_error": late_peak(alone), "first_error": float(abs(error[0]))}


def _live(m: dict[str, float], _: Study) -> Text:
    doubt = text("Not every wrong start of the observer decays.") if m["slowest_observer"] >= 0 else NO_WORDS
    return joined(text("Slowest modes of the error: copy {theirs:+.3g}, observer {ours:+.3g} per second.",
                       theirs=m["slowest_copy"], ours=m["slowest_observer"]), doubt)


def own_look(model: Model) -> Look:
    """Its own names and units."""
    def view(signal: Signal) -> View:
        return View(signal.name, f"[{signal.unit}]", signal.of, partial(_ends, signal))
    output, secret = judged(model)
    sensor = model.plant.output_names[0]
    return Look(
        view(secret), view(output),
        View(text("first input, known to all three"), f"[{model.input_unit}]", lambda u: u[:, 0], lambda outcome: text(
            "On at {u_applied:.3g} {input_unit}, then off.", u_applied=np.max(outcome.study.run.u_applied), input_unit=model.input_unit),
            (0.0, model.u_max)), text("input"),
        View(text("size of the error"), "‖e‖", lambda e: np.linalg.norm(e, axis=1), _known),
        View(text("innovation y − ŷ"), f"[{model.plant.unit(sensor)}]", lambda d: d[:, 0], lambda outcome: text(
            "Sensor {name} minus its prediction; up to {heard:.2g} in the last tenth of "
            "the run.", name=signal_name(model.plant, sensor), heard=late_innovation(outcome))), _locus)


def _ends(signal: Signal, outcome: Outcome[Study]) -> Text:
    run, copy = outcome.study.run, outcome.study.copy
    at = min(len(run.t), len(copy.t)) - 1
    true, ours, theirs = (float(signal.of(x[at])) for x in (run.x, run.xhat, copy.xhat))
    return text("At the end of the run the observer is off by {true:.2g}, the copy by "
                "{true2:.2g} {unit}.", true=abs(true - ours), true2=abs(true - theirs), unit=signal.unit)


def _known(outcome: Outcome[Study]) -> Text:
    run = outcome.study.run
    size = np.linalg.norm(run.e[:len(outcome.study.copy.t)], axis=1)
    off = np.flatnonzero(size > KNOWN_ERROR_SHARE * max(float(size[0]), 1e-300))
    if len(off) and off[-1] == len(size) - 1:
        return text("The observer's error is not below a twentieth of its start at the end.")
    return text("The observer's error is below a twentieth of its start after {t:.3g} s.", t=run.t[off[-1] + 1] if len(off) else 0)


def _locus(outcome: Outcome[Study]) -> tuple[tuple[Curve, ...], tuple[Point, ...], Text, Range, Range]:
    window, seen = outcome.study.here.model.observer_window, outcome.study
    points = tuple(Point(float(p.real), float(p.imag), "muted", "dot") for row in seen.poles[1:] for p in row
                   if abs(p) < 3 * max(-window.re_low, window.im_high))
    shaky = seen.trusts[~np.all(np.real(seen.poles) < 0, axis=1)]
    need = (text("All trusts tried, up to 2, make every mode stable.") if not len(shaky) else
            text("No trust tried, up to 2, makes every mode stable.") if len(shaky) == len(seen.trusts) else
            text("Only a trust of {trust:.2g} is not stable among those tried.", trust=shaky[0]) if len(shaky) == 1 else
            text("Some of the values of trust tried from {trusts:.2g} to {trusts2:.2g} are unstable.", trusts=shaky[0], trusts2=shaky[-1]))
    return (), points, need, (window.re_low, max(window.re_high, 0.3 * -window.re_low)), (-window.im_high, window.im_high)


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, which fits whatever it is; the tasks are about the chip and stay with it."""
    return replace(lesson, knobs=own_knobs(lesson, model), compute=partial(compute, partial(own_setting, model)),
                   figures=partial(figures, own_look(model)), tasks=(), derived=derived_own)
