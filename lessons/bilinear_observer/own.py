"""Compute lesson 16 on the user's own bilinear plant: any K, chosen poles, failed conditions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Board, Check, Design, Lesson, Outcome, Stage
from observer_lab.plants import Model
from observer_lab.text import text

from ..toolkit.boards import listed
from ..toolkit.figures import settle_time
from .code import own_code
from .derive import own_derived
from .formulas import own_formulas
from .input_signals import columns, form_index, number_of
from .own_figures import figures
from .own_knobs import own_knobs
from .own_plant import Here, error_matrix, fitted
from .own_run import forms_at, run_of
from .own_summary import LAW, Story, live
from .study import promises


def compute(here: Here, design: Design) -> Outcome[Story]:
    """The eight steps for what is wanted, L with the poles asked for, and one run of all three forms under the chosen input."""
    wanted = here.of(design["wanted"])
    asked = design[f"poles_{wanted.id}"] if wanted.poles else ()
    L = wanted.gain(asked)
    poles = np.sort_complex(np.linalg.eigvals(error_matrix(wanted.solved, L)).astype(complex))
    run = run_of(here, design, wanted, L)
    story = Story(here, wanted, L, forms_at(wanted, L)[1], poles, run)
    metrics, plants = LazyMap(lambda: _metrics(design, story)), np.sort_complex(np.asarray(here.model.plant.poles, dtype=complex))
    return Outcome(design, {"L": L}, {"observer": poles, "plant": plants}, metrics, LazySequence(lambda: _checks(story, metrics)), None,
                   _boards(design, story), _stage(design, story), LazySequence(lambda: own_formulas(
                       wanted.solved, L, story.plain, wanted.pi(asked), poles, int(design["step"]))),
                   LazyValue(lambda: live(design, story, metrics)), story)


def _metrics(design: Design, s: Story) -> dict[str, float]:
    """Errors relative to the largest |g| of the run, row by row, the worst row of each moment."""
    o, run, index = s.wanted.solved, s.run, form_index(design)
    size = np.max(np.abs(run.g), axis=0)
    size = np.where(size > 0, size, 1.0)
    worst, count = np.max(np.abs(run.errors[:, index]) / size, axis=1), len(run.t)
    settled = settle_time(run.t, worst)
    found = {"case": float(o.case), "order": float(o.order), "defect": o.defect_size, "slowest": float(np.max(np.real(s.poles))),
             "law_gap": float(min(run.gap, 1e15)), "first_error": float(worst[0]),
             "late_error": float(np.max(worst[-max(count // 10, 1):])), "half_error": float(np.max(worst[count // 2:])),
             "settled_after": float("inf") if settled is None else settled}
    if design["noise"]:
        late = run.heard[count // 2:, index] / size
        found |= {"noise_rms": float(np.max(np.sqrt(np.mean(late ** 2, axis=0)))),
                  "noise_promised": float(min(np.max(run.promised[index] / size), 1e15))}
    return {name: float(np.clip(value, -1e15, 1e15)) for name, value in found.items()}


def _checks(s: Story, m: Mapping[str, float]) -> tuple[Check, ...]:
    o, start = s.wanted.solved, s.wanted.start
    return (
        Check("case1", text("case 1: (21) fails, no L"), o.case == 1, o.defect_size, informative=True),
        Check("case2", text("case 2: one L only"), o.case == 2, float(o.canonical_Q.rank), informative=True),
        Check("case3", text("case 3: a family of L"), o.case == 3, float(len(o.canonical_Q.zero_left)), informative=True),
        Check("controllable", text("(A*, B*) controllable: any poles"), start is not None and not len(start.bolted),
              0.0 if start is None else float(len(start.moved))),
        Check("stable", text("the poles in use are on the left"), m["slowest"] < 0, m["slowest"]),
        Check("law", text("ε follows its poles under this u"), m["law_gap"] <= LAW, m["law_gap"]),
        *promises(o),
    )


def _boards(design: Design, s: Story) -> tuple[Board, ...]:
    w, window = s.wanted, s.wanted.window
    seen = listed(np.asarray(s.here.model.plant.poles, dtype=complex))
    reach = max((abs(p) for p in seen), default=1.0) or 1.0
    held = tuple(p for p in (w.bolted if w.poles else tuple(map(complex, s.poles)) if w.solved.case != 1 else ())
                 if window.re_low <= p.real <= window.re_high and abs(p.imag) <= window.im_high)
    return (
        Board("plant", text("the plant's poles at u = 0  eig(A)"), seen, side="left", re_low=-1.3 * reach, re_high=1.3 * reach,
              im_high=1.3 * reach),
        Board("observer", text("observer poles  eig (V₂ − LV₁)AT₂"), design[f"poles_{w.id}"] if w.poles else (),
              f"poles_{w.id}" if w.poles else None, fixed=held, role="estimate", side="right", re_low=window.re_low, re_high=window.re_high,
              im_high=window.im_high),
    )


def _stage(design: Design, s: Story) -> Stage:
    run, standing = s.run, s.wanted.standing
    true, ghost = np.hstack([run.x, run.g]), np.hstack([run.x, run.estimates[:, form_index(design)]])
    return Stage(s.wanted.body, run.t, true[:, standing], ghost[:, standing], columns(run.u))


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant; the tasks stay with the paper's."""
    here = fitted(model)
    return replace(lesson, knobs=own_knobs(here), compute=partial(compute, here), figures=figures, tasks=(), code=own_code,
                   derived=own_derived, key=("step", "wanted", "input"), aside=(
                       *(name + number_of(j) for j in range(here.plant.inputs) for name in ("amplitude", "omega", "seed")), "tau"))
