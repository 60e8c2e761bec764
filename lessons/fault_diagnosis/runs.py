"""One run: the deck, a fault at a chosen time and place, the loop that believes its filter, and the bank that watches."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from app.engine.observers import ResidualGenerator
from app.engine.systems import affine_scan, root

from .bank import COUNT, DT, MODEL, PLACES, SIGMA, gain, guard, model, truth

NONE = "none"
BIAS, DRIFT, STUCK = "bias", "drift", "stuck"
OPEN, BLIND, SWITCH = "open", "blind", "switch"


@dataclass(frozen=True)
class Case:
    """What is simulated. `size`: mm/s of a bias, mm/s² of a drift, share of a coil's force that is lost.

    `force` N and `tone` Hz: the known force on top of what the loop asks for. `stiffer`: share by which the true vertical
    springs are stiffer than the model's.
    """

    place: str = NONE
    kind: str = BIAS
    size: float = 0.0
    at: float = 4.0
    force: float = 1.0
    tone: float = 0.5
    loop: str = BLIND
    stiffer: float = 0.0
    kick: float = -1.0

    @property
    def sensor(self) -> int | None:
        """Which sensor lies, if any."""
        index = PLACES.index(self.place) if self.place != NONE else 4
        return index if index < 4 else None

    @property
    def coil(self) -> int | None:
        """Which coil is weak, if any."""
        index = PLACES.index(self.place) if self.place != NONE else 0
        return index - 4 if index >= 4 else None

    @property
    def start(self) -> int:
        """The first sample with the fault; beyond the record if there is none."""
        return COUNT if self.place == NONE else min(max(round(self.at / DT), 1), COUNT)


@dataclass(frozen=True, eq=False)
class Noise:
    """What is drawn: jumps of the state w (COUNT, 6), noise of the readings v (COUNT, 4), errors of all filters at the start."""

    w: np.ndarray
    v: np.ndarray
    whole: np.ndarray
    bank: np.ndarray


def draw(seed: int) -> Noise:
    """The draws of a seed; −1 is silence, every filter starting from the truth."""
    g = guard()
    if seed < 0:
        return Noise(np.zeros((COUNT, 6)), np.zeros((COUNT, 4)), np.zeros(6), g.bank.start(np.zeros(6)))
    rng = np.random.default_rng([seed, 17])
    shake, spread = _roots()
    w = rng.standard_normal((COUNT, 6)) @ shake.T
    v = SIGMA * rng.standard_normal((COUNT, 4))
    bank = g.bank.start(np.zeros(6), rng=rng)
    return Noise(w, v, -spread @ rng.standard_normal(6), bank)


@lru_cache(maxsize=1)
def _roots() -> tuple[np.ndarray, np.ndarray]:
    return root(model().Q), root(guard().whole.P)


drawn = lru_cache(maxsize=8)(draw)


def known_force(case: Case) -> np.ndarray:
    """The known force, (COUNT, 3): both vertical coils in step, the third a quarter period ahead; it sets in softly."""
    t = DT * np.arange(COUNT)
    angle, rise = 2 * np.pi * case.tone * t, case.force * (1 - np.exp(-2 * t))
    return np.column_stack([rise * np.sin(angle), rise * np.sin(angle), rise * np.cos(angle)])


@dataclass(frozen=True, eq=False)
class Record:
    """States x, estimates that the loop uses, readings y, what honest sensors would read, forces asked and delivered.

    residuals (COUNT, 7, 3) of the bank, states of its members (COUNT, N). All time-first.
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
class _Leg:
    """A stretch of the run in which nothing changes: which observer the loop believes, its gain, what reaches what."""

    K: np.ndarray
    observer: ResidualGenerator
    B: np.ndarray
    C: np.ndarray
    known: np.ndarray


def simulate(case: Case, noise: Noise) -> Record:
    """The run in which nobody notices: the loop keeps believing all four sensors."""
    K = gain() if case.loop != OPEN else np.zeros((3, 6))
    return _finish(case, noise, *_healthy_then_not(case, noise, K))


def switched(case: Case, noise: Noise, before: Record, decided: int, verdict: str) -> Record:
    """The run in which the loop acts on the verdict: the accused sensor is left out, or the accused coil is no longer used."""
    g, index = guard(), PLACES.index(verdict)
    sensor, coil = index < 4, index - 4
    observer = g.bank.members[index] if sensor else g.whole
    xhat = before.states[decided][g.bank.slices[index]] if sensor else before.xhat[decided]
    shape = known_force(case)
    if not sensor:
        shape[:, coil] = 0.0
    start = min(case.start, COUNT - 1)
    B, C, extra = _lies(case, noise, before.honest[start] + noise.v[start])
    leg = _Leg(gain(None if sensor else coil), observer, B, C, shape)
    x, guess, asked = before.x.copy(), before.xhat.copy(), before.asked.copy()
    _march(case, noise, leg, extra, decided, COUNT, np.concatenate([x[decided], xhat]), x, guess, asked)
    return _finish(case, noise, x, guess, asked)


def _healthy_then_not(case: Case, noise: Noise, K: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    g, kf = guard(), model()
    _, B = truth(case.stiffer)
    x, guess, asked = np.empty((COUNT, 6)), np.empty((COUNT, 6)), np.empty((COUNT, 3))
    shape, start = known_force(case), min(case.start, COUNT)
    first = _Leg(K, g.whole, B, kf.C, shape)
    z = _march(case, noise, first, noise.v, 0, start, np.concatenate([np.zeros(6), noise.whole]), x, guess, asked)
    if start < COUNT:
        x[start] = z[:6]
        stuck = kf.C @ x[start] + noise.v[start]
        B, C, extra = _lies(case, noise, stuck)
        _march(case, noise, _Leg(K, g.whole, B, C, shape), extra, start, COUNT, z, x, guess, asked)
    return x, guess, asked


def _lies(case: Case, noise: Noise, stuck: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """B, C of the deck with its fault, and what is added to C x: noise, bias, or the value that is stuck."""
    _, B = truth(case.stiffer)
    C, extra, start = model().C, noise.v, case.start
    if case.coil is not None:
        B = B.copy()
        B[:, case.coil] *= 1 - case.size
    elif case.sensor is not None and start < COUNT:
        i, C, extra = case.sensor, C.copy(), extra.copy()
        if case.kind == STUCK:
            C[i], extra[start:, i] = 0.0, stuck[i]
        else:
            extra[start:, i] += 1e-3 * case.size * (DT * np.arange(COUNT - start) if case.kind == DRIFT else 1.0)
    return B, C, extra


def _march(case: Case, noise: Noise, leg: _Leg, extra: np.ndarray, begin: int, end: int, z0: np.ndarray, x: np.ndarray,
           guess: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Fill samples begin … end − 1 of x, x̂ and u; returns (x, x̂) at `end`. z⁺ = Φ z + forcing for z = (x, x̂)."""
    A = truth(case.stiffer)[0]
    o = leg.observer
    Phi = np.block([[A, -leg.B @ leg.K], [o.K @ leg.C, o.F - o.G @ leg.K]])
    r = leg.known[begin:end]
    forcing = np.hstack([r @ leg.B.T + noise.w[begin:end], r @ o.G.T + extra[begin:end] @ o.K.T])
    kicked = round(case.kick / DT) - 1 if case.kick >= 0 else -1
    if begin <= max(kicked, 0) < end and case.kick >= 0:
        forcing[max(kicked, 0) - begin, :6] += MODEL.kick
    z = affine_scan(Phi, forcing, z0, end - begin)
    x[begin:end], guess[begin:end] = z[:-1, :6], z[:-1, 6:]
    asked[begin:end] = r - guess[begin:end] @ leg.K.T
    return z[-1]


def _finish(case: Case, noise: Noise, x: np.ndarray, guess: np.ndarray, asked: np.ndarray) -> Record:
    kf, start = model(), case.start
    honest = x @ kf.C.T
    y = honest + noise.v
    applied = asked
    if start < COUNT:
        _, C, extra = _lies(case, noise, honest[start] + noise.v[start])
        y[start:] = x[start:] @ C.T + extra[start:]
        if case.coil is not None:
            applied = asked.copy()
            applied[start:, case.coil] *= 1 - case.size
    residuals, states = guard().bank.run(y, asked, noise.bank)
    return Record(x, guess, y, honest, asked, applied, residuals, states)


def quiet(case: Case) -> Record:
    """The same run without any noise, nobody noticing: what the fault alone, and a wrong model, does to the residuals."""
    return simulate(replace(case, kick=-1.0), drawn(-1))
