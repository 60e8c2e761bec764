"""Describe the run with its fault, the bank of seven and its diagnosis as code."""

from __future__ import annotations

import math

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue

from .diagnosis import ALARM_HOLD_SAMPLES, DETECTION_POWER, ENERGY, FADE
from .fault_pairs import judge_pairs, pair_bank, pair_start
from .observer_bank import DT, FAULT_PLACES, MEMBER_NAMES, MODEL, Q_WEIGHT, SAMPLE_COUNT, SENSOR_SIGMA, guard, model, truth
from .results import Study
from .runs import KEEP_LOOP_OPEN, NONE, SWITCH_LOOP, Fault, drawn


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, s = outcome.design, outcome.metrics, outcome.study
    case, also, kf, bank = s.case, s.case.also or Fault(), model(), guard().bank
    A_true, B_true = truth(case.stiffer)
    noise = drawn(int(d["seed"]))
    ignoring = np.array([member.basis @ noise.bank[part] for member, part in zip(bank.members, bank.slices, strict=True)][4:])
    two = pair_bank()
    in_pairs = np.array([member.basis @ start for member, start in zip(two.members, np.split(pair_start(int(d["seed"])), [
        part.stop for part in two.slices[:-1]]), strict=True)])
    said = judge_pairs(s.test, s.record, int(d["seed"]))
    poles = [ShownValue(f"eigvals(step_of['m{k}'])", outcome.poles[name], poles=True) for k, name in enumerate(MEMBER_NAMES)]
    return Code(
        ("faults",),
        (
            GivenValue("A", kf.A, "the bank's model of the deck at its samples: x[k+1] = A x + B u + w, y = C x + v"),
            GivenValue("B", kf.B),
            GivenValue("C", kf.C),
            GivenValue("Q", kf.Q, "covariance of w"),
            GivenValue("sigma", SENSOR_SIGMA, "m/s, noise of a reading"),
            GivenValue("h", DT, "s"),
            GivenValue("count", SAMPLE_COUNT),
            GivenValue("A_true", A_true, "the deck as it is"),
            GivenValue("B_true", B_true),
            GivenValue("weight", Q_WEIGHT, "of the outputs, against 1 for the inputs"),
            GivenValue("place", -1 if s.column is None else s.column, "what fails: sensor 0 ... 3, coil 4 ... 6, or -1: nothing"),
            GivenValue("kind", case.kind, "how a sensor fails"),
            GivenValue("size", case.size, "mm/s of a bias, mm/s^2 of a drift, share of a coil's force that is lost"),
            GivenValue("fails_at", case.start, "the first sample with the fault"),
            GivenValue("also_place", -1 if also.place == NONE else FAULT_PLACES.index(also.place), "what fails besides, or -1: nothing"),
            GivenValue("also_kind", also.kind),
            GivenValue("also_size", also.size),
            GivenValue("also_fails_at", also.start),
            GivenValue("force", case.force, "N"),
            GivenValue("tone", case.tone, "Hz"),
            GivenValue("closed", case.loop != KEEP_LOOP_OPEN),
            GivenValue("switches", case.loop == SWITCH_LOOP, "the loop acts on the verdict"),
            GivenValue("kick_at", round(case.kick / DT) - 1 if case.kick >= 0 else -2, "the sample after which x jumps, -2: never"),
            GivenValue("kick", np.asarray(MODEL.kick)),
            GivenValue("energy", s.test.statistic == ENERGY, "sum of squares, or square of the mean"),
            GivenValue("window", s.test.window),
            GivenValue("rate", s.test.rate, "false-alarm rate of one window of one member"),
            GivenValue("hold", ALARM_HOLD_SAMPLES, "samples that one pattern of alarms must last"),
            GivenValue("fade", FADE, "samples until a kick has no more effect on the bank"),
            GivenValue("power", DETECTION_POWER),
            GivenValue("seed", int(d["seed"])),
            GivenValue("first_errors", ignoring, "of the members that ignore a coil: drawn in one of many bases, the page's"),
            GivenValue("pair_errors", in_pairs, "of the members that ignore two parts, in the order of their pairs"),
        ),
        (
            ShownValue("L", outcome.gains["L"]),
            *poles,
            ShownValue("x", s.record.x),
            ShownValue("xhat", s.record.xhat),
            ShownValue("y", s.record.y),
            ShownValue("asked", s.record.asked),
            ShownValue("applied", s.record.applied),
            ShownValue("statistics", s.verdict.values),
            ShownValue("pair_statistics", said.values),
            ShownValue("named_alone", _named(said.alone, 1)),
            ShownValue("named_pair", _named(said.both, 2)),
            *(
                ShownValue(name, m[name] if math.isfinite(m[name]) else -1.0)
                for name in ("threshold", "dof", "needed", "accused", "right_verdict", "delay", "expected_delay", "pitch")
            ),
        ),
        "Shares over many runs, the cumulative sum, and how small a fault the banks detect",
        (
            GivenValue("w", noise.w),
            GivenValue("v", noise.v),
            GivenValue("first_error", noise.whole, "of the filter that the loop uses"),
            GivenValue("first_starts", np.array([noise.bank[part] for part in bank.slices[:4]]), "of the members that leave out a sensor"),
        ),
        DT,
    )


def _named(verdict: tuple[int, tuple[int, ...]] | None, parts: int) -> np.ndarray:
    """The sample of a verdict and the parts it names, -1 where there is none."""
    return np.array([-1] * (1 + parts) if verdict is None else [verdict[0], *verdict[1]])
