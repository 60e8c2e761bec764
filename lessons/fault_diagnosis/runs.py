"""Simulate one run with one or two faults: deck, loop with its filter, and the bank."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from observer_lab.engine.observers import ResidualGenerator
from observer_lab.engine.systems import affine_scan, root

from .observer_bank import DT, FAULT_PLACES, MODEL, SAMPLE_COUNT, SENSOR_SIGMA, gain, guard, model, truth

NONE = "none"
BIAS_FAULT, DRIFT_FAULT, STUCK_FAULT = "bias", "drift", "stuck"
KEEP_LOOP_OPEN, NO_REACTION, SWITCH_LOOP = "open", "blind", "switch"


@dataclass(frozen=True)
class Fault:
    """What fails, how, how much and when. `size`: mm/s of a bias, mm/s² of a drift, share of a coil's force that is lost."""

    place: str = NONE
    kind: str = BIAS_FAULT
    size: float = 0.0
    at: float = 4.0

    @property
    def sensor(self) -> int | None:
        """Which sensor lies, if any."""
        index = FAULT_PLACES.index(self.place) if self.place != NONE else 4
        return index if index < 4 else None

    @property
    def coil(self) -> int | None:
        """Which coil is weak, if any."""
        index = FAULT_PLACES.index(self.place) if self.place != NONE else 0
        return index - 4 if index >= 4 else None

    @property
    def start(self) -> int:
        """The first sample with the fault; beyond the record if there is none."""
        return SAMPLE_COUNT if self.place == NONE else min(max(round(self.at / DT), 1), SAMPLE_COUNT)


@dataclass(frozen=True)
class Case(Fault):
    """What is simulated: a fault, `also` one of another part that begins no sooner, and what goes on besides.

    `force` N and `tone` Hz: the known force on top of what the loop asks for. `stiffer`: share by which the true vertical
    springs are stiffer than the model's.
    """

    force: float = 1.0
    tone: float = 0.5
    loop: str = NO_REACTION
    stiffer: float = 0.0
    kick: float = -1.0
    also: Fault | None = None

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The faults in the order in which they begin."""
        return tuple(f for f in (self, self.also) if f is not None and f.place != NONE)


@dataclass(frozen=True, eq=False)
class Noise:
    """What is drawn: jumps of the state w (SAMPLE_COUNT, 6), noise of the readings v (SAMPLE_COUNT, 4), filters' errors at the start."""

    w: np.ndarray
    v: np.ndarray
    whole: np.ndarray
    bank: np.ndarray


def draw(seed: int) -> Noise:
    """The draws of a seed; −1 is silence, every filter starting from the truth."""
    g = guard()
    if seed < 0:
        return Noise(np.zeros((SAMPLE_COUNT, 6)), np.zeros((SAMPLE_COUNT, 4)), np.zeros(6), g.bank.start(np.zeros(6)))
    rng = np.random.default_rng([seed, 17])
    shake, spread = _roots()
    w = rng.standard_normal((SAMPLE_COUNT, 6)) @ shake.T
    v = SENSOR_SIGMA * rng.standard_normal((SAMPLE_COUNT, 4))
    bank = g.bank.start(np.zeros(6), rng=rng)
    return Noise(w, v, -spread @ rng.standard_normal(6), bank)


@lru_cache(maxsize=1)
def _roots() -> tuple[np.ndarray, np.ndarray]:
    return root(model().Q), root(guard().whole.P)


drawn = lru_cache(maxsize=8)(draw)


def known_force(case: Case) -> np.ndarray:
    """The known force, (SAMPLE_COUNT, 3): both vertical coils in step, the third a quarter period ahead; it sets in softly."""
    t = DT * np.arange(SAMPLE_COUNT)
    angle, rise = 2 * np.pi * case.tone * t, case.force * (1 - np.exp(-2 * t))
    return np.column_stack([rise * np.sin(angle), rise * np.sin(angle), rise * np.cos(angle)])


@dataclass(frozen=True, eq=False)
class Deck:
    """The deck with what has failed so far: B and C as they are; added to C x (SAMPLE_COUNT, …, 4): noise, bias, what is stuck."""

    B: np.ndarray
    C: np.ndarray
    extra: np.ndarray


def stretches(case: Case, begin: int) -> Iterator[tuple[int, int]]:
    """From a sample to the end of the record, cut wherever a fault begins."""
    return pairwise(sorted({begin, SAMPLE_COUNT, *(f.start for f in case.faults if begin < f.start)}))


def failed(case: Case, v: np.ndarray, x: np.ndarray, now: int) -> Deck:
    """The deck from sample `now` until the next fault, for noise v (SAMPLE_COUNT, …, 4), x (SAMPLE_COUNT, …, 6) known up to `now`."""
    honest, (_, B), C, extra = model().C, truth(case.stiffer), model().C, v
    for fault in case.faults:
        if fault.start > now or fault.start >= SAMPLE_COUNT:
            continue
        start = fault.start
        if fault.coil is not None:
            B = B.copy()
            B[:, fault.coil] *= 1 - fault.size
        elif (i := fault.sensor) is not None:
            C, extra = C.copy(), extra.copy()
            if fault.kind == STUCK_FAULT:
                C[i], extra[start:, ..., i] = 0.0, x[start] @ honest[i] + v[start, ..., i]
            else:
                grown = DT * np.arange(SAMPLE_COUNT - start) if fault.kind == DRIFT_FAULT else np.ones(SAMPLE_COUNT - start)
                extra[start:, ..., i] += 1e-3 * fault.size * grown.reshape(-1, *[1] * (v.ndim - 2))
    return Deck(B, C, extra)


@dataclass(frozen=True, eq=False)
class Record:
    """States x, estimates that the loop uses, readings y, what honest sensors would read, forces asked and delivered.

    residuals (SAMPLE_COUNT, 7, 3) of the bank, states of its members (SAMPLE_COUNT, N). All time-first.
    """

    x: np.ndarray
    xhat: np.ndarray
    y: np.ndarray
    honest: np.ndarray
    asked: np.ndarray
    applied: np.ndarray
    residuals: np.ndarray
    states: np.ndarray


@dataclass(frozen=True, eq=False)
class _Loop:
    """Who is believed: the gain, the observer, and the force that is known to it."""

    K: np.ndarray
    observer: ResidualGenerator
    known: np.ndarray


@dataclass(frozen=True, eq=False)
class _Trace:
    """What a run fills: states, estimates, forces asked."""

    x: np.ndarray
    guess: np.ndarray
    asked: np.ndarray


def simulate(case: Case, noise: Noise) -> Record:
    """The run in which nobody notices: the loop keeps believing all four sensors."""
    loop = _Loop(gain() if case.loop != KEEP_LOOP_OPEN else np.zeros((3, 6)), guard().whole, known_force(case))
    trace = _Trace(np.empty((SAMPLE_COUNT, 6)), np.empty((SAMPLE_COUNT, 6)), np.empty((SAMPLE_COUNT, 3)))
    _through(case, noise, loop, 0, np.concatenate([np.zeros(6), noise.whole]), trace)
    return _finish(case, noise, trace)


def switched(case: Case, noise: Noise, before: Record, decided: int, verdict: str) -> Record:
    """The run in which the loop acts on the verdict: the accused sensor is left out, or the accused coil is no longer used."""
    g, index = guard(), FAULT_PLACES.index(verdict)
    sensor, coil = index < 4, index - 4
    xhat = before.states[decided][g.bank.slices[index]] if sensor else before.xhat[decided]
    shape = known_force(case)
    if not sensor:
        shape[:, coil] = 0.0
    loop = _Loop(gain(None if sensor else coil), g.bank.members[index] if sensor else g.whole, shape)
    trace = _Trace(before.x.copy(), before.xhat.copy(), before.asked.copy())
    _through(case, noise, loop, decided, np.concatenate([before.x[decided], xhat]), trace)
    return _finish(case, noise, trace)


def _through(case: Case, noise: Noise, loop: _Loop, begin: int, z: np.ndarray, trace: _Trace) -> None:
    """Fill the trace from `begin` on, where (x, x̂) = z, stretch by stretch."""
    for first, end in stretches(case, begin):
        trace.x[first] = z[:6]
        z = _march(case, noise, loop, failed(case, noise.v, trace.x, first), first, end, z, trace)


def _march(case: Case, noise: Noise, loop: _Loop, deck: Deck, begin: int, end: int, z0: np.ndarray, trace: _Trace) -> np.ndarray:
    """Fill samples begin … end − 1 of x, x̂ and u; returns (x, x̂) at `end`. z⁺ = Φ z + forcing for z = (x, x̂)."""
    A, o = truth(case.stiffer)[0], loop.observer
    Phi = np.block([[A, -deck.B @ loop.K], [o.K @ deck.C, o.F - o.G @ loop.K]])
    r = loop.known[begin:end]
    forcing = np.hstack([r @ deck.B.T + noise.w[begin:end], r @ o.G.T + deck.extra[begin:end] @ o.K.T])
    kicked = round(case.kick / DT) - 1 if case.kick >= 0 else -1
    if begin <= max(kicked, 0) < end and case.kick >= 0:
        forcing[max(kicked, 0) - begin, :6] += MODEL.kick
    z = affine_scan(Phi, forcing, z0, end - begin)
    trace.x[begin:end], trace.guess[begin:end] = z[:-1, :6], z[:-1, 6:]
    trace.asked[begin:end] = r - trace.guess[begin:end] @ loop.K.T
    return z[-1]


def _finish(case: Case, noise: Noise, trace: _Trace) -> Record:
    x, honest, y, applied = trace.x, trace.x @ model().C.T, np.empty((SAMPLE_COUNT, 4)), trace.asked
    for begin, end in stretches(case, 0):
        deck = failed(case, noise.v, x, begin)
        y[begin:end] = x[begin:end] @ deck.C.T + deck.extra[begin:end]
    for fault in case.faults:
        if fault.coil is not None:
            applied = applied.copy()
            applied[fault.start:, fault.coil] *= 1 - fault.size
    residuals, states = guard().bank.run(y, trace.asked, noise.bank)
    return Record(x, trace.guess, y, honest, trace.asked, applied, residuals, states)


def quiet(case: Case) -> Record:
    """The same run without any noise, nobody noticing: what the fault alone, and a wrong model, does to the residuals."""
    return simulate(replace(case, kick=-1.0), drawn(-1))
