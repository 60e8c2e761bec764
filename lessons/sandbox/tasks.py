"""Define the tasks of lesson 19, for any plant on which they can be solved."""

from __future__ import annotations

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import text

from .analyses import Refusal
from .knobs import APPLIED
from .study import Study, times_the_least

UNION_TOLERANCE = 1e-8
FOUND_OUT = 1.5  # times the expected NIS
MIN_CLIPPED_SHARE, MAX_CLIPPED_SHARE = 0.05, 0.07  # share of the run for which the inputs are to be clipped
SPENT, DISK_MARGIN_TOLERANCE, ERROR = 1.0, 0.05, 1.1  # disk margin and how near; times the least error


def _through_the_limit(outcome: Outcome[Study]) -> Verdict:
    """Inputs clipped, and the error lives by itself all the same."""
    share, meter = outcome.metrics["clipped_share"], outcome.metrics["separation_meter"]
    if not MIN_CLIPPED_SHARE <= share <= MAX_CLIPPED_SHARE:
        return Verdict(False, text("An input is clipped for {share:.3g} % of the run; {least:.0f} to {most:.0f} % are wanted.",
                                   share=100 * share, least=100 * MIN_CLIPPED_SHARE, most=100 * MAX_CLIPPED_SHARE))
    if meter > UNION_TOLERANCE:
        return Verdict(False, text("Clipped for {share:.3g} % of the run, but the separation meter reads "
                                   "{meter:.2g}.",
                                   share=100 * share, meter=meter))
    return Verdict(True, text("Clipped for {share:.3g} % of the run, and the meter reads 0.", share=100 * share))


def _wrong_belief(outcome: Outcome[Study]) -> Verdict:
    """A filter that its own NIS convicts of overconfidence."""
    trial = outcome.study.trial
    if isinstance(trial, Refusal):
        return Verdict(False, trial.text)
    p = trial.test.dof
    said = text("On average NIS is {expected:.3g} with {p} expected", expected=trial.expected, p=p)
    if outcome.design["belief"] > 0.1 or not 1 <= trial.expected / (FOUND_OUT * p) <= 1.05:
        return Verdict(False, text("{said}; the filter must assume a tenth of the noise or less, and NIS must be 1.5 times that within "
                                   "5 %.",
                                   said=said))
    return Verdict(True, text("{said}: the innovations flag it.", said=said))


def _below_the_tolerance(outcome: Outcome[Study]) -> Verdict:
    """A rank that drops although no mode is hidden."""
    seen = outcome.study.structure.seen
    if isinstance(seen, Refusal):
        return Verdict(False, seen.text)
    n = len(seen.modes)
    rank = seen.matrix_rank(outcome.design["tolerance"])
    if not seen.observable:
        return Verdict(False, text("A mode of this plant is hidden indeed."))
    if rank != n - 1:
        return Verdict(False, text("rank(O) = {rank} of {n} at this tolerance; make it drop by one.", rank=rank, n=n))
    return Verdict(True, text("rank(O) = {rank} of {n} now, and not one mode is hidden: the tolerance decided, "
                              "not the plant.",
                              rank=rank, n=n))


def _spent_margin(outcome: Outcome[Study]) -> Verdict:
    """A disk margin of one, and an observer near the Kalman filter."""
    margins, ratio = outcome.study.margins, times_the_least(outcome.study.noise)
    if isinstance(margins, Refusal):
        return Verdict(False, margins.text)
    if isinstance(ratio, Refusal):
        return Verdict(False, ratio.text)
    margin = margins.together
    if abs(margin - SPENT) > DISK_MARGIN_TOLERANCE:
        return Verdict(False, text("Disk margin {margin:.3g}; 1.0 within 5 % is wanted.", margin=margin))
    if ratio > ERROR:
        return Verdict(False, text("The observer's error is {ratio:.3g} times the least; at most {most:g} times is wanted.",
                                   ratio=ratio, most=ERROR))
    return Verdict(True, text("Disk margin {margin:.3g}, and an error of {ratio:.3g} times the least.", margin=margin, ratio=ratio))


DEADBEAT = Typed("d^2/h", ("d", "h"), slips=(
    ("1/h", text("That is for a velocity that nothing slows, d = 1.")),
    ("d/h", text("The determinant is d (1 − l₁) + h l₂, and l₁ = 1 + d."))))
STROBOSCOPE = Typed("sin(w*h)/w", ("w", "h"), slips=(
    ("sin(w*h)", text("The velocity enters the place divided by w.")),
    ("1", text("That is the continuous oscillator; between two readings it has turned by w h."))))

TASKS = (
    Task("through-the-limit", _through_the_limit, {"limited": True, "fed": APPLIED, "u_max": 0.2}),
    Task("wrong-belief", _wrong_belief, {"belief": 0.05, "sensor": 0.02}),
    Task("below-the-tolerance", _below_the_tolerance, {"tolerance": 0.29}),
    typed_task("deadbeat", DEADBEAT),
    typed_task("stroboscope", STROBOSCOPE),
    Task("spent-margin", _spent_margin, {"method": "weights", "q": 0.5, "r": 1.0, "w": 3.0, "v": 1.0}),
)
