"""Define the tasks of lesson 18."""

from __future__ import annotations

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import format_number, text

from .cases import CART_CASE, SCALAR_CASE, TWO
from .study import AUTONOMOUS_TOLERANCE, TOLD_AHEAD, Study

NO_FASTER = 0.82  # share that may be lost at most where sampling is no faster than needed


def _edge(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    if d["case"] != SCALAR_CASE or d["a"] < 1.3:
        return Verdict(False, text("This task is about the scalar plant with a of at least 1.3."))
    now = text("{loss:.1f} % are lost, {critical:.1f} % is the edge",
               loss=100 * d["loss"], critical=100 * m["critical"])
    if d["loss"] >= m["critical"]:
        return Verdict(False, text("{now}: the mean diverges.", now=now))
    if d["loss"] < m["critical"] - 0.02:
        return Verdict(False, text("{now}: more could be lost.", now=now))
    return Verdict(True, text("{now}: bounded, and close.", now=now))


def _faster(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    if d["case"] != CART_CASE or d["loss"] < 0.8:
        return Verdict(False, text("{loss:.0f} % lost; take the pole on a cart and lose at least 80 %.",
                                   loss=100 * d["loss"]))
    period, critical = 1e3 * m["period"], 100 * m["critical"]
    if d["loss"] >= m["critical"]:
        return Verdict(False, text("Sampled every {period:.1f} ms, only {critical:.1f} % losses can be tolerated.",
                                   period=period, critical=critical))
    if m["critical"] > NO_FASTER:
        return Verdict(False, text("Sampled every {period:.1f} ms, {critical:.1f} % losses can be tolerated: faster than needed.",
                                   period=period, critical=critical))
    return Verdict(True, text("Sampled every {period:.1f} ms, {critical:.1f} % losses can be tolerated.", period=period, critical=critical))


def _gap(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    if d["case"] != TWO:
        return Verdict(False, text("Choose the plant with two unstable modes."))
    if not m["safe"] < d["loss"] < m["critical"]:
        side = text("both bounds stay finite") if d["loss"] <= m["safe"] else text("both bounds diverge")
        return Verdict(False, text("At {loss:.1f} % {side}.", loss=100 * d["loss"], side=side))
    return Verdict(True, text("At {loss:.1f} % the lower bound has a limit and the upper one has none.",
                              loss=100 * d["loss"]))


def _wall(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    if d["case"] != CART_CASE or d["delay"] < 2:
        return Verdict(False, text("Take the pole on a cart and a delay of at least 2 samples."))
    if m["separation_meter"] > AUTONOMOUS_TOLERANCE:
        read = format_number(m["separation_meter"], ".2g")
        return Verdict(False, text("The meter reads {read}: the observer counts with an input that does not act.",
                                   read=read))
    if m["loop_radius"] > m["designed_radius"] * (1 + 1e-6):
        return Verdict(False, text("The meter reads 0, but the loop has a pole of modulus {loop_radius:.3f}; designed were "
                                   "{designed:.3f} at most.", loop_radius=m["loop_radius"], designed=m["designed_radius"]))
    return Verdict(True, text("The meter reads 0 and the largest modulus is {loop_radius:.3f}, as designed.",
                              loop_radius=m["loop_radius"]))


PERFECT_READINGS = Typed("Q/(1-p*a^2)", ("a", "p", "Q"), slips=(
    ("Q/(1-a^2)", text("That is without any reading; here only a share p of them is lost.")),
    ("Q/(1-p*a)", text("A variance grows with a², not with a."))))
NOISY_READINGS = Typed("R*(a^2-1)/(1-p*a^2)", ("a", "p", "R"), slips=(
    ("R*(a^2-1)", text("That is without any loss; a share p of the readings does not come.")),
    ("R*(a^2*(1-p)-1)", text("Only the gain term is weighed with 1 − p; the growth a² acts every time."))))

BUDGET = Typed("exp(-2*a/R)", ("a", "R", "k"), slips=(
    ("exp(-2*a*k/R)", text("This share of the samples can be lost; but a sample is lost only if all its k copies are lost.")),
    ("exp(-a/R)", text("That is the edge for the error's mean size; the variance grows with its square."))))

TASKS = (
    Task("edge", _edge, {"a": 1.4, "loss": 0.5}),
    Task("faster", _faster, {"case": CART_CASE, "loss": 0.8, "stretch": 0.6}),
    Task("gap", _gap, {"case": TWO, "loss": 0.58}, Typed(lambda o: 1 / o.metrics["safe"])),
    Task("wall", _wall, {"case": CART_CASE, "delay": 2.0, "told": TOLD_AHEAD}),
    typed_task("perfect-readings", PERFECT_READINGS),
    typed_task("noisy-readings", NOISY_READINGS),
    typed_task("budget", BUDGET),
)
