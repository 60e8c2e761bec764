"""The run with its fault, the bank of seven and its verdict as code."""

from __future__ import annotations

import numpy as np

from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Outcome

from .bank import COUNT, DT, MODEL, NAMES, PLACES, Q_WEIGHT, SIGMA, guard, model, truth
from .diagnosis import ENERGY, FADE, HOLD, POWER
from .pairs import judge_pairs, pair_bank, pair_start
from .record import Study
from .runs import NONE, OPEN, SWITCH, Fault, drawn


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
    poles = [Shown(f"eigvals(step_of['m{k}'])", outcome.poles[name], poles=True) for k, name in enumerate(NAMES)]
    return Code(("faults",), (
        Given("A", kf.A, "the deck at its samples, as the bank believes it: x[k+1] = A x + B u + w, y = C x + v"), Given("B", kf.B),
        Given("C", kf.C), Given("Q", kf.Q, "covariance of w"), Given("sigma", SIGMA, "m/s, noise of a reading"), Given("h", DT, "s"),
        Given("count", COUNT), Given("A_true", A_true, "the deck as it is"), Given("B_true", B_true),
        Given("weight", Q_WEIGHT, "of the outputs, against 1 for the inputs"),
        Given("place", -1 if s.column is None else s.column, "what fails: sensor 0 ... 3, coil 4 ... 6, or -1: nothing"),
        Given("kind", case.kind, "how a sensor lies"),
        Given("size", case.size, "mm/s of a bias, mm/s^2 of a drift, share of a coil's force that is lost"),
        Given("fails_at", case.start, "the first sample with the fault"),
        Given("also_place", -1 if also.place == NONE else PLACES.index(also.place), "what fails besides, or -1: nothing"),
        Given("also_kind", also.kind), Given("also_size", also.size), Given("also_fails_at", also.start),
        Given("force", case.force, "N"), Given("tone", case.tone, "Hz"),
        Given("closed", case.loop != OPEN), Given("switches", case.loop == SWITCH, "the loop acts on the verdict"),
        Given("kick_at", round(case.kick / DT) - 1 if case.kick >= 0 else -2, "the sample after which x jumps, -2: never"),
        Given("kick", np.asarray(MODEL.kick)), Given("energy", s.test.statistic == ENERGY, "sum of squares, or square of the mean"),
        Given("window", s.test.window), Given("rate", s.test.rate, "false-alarm rate of one window of one member"),
        Given("hold", HOLD, "samples that one pattern of alarms must last"),
        Given("fade", FADE, "samples in which the bank forgets a kick"), Given("power", POWER),
        Given("seed", int(d["seed"])),
        Given("first_errors", ignoring, "of the members that ignore a coil: drawn in a basis of which there are many, the page's"),
        Given("pair_errors", in_pairs, "of the members that ignore two parts, in the order of their pairs"),
    ), (
        Shown("L", outcome.gains["L"]), *poles, Shown("x", s.record.x), Shown("xhat", s.record.xhat), Shown("y", s.record.y),
        Shown("asked", s.record.asked), Shown("applied", s.record.applied), Shown("statistics", s.verdict.values),
        Shown("pair_statistics", said.values), Shown("named_alone", _named(said.alone, 1)), Shown("named_pair", _named(said.both, 2)),
        *(Shown(name, m[name]) for name in ("threshold", "dof", "needed", "hourly", "accused", "right_verdict", "delay", "expected_delay",
                                            "pitch"))), "Shares over many runs, the cumulative sum, and how small a fault the banks see", (
        Given("w", noise.w), Given("v", noise.v), Given("first_error", noise.whole, "of the filter that the loop believes"),
        Given("first_starts", np.array([noise.bank[part] for part in bank.slices[:4]]), "of the members that leave out a sensor"),
    ), DT)


def _named(verdict: tuple[int, tuple[int, ...]] | None, parts: int) -> np.ndarray:
    """The sample of a verdict and the parts it names, -1 where there is none."""
    return np.array([-1] * (1 + parts) if verdict is None else [verdict[0], *verdict[1]])
