"""Fit lesson 8 to the user's own plant: the assumed process noise takes the place of speed."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache, partial
from types import MappingProxyType

import numpy as np

from observer_lab.course.knobs import Choice, Knob, Number, Poles
from observer_lab.course.lesson import Design, Formula, Lesson
from observer_lab.engine import Plant, lqe
from observer_lab.engine.design import Optimal
from observer_lab.engine.filters import Ladder, noise_ladder
from observer_lab.engine.systems import sorted_poles
from observer_lab.plants import Model
from observer_lab.text import Text, text

from ..toolkit.boards import stage
from ..toolkit.gains import injection, judged, noise_units
from ..toolkit.knobs import run_knobs
from ..toolkit.latex import gain_words, percent
from .figures import figures
from .knobs import BY_POLES
from .study import Look, Setting, Study, Sweep, compute

BELIEF = "belief"
ASSUMED_NOISE_RATIOS = np.logspace(-3, 3, 11)  # beliefs in the process noise, times the truth
SAMPLED = 120  # instants at which a peak is looked for
SHOWN_SIGNALS = 6  # of the table of shares
MAX_LIVE_STATES = 12  # states up to which the ladder of beliefs follows a hand; beyond, it follows when the hand pauses


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """The lesson's knobs in the plant's own measures."""
    window, (one, two) = model.observer_window, judged(model)
    return (
        Choice("method", "", text("observer by"), default=BELIEF,
               options=((BELIEF, text("belief in the process noise")), (BY_POLES, text(
                   "dragging poles"))),
               hint=text("A Kalman filter that assumes b times the process noise, or poles of your own.")),
        Number("belief", "b", text("assumed / true process noise"), low=1e-3, high=1e3, default=100.0,
               scale="log",
               when=("method", (BELIEF,)), hint=text("Above 1 the observer is too fast, below 1 too slow.")),
        Poles("observer_poles", "q", text("Observer poles"), "rad/s", default=model.observer_poles, re_low=window.re_low,
              re_high=window.re_high, im_high=window.im_high, role="estimate", when=("method", (BY_POLES,)),
              hidden=not model.observer_poles, hint=text("eig(A − LC): farther left is faster.")),
        Number("w", r"\sigma_w", text("process noise, share of the natural input"), low=1e-3, high=10.0,
               default=0.1, scale="log", hint=text("An unknown input, as strong as this share of the natural one.")),
        Number("v", r"\sigma_v", text("sensor noise, share of the outputs"), low=1e-4, high=1.0,
               default=0.01,
               scale="log", hint=text("As a share of the outputs at the start.")),
        Number("start", r"\epsilon", text("error at the start"), low=0.0, high=2.0, default=0.3, step=0.05,
               hint=text("At 1 the observer starts from rest although the plant does not.")),
        Choice("watch", "", text("judge by the error in"), default="second",
               options=(("first", one.name), ("second", two.name)), hint=text("Which error the curves show.")),
        *run_knobs(model.horizon),
    )


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, where a Kalman filter for it exists; the tasks stay with the block."""
    here = own_setting(model)
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, here), figures=partial(figures, here), tasks=())


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
