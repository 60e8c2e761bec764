"""The tasks of lesson 21."""

from __future__ import annotations

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.engine.identification.evidence import WHITE
from observer_lab.text import text

from .knobs import FURNACE, MASSES, TANKS
from .study import Study

DOUBTFUL, HALF, CLOSE = 2.0, 0.5, 0.05
SURE, LITTLE = 0.09, 45.0


def _other(outcome: Outcome[Study], data: str) -> bool:
    return outcome.design["data"] != data


def _right_order(outcome: Outcome[Study]) -> Verdict:
    """The two masses with an order at which everything holds, half of the record and the likely Q."""
    m, d = outcome.metrics, outcome.design
    if _other(outcome, MASSES):
        return Verdict(False, text("Choose the record of the two masses."))
    if d["factor"] != 1 or d["share"] != 50:
        return Verdict(False, text("Keep the likely Q and half of the record for the fit."))
    if m["white_p"] < WHITE or not m["nis_low"] <= m["mean_nis"] <= m["nis_high"]:
        return Verdict(False, text("The innovations can still be predicted (p = {p:.2g}); the model has too few states.", p=m["white_p"]))
    if d["order"] > 4:
        return Verdict(False, text("The innovations are white, but a smaller order does it too."))
    return Verdict(True, text("Order {order:.0f}: the innovations are white and the NIS is in its band.", order=d["order"]))


def _over_confident(outcome: Outcome[Study]) -> Verdict:
    """A mean NIS of two within a twentieth, by Q alone, on the spring."""
    if outcome.design["order"] != 2 or outcome.design["share"] != 50 or outcome.design["data"] != "spring":
        return Verdict(False, text("Keep the spring, order 2 and half of the record."))
    nis = outcome.metrics["mean_nis"]
    if abs(nis / DOUBTFUL - 1) <= CLOSE:
        return Verdict(True, text("The mean NIS is {nis:.3g}: the filter is over-confident.", nis=nis))
    return Verdict(False, text("The mean NIS is {nis:.3g}; bring it to 2 within 5 %.", nis=nis))


def _under_confident(outcome: Outcome[Study]) -> Verdict:
    """A mean NIS of a half, on the tanks."""
    if _other(outcome, TANKS):
        return Verdict(False, text("Choose the record of the two tanks."))
    nis = outcome.metrics["mean_nis"]
    if abs(nis / HALF - 1) <= CLOSE:
        return Verdict(True, text("The mean NIS is {nis:.3g}: the filter is under-confident.", nis=nis))
    return Verdict(False, text("The mean NIS is {nis:.3g}; bring it to 0.5 within 5 %.", nis=nis))


def _little_data(outcome: Outcome[Study]) -> Verdict:
    """Poles of the masses that are sure, from as little of the record as that takes."""
    m, d = outcome.metrics, outcome.design
    if _other(outcome, MASSES) or d["order"] != 4:
        return Verdict(False, text("Choose the record of the two masses and order 4."))
    if m["deviation"] > SURE:
        return Verdict(False, text("The least certain pole has a standard deviation of {sigma:.2g}; at most 0.09 is allowed.",
                                   sigma=m["deviation"]))
    if d["share"] > LITTLE:
        return Verdict(False, text("The poles are certain enough; do it with at most 45 % of the record."))
    return Verdict(True, text("With {share:.0f} % of the record the least certain pole has a standard deviation of {sigma:.2g}.",
                              share=d["share"], sigma=m["deviation"]))


def _real(outcome: Outcome[Study]) -> Verdict:
    """A filter for the furnace whose NIS is in its band."""
    m = outcome.metrics
    if _other(outcome, FURNACE) or outcome.design["share"] != 50:
        return Verdict(False, text("Choose the record of the gas furnace and half of it for the fit."))
    if not m["nis_low"] <= m["mean_nis"] <= m["nis_high"]:
        return Verdict(False, text("The mean NIS is {nis:.3g} and its band ends at {high:.2f}.", nis=m["mean_nis"], high=m["nis_high"]))
    if m["fit"] < 80:
        return Verdict(False, text("The NIS is in its band, but only {fit:.3g} % of the variation is predicted; ask for 80 %.",
                                   fit=m["fit"]))
    return Verdict(True, text("The mean NIS is {nis:.3g}, in its band, and {fit:.3g} % of the variation is predicted.",
                              nis=m["mean_nis"], fit=m["fit"]))


BACK = Typed("s*(1-k/a)", ("a", "k", "s"), slips=(
    ("s*(1-k)", text("That is right for the filter gain M; the predictor gain is k = a M.")),
    ("s*k/a", text("That is the part of the state, C P Cᵀ; R is the rest."))))

TASKS = (
    Task("right-order", _right_order, {"data": MASSES, "order": 4}),
    Task("over-confident", _over_confident, {"factor": 0.035}),
    Task("under-confident", _under_confident, {"data": TANKS, "factor": 16.0}),
    Task("little-data", _little_data, {"data": MASSES, "order": 4, "share": 45}),
    Task("real", _real, {"data": FURNACE, "factor": 20.0}),
    typed_task("back", BACK),
)
