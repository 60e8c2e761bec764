"""Compute a design of lesson 8: an observer's error variance and one noisy run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue, TabFigures
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome, Stage
from observer_lab.engine import Plant, Scenario, error_parts, lqe, simulate
from observer_lab.engine.design import Optimal
from observer_lab.engine.filters import ErrorParts, growing_error
from observer_lab.engine.simulation import Run
from observer_lab.plants import Model, Signal
from observer_lab.text import Text, text

from ..toolkit.boards import bolts, listed
from ..toolkit.knobs import kicks
from .knobs import BY_POLES

ROUNDING = 1e-6  # of tr P_min: a negative eigenvalue of P − P_min that is no larger comes of rounding


@dataclass(frozen=True, eq=False)
class Sweep:
    """Observers along one number, the speed in rad/s or the assumed process noise over the true one.

    along (n,); process, sensor (n, k): variances of the error in the k signals by cause; peak (n,): largest error without noise of the
    signal that is not measured.
    """

    along: np.ndarray
    process: np.ndarray
    sensor: np.ndarray
    peak: np.ndarray


@dataclass(frozen=True, eq=False)
class Trials:
    """Monte-Carlo: mean square (n_t, k) of the error of k signals about its noise-free course over `count` runs."""

    count: int
    square: np.ndarray


@dataclass(frozen=True, eq=False)
class Study:
    """The observer of a design, its error's parts and its run; what other observers do, and the rest, when it is looked at."""

    here: Setting
    design: Design
    kalman: Optimal
    L: np.ndarray
    poles: np.ndarray
    parts: ErrorParts
    run: Run
    trials: Trials | None = None

    @property
    def judged(self) -> int:
        """The place of the signal whose error is judged."""
        return self.here.judged(self.design)

    @property
    def hidden(self) -> int:
        """The place of the signal whose peak is told and that stands below the measured one."""
        return self.here.hidden(self.design)

    @cached_property
    def rows(self) -> np.ndarray:
        """The weights (k, n) of the signals."""
        return np.array([signal.weights for signal in self.here.signals])

    @cached_property
    def least(self) -> np.ndarray:
        """P_min, what the Kalman filter leaves of the error."""
        return error_parts(self.here.model.plant, self.kalman.gain, *self.here.noises(self.design)).total

    @cached_property
    def quiet(self) -> np.ndarray:
        """The error without noise (n_t, n), as far as both runs go."""
        return drawn(replace(self.run.scenario, W=None, V=None)).e[:len(self.run.t)]

    @cached_property
    def grown(self) -> np.ndarray:
        """The covariance (n_t, k, k) of the signals' errors about that."""
        model, V = self.here.model, self.here.noises(self.design)[2]
        return growing_error(model.plant, self.L, self.parts, V, model.dt, self.rows, len(self.quiet))

    @cached_property
    def sweep(self) -> Sweep:
        """Other observers."""
        return self.here.sweep(self)

    @property
    def peak(self) -> float:
        """The largest error of the hidden signal in this run, without noise."""
        return float(np.abs(self.quiet @ self.rows[self.hidden]).max())

    def deviation(self, P: np.ndarray, i: int) -> float:
        """σ of the i-th signal under the covariance P (n, n) of the error."""
        return float(np.sqrt(max(self.rows[i] @ P @ self.rows[i], 1e-300)))

    @property
    def ratio(self) -> float:
        """σ of the judged signal over the least possible."""
        return self.deviation(self.parts.total, self.judged) / self.deviation(self.least, self.judged)

    @property
    def sensor_share(self) -> float:
        """The share of its variance that sensor noise makes."""
        return (self.deviation(self.parts.sensor, self.judged) / self.deviation(self.parts.total, self.judged)) ** 2


@dataclass(frozen=True, eq=False)
class Look:
    """How the figures show a plant.

    `over`: the title of the sweep, of a name; `process`: what process noise is called; `axis`, `ends`: the label of the sweep and the
    decades that it spans; `places`: where on it the design stands, if it does, and the Kalman filter; `decades`: how many σ spans at
    least and at most; `peak`: title, curve and label of the largest errors, `peak_ends` their decades, if fixed; `labels`: of
    axes over time by the figure's id, where it is not the unit; `windows`: their least ranges; `captions`: what stands below a figure.
    """

    over: Text
    process: Text
    axis: str
    ends: tuple[float, float]
    places: Callable[[Study], tuple[float | None, float]]
    decades: tuple[float, float]
    peak: tuple[Text, Text, str]
    peak_ends: tuple[float, float] | None
    labels: Mapping[str, str]
    windows: Mapping[str, tuple[float, float]]
    captions: Mapping[str, Callable[[Study], Text]]


@dataclass(frozen=True, eq=False)
class Setting:
    """The plant of the lesson, the signals whose errors it shows, and what differs in its designs.

    `model`: with the grid of the run and the window of the boards; `noises`: G, W and V of a design; `start`: x(0); `observer`: poles
    and gain, given the Kalman filter; `numbers`, `tried`: further metrics, of a design and of its trials; `more`: further tabs; `heavy`:
    the sweep waits until a hand pauses.
    """

    model: Model
    signals: tuple[Signal, ...]
    judged: Callable[[Design], int]
    hidden: Callable[[Design], int]
    noises: Callable[[Design], tuple[np.ndarray, np.ndarray, np.ndarray]]
    start: Callable[[Design], Sequence[float]]
    observer: Callable[[Design, Optimal], tuple[np.ndarray, np.ndarray]]
    sweep: Callable[[Study], Sweep]
    stage: Callable[[Study], Stage]
    numbers: Callable[[Study], Mapping[str, float]]
    formulas: Callable[[Study], tuple[Formula, ...]]
    live: Callable[[Study], Text]
    look: Look
    more: Callable[[Outcome[Study]], tuple[TabFigures, ...]] = lambda _: ()
    tried: Callable[[Study, Trials], Mapping[str, float]] = lambda *_: {}
    heavy: bool = False


@lru_cache(maxsize=32)
def _best(plant: Plant, G: bytes, W: bytes, V: bytes) -> Optimal:
    G_ = np.frombuffer(G).reshape(plant.n, -1)
    return lqe(plant.A, G_, plant.C, np.frombuffer(W).reshape(G_.shape[1], -1), np.frombuffer(V).reshape(plant.p, plant.p))


def drawn(scenario: Scenario) -> Run:
    """The run of a scenario. Raises KnobError where its noise outgrows every number."""
    with np.errstate(over="ignore", invalid="ignore"):
        run = simulate(scenario)
    if len(run.t) < 2 or not np.all(np.isfinite(run.x)):
        raise KnobError(text("The noise of this plant outgrows every number within the run."))
    return run


def compute(here: Setting, design: Design) -> Outcome[Study]:
    """The observer's error covariance beside the least one, other observers, and one noisy run. Raises EngineError."""
    model, plant = here.model, here.model.plant
    G, W, V = here.noises(design)
    kalman = _best(plant, *(np.ascontiguousarray(M).tobytes() for M in (G, W, V)))
    poles, L = here.observer(design, kalman)
    parts = error_parts(plant, L, G, W, V)
    runs_away = float(np.real(plant.poles).max()) > 1e-9 and model.controller is not None
    run = drawn(Scenario(
        plant, model.controller.gain if runs_away and model.controller else None, L, x0=here.start(design), xhat0=model.guess,
        horizon=model.horizon, dt=model.dt, W=W, V=V, G=G, impulses=kicks(design, model), seed=int(design["seed"])))
    study = Study(here, design, kalman, L, poles, parts, run)
    metrics = LazyMap(lambda: {**_metrics(study), **here.numbers(study)})
    return Outcome(design, {"L": L, "L_kalman": kalman.gain}, {"observer": poles, "kalman": kalman.poles}, metrics,
                   LazySequence(lambda: _checks(study, metrics["floor"])), run, _boards(study), here.stage(study),
                   LazySequence(lambda: here.formulas(study)), LazyValue(lambda: here.live(study)), study)


def _metrics(s: Study) -> dict[str, float]:
    gap = s.parts.total - s.least
    return {"floor": float(np.linalg.eigvalsh(gap)[0] / max(np.trace(s.least), 1e-300)), "largest_gain": float(np.abs(s.L).max()),
            "peak": s.peak}


def _checks(s: Study, floor: float) -> tuple[Check, ...]:
    return (
        Check("least", text("within 1 % of the least variance"), s.ratio**2 <= 1.01, s.ratio**2, informative=True),
        Check("floor", text("no observer beats the Kalman filter: P − P_min ≥ 0"), floor > -ROUNDING, floor))


def _boards(s: Study) -> tuple[Board, Board]:
    model, window, by_hand = s.here.model, s.here.model.observer_window, s.design["method"] == BY_POLES
    return (
        Board("kalman", text("poles of the Kalman filter"), listed(s.kalman.poles), side="left",
              re_low=window.re_low, re_high=window.re_high, im_high=window.im_high),
        Board("observer", text("observer poles  eig(A − LC)"),
              s.design["observer_poles"] if by_hand else listed(s.poles),
              "observer_poles" if by_hand or len(s.poles) == len(model.observer_poles) else None,
              bolts(model.observer, window) if by_hand else (), role="estimate", side="right", re_low=window.re_low,
              re_high=window.re_high, im_high=window.im_high, also=(("method", BY_POLES),), landscape=model.plant.A - s.L @ model.plant.C))
