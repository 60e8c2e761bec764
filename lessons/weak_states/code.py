"""Describe Hankel values, a truncation and two regulators as code."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.lesson import Design, Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue
from observer_lab.plants.platform.lqg_weights import COIL_COUNT

from .balanced_platform import HEARD
from .body import MAX_DRAWN_MOTION
from .reduced_regulator import EQUAL, WEIGHT_OUTPUTS, weights_of
from .study import RELATIVE, Ranks, Study

RANK_CHOICE_MARGIN = 1e-13  # of the largest singular value: how near to the tolerance another may lie for rounding to decide the rank


def ranks_shown(d: Design, m: Mapping[str, float], ranks: Ranks) -> tuple[list[ShownValue], str]:
    """Both ranks, but those that rounding decides, and the words for these."""
    shown, unsaid = [], ""
    for name, values in (("rank_controllability", ranks.reached), ("rank_observability", ranks.seen)):
        edge = d["tolerance"] * (values[0] if d["measure"] == RELATIVE else 1.0)
        if np.abs(values - edge).min() > RANK_CHOICE_MARGIN * values[0]:
            shown.append(ShownValue(name, m[name]))
        else:
            unsaid += f", {name.replace('_', ' of ')}, which rounding decides at this tolerance"
    return shown, unsaid


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    s, cut = study.system, study.cut
    weights, p = weights_of(s, d["v0"]), s.parameters
    shown = [
        ShownValue("hankel", s.hankel),
        ShownValue("eigvals(A)", outcome.poles["plant"], poles=True),
        ShownValue("eigvals(Ar)", outcome.poles["model"], poles=True),
        ShownValue("error", m["error"], max(m["error"], float(s.hankel[0]))),
        ShownValue("bound", m["bound"], float(s.hankel[0])),
        ShownValue("held", m["held"], 1.0),
        ShownValue("frequency", m["frequency"]),
        ShownValue("growth", m["growth"], max(1.0, abs(m["growth"]))),
        ShownValue("K", outcome.gains["K"]),
        ShownValue("L", outcome.gains["L"]),
    ]
    shown += [ShownValue(name, m[name], max(1.0, abs(m[name]))) for name in ("gap", "extra") if name in m]
    ranks, unsaid = ranks_shown(d, m, study.ranks)
    shown += ranks
    return Code(
        ("weak",),
        (
            GivenValue("A", s.plant.A, "the platform: five positions and five velocities"),
            GivenValue("B", s.plant.B, "three coils, two motions of the ground"),
            GivenValue("C", s.plant.C),
            GivenValue("D", np.asarray(s.plant.D)),
            GivenValue("coils", COIL_COUNT),
            GivenValue("order", cut.order, "states kept"),
            GivenValue("pair", int(d["pair"]), "whose motion is drawn, the strongest first"),
            GivenValue("clock", d["clock"], "s, the unit of time"),
            GivenValue("tolerance", d["tolerance"]),
            GivenValue("relative", d["measure"] == RELATIVE, "singular values are measured against the largest"),
            GivenValue("heard", HEARD, "outputs that count: HR = -HL"),
            GivenValue("frequencies", s.frequencies, "Hz"),
            GivenValue(
                "to_balanced", s.balanced.left, "z = to_balanced x: balanced states, their signs and those of equals as the page has them"
            ),
            GivenValue("from_balanced", s.balanced.T),
            GivenValue("half_width", p.s, "m, sensors off the centre"),
            GivenValue("reach", MAX_DRAWN_MOTION, "how far motions are drawn"),
            GivenValue(
                "outputs_pressed", d["pressed"] == WEIGHT_OUTPUTS, "the cost presses on the outputs, or on every balanced state alike"
            ),
            GivenValue("of_outputs", weights.Q(s.plant), "x' Q x of the outputs"),
            GivenValue("alike", EQUAL),
            GivenValue("R", weights.R),
            GivenValue("W", weights.W, "intensity of the ground"),
            GivenValue("V", weights.V, "intensity of the readings' noise"),
        ),
        tuple(shown),
        "Forces by pair, and the closed forms" + unsaid,
    )
