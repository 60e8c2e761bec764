"""Compute a design of lesson 17: run, diagnosis, expected values and checks."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome, Stage
from observer_lab.engine.observers import Decoupling, decoupling
from observer_lab.text import text

from ..toolkit.boards import listed
from ..toolkit.latex import matrix, number
from .body import BANK_SHOWN, BODIES
from .diagnosis import ENERGY, Forecast, Rule, forecast, judge
from .fault_pairs import ALWAYS_ISOLABLE, isolable, rivals
from .observer_bank import COIL_IDS, DT, FAULT_PLACES, MODEL, SAMPLE_COUNT, guard
from .results import Study
from .run_length import member_run, seconds_between
from .runs import BIAS_FAULT, NONE, SWITCH_LOOP, Case, Fault, Record, drawn, quiet, simulate, switched
from .summary import live


def case_of(d: Design) -> Case:
    """What a design simulates; knobs that do not matter are left at their defaults, so that equal runs are equal cases."""
    common = {"force": d["force"], "tone": d["tone"], "loop": d["loop"], "stiffer": d["stiffer"] / 100, "kick": d["kick"]}
    one, other = _first(d), _second(d)
    if one is None:
        return Case(**common)
    if other is not None and other.start < one.start:
        one, other = other, one
    return Case(one.place, one.kind, one.size, one.at, **common, also=other)


def _first(d: Design) -> Fault | None:
    place, kind = d["place"], d["kind"]
    if place == NONE:
        return None
    if place in COIL_IDS:
        return Fault(place, BIAS_FAULT, d["loss"] / 100, d["at"])
    return Fault(place, kind, {"bias": d["bias"], "drift": d["drift"]}.get(kind, 0.0), d["at"])


def _second(d: Design) -> Fault | None:
    """The second fault, None where it is none or of the same part."""
    place = d["place2"]
    if place in (NONE, d["place"]):
        return None
    return Fault(place, BIAS_FAULT, d["loss2"] / 100 if place in COIL_IDS else d["bias2"], d["at2"])


def test_of(d: Design) -> Rule:
    """How a design judges."""
    return Rule(d["statistic"], int(d["window"]), d["rate"])


def study(d: Design) -> Study:
    """One design, worked out."""
    case, test = case_of(d), test_of(d)
    blind = simulate(case, drawn(int(d["seed"])))
    verdict = judge(test, blind)
    record = blind
    if case.loop == SWITCH_LOOP and verdict.decided is not None and verdict.who is not None:
        record = switched(case, drawn(int(d["seed"])), blind, verdict.decided, verdict.who)
        later = judge(test, record)
        verdict = replace(later, decided=verdict.decided, who=verdict.who, first=verdict.first)
    silent = quiet(case)
    column = None if case.place == NONE else FAULT_PLACES.index(case.place)
    expected = forecast(test, silent, column, case.start, SAMPLE_COUNT if case.also is None else case.also.start)
    return Study(case, test, record, blind, verdict, silent, expected, _calm(case, silent, expected))


def _calm(case: Case, silent: Record, expected: Forecast) -> float:
    """The largest pitch in rad after the fault, without noise, where the loop acts when the verdict is due."""
    if case.loop == SWITCH_LOOP and expected.delay is not None:
        silent = switched(replace(case, kick=-1.0), drawn(-1), silent, case.start + expected.delay, case.place)
    return float(np.abs(silent.x[0 if case.place == NONE else case.start:, 2]).max())


@lru_cache(maxsize=3)
def unknown_coil(coil: int) -> Decoupling:
    """Whether an observer of the whole deck could ignore this coil, in continuous time."""
    return decoupling(MODEL.plant, MODEL.plant.B[:, [coil]])


def between(s: Study) -> float:
    """Mean time in s between two false alarms of the whole bank, which tests a window at every sample."""
    return seconds_between(s.test)


def compute(design: Design) -> Outcome[Study]:
    """The run with its fault, the bank, the verdict, and what it does to the loop."""
    s = study(design)
    return _outcome(design, s)


def _outcome(design: Design, s: Study) -> Outcome[Study]:
    members = guard().bank.members
    coil = s.case.coil or 0
    return Outcome(design, {"L": guard().whole.K}, {m.name: m.poles for m in members}, metrics_of(s), _checks(s), None, _boards(s),
                   _stage(s, design["shown"]), _formulas(s, coil), live(s), s)


def metrics_of(s: Study) -> dict[str, float]:
    """The numbers of a study by name."""
    v, t = s.verdict, s.trials
    found = {"trials": float(t.runs), "windows": float(t.windows), "worst_share": float(t.alarms.max()) / t.windows,
             "right": float(t.right), "wrong": float(t.wrong), "measured_between": t.between(s.test.window)} if t is not None else {}
    return {
        "threshold": s.test.threshold, "dof": float(s.test.dof), "needed": s.test.needed, "between": between(s),
        "member_between": DT * member_run(s.test),
        "accused": -1.0 if v.who is None else float(FAULT_PLACES.index(v.who)), "right_verdict": float(s.right),
        "delay": math.inf if s.delay is None or not s.right else s.delay,
        "expected_delay": math.inf if s.forecast.delay is None else DT * s.forecast.delay,
        "pitch": s.calm, **found,
    }


def _checks(s: Study) -> tuple[Check, ...]:
    signature = guard().bank.signature
    single = len({tuple(column) for column in signature.T}) == len(FAULT_PLACES)
    early = s.verdict.decided is not None and s.verdict.decided < s.case.start
    conditions = [unknown_coil(j) for j in range(3)]
    return (
        Check("signatures", text("every fault has a signature of its own"), single, float(single)),
        Check(
            "rank",
            text("rank(CE) = rank(E) for every coil"),
            all(c.rank_CE == c.rank_E for c in conditions),
            float(min(c.rank_CE for c in conditions)),
        ),
        Check(
            "right",
            text("the right part is diagnosed") if s.case.place != NONE else text("no fault is diagnosed"),
            s.right if s.case.place != NONE else s.verdict.who is None,
            math.inf if s.delay is None or not s.right else s.delay,
        ),
        Check("patient", text("no diagnosis before the fault"), not early, float(early)),
        Check(
            "expected",
            text("the fault is large enough to count on that"),
            s.forecast.delay is not None,
            math.inf if s.forecast.delay is None else DT * s.forecast.delay,
        ),
        *(
            ()
            if s.pair is None
            else (
                Check(
                    "pair",
                    text("no other pair of faults can make the same readings"),
                    isolable(s.pair) == ALWAYS_ISOLABLE,
                    float(len(rivals()[s.pair])),
                ),
            )
        ),
    )


def _boards(s: Study) -> tuple[Board, Board]:
    zeros = unknown_coil(s.case.coil or 0).zeros
    poles = guard().bank.members[_ignoring(s)].poles
    lively = np.log(poles[np.abs(poles) > 1e-6].astype(complex)) / DT
    w = MODEL.observer_window
    return (
        Board("deck", text("deck: poles ×, zero ○"), tuple(MODEL.plant.poles),
              zeros=() if zeros is None else tuple(complex(z) for z in zeros), side="left", re_low=-6.0, re_high=2.0, im_high=12.0),
        Board("member", text("poles of the member below its threshold"), listed(lively),
              role="estimate", side="right", re_low=w.re_low, re_high=w.re_high, im_high=w.im_high),
    )


def _ignoring(s: Study) -> int:
    """The member that ignores the true fault; the first one if there is none."""
    return 0 if s.column is None else s.column


def _stage(s: Study, shown: str) -> Stage:
    fails, accused = np.zeros((SAMPLE_COUNT, 7)), np.zeros((SAMPLE_COUNT, 7))
    for fault in s.case.faults:
        fails[fault.start:, FAULT_PLACES.index(fault.place)] = 1.0
    if s.verdict.who is not None:
        accused[s.verdict.decided:, FAULT_PLACES.index(s.verdict.who)] = 1.0
    t = DT * np.arange(SAMPLE_COUNT)
    marks = np.hstack([fails, accused, *([s.verdict.values] if shown == BANK_SHOWN else [])])
    return Stage(BODIES[shown], t, np.hstack([s.record.x, marks]), np.hstack([s.record.xhat, np.zeros_like(marks)]), s.record.applied)


def _formulas(s: Study, coil: int) -> tuple[Formula, ...]:
    quiet = guard().bank.members[_ignoring(s)]
    name = quiet.name.replace("−", "-")
    total = (rf"T = \sum_{{i=0}}^{{{s.test.window - 1}}} \nu_{{k-i}}^{{\mathsf T}} S^{{-1}} \nu_{{k-i}}" if s.test.statistic == ENERGY
             else rf"T = \tfrac{{1}}{{{s.test.window}}} \| \sum_i S^{{-1/2}} \nu_{{k-i}} \|^2")
    zeros = unknown_coil(coil).zeros
    return (
        Formula("statistic", total, text("of each member")),
        Formula("threshold", rf"\chi^2_{{{s.test.dof},\,1-\alpha}} = {number(s.test.threshold, 4)}, "
                             rf"\quad \alpha = {number(s.test.rate, 2)}",
                text("threshold")),
        Formula("S", rf"S_{{{name}}} = {matrix(1e6 * quiet.S)}", text("covariance of its innovation in mm²/s²")),
        Formula("coil", rf"\mathrm{{rank}}\, C b_{{{coil + 1}}} = \mathrm{{rank}}\, b_{{{coil + 1}}} = 1, \quad "
                        rf"s_0 = {number(0.0 if zeros is None else float(abs(zeros[0])) if abs(zeros[0]) > 1e-9 else 0.0)}",
                text("a coil as unknown input: its zero")),
    )
