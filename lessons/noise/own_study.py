"""Compute lesson 8 on an own plant: filters over assumed noise, and the chosen observer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome
from observer_lab.engine import Plant, Scenario, error_parts, lqe, simulate
from observer_lab.engine.filters import ErrorParts, Ladder, growing_error, noise_ladder
from observer_lab.engine.simulation import Run
from observer_lab.engine.systems import sorted_poles
from observer_lab.plants import Model, Signal
from observer_lab.text import Text, text

from ..toolkit.boards import bolts, listed, stage
from ..toolkit.gains import injection, noise_units
from ..toolkit.knobs import kicks
from ..toolkit.latex import gain_words
from .knobs import BY_POLES
from .study import Trials

BELIEF = "belief"
ASSUMED_NOISE_RATIOS = np.logspace(-3, 3, 11)  # beliefs in the process noise, times the truth
SAMPLED = 120  # instants at which a peak is looked for


@dataclass(frozen=True, eq=False)
class Study:
    """The observer of a design, its error's parts and its run; what other observers do, and the rest, when it is looked at."""

    model: Model
    design: Design
    L: np.ndarray
    parts: ErrorParts
    run: Run
    trials: Trials | None = None

    @cached_property
    def kalman(self) -> np.ndarray:
        """The gain (n×p) of the filter that believes the truth."""
        return _best(self.model.plant, *_packed(self.model, self.design))

    @cached_property
    def least(self) -> ErrorParts:
        """What it leaves of the error."""
        return error_parts(self.model.plant, self.kalman, *noises(self.model, self.design))

    @cached_property
    def ladder(self) -> Ladder:
        """Filters of other beliefs."""
        return _ladder(self.model.plant, *_packed(self.model, self.design))

    @cached_property
    def row(self) -> np.ndarray:
        """The weights (1×n) of the signal that is watched."""
        return np.array(watched_signal(self.model, self.design).weights)[None]

    @cached_property
    def quiet(self) -> np.ndarray:
        """The error without noise (n_t, n), as far as both runs go."""
        return drawn(replace(self.run.scenario, W=None, V=None)).e[:len(self.run.t)]

    @cached_property
    def grown(self) -> np.ndarray:
        """The variance (n_t,) of the watched signal's error about that."""
        model, V = self.model, noises(self.model, self.design)[2]
        return growing_error(model.plant, self.L, self.parts, V, model.dt, self.row, len(self.quiet))[:, 0]

    @cached_property
    def peaks(self) -> np.ndarray:
        """The largest error (k,) of the watched signal along the ladder, without noise."""
        return _peaks_along(self.model.plant, self.ladder, np.array(self.model.x0), self.row, self.model.dt, SAMPLED)


def signals(model: Model) -> tuple[Signal, Signal]:
    """What the error is judged in: an output, and a state that no output reads, as far as there is one."""
    second = next((s for s in model.watched if s.name("en").startswith("state")), model.watched[-1])
    return model.watched[0], second


def watched_signal(model: Model, design: Design) -> Signal:
    return signals(model)[0 if design["watch"] == "first" else 1]


def noises(model: Model, design: Design) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """G, W, V of a design."""
    G, W, V = noise_units(model)
    return G, design["w"] ** 2 * W, design["v"] ** 2 * V


@lru_cache(maxsize=32)
def _ladder(plant: Plant, G: bytes, W: bytes, V: bytes) -> Ladder:
    G_ = np.frombuffer(G).reshape(plant.n, -1)
    q = G_.shape[1]
    return noise_ladder(plant, G_, np.frombuffer(W).reshape(q, q), np.frombuffer(V).reshape(plant.p, plant.p), ASSUMED_NOISE_RATIOS)


@lru_cache(maxsize=32)
def _best(plant: Plant, G: bytes, W: bytes, V: bytes) -> np.ndarray:
    G_ = np.frombuffer(G).reshape(plant.n, -1)
    return lqe(plant.A, G_, plant.C, np.frombuffer(W).reshape(G_.shape[1], -1), np.frombuffer(V).reshape(plant.p, plant.p)).gain


def _packed(model: Model, design: Design) -> tuple[bytes, bytes, bytes]:
    G, W, V = (np.ascontiguousarray(M).tobytes() for M in noises(model, design))
    return G, W, V


def scenario_of(model: Model, design: Design, L: np.ndarray) -> Scenario:
    """Plant and observer under both noises, steered by the starting controller where the plant would run away."""
    G, W, V = noises(model, design)
    runs_away = float(np.real(model.plant.poles).max()) > 1e-9 and model.controller is not None
    return Scenario(model.plant, model.controller.gain if runs_away and model.controller else None, L,
                    x0=[design["start"] * v for v in model.x0], xhat0=model.guess, horizon=model.horizon, dt=model.dt, W=W, V=V, G=G,
                    impulses=kicks(design, model), seed=int(design["seed"]))


def drawn(scenario: Scenario) -> Run:
    """The run of a scenario. Raises KnobError where its noise outgrows every number."""
    with np.errstate(over="ignore", invalid="ignore"):
        run = simulate(scenario)
    if len(run.t) < 2 or not np.all(np.isfinite(run.x)):
        raise KnobError(text("The noise of this plant outgrows every number within the run."))
    return run


def compute(model: Model, design: Design) -> Outcome[Study]:
    """The observer's error covariance beside the least one, the ladder, and one noisy run. Raises EngineError."""
    plant = model.plant
    G, W, V = noises(model, design)
    L = (lqe(plant.A, G, plant.C, design["belief"] * W, V).gain if design["method"] == BELIEF
         else injection(plant, design["observer_poles"], model))
    study = Study(model, design, L, error_parts(plant, L, G, W, V), drawn(scenario_of(model, design, L)))
    poles, kalman = sorted_poles(plant.A - L @ plant.C), np.linalg.eigvals(plant.A - study.kalman @ plant.C)
    metrics = LazyMap(lambda: _metrics(study))
    return Outcome(design, {"L": L}, {"observer": poles, "kalman": kalman}, metrics, LazySequence(lambda: _checks(metrics)), study.run,
                   _boards(model, design, L, poles, kalman), stage(model, study.run, design), LazySequence(lambda: (
                       Formula("lyapunov", r"F P + P F^{\mathsf T} + G W G^{\mathsf T} + L V L^{\mathsf T} = 0,\quad F = A - LC"),
                       Formula("L", gain_words("L", L)))), LazyValue(lambda: _live(metrics)), study)


def _metrics(study: Study) -> dict[str, float]:
    total, least, row = study.parts.total, study.least.total, study.row
    now, best = (float(np.sqrt(max((row @ P @ row.T).item(), 0.0))) for P in (total, least))
    return {"rms": now, "least_rms": best, "ratio": now / max(best, 1e-300),
            "floor": float(np.linalg.eigvalsh(total - least)[0] / max(np.trace(least), 1e-300)),
            "largest_gain": float(np.abs(study.L).max()), "peak": float(np.abs(study.quiet @ row[0]).max())}


def _checks(m: Mapping[str, float]) -> tuple[Check, ...]:
    return (
        Check("least", text("within 1 % of the least variance"), m["ratio"] ** 2 <= 1.01, m["ratio"], informative=True),
        Check("floor", text("no observer beats the Kalman filter: P − P_min ≥ 0"), m["floor"] > -1e-6, m["floor"]))


def _boards(model: Model, design: Design, L: np.ndarray, poles: np.ndarray, kalman: np.ndarray) -> tuple[Board, Board]:
    window, plant, by_hand = model.observer_window, model.plant, design["method"] == BY_POLES
    return (
        Board("kalman", text("poles of the Kalman filter"), listed(np.sort_complex(kalman)), side="left",
              re_low=window.re_low, re_high=window.re_high, im_high=window.im_high),
        Board("observer", text("observer poles  eig(A − LC)"),
              design["observer_poles"] if by_hand else listed(poles),
              "observer_poles" if by_hand or len(poles) == len(model.observer_poles) else None,
              bolts(model.observer, window) if by_hand else (), role="estimate", side="right", re_low=window.re_low,
              re_high=window.re_high, im_high=window.im_high, also=(("method", BY_POLES),), landscape=plant.A - L @ plant.C))


def _peaks_along(plant: Plant, ladder: Ladder, start: np.ndarray, row: np.ndarray, dt: float, count: int) -> np.ndarray:
    """max |row e| of the rungs from the error `start`, by the modes of F; the start itself where those are poor."""
    t, found = dt * np.geomspace(0.02, 400, count), []
    for L in ladder.gains:
        values, vectors = np.linalg.eig(plant.A - L @ plant.C)
        if np.linalg.cond(vectors) > 1e10:
            found.append(np.nan)
            continue
        shares = (row @ vectors)[0] * np.linalg.solve(vectors, start.astype(complex))
        found.append(float(np.abs(np.real(np.exp(np.minimum(np.outer(t, values).real,
                                                            50.0) + 1j * np.outer(t, values).imag) @ shares)).max()))
    known = np.array(found)
    fill = float(np.nanmax(known)) if np.any(np.isfinite(known)) else 1.0
    return np.maximum(np.nan_to_num(known, nan=fill), abs(float((row @ start).item())))


def _live(m: Mapping[str, float]) -> Text:
    if m["ratio"] < 1.005:
        return text("The error is as small as any observer can make it.")
    return text("The error is {ratio:.3g} times the least possible.", ratio=m["ratio"])
