"""Compute the numbers in the derivation of lesson 16: the eight steps at the present pole."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome
from observer_lab.plants.bilinear import X0

from ..toolkit.latex import MOST_ENTRIES
from .input_signals import FILTERED_DERIVATIVE, form_index
from .own_plant import setting_of
from .paper_example import base_of, pole_of
from .problems import COMPUTED_GAIN
from .study import DT, Study

LATER = 20  # steps after which the error of the run is compared


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Both parts of g, L Q beside W, the family of L in its last entry, the pole, and the error of the run; what there is of it."""
    o, run, design = outcome.study.observer, outcome.study.run, outcome.design
    x0 = np.array(X0)
    known: dict[str, Value] = {
        "g_seen": (o.K @ o.T[0] @ o.V[0] @ x0).item(), "g_rest": (o.K @ o.T[1] @ o.V[1] @ x0).item(), "g": (o.K @ x0).item(),
        "rows": float(o.Q.shape[0]), "columns": float(o.Q.shape[1])}
    if o.L is not None:
        known |= {"LQ": o.L @ o.Q, "W": o.right, "L": o.L}
    if o.L is not None and o.pi is not None:
        pole = pole_of(o, o.L)
        known |= {"base4": float(base_of(o)[0, -1]), "pi": o.pi.item(), "free4": float(o.canonical_Q.zero_left[0, -1]),
                  "L4": float(o.L[0, -1]), "A_star": o.A_star.item(), "B_star": o.B_star.item(), "pole": pole, "p": float(o.asked[0].real)}
        if (
            design["gain"] == COMPUTED_GAIN
            and not design["noise"]
            and design["form"] != FILTERED_DERIVATIVE
            and design["kick"] < 0
            and len(run.t) > LATER
        ):
            errors = run.errors[:, form_index(design), 0]
            known |= {"time": LATER * DT, "eps0": float(errors[0]), "eps1": float(errors[LATER])}
    return known


def own_derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """The same on a person's own plant, as far as an equation of the derivation is about what this plant has: one row, one state."""
    s, run, design = setting_of(outcome), outcome.study.run, outcome.design
    o, x0 = s.solved, s.x0 * s.scale
    seen, rest = o.K @ o.T[0] @ o.V[0] @ x0, o.K @ o.T[1] @ o.V[1] @ x0
    known: dict[str, Value] = {"rows": float(o.Q.shape[0]), "columns": float(o.Q.shape[1])}
    if len(o.K) == 1:
        known |= {"g_seen": seen.item(), "g_rest": rest.item(), "g": (seen + rest).item()}
    if o.case == 1:
        return known
    if o.Q.shape[1] * o.order <= MOST_ENTRIES and s.L.size <= MOST_ENTRIES:
        known |= {"LQ": s.L @ o.Q, "W": o.right, "L": s.L}
    pi = s.wanted.pi(design[f"poles_{s.wanted.id}"] if s.wanted.poles else ())
    pole = float(s.poles[0].real)
    if pi is not None and o.order == 1 and o.B_star.size == 1 and np.any(o.B_star):
        known |= {"pi": pi.item(), "A_star": o.A_star.item(), "B_star": o.B_star.item(), "pole": pole}
    if o.order == 1:
        known |= {"p": pole}
        if len(o.K) == 1 and design["form"] != FILTERED_DERIVATIVE and not design["noise"] and design["kick"] < 0 and len(run.t) > LATER:
            errors = run.errors[:, form_index(design), 0]
            if abs(errors[LATER]) > 1e-9 * float(np.abs(run.estimates).max()):  # beyond that it is rounding
                known |= {"time": LATER * s.dt, "eps0": float(errors[0]), "eps1": float(errors[LATER])}
    return known
