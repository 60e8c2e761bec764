"""Compute the numbers in the derivation of lesson 16: the eight steps at the present pole."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome
from observer_lab.engine.observers import BilinearObserver
from observer_lab.plants.bilinear import X0

from ..toolkit.latex import MOST_ENTRIES
from .input_signals import FILTERED_DERIVATIVE, form_index
from .own_plant import Here
from .paper_example import base_of, pole_of
from .problems import COMPUTED_GAIN
from .study import Study

LATER = 20  # steps after which the error of the run is compared
ROUNDING = 1e-9  # of the largest estimate: a smaller error is rounding


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Both parts of g, L Q beside W, the family of L in its last entry, the pole, and the error of the run; what there is of it."""
    o, design = outcome.study.observer, outcome.design
    known = _parts(o, np.array(X0), o.L)
    if o.L is None or o.pi is None:
        return known
    family = {"base4": float(base_of(o)[0, -1]), "pi": o.pi.item(), "free4": float(o.canonical_Q.zero_left[0, -1]),
              "L4": float(o.L[0, -1]), "A_star": o.A_star.item(), "B_star": o.B_star.item(), "pole": pole_of(o, o.L),
              "p": float(o.asked[0].real)}
    return {**known, **family, **(_errors(outcome) if design["gain"] == COMPUTED_GAIN else {})}


def own_derived(here: Here, outcome: Outcome[Study]) -> Mapping[str, Value]:
    """The same on a person's own plant, as far as an equation of the derivation is about what this plant has: one row, one state."""
    s, o, wanted = outcome.study.setting, outcome.study.observer, here.of(outcome.design["wanted"])
    known = _parts(o, s.x0 * s.scale, None if o.case == 1 else s.L)
    if o.case == 1 or o.order != 1:
        return known
    pi, pole = wanted.pi(outcome.design[f"poles_{wanted.id}"] if wanted.poles else ()), float(s.poles[0].real)
    if pi is not None and o.B_star.size == 1 and np.any(o.B_star):
        known |= {"pi": pi.item(), "A_star": o.A_star.item(), "B_star": o.B_star.item(), "pole": pole}
    return {**known, "p": pole, **(_errors(outcome) if len(o.K) == 1 else {})}


def _parts(o: BilinearObserver, x0: np.ndarray, L: np.ndarray | None) -> dict[str, Value]:
    """Both parts of g at the start, if it is one number; L Q beside W, if there is such an L and it is small."""
    seen, rest = (o.K @ o.T[k] @ o.V[k] @ x0 for k in (0, 1))
    known: dict[str, Value] = {"rows": float(o.Q.shape[0]), "columns": float(o.Q.shape[1])}
    if len(o.K) == 1:
        known |= {"g_seen": seen.item(), "g_rest": rest.item(), "g": (seen + rest).item()}
    if L is not None and o.Q.shape[1] * o.order <= MOST_ENTRIES and L.size <= MOST_ENTRIES:
        known |= {"LQ": L @ o.Q, "W": o.right, "L": L}
    return known


def _errors(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """The error at the start and a little later, of a run that follows its law by more than rounding."""
    run, design = outcome.study.run, outcome.design
    if design["noise"] or design["form"] == FILTERED_DERIVATIVE or design["kick"] >= 0 or len(run.t) <= LATER:
        return {}
    errors = run.errors[:, form_index(design), 0]
    if abs(errors[LATER]) <= ROUNDING * float(np.abs(run.estimates).max()):
        return {}
    return {"time": LATER * outcome.study.setting.dt, "eps0": float(errors[0]), "eps1": float(errors[LATER])}
