"""Run a plant of lesson 15 with its observer: its setting, its loop, the outcome of a design."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np
from scipy.linalg import expm

from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome, Stage
from observer_lab.engine import Plant
from observer_lab.engine.observers import FunctionalObserver, Perturbations
from observer_lab.engine.systems import Poles, affine_scan, sorted_poles
from observer_lab.plants import Window
from observer_lab.text import Text, text

CONDITION_RTOL = 1e-9
DIVERGENCE_FACTOR = 1e9  # times the start: where a run that grows is held
Errors = tuple[np.ndarray, np.ndarray, np.ndarray]  # ΔA, ΔB, ΔC of the true plant


@dataclass(frozen=True)
class Drive:
    """v = amplitude · sin(rate t + phase), added to one input; `fed` where the observer gives that input, else it only watches."""

    amplitude: float
    rate: float
    phase: float = 0.0
    on: int = 0
    fed: bool = True


@dataclass(frozen=True, eq=False)
class Loop:
    """True plant and observer, from v to the error: states (x, z), readings C x, inputs less v (m, n + q)."""

    A: np.ndarray
    b: np.ndarray
    error: np.ndarray
    wanted: np.ndarray
    inputs: np.ndarray
    readings: np.ndarray
    drive: Drive

    def steady(self) -> float:
        """Amplitude of the error once the start has died out, amplitude · |error (jω − A)⁻¹ b|; ∞ where the loop is unstable."""
        if np.max(np.linalg.eigvals(self.A).real) >= 0:
            return np.inf
        settled = np.linalg.solve(1j * self.drive.rate * np.eye(len(self.A)) - self.A, self.b + 0j)
        return abs(self.drive.amplitude) * float(abs(self.error[0] @ settled))


@dataclass(frozen=True, eq=False)
class Run:
    """A run of the loop: t (n_t,), x (n_t, n), z (n_t, q), y (n_t, p), u (n_t, m); v, the error and what is wanted (n_t,); poles."""

    loop: Loop
    t: np.ndarray
    x: np.ndarray
    z: np.ndarray
    y: np.ndarray
    u: np.ndarray
    v: np.ndarray
    e: np.ndarray
    wanted: np.ndarray
    poles: Poles
    from_s: float

    def late(self, signal: np.ndarray) -> float:
        """The largest |signal| (n_t,) in the last quarter."""
        return float(np.abs(signal[self.t >= self.from_s]).max())


@dataclass(frozen=True, eq=False)
class Story:
    """The observer, its run on the true plant and, when it is looked at, on the model."""

    observer: FunctionalObserver
    alone: LazyValue[Run]
    true: Run

    @property
    def model(self) -> Run:
        """The run on the model."""
        return self.alone.value


S = TypeVar("S", bound=Story)


@dataclass(frozen=True, eq=False)
class Setting(Generic[S]):
    """What a plant brings: the paper's, or a person's own.

    `late`: s from which on the last quarter is read. `most`: the largest error that is told. `rows`: K (m×n) of the whole controller,
    and the wanted row (1×n). `inner`: plant and row in states of like size, and their unit of time in 1/s. `orders`: the poles of each
    order, from none on. `start`: x(0) and z(0). `bounded`: states and v of a run that may grow, as they are kept. `knob`: which one
    holds the observer's poles. `told`: metrics beside those of every plant.
    """

    horizon: float
    dt: float
    late: float
    most: float
    window: Window
    rows: Callable[[Design], tuple[np.ndarray, np.ndarray]]
    inner: Callable[[Design], tuple[Plant, np.ndarray, float]]
    orders: Callable[[Design], Iterable[Sequence[complex]]]
    observer: Callable[[Design], FunctionalObserver]
    errors: Callable[[Design], Errors]
    drive: Callable[[Design], Drive]
    start: Callable[[Design], tuple[Sequence[float], Sequence[float] | np.ndarray]]
    bounded: Callable[[np.ndarray], np.ndarray]
    knob: Callable[[Design], str]
    story: Callable[[Design, Story], S]
    told: Callable[[Design, S], Mapping[str, float]]
    conditions: Callable[[Mapping[str, float]], tuple[Check, ...]]
    left_board: Callable[[Design, Poles], Board]
    stage: Callable[[Design, S], Stage]
    formulas: Callable[[Design, FunctionalObserver], Sequence[Formula]]
    live: Callable[[Design, Mapping[str, float]], Text]
    run_form: Callable[[FunctionalObserver], FunctionalObserver] = lambda o: o


def weighed(wrong: Perturbations, design: Design) -> Perturbations:
    """Directions of the model error with the design's weights, one for all directions of each sum."""
    return replace(wrong, alpha=np.full(len(wrong.A), design["alpha"]), beta=np.full(len(wrong.C), design["beta"]),
                   gamma=np.full(len(wrong.C), design["gamma"]))


def loop_of(here: Setting, design: Design, observer: FunctionalObserver, errors: Errors | None = None) -> Loop:
    """u_j = −(Nz + My) + v on the input that is fed, u = −Kx from the true state on the others; for a watched state on all."""
    o, (K, row), drive = here.run_form(observer), here.rows(design), here.drive(design)
    plant, q = o.plant, o.order
    A, B, C = plant.A, plant.B, plant.C
    if errors is not None:
        A, B, C = A + errors[0], B + errors[1], C + errors[2]
    estimate = np.hstack([o.M @ C, o.N])
    inputs = np.hstack([-K, np.zeros((plant.m, q))])
    if drive.fed:
        inputs[drive.on] = -estimate[0]
    way = np.vstack([B, o.T @ plant.B])
    wanted = np.hstack([row, np.zeros((1, q))])
    return Loop(np.block([[A, np.zeros((plant.n, q))], [o.L @ C, o.F]]) + way @ inputs, way[:, drive.on], wanted - estimate, wanted, inputs,
                np.hstack([C, np.zeros((plant.p, q))]), drive)


def run_of(here: Setting, design: Design, o: FunctionalObserver, errors: Errors | None = None) -> Run:
    """The run under v from the starts of the setting: exact at the samples; on the model without errors."""
    loop, (x0, z0), n = loop_of(here, design, o, errors), here.start(design), o.plant.n
    drive, t, size = loop.drive, np.arange(round(here.horizon / here.dt) + 1) * here.dt, len(loop.A)
    whole = np.zeros((size + 2, size + 2))
    whole[:size, :size], whole[:size, size] = loop.A, drive.amplitude * loop.b
    whole[size, size + 1], whole[size + 1, size] = drive.rate, -drive.rate
    turned = np.column_stack([np.sin(drive.rate * t + drive.phase), np.cos(drive.rate * t + drive.phase)])
    start, v = np.concatenate([x0, z0, np.zeros(size - n - len(z0))]), drive.amplitude * turned[:, 0]
    with np.errstate(over="ignore", invalid="ignore"):
        step: np.ndarray = expm(whole * here.dt)[:size]
        states = (affine_scan(step[:, :size], turned[:-1] @ step[:, size:].T, start, len(t) - 1) if np.isfinite(step).all() else
                  np.vstack([start, np.full((len(t) - 1, size), np.nan)]))
    states, v = np.split(here.bounded(np.column_stack([states, v])), [size], axis=1)
    u = states @ loop.inputs.T
    u[:, drive.on] += v[:, 0]
    return Run(loop, t, states[:, :n], states[:, n:], states @ loop.readings.T + u @ np.asarray(o.plant.D).T, u, v[:, 0],
               states @ loop.error[0], states @ loop.wanted[0], sorted_poles(loop.A), here.late)


def amplitudes(loops: Sequence[Loop], frequencies: np.ndarray) -> np.ndarray:
    """|v → error| (len(loops), n_f) of each loop over frequencies in Hz, whether it is stable or not."""
    A, b, error = (np.stack([getattr(loop, name) for loop in loops]) for name in ("A", "b", "error"))
    s = 2j * np.pi * frequencies
    try:
        solved = np.linalg.solve(s[None, :, None, None] * np.eye(A.shape[1]) - A[:, None], b[:, None, :, None] + 0j)
    except np.linalg.LinAlgError:
        return np.full((len(loops), len(s)), DIVERGENCE_FACTOR)
    return np.nan_to_num(np.abs((error[:, None] @ solved)[..., 0, 0]), nan=DIVERGENCE_FACTOR, posinf=DIVERGENCE_FACTOR)


def compute(here: Setting[S], design: Design) -> Outcome[S]:
    """The observer, its conditions and J, and one run each on the model and on the true plant. Raises KnobError, EngineError."""
    o, knob, window = here.observer(design), here.knob(design), here.window
    true = run_of(here, design, o, here.errors(design))
    story = here.story(design, Story(o, LazyValue(lambda: run_of(here, design, o)), true))
    known = {"J": o.J, "order": float(o.order), "slowest_loop": float(true.poles.real.max()), "error_start": float(true.e[0]),
             "late_error": min(true.late(true.e), here.most)}
    metrics = LazyMap(lambda: {**known, "dynamics_residual": o.dynamics_residual, "output_residual": o.output_residual,
                               **here.told(design, story)}, known)
    board = Board("observer", text("observer poles  eig F"), design[knob], knob, role="estimate", side="right", re_low=window.re_low,
                  re_high=window.re_high, im_high=window.im_high)
    return Outcome(design, {"F": o.F, "T": o.T, "L": o.L, "N": o.N, "M": o.M, "K": o.K},
                   {"observer": np.array(design[knob]), "loop": true.poles}, metrics,
                   LazySequence(lambda: (*here.conditions(metrics), _stable(metrics["slowest_loop"]))), None,
                   (here.left_board(design, true.poles), board), here.stage(design, story), LazySequence(lambda: here.formulas(design, o)),
                   LazyValue(lambda: here.live(design, metrics)), story)


def _stable(slowest: float) -> Check:
    return Check("stable", text("the loop with the true plant is stable"), slowest < 0, slowest)
