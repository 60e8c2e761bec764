"""Fit lesson 16 to the user's own bilinear plant: any K, chosen poles, failed conditions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Board, Design, Lesson, Stage
from observer_lab.engine.observers import BilinearRun
from observer_lab.plants import Model
from observer_lab.text import Text, text

from ..toolkit.boards import listed
from .code import own_code
from .derive import own_derived
from .formulas import own_formulas
from .input_signals import columns, form_index, number_of, signal, together
from .own_figures import figures
from .own_knobs import own_knobs
from .own_plant import Here, OwnSetting, Wanted, error_matrix, fitted
from .own_summary import live
from .run_record import Record, Row, end_to_end
from .study import FORM_NAMES, LAW_TOLERANCE, WINDOWS, compute

HELD_SHARE = 1e-4  # of the largest |ĝ| and |g|: an error below this is compared with that, for digits' sake


def own_setting(here: Here, design: Design) -> OwnSetting:
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
    return OwnSetting(
        True, o, L, exact, plain, poles, plant_poles, here.inner, scale, np.array(model.x0) / scale, np.zeros(o.order),
        np.array(model.kick) / scale, here.horizon, here.dt, together([signal(design, horizon=here.horizon, which=j)
                                                                       for j in range(here.plant.inputs)]),
        design["noise"] / 100 * here.readings, rows, tuple(zip(here.names, here.units, strict=True)),
        (model.plant.input_names, model.plant.output_names), {"error": (WINDOWS["error"][0], 1.0)},
        _boards(here, wanted, design, poles),
        (start is not None and not len(start.bolted), 0.0 if start is None else float(len(start.moved))),
        partial(_law, here, wanted, L, index), partial(_told, wanted, poles, index), partial(_told_of_error, wanted),
        partial(_stage, wanted, index), lambda: own_formulas(o, L, plain, wanted.pi(asked), poles, int(design["step"])),
        partial(live, design, wanted, poles), here, wanted)


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
    reach = max((abs(p) for p in seen), default=1.0) or 1.0
    held = tuple(p for p in (w.bolted if w.poles else tuple(map(complex, poles)) if w.solved.case != 1 else ())
                 if window.re_low <= p.real <= window.re_high and abs(p.imag) <= window.im_high)
    return (
        Board("plant", text("the plant's poles at u = 0  eig(A)"), seen, side="left", re_low=-1.3 * reach, re_high=1.3 * reach,
              im_high=1.3 * reach),
        Board("observer", text("observer poles  eig (V₂ − LV₁)AT₂"), design[f"poles_{w.id}"] if w.poles else (),
              f"poles_{w.id}" if w.poles else None, fixed=held, role="estimate", side="right", re_low=window.re_low, re_high=window.re_high,
              im_high=window.im_high),
    )


def _stage(wanted: Wanted, index: int, run: Record) -> Stage:
    true, ghost = np.hstack([run.x, run.g]), np.hstack([run.x, run.estimates[:, index]])
    return Stage(wanted.body, run.t, true[:, wanted.standing], ghost[:, wanted.standing], columns(run.u))


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant; the tasks stay with the paper's."""
    here = fitted(model)
    return replace(lesson, knobs=own_knobs(here), compute=partial(compute, partial(own_setting, here)), figures=figures, tasks=(),
                   code=own_code, derived=own_derived, key=("step", "wanted", "input"), aside=(
                       *(name + number_of(j) for j in range(here.plant.inputs) for name in ("amplitude", "omega", "seed")), "tau"))
