"""Define the tasks of lesson 15."""

from __future__ import annotations

import numpy as np

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import text

from .knobs import COLUMNS, EXAMPLE_FOUR, EXAMPLE_ONE, EXAMPLE_THREE, EXAMPLE_TWO, REMARKS, SENSITIVITY_LINES
from .paper_slips import PRINTED_SIZES, claimed_columns, free_columns, remark_3, true_size
from .study import BEST_POLE, Story, turn

FLOOR_J = 38 / 9
RIGHT_END, CIRCLE_J = -1.0, 5.2  # of the circle: Re s and J
NO_EFFECT_SHARE = 0.01  # of the larger entry of N: a state that has no say
SLOWEST_POLE_RAD_S, DIRECT, DIRECT_TOLERANCE, STEERS = -1.1, 3.5, 0.2, 2.2  # of the two roads: Re s, |M| and how near, entries of N


def _kink(outcome: Outcome[Story]) -> Verdict:
    d, J = outcome.design, outcome.metrics["J"]
    if d["example"] != EXAMPLE_ONE or any(d[name] != 1.0 for name in ("alpha", "second", "beta", "gamma")):
        return Verdict(False, text("This task is about Example 1 with all weights at 1."))
    if J > FLOOR_J + 0.05:
        return Verdict(False, text("J is {j:.3g}; it can be brought below {floor_j:.3g}.",
                                   j=J, floor_j=FLOOR_J + 0.05))
    return Verdict(True, text("J is {j:.4g} at s = {pole_real:.4g}; its least value is 38/9, at −5/3.",
                              j=J, pole_real=d["pole"][0].real))


def _one_observer(outcome: Outcome[Story]) -> Verdict:
    d, gap = outcome.design, outcome.metrics["coordinate_gap"]
    if d["example"] != EXAMPLE_TWO or abs(d["w12"]) < 1:
        return Verdict(False, text("Take Example 2 and keep |w| at 1 or more."))
    if gap > 1e-6:
        return Verdict(False, text("On the model e_u still differs from that of W = I by up to {gap:.3g}.", gap=gap))
    return Verdict(True, text("W has w = {w12:g}, and e_u equals that of W = I to {gap:.0e}: one observer, twice.",
                              w12=d["w12"], gap=max(gap, 1e-16)))


def _remark(outcome: Outcome[Story]) -> Verdict:
    d = outcome.design
    if d["example"] != EXAMPLE_TWO:
        return Verdict(False, text("Take Example 2, where Λ is a matrix and the order of factors matters."))
    gaps = remark_3(d["remark"])
    if gaps.dynamics is None or gaps.output is None:
        return Verdict(False, text("In {remarks} the factors do not even fit together.",
                                   remarks=REMARKS[d["remark"]]))
    if not gaps.met:
        return Verdict(False, text("(2b) is missed by {dynamics:.2g} and (2c) by {output:.2g}, relative; both "
                                   "must be 0.",
                                   dynamics=gaps.dynamics, output=gaps.output))
    return Verdict(True, text("Both conditions hold: a change of coordinates turns F into ΛFΛ⁻¹ and T into ΛT."))


def _sizes(outcome: Outcome[Story]) -> Verdict:
    d = outcome.design
    if d["example"] != EXAMPLE_TWO:
        return Verdict(False, text("Take Example 2: its lines are the ones to check."))
    printed, true = PRINTED_SIZES[d["line"]], true_size(d["line"])
    if printed == true:
        return Verdict(False, text("{lines} is printed {true}×{true2}, and that is right; look at another line.",
                                   lines=SENSITIVITY_LINES[d["line"]], true=true[0], true2=true[1]))
    claimed, right = claimed_columns(d["columns"]), free_columns()
    if claimed != right:
        return Verdict(False, text("The line is found. {columns} gives M′ {claimed} columns here; it has {right}.",
                                   columns=COLUMNS[d["columns"]], claimed=claimed, right=right))
    return Verdict(True, text("{lines} is {true}×{true2}, printed {printed}×{printed2}; M′ has {columns} = "
                              "{right} columns here.",
                              lines=SENSITIVITY_LINES[d["line"]], true=true[0], true2=true[1], printed=printed[0],
                              printed2=printed[1], columns=COLUMNS[d["columns"]], right=right))


def _two_roads(outcome: Outcome[Story]) -> Verdict:
    d, g = outcome.design, outcome.gains
    slowest = max(p.real for p in outcome.poles["observer"])
    if d["example"] != EXAMPLE_TWO or slowest > SLOWEST_POLE_RAD_S + 1e-9:
        return Verdict(False, text("Take Example 2, with both poles at Re s ≤ −1.1; the slower one is at {slowest:.3g}.", slowest=slowest))
    direct, size = float(np.abs(g["M"]).max()), float(np.abs(g["N"] @ turn(d)).max())
    if abs(direct - DIRECT) > DIRECT_TOLERANCE:
        return Verdict(
            False, text("|M| = {direct:.3g}; wanted are {wanted:g} within {near:g}.", direct=direct, wanted=DIRECT, near=DIRECT_TOLERANCE)
        )
    if size > STEERS:
        return Verdict(False, text("|M| = {direct:.3g} is right, but N has an entry of {size:.3g}; at most {most:g} is wanted.",
                                   direct=direct, size=size, most=STEERS))
    return Verdict(True, text("|M| = {direct:.3g}, and no entry of N is above {size:.3g}.", direct=direct, size=size))


def _no_say(outcome: Outcome[Story]) -> Verdict:
    d = outcome.design
    if d["example"] != EXAMPLE_THREE or any(p.imag for p in outcome.poles["observer"]):
        return Verdict(False, text("Take Example 1 with one observer state more, and keep both poles real."))
    N = outcome.gains["N"][0]
    silent = int(np.argmin(np.abs(N)))
    if abs(N[silent]) > NO_EFFECT_SHARE * np.abs(N).max():
        return Verdict(False, text("N = ({first:.3g}, {second:.3g}): both states still affect û.", first=N[0], second=N[1]))
    left = d["pair"][1 - silent].real
    return Verdict(True, text("N = ({first:.3g}, {second:.3g}): what is left is the first-order observer with its pole at {left:.3g}.",
                              first=N[0], second=N[1], left=left))


def _circle(outcome: Outcome[Story]) -> Verdict:
    d, J, slowest = outcome.design, outcome.metrics["J"], float(outcome.poles["observer"].real.max())
    if d["example"] != EXAMPLE_FOUR or d["norm"] != "2" or any(d[name] != 1.0 for name in ("alpha", "second", "beta", "gamma")):
        return Verdict(False, text("Take the two carts, the norm 2 and all weights at 1."))
    if slowest > RIGHT_END:
        return Verdict(False, text("The slowest pole is at {slowest:.3g}; both must be at −1 or left of it.", slowest=slowest))
    if J > CIRCLE_J:
        return Verdict(False, text("J is {j:.3g}; {most:g} or less is wanted.", j=J, most=CIRCLE_J))
    return Verdict(True, text("J is {j:.3g}, and from the tachometer straight into û goes only {direct:.2g}.", j=J,
                              direct=abs(outcome.gains["M"][0, 1])))


WRONG_SENSOR = Typed("(k-a)*(l-a)/(k*l)", ("a", "k", "l"), slips=(
    ("(k-a)/k", text("That is for y fed back at once, u = −k y; the observer costs a factor as well.")),
    ("1-(k-a)*(l-a)/(k*l)", text("That is the share that must still be read; d is what may be missing."))))

TASKS = (
    Task("kink", _kink, {"pole": (complex(BEST_POLE),)}),
    Task("one-observer", _one_observer, {"example": EXAMPLE_TWO, "w12": 1.2, "carried": True},
         Typed("a + w*b", ("a", "b", "w"), (("a", text("That is the old start; W moves the first entry too.")),))),
    Task("remark-3", _remark, {"example": EXAMPLE_TWO, "remark": "similar"}, Typed("n/r", ("n", "r"), (
        ("n*r", text("With that, N′T′ is r² N T; the product must not change.")),))),
    Task("sizes", _sizes, {"example": EXAMPLE_TWO, "line": "LC", "columns": "mp"},
         Typed("m + p - r", ("m", "p", "r"))),
    Task("no-say", _no_say, {"example": EXAMPLE_THREE, "free": 25.0}, Typed("-50 - 30*s", ("s",), (
        ("50 + 30*s", text("That is M in the paper's sign, u = +K x; the page has u = −K x̂.")),))),
    typed_task("wrong-sensor", WRONG_SENSOR),
    Task("two-roads", _two_roads, {"example": EXAMPLE_TWO, "pair": (-1.1 - 1.05j, -1.1 + 1.05j)}),
    Task("circle", _circle, {"example": EXAMPLE_FOUR, "pair": (-1 - 3.77j, -1 + 3.77j)}, Typed("-27/4 - 22*s", ("s",), (
        ("-27/4 - 11*s", text("A pair has s₁ + s₂ = 2 Re s; one of the two is missing.")),
        ("27/4 + 22*s", text("Check the sign: Re s is negative and |s|² is positive.")),))),
)
