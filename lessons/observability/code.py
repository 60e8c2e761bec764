"""Describe the estimate of x(0) as code: plant, readings, noise, shown numbers."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue

from .study import Study

RANK_CHOICE_MARGIN = 1e-6  # how near to the tolerance a singular value may lie, in shares of it, for the rank to be rounding's choice
POOR = 1e-9  # a singular value by which no reading should be divided that another machine has to find again


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    s, built, belief = study.sensed, study.rebuilt, study.belief
    size = max(float(np.linalg.norm(M, 2)) for M in (s.plant.A, s.plant.C))
    shown = [
        ShownValue("eigvals(A)", outcome.poles["plant"], poles=True),
        ShownValue("O", built.matrix),
        ShownValue("sizes", built.sizes),
        ShownValue("weakest", m["weakest"], max(m["weakest"], 0.05 * size)),
        ShownValue("W", s.energy[-1]),
        ShownValue("x", s.powers @ study.start),
        ShownValue("mean", belief.mean),
        ShownValue("halves", belief.halves),
        ShownValue("known", m["known"]),
        ShownValue("least_energy", m["least_energy"], float(s.heard[-1, -1])),
    ]
    unsaid = "Rank and distance along the knob"
    if _clear(s.seen.singular_values, d["tolerance"]):
        shown.append(ShownValue("rank", m["rank"]))
    else:
        unsaid += ", rank(O), which rounding decides at this tolerance"
    if _clear(built.sizes, d["tolerance"]) and (built.rank == 0 or built.sizes[built.rank - 1] > POOR * built.sizes[0]):
        shown += [ShownValue("rank_built", m["rank_built"]), ShownValue("guess", built.guess)]
    else:
        unsaid += ", x(0) from derivatives, which rounding decides at this tolerance"
    return Code(("observability",), (
        GivenValue("A", s.plant.A, "states and readings in typical sizes: dz/dt = A z, y = C z"), GivenValue("C", s.plant.C),
        GivenValue("z0", study.start), GivenValue("blocks", built.rows, "block rows of O that are built"),
        GivenValue("tolerance", d["tolerance"], "singular values at or below it times the largest count as zero"),
        GivenValue("reading", d["reading"], "relative error of each derivative at t = 0"),
        GivenValue("noise", d["noise"], "white noise over the run, as a share of a typical reading"),
        GivenValue("horizon", float(s.t[-1]), "s"), GivenValue("steps", len(s.t) - 1), GivenValue("seed", int(d["seed"])),
        GivenValue("root", s.root, "a square root of W over one step; there are many, this is the one that the page's noise went through"),
    ), tuple(shown), unsaid, (
        GivenValue("slips", np.random.default_rng(int(d["seed"])).standard_normal(len(built.matrix)), "of the derivatives"),
        GivenValue("normal", np.random.default_rng(int(d["seed"])).standard_normal((len(s.t) - 1, s.plant.n)), "of the noise"),
    ))


def _clear(values: np.ndarray, tolerance: float) -> bool:
    """Whether the count of singular values above the tolerance does not hang on rounding."""
    edge, dust = tolerance * values[0], 100 * np.finfo(float).eps * values[0]
    return bool(values[0] == 0 or np.all(np.abs(values - edge) > np.maximum(RANK_CHOICE_MARGIN * edge, dust)))
