"""Describe Hankel values and a truncation of the user's own plant as code."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue

from .code import ranks_shown
from .own_system import OwnStudy
from .study import RELATIVE


def own_code(outcome: Outcome[OwnStudy]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    s, stable = study.system, study.system.most - study.system.whole.kept
    largest = float(s.hankel[0])
    shown = [ShownValue("hankel", s.hankel[:stable], largest), ShownValue("eigvals(A)", outcome.poles["plant"], poles=True),
             ShownValue("eigvals(Ar)", outcome.poles["model"], poles=True),
             ShownValue("error", m["error"], max(m["error"], largest))]
    ranks, unsaid = ranks_shown(d, m, study.ranks)
    return Code(("weak_own",), (
        GivenValue("A", s.plant.A, "the plant"), GivenValue("B", s.plant.B), GivenValue("C", s.plant.C),
        GivenValue("D", np.asarray(s.plant.D)),
        GivenValue("order", study.order, "states kept"), GivenValue("unstable", s.whole.kept, "states that always stay"),
        GivenValue("clock", d["clock"], "s, the unit of time"), GivenValue("tolerance", d["tolerance"]),
        GivenValue("relative", d["measure"] == RELATIVE, "singular values are measured against the largest"),
        GivenValue("frequencies", s.frequencies, "Hz"),
        GivenValue("to_balanced", s.whole.left, "z = to_balanced x: balanced states, then unstable ones"),
        GivenValue("from_balanced", s.whole.T)), tuple(shown + ranks), "The outputs after a blow" + unsaid)
