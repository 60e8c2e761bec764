"""Hankel values, a truncation and two regulators as code."""

from __future__ import annotations

import numpy as np

from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Outcome
from app.plants.platform_lqg import COILS

from .body import REACH
from .regulator import EQUAL, OUTPUTS, weights_of
from .study import RELATIVE, Study
from .system import HEARD

DUST = 1e-13  # of the largest singular value: how near to the tolerance another may lie for rounding to decide the rank


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    s, cut = study.system, study.cut
    weights, p = weights_of(s, d["v0"]), s.parameters
    shown = [Shown("hankel", s.hankel), Shown("eigvals(A)", outcome.poles["plant"], poles=True),
             Shown("eigvals(Ar)", outcome.poles["model"], poles=True), Shown("error", m["error"], max(m["error"], float(s.hankel[0]))),
             Shown("bound", m["bound"], float(s.hankel[0])), Shown("held", m["held"], 1.0), Shown("frequency", m["frequency"]),
             Shown("growth", m["growth"], max(1.0, abs(m["growth"]))), Shown("K", outcome.gains["K"]), Shown("L", outcome.gains["L"])]
    shown += [Shown(name, m[name], max(1.0, abs(m[name]))) for name in ("gap", "extra") if name in m]
    unsaid = "Forces by pair, and the closed forms"
    for name, values in (("rank_controllability", study.ranks.reached), ("rank_observability", study.ranks.seen)):
        edge = d["tolerance"] * (values[0] if d["measure"] == RELATIVE else 1.0)
        if np.abs(values - edge).min() > DUST * values[0]:
            shown.append(Shown(name, m[name]))
        else:
            unsaid += f", {name.replace('_', ' of ')}, which rounding decides at this tolerance"
    return Code(("weak",), (
        Given("A", s.plant.A, "the platform: five positions and five velocities"),
        Given("B", s.plant.B, "three coils, two motions of the ground"),
        Given("C", s.plant.C), Given("D", np.asarray(s.plant.D)), Given("coils", COILS), Given("order", cut.order, "states kept"),
        Given("pair", int(d["pair"]), "whose motion is drawn, the strongest first"), Given("clock", d["clock"], "s, the unit of time"),
        Given("tolerance", d["tolerance"]), Given("relative", d["measure"] == RELATIVE, "singular values are measured against the largest"),
        Given("heard", HEARD, "outputs that count: HR = -HL"), Given("frequencies", s.frequencies, "Hz"),
        Given("to_balanced", s.balanced.left, "z = to_balanced x: balanced states, their signs and those of equals as the page has them"),
        Given("from_balanced", s.balanced.T), Given("half_width", p.s, "m, sensors off the centre"),
        Given("reach", REACH, "how far motions are drawn"),
        Given("outputs_pressed", d["pressed"] == OUTPUTS, "the cost presses on the outputs, or on every balanced state alike"),
        Given("of_outputs", weights.Q(s.plant), "x' Q x of the outputs"), Given("alike", EQUAL), Given("R", weights.R),
        Given("W", weights.W, "intensity of the ground"), Given("V", weights.V, "intensity of the readings' noise"),
    ), tuple(shown), unsaid)
