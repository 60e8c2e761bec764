"""Define the tasks of lesson 17."""

from __future__ import annotations

import numpy as np

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.engine.observers import alarm_probability
from observer_lab.text import Text, text

from .diagnosis import MEAN, forecast
from .observer_bank import DT, FAULT_PLACES
from .results import Study
from .run_length import duration
from .runs import KEEP_LOOP_OPEN, SWITCH_LOOP
from .sensitivity import least_beside
from .study import between

HOUR, SOONEST, MAX_PITCH_MRAD = 3600.0, 3.0, 1.5  # s between two false alarms, s, mrad
MAX_LOST_SHARE, MAX_FORCE_N = 0.5, 1.0  # share lost, N
MAX_DRIFT, NEAR, DUE = 1.0, 1.1, 2.12  # mm/s², times an hour between two false alarms, s
SECOND_FAULT, MAX_DELAY_SAMPLES = "VL", 90  # the sensor that fails besides, samples
MIN_BIAS_MM_S, WRONG_DIAGNOSIS, MAX_ALARM_PERCENT = 3.0, "u3", 1.0  # mm/s, a coil that has not failed, per cent


def _rare(o: Outcome[Study]) -> Verdict:
    s: Study = o.study
    if s.case.place != "VL" or s.case.kind != "bias" or s.case.size > 3:
        return Verdict(False, text("Let VL have a bias of at most 3 mm/s."))
    time, delay = between(s), s.forecast.delay
    said = _said(time, delay)
    if time >= HOUR and delay is not None and DT * delay <= SOONEST:
        return Verdict(True, text("{said} Both as wanted.", said=said))
    return Verdict(False, text("{said} Wanted: at least one hour, and at most {soonest:.0f} s.", said=said, soonest=SOONEST))


def _said(time: float, delay: int | None) -> Text:
    """The mean time between false alarms and when the fault is due."""
    if delay is None:
        return text("One false alarm every {time} on average; not all six members detect the fault with 99 %.", time=duration(time))
    return text("One false alarm every {time} on average; all six members detect the fault with 99 % after {dt:.2f} "
                "s.", time=duration(time),
                dt=DT * delay)


def _weak(o: Outcome[Study]) -> Verdict:
    s: Study = o.study
    if s.case.place != "u1" or s.case.size > MAX_LOST_SHARE or s.case.force > MAX_FORCE_N:
        return Verdict(False, text("Let u1 lose at most {half:.0f} % and keep the known force at or below "
                                   "{most:.0f} N.",
                                   half=100 * MAX_LOST_SHARE, most=MAX_FORCE_N))
    delay = s.forecast.delay
    seen = FAULT_PLACES.index("u1")
    worst = 100 * float(np.max(np.min(np.delete(s.forecast.strength, seen, axis=1), axis=1)))
    if delay is None:
        return Verdict(False, text("The member with the smallest signal gets {worst:.0f} % of what 99 % power takes.",
                                   worst=worst))
    return Verdict(True, text("All six detect it with 99 % after {dt:.2f} s.", dt=DT * delay))


def _unseen(o: Outcome[Study]) -> Verdict:
    s: Study = o.study
    if s.case.coil is None or s.case.size < 1:
        return Verdict(False, text("Let a coil lose everything."))
    moved = float(np.abs(s.record.asked - s.record.applied).max())
    if moved > 0:
        return Verdict(False, text("Up to {moved:.2g} N are missing, and every member but one can detect that.",
                                   moved=moved))
    return Verdict(True, text("Nothing was asked, so nothing is missing: the residuals are those of a healthy "
                              "deck."))


def _limp(o: Outcome[Study]) -> Verdict:
    s: Study = o.study
    if s.case.place != "VR" or s.case.kind != "drift" or s.case.size < 4 or s.case.start * DT > 4.01 or s.case.loop == KEEP_LOOP_OPEN:
        return Verdict(False, text("Let VR drift by at least 4 mm/s² from 4 s or before, the loop closed."))
    pitch = 1e3 * s.calm
    said = text("Without noise the pitch reaches {pitch:.1f} mrad", pitch=pitch)
    if pitch > MAX_PITCH_MRAD:
        return Verdict(False, text("{said}; at most {calm:.1f} mrad are wanted.", said=said, calm=MAX_PITCH_MRAD))
    return Verdict(True, text("{said} and the deck goes on without VR.", said=said))


def _ramp(o: Outcome[Study]) -> Verdict:
    s: Study = o.study
    if s.case.place != "HR" or s.case.kind != "drift" or s.case.size > MAX_DRIFT or s.case.stiffer:
        return Verdict(False, text("Let HR drift by at most 1 mm/s², with springs as the model has them."))
    time, delay = between(s), s.forecast.delay
    if HOUR / NEAR <= time <= HOUR * NEAR and delay is not None and DT * delay <= DUE + 1e-9:
        return Verdict(True, _said(time, delay))
    return Verdict(False, text("{said} Wanted: one hour within 10 %, and at most {soonest:.2f} s.", said=_said(time, delay), soonest=DUE))


def _beside(o: Outcome[Study]) -> Verdict:
    s, d = o.study, o.design
    if (
        d["place"] != "u1"
        or d["loss"] > 100 * MAX_LOST_SHARE
        or d["place2"] != SECOND_FAULT
        or s.case.force > MAX_FORCE_N
        or s.case.loop != KEEP_LOOP_OPEN
    ):
        return Verdict(False, text("Let u1 lose at most {half:.0f} % and {liar} fail as well, with the loop open and a known force of at "
                                   "most {most:.0f} N.", half=100 * MAX_LOST_SHARE, liar=SECOND_FAULT, most=MAX_FORCE_N))
    time, missing = between(s), s.case.force * d["loss"] / 100
    least = float(least_beside(s.test, s.case.tone)[FAULT_PLACES.index("u1"), FAULT_PLACES.index(SECOND_FAULT)])
    said = text("{missing:.2f} N are missing, and beside {liar} u1 is seen from {least:.2f} N on", missing=missing,
                liar=SECOND_FAULT, least=least)
    if least > missing:
        return Verdict(False, text("{said}: that is more.", said=said))
    if time < HOUR or s.test.window > MAX_DELAY_SAMPLES:
        return Verdict(False, text("{said}, with one false alarm every {time} on average and a window of {window} samples. Wanted: at "
                                   "least one hour, and at most {longest} samples.", said=said, time=duration(time), window=s.test.window,
                                   longest=MAX_DELAY_SAMPLES))
    return Verdict(True, text("{said}, whatever {liar} does.", said=said, liar=SECOND_FAULT))


def _wrong_diagnosis(o: Outcome[Study]) -> Verdict:
    s: Study = o.study
    biased = o.design["place"] == "HL" and o.design["kind"] == "bias" and o.design["bias"] >= MIN_BIAS_MM_S
    if not biased or any(f.coil is not None for f in s.case.faults):
        return Verdict(False, text("Let HL have a bias of at least {lie:.0f} mm/s, and no coil fail.", lie=MIN_BIAS_MM_S))
    column = FAULT_PLACES.index(WRONG_DIAGNOSIS)
    due = forecast(s.test, s.silent, column, s.case.start).delay
    heard = float(s.test.values(s.silent.residuals)[:, column].max())
    alarm = 100 * float(alarm_probability(heard, s.test.dof, s.test.rate))
    if alarm > MAX_ALARM_PERCENT:
        return Verdict(False, text("Member −{who} would give an alarm with {alarm:.2g} %; above {most:.0f} % {who} is not diagnosed.",
                                   who=WRONG_DIAGNOSIS, alarm=alarm, most=MAX_ALARM_PERCENT))
    if due is None:
        return Verdict(False, text("Member −{who} gives no alarm, but not all the others detect it with 99 %.", who=WRONG_DIAGNOSIS))
    return Verdict(True, text("All others detect it with 99 % after {dt:.2f} s and −{who} gives no alarm: {who} is diagnosed although it "
                              "is fault-free.",
                              dt=DT * due, who=WRONG_DIAGNOSIS))


SWALLOWED = Typed("a*f/(a+L)", ("a", "L", "f"), slips=(
    ("f", text("That is the first moment; then the observer follows its sensor.")),
    ("L*f/(a+L)", text("That is how far the estimate is led astray; the residual is what is left of f."))))

TASKS = (
    Task("rare", _rare, {"place": "VL", "statistic": MEAN, "window": 100.0, "rate": 1.2e-5}),
    Task("weak", _weak, {"place": "u1", "loss": 50.0, "loop": KEEP_LOOP_OPEN, "tone": 1.4}),
    Task("unseen", _unseen, {"place": "u1", "loss": 100.0, "loop": KEEP_LOOP_OPEN, "force": 0.0}),
    Task("limp", _limp, {"place": "VR", "kind": "drift", "drift": 4.0, "loop": SWITCH_LOOP, "statistic": MEAN}),
    typed_task("swallowed", SWALLOWED),
    Task("ramp", _ramp, {"place": "HR", "kind": "drift", "drift": 1.0, "statistic": MEAN, "window": 64.0, "rate": 8.3e-6}),
    Task("framed", _wrong_diagnosis, {"place2": "HR", "bias2": -3.0, "at2": 4.0}),
    Task(
        "beside",
        _beside,
        {"place": "u1", "loss": 50.0, "place2": SECOND_FAULT, "loop": KEEP_LOOP_OPEN, "tone": 1.2, "window": 90.0, "rate": 8.4e-6},
    ),
)
