"""Compute lesson 8 on an own plant: filters over the assumed process noise take the place of speed."""

from __future__ import annotations

from functools import lru_cache
from types import MappingProxyType

import numpy as np

from observer_lab.course.lesson import Design, Formula
from observer_lab.engine import Plant, lqe
from observer_lab.engine.design import Optimal
from observer_lab.engine.filters import Ladder, noise_ladder
from observer_lab.engine.systems import sorted_poles
from observer_lab.plants import Model, Signal
from observer_lab.text import Text, text

from ..toolkit.boards import stage
from ..toolkit.gains import injection, noise_units
from ..toolkit.latex import gain_words
from ..toolkit.shares import percent
from .study import Look, Setting, Study, Sweep

BELIEF = "belief"
ASSUMED_NOISE_RATIOS = np.logspace(-3, 3, 11)  # beliefs in the process noise, times the truth
SAMPLED = 120  # instants at which a peak is looked for
SHOWN_SIGNALS = 6  # of the table of shares
MAX_LIVE_STATES = 12  # states up to which the ladder of beliefs follows a hand; beyond, it follows when the hand pauses


def judged(model: Model) -> tuple[Signal, Signal]:
    """Signals that the error is judged in: an output and, where there is one, a state that no output reads."""
    second = next((s for s in model.watched if s.name("en").startswith("state")), model.watched[-1])
    return model.watched[0], second


def own_setting(model: Model) -> Setting:
    """A person's own plant, in its own measures."""
    G, W, V = noise_units(model)

    def noises(design: Design) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return G, design["w"] ** 2 * W, design["v"] ** 2 * V

    def observer(design: Design, _: Optimal) -> tuple[np.ndarray, np.ndarray]:
        G, W, V = noises(design)
        L = (lqe(model.plant.A, G, model.plant.C, design["belief"] * W, V).gain if design["method"] == BELIEF
             else injection(model.plant, design["observer_poles"], model))
        return sorted_poles(model.plant.A - L @ model.plant.C), L

    def watched(design: Design) -> int:
        return 0 if design["watch"] == "first" else signals.index(second)
    first, second = judged(model)
    signals = tuple(dict.fromkeys((first, *model.watched[:SHOWN_SIGNALS], second)))
    return Setting(model, signals, watched, watched, noises, lambda design: [design["start"] * v for v in model.x0], observer, _sweep,
                   lambda s: stage(model, s.run, s.design), _numbers, _formulas, _live, LOOK, heavy=model.plant.n > MAX_LIVE_STATES)


def _sweep(s: Study) -> Sweep:
    """Filters of other beliefs."""
    plant, rows = s.here.model.plant, s.rows
    ladder = _ladder(plant, *(np.ascontiguousarray(M).tobytes() for M in s.here.noises(s.design)))
    process, sensor = (np.array([np.einsum("ki,ij,kj->k", rows, P, rows) for P in parts]) for parts in (
        [p.process for p in ladder.parts], [p.sensor for p in ladder.parts]))
    return Sweep(ASSUMED_NOISE_RATIOS, process, sensor, _peaks_along(s, ladder))


@lru_cache(maxsize=32)
def _ladder(plant: Plant, G: bytes, W: bytes, V: bytes) -> Ladder:
    G_ = np.frombuffer(G).reshape(plant.n, -1)
    q = G_.shape[1]
    return noise_ladder(plant, G_, np.frombuffer(W).reshape(q, q), np.frombuffer(V).reshape(plant.p, plant.p), ASSUMED_NOISE_RATIOS)


def _peaks_along(s: Study, ladder: Ladder) -> np.ndarray:
    """max |row e| of the rungs from x(0), by the modes of F; the start itself where those are poor."""
    model, row, found = s.here.model, s.rows[s.hidden], []
    plant, start, t = model.plant, np.array(model.x0), model.dt * np.geomspace(0.02, 400, SAMPLED)
    for L in ladder.gains:
        values, vectors = np.linalg.eig(plant.A - L @ plant.C)
        if np.linalg.cond(vectors) > 1e10:
            found.append(np.nan)
            continue
        shares, turns = (row @ vectors) * np.linalg.solve(vectors, start.astype(complex)), np.outer(t, values)
        found.append(float(np.abs(np.real(np.exp(np.minimum(turns.real, 50.0) + 1j * turns.imag) @ shares)).max()))
    known = np.array(found)
    fill = float(np.nanmax(known)) if np.any(np.isfinite(known)) else 1.0
    return np.maximum(np.nan_to_num(known, nan=fill), abs(float(row @ start)))


def _numbers(s: Study) -> dict[str, float]:
    return {"rms": s.deviation(s.parts.total, s.judged), "least_rms": s.deviation(s.least, s.judged), "ratio": s.ratio}


def _formulas(s: Study) -> tuple[Formula, ...]:
    return (Formula("lyapunov", r"F P + P F^{\mathsf T} + G W G^{\mathsf T} + L V L^{\mathsf T} = 0,\quad F = A - LC"),
            Formula("L", gain_words("L", s.L)))


def _live(s: Study) -> Text:
    if s.ratio < 1.005:
        return text("The error is as small as any observer can make it.")
    return text("The error is {ratio:.3g} times the least possible.", ratio=s.ratio)


def _least(s: Study) -> Text:
    return text("σ = {rms:.3g} {unit}, {sensor_share} % of σ² from the sensor; the least is {least_rms:.3g}.",
                rms=s.deviation(s.parts.total, s.judged), unit=s.here.signals[s.judged].unit, sensor_share=percent(s.sensor_share),
                least_rms=s.deviation(s.least, s.judged))


def _readings(s: Study) -> Text:
    return text("Readings differ from the truth by up to {y:.2g}.", y=np.abs(s.run.y[:, 0] - s.here.signals[0].of(s.run.x)).max())


def _apart(s: Study) -> Text:
    signal = s.here.signals[s.hidden]
    return text("Largest difference: {true:.2g} {unit}.", true=np.abs(signal.of(s.run.e)).max(), unit=signal.unit)


LOOK = Look(
    text("error of {name} over belief"), text("process noise"), "b", (-3.0, 3.0),
    lambda s: (float(np.log10(s.design["belief"])) if s.design["method"] == BELIEF else None, 0.0), (2.0, np.inf),
    (text("peak of the error from x(0), without noise"), text("start as wrong as x(0)"), "max|e|"), None, {}, {},
    MappingProxyType({
        "valley": _least, "measured": _readings, "velocity": _apart,
        "peaks": lambda s: text("In this run the estimate is wrong by up to {peak:.3g}, noise aside.", peak=s.peak),
        "shares": lambda _: text("No entry of the column both is below that of the column least.")}))
