"""Define the tasks of lesson 10."""

from __future__ import annotations

import numpy as np

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import text

from .cases import DOYLE, REPORT
from .knobs import NONE, SENSOR_RULE, UNITS_RULE
from .loops import setting_of
from .robustness import beyond, real, within
from .study import Study
from .tuning import channel_reductions, reached, structure

AS_MODELLED = Verdict(False, text("Take the platform with inputs as strong as the model says."))
BREAKING_GAIN = 1.001  # a gain that breaks the loop of the first task
HEAVY = 1000.0  # q and σ at least, in the second
MIN_GAIN_UP, MAX_GAIN_DOWN = 2.0, 0.5  # gain margins asked back
MIN_SUPPRESSION_DB, MIN_DELAY_MARGIN_S = 20.0, 0.1
REGULATOR_DB, LOOP_DB = (80.0, 90.0), 60.0  # with the state measured, and with the filter
MIN_SPARSE_GAIN_DB, SPARSE_DEARER = 20.0, 1.01  # dB of the rotation, times the cost with all of K
LOUD, DELAY, DEARER = 1e7, (0.12, 0.13), 1.25  # true sensor noise; s of delay margin; of the least cost


def _on(outcome: Outcome[Study], case: str) -> bool:
    return outcome.study.case.id == case


def _vanish(outcome: Outcome[Study]) -> Verdict:
    if not _on(outcome, DOYLE):
        return Verdict(False, text("Choose Doyle's plant first."))
    high = outcome.study.real.margins.gain[1]
    if outcome.design["recovery"] > 0:
        return Verdict(False, text("Leave recovery at 0: plain LQG is asked for."))
    if high > BREAKING_GAIN:
        return Verdict(False, text("It is still stable for a gain of {high:.5g}; an error of 0.1 % should make it unstable.",
                                   high=high))
    return Verdict(True, text("At {high:.10g} times the model's gain this optimal loop is lost.", high=beyond(high)))


def _recover(outcome: Outcome[Study]) -> Verdict:
    d, s = outcome.design, outcome.study
    if not _on(outcome, DOYLE) or d["q"] < HEAVY or d["sigma"] < HEAVY:
        return Verdict(False, text("Doyle's plant with q and σ of at least 1000, please."))
    low, high = s.real.margins.gain
    inner = within((low, high))
    found = text("Gains from {low:.10g} to {high:.10g} keep the loop stable", low=inner[0], high=inner[1])
    if high < MIN_GAIN_UP or low > MAX_GAIN_DOWN:
        return Verdict(False, text("{found}; from 0.5 to 2 is wanted.", found=found))
    if s.density is None:
        return Verdict(False, text("The margins are there, but the true gain m lies outside them."))
    price = np.linalg.norm(s.cost.sensors) / np.linalg.norm(s.plain_cost.sensors)
    return Verdict(True, text("{found}; the sensors' noise now moves the input {price:.3g} times as much.",
                              found=found, price=price))


def _least_delay(outcome: Outcome[Study]) -> float:
    """The delay in s that the weakest of the inputs bears."""
    s, setting = outcome.study, setting_of(outcome.study.case, outcome.design)
    return min(real(s.case, setting.factors, setting.recovery, i).margins.delay for i in range(s.case.plant.m))


def _patience(outcome: Outcome[Study]) -> Verdict:
    s, d = outcome.study, outcome.design
    if not _on(outcome, REPORT) or abs(d["sensor"] / LOUD - 1) > 0.01 or d["gain"] != 1.0:
        return Verdict(False, text("Take the platform with a true sensor noise of 10⁷ and inputs as strong as the model says."))
    if s.suppression is None:
        return Verdict(False, text("This loop is unstable."))
    price, least = s.cost.total / s.cost.least, _least_delay(outcome)
    found = text("The cost is {price:.3f} times the least, and the least delay margin is {least:.3f} s", price=price, least=least)
    if price > DEARER or not DELAY[0] <= least <= DELAY[1]:
        return Verdict(False, text("{found}; wanted are at most {most:g} times and {low:g} to {high:g} s.", found=found, most=DEARER,
                                   low=DELAY[0], high=DELAY[1]))
    return Verdict(True, text("{found}.", found=found))


def _twenty(outcome: Outcome[Study]) -> Verdict:
    s = outcome.study
    if not _on(outcome, REPORT) or s.suppression is None:
        return Verdict(False, text("A stable loop on the platform is asked for."))
    worst, least = float(np.min(s.suppression)), _least_delay(outcome)
    found = text("The least of the three channels gains {worst:.1f} dB, the least delay margin is {least:.3g} s",
                 worst=worst, least=least)
    if worst < MIN_SUPPRESSION_DB or least < MIN_DELAY_MARGIN_S:
        return Verdict(False, text("{found}; wanted are 20 dB and 0.1 s.", found=found))
    return Verdict(True, text("{found}.", found=found))


def _as_modelled(outcome: Outcome[Study]) -> bool:
    """Whether the platform's inputs are as strong as the model says; its optimal loops are stable then."""
    return _on(outcome, REPORT) and outcome.study.suppression is not None and outcome.design["gain"] == 1.0


def _stages(outcome: Outcome[Study]) -> Verdict:
    s = outcome.study
    if not _as_modelled(outcome):
        return AS_MODELLED
    assert s.suppression is not None
    measured = reached(s.case, s.setting, True)
    assert measured is not None and measured.reductions is not None  # LQR is stable, and so is the platform
    known, kept = float(np.min(measured.reductions)), float(np.min(s.suppression))
    found = text("The least reduction is {known:.1f} dB with the state measured and {kept:.1f} dB with this filter", known=known, kept=kept)
    if not REGULATOR_DB[0] <= known <= REGULATOR_DB[1] or kept < LOOP_DB:
        return Verdict(False, text("{found}; wanted are 80 to 90 dB and then 60 dB.", found=found))
    return Verdict(True, text("{found}.", found=found))


def _sparse(outcome: Outcome[Study]) -> Verdict:
    s = outcome.study
    if not _as_modelled(outcome):
        return AS_MODELLED
    assert s.suppression is not None
    both = structure(s.case, s.setting)
    sparse = channel_reductions(s.case, s.setting, both.sparse)
    if sparse is None:
        return Verdict(False, text("Without the cross gains this loop is unstable."))
    gained, price = float(sparse[1] - s.suppression[1]), both.cost[1] / both.cost[0]
    found = text("Without the cross gains the rotation's peak is {gained:.1f} dB lower, at {price:.4f} times the cost",
                 gained=gained, price=price)
    if gained < MIN_SPARSE_GAIN_DB or price > SPARSE_DEARER:
        return Verdict(False, text("{found}; wanted are 20 dB and at most 1.01 times.", found=found))
    return Verdict(True, text("{found}.", found=found))


def _rule(outcome: Outcome[Study]) -> Verdict:
    rule, more = outcome.design["rule"], outcome.metrics.get("sensor_more", np.inf)
    if rule == NONE:
        return Verdict(False, text("Choose the line that you doubt."))
    if rule == UNITS_RULE:
        return Verdict(False, text("This rule has an error in its units; choose a rule of tuning."))
    if rule != SENSOR_RULE:
        return Verdict(False, text("This line holds; the table says why."))
    if not more < 0.9:
        return Verdict(False, text("Here ten times β_R leaves {more:.3g} times the noise in the input; find a "
                                   "loop with less than 0.9.",
                                   more=more))
    return Verdict(True, text("Ten times β_R leaves {more:.3g} times the noise in the input: suppressed more, not "
                              "less.",
                              more=more))


WEAKER = Typed("a*(K+L-a)/(K*L)", ("a", "K", "L"), slips=(
    ("a/K", text("That is the regulator that measures x itself.")),
    ("a*(K+L)/(K*L)", text("The compensator has the pole a − K − L: you left out its a."))))

TASKS = (
    Task("vanish", _vanish, {"case": DOYLE, "q": 1000.0, "sigma": 1000.0}),
    Task("recover", _recover, {"case": DOYLE, "q": 1000.0, "sigma": 1000.0, "recovery": 6.0}),
    Task("twenty", _twenty, {"beta_r": 1e8}),
    Task("patience", _patience, {"sensor": LOUD, "beta_r": 3.5e7}),
    Task(
        "rule", _rule, {"rule": SENSOR_RULE}, Typed(lambda _: 0.1, slips=(("10", text("The other way round: W is to fall as V rises.")),))
    ),
    typed_task("weaker", WEAKER),
    Task("stages", _stages, {"alpha_r": 100.0, "beta_r": 1e5}),
    Task("sparse", _sparse, {"alpha_r": 1e4, "beta_r": 1.0}),
)
