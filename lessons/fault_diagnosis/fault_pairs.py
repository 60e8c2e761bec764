"""Decide which pairs of faults can be isolated, and build a bank that ignores two parts each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np

from observer_lab.engine import residual_generator
from observer_lab.engine.observers import FaultBank, ResidualGenerator, isolate, needed_noncentrality, residual_threshold

from .diagnosis import DETECTION_POWER, ENERGY, Rule, lasting, lasting_fit
from .observer_bank import FAULT_PLACES, MEMBER_NAMES, SAMPLE_COUNT, model
from .runs import Record

Pair = tuple[int, int]
PAIRS: tuple[Pair, ...] = tuple((i, j) for i, j in combinations(range(len(FAULT_PLACES)), 2))
SETS: tuple[tuple[int, ...], ...] = (*((i,) for i in range(len(FAULT_PLACES))), *PAIRS)  # what the bank of pairs may name
ANGLES = (0.11, 0.7, 1.9)  # points on the unit circle at which directions are compared
RANK_RTOL = 1e-7  # singular values below this, of rows and columns of like size, count as zero
ALWAYS_ISOLABLE, MOSTLY_ISOLABLE, NEVER_ISOLABLE = "sure", "special", "never"


# --- what can be told apart ------------------------------------------------------------------------------------------------
@lru_cache(maxsize=1)
def directions() -> tuple[np.ndarray, ...]:
    """H(z) = [I, −C (zI − A)⁻¹ B] (4×7) at ANGLES: what a fault zᵏ of each sensor, and each coil's missing force, adds to the outputs."""
    kf, found = model(), []
    for z in np.exp(1j * np.array(ANGLES)):
        found.append(np.hstack([np.eye(len(kf.C)), -kf.C @ np.linalg.solve(z * np.eye(kf.n) - kf.A, kf.B)]))
    return tuple(found)


@lru_cache(maxsize=256)
def rank_of(faults: frozenset[int]) -> int:
    """Rank of the columns of these faults in H(z), at all z but single ones: the number of courses that can be told apart in y."""
    return max(int(np.sum(np.linalg.svd(_even(H[:, sorted(faults)]), compute_uv=False) > RANK_RTOL)) for H in directions())


def _even(M: np.ndarray) -> np.ndarray:
    for axis in (0, 1, 0):
        size = np.linalg.norm(M, axis=axis, keepdims=True)
        M = M / np.where(size > 0, size, 1.0)
    return M


@lru_cache(maxsize=1)
def rivals() -> dict[Pair, tuple[Pair, ...]]:
    """The pairs that can make the same readings as each pair, for special courses at least: rank [Hₚ H_q] below |P ∪ Q|."""
    return {p: tuple(q for q in PAIRS if q != p and rank_of(frozenset(p + q)) < len({*p, *q})) for p in PAIRS}


@lru_cache(maxsize=32)
def isolable(pair: Pair) -> str:
    """ALWAYS_ISOLABLE: told from any other pair whatever both faults do; MOSTLY_ISOLABLE: but for special courses.

    NEVER_ISOLABLE: another pair does all that this one does.
    """
    others = rivals()[pair]
    if not others:
        return ALWAYS_ISOLABLE
    return NEVER_ISOLABLE if any(rank_of(frozenset(pair + q)) == rank_of(frozenset(q)) for q in others) else MOSTLY_ISOLABLE


# --- the bank of pairs ------------------------------------------------------------------------------------------------------
@lru_cache(maxsize=1)
def pair_bank() -> FaultBank:
    """A member for each pair: it leaves out the sensors of the two and ignores their coils, which leaves two residuals of four."""
    kf = model()

    def member(pair: Pair) -> ResidualGenerator:
        left = [j for j in range(4) if j not in pair]
        coils = [j - 4 for j in pair if j >= 4]
        return residual_generator(kf, name=MEMBER_NAMES[pair[0]] + MEMBER_NAMES[pair[1]], outputs=left, E=kf.B[:, coils] if coils else None)
    return FaultBank(kf, tuple(member(pair) for pair in PAIRS))


@lru_cache(maxsize=1)
def pattern() -> np.ndarray:
    """Which member gives an alarm where these parts fail, bool (21, 28): all that see one of them."""
    return np.column_stack([pair_bank().signature[:, list(faults)].any(axis=1) for faults in SETS])


@lru_cache(maxsize=8)
def pair_start(seed: int) -> np.ndarray:
    rng = None if seed < 0 else np.random.default_rng([seed, 17, 2])
    return pair_bank().start(np.zeros(model().n), rng=rng)


@dataclass(frozen=True, eq=False)
class PairVerdict:
    """values (SAMPLE_COUNT, 21): statistic over threshold of each member. named (SAMPLE_COUNT,): number in SETS, −1 none, −2 unclear.

    alone, both: sample and parts of the first accusation of one part and of two; None where there is none.
    """

    values: np.ndarray
    named: np.ndarray
    alone: tuple[int, tuple[int, ...]] | None
    both: tuple[int, tuple[int, ...]] | None


def _dof(test: Rule) -> int:
    return pair_bank().dof * (test.window if test.statistic == ENERGY else 1)


def values_of(test: Rule, record: Record, seed: int) -> np.ndarray:
    """The statistic of the windows that end at each sample, (SAMPLE_COUNT, 21), of the bank of pairs on a record."""
    return test.values(pair_bank().run(record.y, record.asked, pair_start(seed))[0])


def judge_pairs(test: Rule, record: Record, seed: int) -> PairVerdict:
    """The rule of seven members: alarms that fit one column for ALARM_HOLD_SAMPLES samples, the members that ignore it quiet before."""
    ratio = values_of(test, record, seed) / _threshold(_dof(test), test.rate)
    at = lasting_fit(ratio > 1, pattern(), test.window)

    def first(size: int) -> tuple[int, tuple[int, ...]] | None:
        columns = [k for k, faults in enumerate(SETS) if len(faults) == size]
        best = min(columns, key=lambda k: int(at[k]))
        return (int(at[best]), SETS[best]) if at[best] < SAMPLE_COUNT else None
    return PairVerdict(ratio, isolate(ratio > 1, pattern()), first(1), first(2))


def strength_of(test: Rule, silent: Record) -> np.ndarray:
    """Noncentrality of each window over what DETECTION_POWER asks for, (SAMPLE_COUNT, 21), in the run without noise."""
    return values_of(test, silent, -1) / _needed(_dof(test), test.rate, DETECTION_POWER)


_threshold = lru_cache(maxsize=64)(residual_threshold)
_needed = lru_cache(maxsize=64)(needed_noncentrality)


def due(test: Rule, silent: Record, pair: Pair, start: int) -> int | None:
    """Samples from `start` until, without noise, every member that sees one of the two gives an alarm with probability DETECTION_POWER."""
    seen = pattern()[:, SETS.index(pair)]
    at = int(lasting(np.all(strength_of(test, silent)[start:, seen] >= 1, axis=1, keepdims=True))[0])
    return at if at < SAMPLE_COUNT else None
