"""Fit lesson 16 to the user's own bilinear plant: any K, chosen poles, failed conditions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.knobs import Choice, Knob, Number, Poles
from observer_lab.course.lesson import Board, Design, Lesson, Stage
from observer_lab.engine.observers import BilinearObserver, BilinearRun
from observer_lab.plants import Model
from observer_lab.plants.model import Window
from observer_lab.text import Text, text

from ..toolkit.boards import listed
from ..toolkit.knobs import run_knobs
from ..toolkit.latex import pole_words
from .code import own_code
from .derive import own_derived
from .figures import figures
from .formulas import own_formulas
from .input_signals import FILTERED_DERIVATIVE, columns, form_index, number_of, signal, together
from .knobs import FIRST_LABELS, FORM, STEP, input_knobs
from .own_figures import own_cases, own_steps
from .own_plant import Here, Wanted, fitted, omega_of
from .paper_example import error_matrix
from .run_record import Record, Row, Setting, end_to_end
from .study import FORM_NAMES, LAW_TOLERANCE, WINDOWS, boards_of, bound, compute, counts

STRONGEST = 4.0  # times the natural input
HELD_SHARE = 1e-4  # of the largest |ĝ| and |g|: an error below this is compared with that, for digits' sake


def own_knobs(here: Here) -> tuple[Knob, ...]:
    """The knobs of a plant: those of the paper's page that any plant has, in this plant's own sizes."""
    return (
        STEP,
        Choice("wanted", "K", text("wanted, g = K x"), default=here.wanted[0].id, options=tuple((w.id, w.label) for w in here.wanted),
               hidden=len(here.wanted) == 1, hint=text("The rows of K in the file, together or alone, or one state that y does not give.")),
        *(knob for j in range(here.plant.inputs) for knob in _drive(here, j)),
        *(Poles(f"poles_{w.id}", "p", text("Observer poles"), "rad/s", default=w.poles, re_low=w.window.re_low, re_high=w.window.re_high,
                im_high=w.window.im_high, role="estimate", when=("wanted", (w.id,)),
                hint=text("The poles that π moves; poles that are the same for every L are fixed modes.")) for w in here.wanted if w.poles),
        FORM,
        Number("tau", r"\tau", text("differentiator's time constant"), "s", low=here.horizon / 2000, high=here.horizon / 20,
               default=here.horizon / 100, scale="log", when=("form", (FILTERED_DERIVATIVE,)), hint=text("ẏ is replaced by s/(τs + 1) y.")),
        Number("noise", r"\sigma", text("noise of each sensor"), "%", low=0.0, high=10.0, default=0.0, step=0.1,
               hint=text("The standard deviation of what each sensor adds to y, as a share of what it reads at most in the first run.")),
        run_knobs(here.horizon)[1],
    )


def _drive(here: Here, which: int) -> tuple[Knob, ...]:
    """What drives an input; the second and those that follow have names of their own."""
    name, strength = here.names[which], float(here.strength[which])
    labels, most = FIRST_LABELS, STRONGEST * strength
    hint = (text("u is {name}. The plant is linear: F is zero, and u multiplies nothing.", name=name) if here.linear else
            text("u pushes the plant and also multiplies its state: {name}.", name=name))
    amplitude = (text("At first half of what a regulator would ask for.") if here.linear else
                 text("At first the input with which u F is half as fast as the plant.") if here.plant.inputs == 1 else
                 text("At first all inputs together make the plant at most half as fast again."))
    if which:
        labels = (text("input {name}", name=name), text("amplitude of {name}", name=name), text("frequency of {name}", name=name),
                  text("random seed of {name}", name=name), text("{name} by hand", name=name))
        hint = text("It multiplies the state by a matrix of its own, F{number}.", number=which + 1)
    return input_knobs(which, labels, (hint, amplitude, text("The sweep ends four times as fast as it says here.")), here.units[which],
                       (strength, most, most / 100), omega_of(here.horizon, which))


def own_setting(here: Here, design: Design) -> Setting:
    """The eight steps for what is wanted, L with the poles asked for; the run goes from the model's x(0) and χ(0) = 0."""
    wanted, model, scale, index = here.of(design["wanted"]), here.model, here.scale, form_index(design)
    asked = design[f"poles_{wanted.id}"] if wanted.poles else ()
    o, L = wanted.solved, wanted.gain(asked)
    exact, plain = o.forms(L)
    poles = np.sort_complex(np.linalg.eigvals(error_matrix(o, L)).astype(complex))
    plant_poles = np.sort_complex(np.asarray(model.plant.poles, dtype=complex))
    start = wanted.start
    rows = tuple(Row(name, text("{name}, estimated {form}", name=name, form=FORM_NAMES[index]), text("|ε| of {name}", name=name),
                     text("law of {name}", name=name), unit) for name, unit in zip(wanted.rows, wanted.units, strict=True))
    return Setting(
        True, o, L, exact, plain, poles, plant_poles, here.inner, scale, np.array(model.x0) / scale, np.zeros(o.order),
        np.array(model.kick) / scale, here.horizon, here.dt, together([signal(design, horizon=here.horizon, which=j)
                                                                       for j in range(here.plant.inputs)]),
        design["noise"] / 100 * here.readings, rows, tuple(zip(here.names, here.units, strict=True)),
        (model.plant.input_names, model.plant.output_names), {"error": (WINDOWS["error"][0], 1.0)},
        _boards(here, wanted, design, poles),
        (start is not None and not len(start.bolted), 0.0 if start is None else float(len(start.moved))),
        partial(_law, here, wanted, L, index), partial(_told, wanted, poles, index), partial(_told_of_error, wanted),
        partial(_stage, wanted, index), lambda: own_formulas(o, L, plain, wanted.pi(asked), poles, int(design["step"])),
        partial(_live, design, wanted, poles))


def _told(wanted: Wanted, poles: np.ndarray, index: int, run: Record, worst: np.ndarray) -> dict[str, float]:
    """`law_gap`: how far ε leaves the law ẇ = A_L w, relative to its peak."""
    held = np.maximum(np.max(np.abs(run.g), axis=0), np.max(np.abs(run.estimates[:, index]), axis=0))
    size = np.maximum(np.max(np.abs(run.law), axis=0), HELD_SHARE * held)
    gap = np.max(np.abs(run.errors[:, index] - run.law) / np.where(size > 0, size, 1.0))
    return {"order": float(wanted.solved.order), "slowest": float(np.max(np.real(poles))), "law_gap": float(gap),
            "first_error": float(worst[0])}


def _law(here: Here, wanted: Wanted, L: np.ndarray, index: int, calm: list[BilinearRun]) -> np.ndarray:
    """ε (n_t, r) of ẇ = A_L w from w(0) by the method of the run, Gauss's of order 6: of a linear equation it makes a Padé approximant."""
    o, plant = wanted.solved, here.inner
    q, A_L = o.order, error_matrix(o, L)
    Z = A_L * here.dt
    even, odd = np.eye(q) + Z @ Z / 10, Z / 2 + Z @ Z @ Z / 120
    step = np.linalg.solve(even - odd, even + odd)

    def of(p: BilinearRun) -> np.ndarray:  # w = μ̂ − μ, and in the form without ẏ μ̂ = χ + L y
        w = np.empty((len(p.t), q))
        w[0] = p.z[0, index * q:(index + 1) * q] - o.V[1] * here.scale @ p.x[0]
        if index == 0:
            w[0] += L @ plant.C @ p.x[0]
        for k in range(1, len(w)):
            w[k] = step @ w[k - 1]
        return np.clip(np.nan_to_num(w @ o.readout.T, nan=1e15, posinf=1e15, neginf=-1e15), -1e15, 1e15)
    return end_to_end([of(p) for p in calm])


def _told_of_error(wanted: Wanted, m: Mapping[str, float]) -> Text:
    if wanted.solved.case == 1:  # at some u it may follow a law all the same
        return text("No L frees |ε| from u and x: in the last tenth of the run it is up to {late:.2g} of g.", late=m["late_error"])
    return claim(text("|ε| follows ẇ = A_L w to within {law_gap:.0e} of its peak, whatever u does.", law_gap=m["law_gap"]), m["law_gap"],
                 below=LAW_TOLERANCE, otherwise=text("|ε| leaves its law: in the last tenth of the run it is up to {late:.2g} of g.",
                                                     late=m["late_error"]))


def _boards(here: Here, w: Wanted, design: Design, poles: np.ndarray) -> tuple[Board, Board]:
    window, seen = w.window, listed(np.asarray(here.model.plant.poles, dtype=complex))
    reach = 1.3 * (max((abs(p) for p in seen), default=1.0) or 1.0)
    held = tuple(p for p in (w.bolted if w.poles else tuple(map(complex, poles)) if w.solved.case != 1 else ())
                 if window.re_low <= p.real <= window.re_high and abs(p.imag) <= window.im_high)
    return boards_of((seen, Window(-reach, reach, reach)), window, text("observer poles  eig (V₂ − LV₁)AT₂"),
                     design[f"poles_{w.id}"] if w.poles else (), f"poles_{w.id}" if w.poles else None, held)


def _stage(wanted: Wanted, index: int, run: Record) -> Stage:
    true, ghost = np.hstack([run.x, run.g]), np.hstack([run.x, run.estimates[:, index]])
    return Stage(wanted.body, run.t, true[:, wanted.standing], ghost[:, wanted.standing], columns(run.u))


def _live(design: Design, wanted: Wanted, found: np.ndarray, m: Mapping[str, float]) -> Text:
    """The sentence of the present design: what holds, or which condition fails and what to change."""
    o, late = wanted.solved, m["late_error"]
    if o.case == 1:
        return _no_gain(o, late)
    fixed = tuple(map(complex, found)) if o.case == 2 else wanted.bolted
    right = [p for p in fixed if p.real >= 0]
    if right and o.case == 2:
        return text("Case 2: one L only, and its pole {poles} is not on the left, so ε does not decay. Measure more, or want another "
                    "g.", poles=pole_words(right))
    if right:
        return text("Case 3: a family of L, but the pole {poles} stays put in all of them, so ε does not decay. Measure other "
                    "states, or want another g.", poles=pole_words(right))
    if m["slowest"] >= 0:
        return text("An observer pole is not on the left, so ε does not decay: drag it left.")
    if design["noise"]:
        return claim(text("The sensors' noise moves ĝ by {rms:.2g} of g (rms, second half of the run); at rest and u = 0 its law says "
                          "{promised:.2g}.", rms=m["noise_rms"], promised=m["noise_promised"]), m["noise_rms"], above=0.0)
    poles = pole_words(listed(found)[:6])
    follows = text("Case {case}: an observer of order {order} estimates g, and ε decays under this u; poles: {poles}.",
                   case=o.case, order=o.order, poles=poles)
    return claim(follows, m["law_gap"], below=LAW_TOLERANCE, otherwise=text(
        "The poles are {poles}, but something still drives ε: when the run ends it is {late:.2g} of g.", poles=poles, late=late))


def _no_gain(o: BilinearObserver, late: float) -> Text:
    (have, need), (left, right) = counts(o), bound(o.plant).split("≥")
    if o.advised:
        return text("Case 1: (21) fails, and the nearest L leaves ε at {late:.2g} of g when the run ends. Measure other states, or want "
                    "another g.", late=late)
    return text("Case 1: (21) fails, and the nearest L leaves ε at {late:.2g} of g when the run ends. {left} is {have}, {right} is {need}: "
                "measure more, or want another g.", late=late, left=left.strip(), have=have, right=right.strip(), need=need)


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant; the tasks stay with the paper's."""
    here = fitted(model)
    aside = [name + number_of(j) for j in range(here.plant.inputs) for name in ("amplitude", "omega", "seed")]
    return replace(lesson, knobs=own_knobs(here), compute=partial(compute, partial(own_setting, here)),
                   figures=partial(figures, own_steps, partial(own_cases, here), lambda _: ()), tasks=(), code=own_code,
                   derived=partial(own_derived, here), key=("step", "wanted", "input"), aside=(*aside, "tau"))
