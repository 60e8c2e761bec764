"""Describe Hankel values, a truncation and two regulators as code."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue
from observer_lab.plants.platform.lqg_weights import COIL_COUNT

from .balanced_platform import HEARD
from .body import MAX_DRAWN_MOTION
from .own_system import OwnStudy
from .platform_study import PlatformStudy
from .reduced_regulator import EQUAL, WEIGHT_OUTPUTS, weights_of
from .study import RELATIVE, S

RANK_CHOICE_MARGIN = 1e-13  # of the largest singular value: how near to the tolerance another may lie for rounding to decide the rank


def _ranks(outcome: Outcome[S]) -> tuple[list[ShownValue], str]:
    """Both ranks, but those that rounding decides, and the words for these."""
    shown, unsaid, d, ranks = [], "", outcome.design, outcome.study.ranks
    for name, values in (("rank_controllability", ranks.reached), ("rank_observability", ranks.seen)):
        edge = d["tolerance"] * (values[0] if d["measure"] == RELATIVE else 1.0)
        if np.abs(values - edge).min() > RANK_CHOICE_MARGIN * values[0]:
            shown.append(ShownValue(name, outcome.metrics[name]))
        else:
            unsaid += f", {name.replace('_', ' of ')}, which rounding decides at this tolerance"
    return shown, unsaid


def _given(outcome: Outcome[S]) -> tuple[GivenValue, ...]:
    """What a cut rests on, beside A, B and the balanced states."""
    d, s = outcome.design, outcome.study.system
    return (
        GivenValue("C", s.plant.C),
        GivenValue("D", np.asarray(s.plant.D)),
        GivenValue("order", outcome.study.order, "states kept"),
        GivenValue("clock", d["clock"], "s, the unit of time"),
        GivenValue("tolerance", d["tolerance"]),
        GivenValue("relative", d["measure"] == RELATIVE, "singular values are measured against the largest"),
        GivenValue("frequencies", s.frequencies, "Hz"),
        GivenValue("from_balanced", s.balanced.T),
    )


def _shown(outcome: Outcome[S]) -> tuple[ShownValue, ...]:
    """Poles and error of a cut."""
    error, largest = outcome.metrics["error"], float(outcome.study.system.hankel[0])
    return (
        ShownValue("eigvals(A)", outcome.poles["plant"], poles=True),
        ShownValue("eigvals(Ar)", outcome.poles["model"], poles=True),
        ShownValue("error", error, max(error, largest)),
    )


def code(outcome: Outcome[PlatformStudy]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    s = study.system
    weights = weights_of(s, d["v0"])
    ranks, unsaid = _ranks(outcome)
    return Code(
        ("weak",),
        (
            GivenValue("A", s.plant.A, "the platform: five positions and five velocities"),
            GivenValue("B", s.plant.B, "three coils, two motions of the ground"),
            GivenValue(
                "to_balanced", s.balanced.left, "z = to_balanced x: balanced states, their signs and those of equals as the page has them"
            ),
            *_given(outcome),
            GivenValue("coils", COIL_COUNT),
            GivenValue("pair", int(d["pair"]), "whose motion is drawn, the strongest first"),
            GivenValue("heard", HEARD, "outputs that count: HR = -HL"),
            GivenValue("half_width", s.parameters.s, "m, sensors off the centre"),
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
        (
            ShownValue("hankel", s.hankel),
            *_shown(outcome),
            ShownValue("bound", m["bound"], float(s.hankel[0])),
            ShownValue("held", m["held"], 1.0),
            ShownValue("frequency", m["frequency"]),
            ShownValue("growth", m["growth"], max(1.0, abs(m["growth"]))),
            ShownValue("K", outcome.gains["K"]),
            ShownValue("L", outcome.gains["L"]),
            *(ShownValue(name, m[name], max(1.0, abs(m[name]))) for name in ("gap", "extra") if name in m),
            *ranks,
        ),
        "Forces by pair, and the closed forms" + unsaid,
    )


def own_code(outcome: Outcome[OwnStudy]) -> Code:
    """The same on a person's own plant, without regulators."""
    s, (ranks, unsaid) = outcome.study.system, _ranks(outcome)
    return Code(
        ("weak_own",),
        (
            GivenValue("A", s.plant.A, "the plant"),
            GivenValue("B", s.plant.B),
            GivenValue("to_balanced", s.balanced.left, "z = to_balanced x: balanced states, then unstable ones"),
            *_given(outcome),
            GivenValue("unstable", s.kept, "states that always stay"),
        ),
        (ShownValue("hankel", s.hankel[:s.most - s.kept], float(s.hankel[0])), *_shown(outcome), *ranks),
        "The outputs after a blow" + unsaid,
    )
