"""Say which fault the diagnosis names, whether rightly, and what the bank of pairs finds."""

from __future__ import annotations

from observer_lab.course.figures.claims import claim
from observer_lab.text import NO_WORDS, Text, joined, text

from .diagnosis import NO_FAULT, UNCLEAR_FAULT
from .fault_pairs import PairVerdict
from .observer_bank import DT, FAULT_PLACES, SAMPLE_COUNT
from .results import Study
from .runs import NONE


def live(s: Study) -> Text:
    """The sentence of the present design."""
    return joined(_verdict(s), together(s))


def _verdict(s: Study) -> Text:
    v, place, also = s.verdict, s.case.place, s.case.also
    if v.who is None:
        alarms = NO_WORDS if v.first is None else text("First alarm at {first:.2f} s.", first=DT * v.first)
        healthy = text("Nothing fails and no fault is diagnosed.")
        missed = (text("{place} fails at {dt:.1f} s and no fault is diagnosed.", place=place, dt=DT * s.case.start) if also is None else
                  text("{place} fails at {dt:.1f} s, {other} at {dt2:.1f} s, and no fault is diagnosed.", place=place, dt=DT * s.case.start,
                       other=also.place, dt2=DT * also.start))
        return joined(healthy if place == NONE else missed, alarms)
    if s.accused is None:
        return text("{who} is diagnosed at {at:.2f} s, wrongly.", who=v.who, at=DT * (v.decided or 0))
    due = (NO_WORDS if s.forecast.delay is None or s.accused.place != place else
           text("Without a kick the design expects it after {expected:.2f} s.", expected=DT * s.forecast.delay))
    return joined(text("{who} is correctly identified {delay:.2f} s after it failed.", who=v.who, delay=s.delay), due)


def together(s: Study) -> Text:
    """What seven members that each expect one fault say most of the time, from the first window on that lies behind the second."""
    also = s.case.also
    if also is None:
        return NO_WORDS
    named = s.verdict.named[also.start + s.test.window - 1:].tolist()
    if not named:
        return text("{place} fails at {dt:.1f} s, too late for a full window.", place=also.place, dt=DT * also.start)
    said = max(sorted(set(named)), key=named.count)
    share = 100 * named.count(said) / len(named)
    if said == NO_FAULT:
        words = text("With both faults no member gives an alarm for {share:.3g} % of the time.", share=share)
    elif said == UNCLEAR_FAULT:
        words = text("With both faults the alarms fit no row for {share:.3g} % of the time: something fails, but the bank cannot say what.",
                     share=share)
    elif FAULT_PLACES[said] in (s.case.place, also.place):
        other = also.place if FAULT_PLACES[said] == s.case.place else s.case.place
        words = text("With both faults the alarms fit the row of {who} for {share:.3g} % of the time: {other} goes unnoticed.",
                     who=FAULT_PLACES[said], share=share, other=other)
    else:
        words = text("With both faults the alarms fit the row of {who}, which is healthy, for {share:.3g} % of the time.",
                     who=FAULT_PLACES[said], share=share)
    return claim(words, share, above=0.0)


def of_pairs(s: Study, v: PairVerdict) -> Text:
    """What the bank of pairs says, of two faults or of one."""
    if s.case.also is None:
        return _alone(v)
    if v.both is None:
        quiet = int((v.values[-1] <= 1).sum())
        return claim(text("The bank of pairs names no pair: at the end {quiet} of its {count} members are below their threshold, not "
                          "one.", quiet=quiet,
                          count=v.values.shape[1]) if quiet != 1 else
                     text("The bank of pairs names no pair: its one member below the threshold was above it before, or below it too "
                          "briefly."),
                     float(quiet), above=-1.0)
    at, (i, j) = v.both
    delay = DT * (at - s.case.also.start)
    wrong = text(
        "The bank of pairs names {first} and {second} at {at:.2f} s, wrongly.", first=FAULT_PLACES[i], second=FAULT_PLACES[j], at=DT * at
    )
    if (i, j) != s.pair:
        return wrong
    return claim(text("The bank of pairs names {first} and {second} {delay:.2f} s after the second fault, rightly.", first=FAULT_PLACES[i],
                      second=FAULT_PLACES[j], delay=delay), delay, above=0.0, otherwise=wrong)


def _alone(v: PairVerdict) -> Text:
    if v.both is not None:
        at, (i, j) = v.both
        return text(
            "The bank of pairs names {first} and {second} at {at:.2f} s, wrongly.",
            first=FAULT_PLACES[i],
            second=FAULT_PLACES[j],
            at=DT * at,
        )
    if v.alone is None:
        return text("The bank of pairs diagnoses no part.")
    at, (i,) = v.alone
    return text("The bank of pairs names {who} at {at:.2f} s: all six members that ignore it are below their "
                "threshold.", who=FAULT_PLACES[i], at=DT * at)


def when_talked_about(s: Study, v: PairVerdict) -> int:
    """The sample of which the table of the bank of pairs tells: that of its verdict, or the last."""
    verdict = v.both if s.case.also is not None else v.both or v.alone
    return SAMPLE_COUNT - 1 if verdict is None else verdict[0]
