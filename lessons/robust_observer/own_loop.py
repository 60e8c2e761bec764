"""Compute the loop of an own plant with its observer: gains, one exact run, error index."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm

from observer_lab.course.knobs import KnobError
from observer_lab.course.lazy import LazyValue
from observer_lab.course.lesson import Design
from observer_lab.engine import EngineError
from observer_lab.engine.observers import FunctionalObserver, Perturbations, RobustObserver
from observer_lab.engine.systems import Poles
from observer_lab.plants import Window
from observer_lab.text import Text, text

from ..toolkit.gains import feedback
from .knobs import NORMS
from .own_plant import Here, coincide, met, row_of

WAVES = 3.0  # periods of v within the run
FREQUENCIES = 50
DIVERGENCE_FACTOR = 1e9  # times the start: where a run that grows is held


# --- the observer ---------------------------------------------------------------------------------------------------
def weighted(here: Here, design: Design) -> Perturbations:
    """Every entry of A and C wrong by itself, with the design's weights."""
    w = here.entries
    return replace(w, alpha=np.full(len(w.A), design["alpha"]), beta=np.full(len(w.C), design["beta"]),
                   gamma=np.full(len(w.C), design["gamma"]))


def errors(here: Here, design: Design) -> tuple[np.ndarray, np.ndarray]:
    """ΔA, ΔC of the true plant."""
    A, C = here.plant.A, here.plant.C
    rng = np.random.default_rng(int(design["signs"]))
    a, c = (rng.choice([-1.0, 1.0], M.shape) if design["signs"] else np.ones(M.shape) for M in (A, C))
    return design["delta_a"] / 100 * a * A, design["delta_c"] / 100 * c * C


def wanted_of(here: Here, design: Design) -> tuple[np.ndarray, np.ndarray]:
    """K (m×n) of the whole controller, and the wanted row (1×n)."""
    K = feedback(here.plant, design["controller_poles"], here.model)
    return K, row_of(here.plant, K, design["wanted"])


def observer_of(here: Here, design: Design) -> FunctionalObserver:
    """The observer of the design. Raises KnobError, in one sentence, where its poles give none."""
    order = int(design["order"])
    poles = design[f"poles_{order}"]
    if max(p.real for p in poles) >= -1e-6 * -here.model.observer_window.re_low:
        raise KnobError(text("An observer pole is not in the left half plane, so its error would not decay; drag "
                             "it left."))
    if coincide(poles):
        raise KnobError(text("Two observer poles coincide; this form of the observer needs them apart, so move "
                             "one."))
    row = wanted_of(here, design)[1]
    try:
        found = here.scaled.observer(row, poles, weighted(here, design), NORMS[design["norm"]])
    except (EngineError, np.linalg.LinAlgError) as problem:
        raise _none(order) from problem
    if not met(found):
        raise _none(order)
    return found


def _none(order: int) -> KnobError:
    return KnobError(text("With these poles no observer of order {order} gives the function to 10⁻⁹; raise the order or move the poles.",
                          order=order))


# --- the loop -------------------------------------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class Loop:
    """The true plant with its observer, from v to the error: states (x, z), z in rows of T of unit length."""

    A: np.ndarray
    b: np.ndarray
    error: np.ndarray
    wanted: np.ndarray
    inputs: np.ndarray  # (m, n + q): u less v
    scale: np.ndarray


def loop_of(here: Here, design: Design, o: FunctionalObserver, dA: np.ndarray, dC: np.ndarray) -> Loop:
    """u_j = −(Nz + My) + v on the wanted input, u = −Kx from the true state on the others; for a state on all, v on the first."""
    plant, (K, row) = here.plant, wanted_of(here, design)
    n, fed = plant.n, design["wanted"][0] == "u"
    j = int(design["wanted"][1:]) - 1 if fed else 0
    A, C, size = plant.A + dA, plant.C + dC, lengths(o.T * here.scaled.unit)
    T, L, N, F = o.T / size[:, None], o.L / size[:, None], o.N * size, o.F * size / size[:, None]
    estimate = np.hstack([o.M @ C, N])
    inputs = np.hstack([-K, np.zeros((plant.m, o.order))])
    if fed:
        inputs[j] = -estimate[0]
    whole = np.block([[A, np.zeros((n, o.order))], [L @ C, F]]) + np.vstack([plant.B, T @ plant.B]) @ inputs
    wanted = np.hstack([row, np.zeros((1, o.order))])
    return Loop(whole, np.concatenate([plant.B[:, j], T @ plant.B[:, j]]), wanted - estimate, wanted, inputs, size)


def lengths(rows: np.ndarray) -> np.ndarray:
    """The length of each row, 1 for a row of zeros."""
    length = np.linalg.norm(rows, axis=1)
    return np.where(length > 0, length, 1.0)


@dataclass(frozen=True, eq=False)
class Run:
    """A run of the loop: t (n_t,), x (n_t, n), z (n_t, q), u (n_t, m), v, error and wanted (n_t,); |v → e| over f; its poles."""

    t: np.ndarray
    x: np.ndarray
    z: np.ndarray
    u: np.ndarray
    v: np.ndarray
    e: np.ndarray
    wanted: np.ndarray
    response: LazyValue[tuple[np.ndarray, np.ndarray]]
    poles: Poles

    @property
    def f(self) -> np.ndarray:
        """Frequencies in Hz."""
        return self.response.value[0]

    @property
    def gain(self) -> np.ndarray:
        """|v → e| there."""
        return self.response.value[1]

    def late(self, signal: np.ndarray) -> float:
        """The largest |signal| (n_t,) in the last quarter."""
        return float(np.abs(signal[self.t >= 0.75 * self.t[-1]]).max())


def run_of(here: Here, design: Design, o: FunctionalObserver, dA: np.ndarray, dC: np.ndarray) -> Run:
    """From the model's x(0) and z(0) = 0 under v = a sin ωt: exact at the samples."""
    model, loop = here.model, loop_of(here, design, o, dA, dC)
    count, size = round(model.horizon / model.dt) + 1, len(loop.A)
    turn = 2 * np.pi * WAVES / model.horizon
    whole = np.zeros((size + 2, size + 2))
    whole[:size, :size], whole[:size, size] = loop.A, design["push"] * loop.b
    whole[size, size + 1], whole[size + 1, size] = turn, -turn
    states = np.zeros((count, size + 2))
    states[0, :here.plant.n], states[0, size + 1] = model.x0, 1.0
    with np.errstate(over="ignore", invalid="ignore"):
        step: np.ndarray = expm(whole * model.dt)
        done = 1
        while done < count:  # twice as many samples each time
            more = min(done, count - done)
            states[done:done + more] = states[:more] @ step.T
            step, done = step @ step, done + more
        states = np.nan_to_num(states, nan=DIVERGENCE_FACTOR, posinf=DIVERGENCE_FACTOR, neginf=-DIVERGENCE_FACTOR)
        bound = DIVERGENCE_FACTOR * max(float(np.abs(states[0]).max()), 1.0)
        states = np.clip(states, -bound, bound)
    v, states = design["push"] * states[:, size], states[:, :size]
    j = int(design["wanted"][1:]) - 1 if design["wanted"][0] == "u" else 0
    u = states @ loop.inputs.T
    u[:, j] += v
    return Run(np.arange(count) * model.dt, states[:, :here.plant.n], states[:, here.plant.n:], u, v, states @ loop.error[0],
               states @ loop.wanted[0], LazyValue(lambda: _gain(here, loop)), np.linalg.eigvals(loop.A).astype(complex))


def _gain(here: Here, loop: Loop) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies in Hz, and |v → error|."""
    rate = 1.0 / here.model.horizon
    f = np.geomspace(0.2 * rate, 200 * rate, FREQUENCIES)
    s = 2j * np.pi * f
    try:
        solved = np.linalg.solve(s[:, None, None] * np.eye(len(loop.A)) - loop.A, loop.b[:, None] + 0j)[..., 0]
    except np.linalg.LinAlgError:
        return f, np.full(f.shape, DIVERGENCE_FACTOR)
    return f, np.nan_to_num(np.abs(solved @ loop.error[0]), nan=DIVERGENCE_FACTOR, posinf=DIVERGENCE_FACTOR)


@dataclass(frozen=True, eq=False)
class Story:
    """The observer, its runs on the model and on the true plant, what is wanted, and what RLO found if it has run."""

    observer: FunctionalObserver
    alone: LazyValue[Run]
    true: Run
    fed: bool
    name: Text
    window: Window
    unit: str
    found: RobustObserver | None = None
    found_run: Run | None = None

    @property
    def model(self) -> Run:
        """The run on the model."""
        return self.alone.value
