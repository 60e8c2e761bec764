"""Simulate and record a run, in one piece, or in two with a kick between them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from observer_lab.course.lesson import Board, Design, Formula, Stage
from observer_lab.engine import BilinearPlant, simulate_bilinear
from observer_lab.engine.observers import BilinearForm, BilinearObserver, BilinearRun
from observer_lab.text import Text

from .input_signals import Signal, columns, joined, noise_values


@dataclass(frozen=True, eq=False)
class Record:
    """t, u (n_t,) or of k inputs (n_t, k), x (n_t, n), g (n_t, r), estimates and errors ε = ĝ − g (n_t, 3, r) in the order of FORMS.

    heard (n_t, 3, r) is the part of the errors that the sensors' noise made. law (n_t, r): ε of the chosen form as its own
    equation has it from the start, or from the kick. fed (n_t, 2): the first row of L ẏ, true and as the differentiator gives it.
    missed (n_t,): the length of ẏ less what the differentiator gives for it.
    """

    t: np.ndarray
    u: np.ndarray
    x: np.ndarray
    g: np.ndarray
    estimates: np.ndarray
    errors: np.ndarray
    heard: np.ndarray
    law: np.ndarray
    fed: np.ndarray
    missed: np.ndarray = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class Row:
    """What a row of g = K x is called, its estimate, its error and the law of that, and the unit of the row."""

    name: Text
    guess: Text
    error: Text
    law: Text
    unit: str = ""


@dataclass(frozen=True, eq=False)
class Setting:
    """A design on the paper's plant, or on a person's own: the eight steps, L and the forms that run, the run, and what is told of it.

    `plant`, x0 and `jump` are in states of like size, `scale` (n,) of those given. `deviations` (m,): of the sensors' noise.
    `controllable`: whether the poles of the family can be placed, and the number behind it. `law`: ε (n_t, r) of a run without noise.
    `told`: metrics beside those of every plant, from the run and the error (n_t,). Of an `own` plant errors are shares of the largest g.
    """

    own: bool
    solved: BilinearObserver
    L: np.ndarray
    exact: BilinearForm
    plain: BilinearForm
    poles: np.ndarray
    plant_poles: np.ndarray
    plant: BilinearPlant
    scale: np.ndarray
    x0: np.ndarray
    chi0: np.ndarray
    jump: np.ndarray
    horizon: float
    dt: float
    u: Signal
    deviations: np.ndarray
    rows: tuple[Row, ...]
    inputs: tuple[tuple[Text, str], ...]  # names and units
    signals: tuple[Sequence[str], Sequence[str]]  # of inputs and outputs, as a device calls them
    windows: Mapping[str, tuple[float, float]]
    boards: tuple[Board, Board]
    controllable: tuple[bool, float]
    law: Callable[[list[BilinearRun]], np.ndarray]
    told: Callable[[Record, np.ndarray], Mapping[str, float]]
    told_of_error: Callable[[Mapping[str, float]], Text]
    stage: Callable[[Record], Stage]
    formulas: Callable[[], Sequence[Formula]]
    live: Callable[[Mapping[str, float]], Text]

    def size(self, run: Record) -> np.ndarray:
        """What errors (…, r) are divided by: the largest |g| of an own plant, else one."""
        size = np.max(np.abs(run.g), axis=0) if self.own else np.ones(1)
        return np.where(size > 0, size, 1.0)

    def noise(self, design: Design, count: int) -> np.ndarray:
        """What the sensors add to y (count, m)."""
        return self.deviations * noise_values(design, count, self.plant.m)


@dataclass(frozen=True, eq=False)
class _Course:
    """A setting with its joined forms and their start, the grid point of a kick, the last one."""

    setting: Setting
    form: BilinearForm
    z0: np.ndarray
    at: int | None
    last: int

    def pieces(self, noise: np.ndarray | None) -> list[BilinearRun]:
        """The run, cut where x jumps; a kick moves x, and through ẏ the exact form, never χ."""
        x0, jump = self.setting.x0, self.setting.jump
        leap = self.form.R @ self.setting.plant.C @ jump
        if self.at is None:
            return [self._piece(x0, self.z0, 0, self.last, noise)]
        if self.at == 0:
            return [self._piece(x0 + jump, self.z0 + leap, 0, self.last, noise)]
        before = self._piece(x0, self.z0, 0, self.at, noise)
        if before.diverged_at is not None:
            return [before]
        return [before, self._piece(before.x[-1] + jump, before.z[-1] + leap, self.at, self.last, noise)]

    def _piece(self, x: np.ndarray, z: np.ndarray, begin: int, end: int, noise: np.ndarray | None) -> BilinearRun:
        s = self.setting
        return simulate_bilinear(s.plant, self.form, np.tile(s.solved.K * s.scale, (3, 1)), lambda t: s.u(t + begin * s.dt), x, z,
                                 horizon=(end - begin) * s.dt, dt=s.dt, noise=None if noise is None else noise[begin:end + 1])


def run_of(s: Setting, design: Design) -> Record:
    """All three forms from χ(0) and μ̂(0) = χ(0) + L y(0) under the chosen input."""
    last, tau, q, r = round(s.horizon / s.dt), design["tau"], len(s.exact.A), len(s.rows)
    start = s.exact.R @ s.plant.C @ s.x0
    z0 = np.concatenate([s.chi0, s.chi0 + start, s.chi0 + start, start])
    course = _Course(s, joined(s.plain, s.exact, tau), z0, kicked_at(design["kick"], s.dt, last), last)
    calm = course.pieces(None)
    pieces = course.pieces(s.noise(design, last + 1)) if design["noise"] else calm
    count = min(len(whole("x", pieces)), len(whole("x", calm)))
    errors, still = (whole("error", of)[:count].reshape(count, 3, r) for of in (pieces, calm))
    u, x, g, estimates = (whole(name, pieces)[:count] for name in ("u", "x", "g", "estimate"))
    return Record(s.dt * np.arange(count), u, x * s.scale, g[:, :r], estimates.reshape(count, 3, r), errors, errors - still,
                  s.law(calm)[:count], fed_of(s.plant, s.exact.R[0], pieces, 3 * q, tau)[:count],
                  missed_of(s.plant, pieces, s.dt, tau)[:count])


def kicked_at(kick: float, dt: float, last: int) -> int | None:
    """The grid point of a kick, None where there is none."""
    return min(int(kick / dt + 1e-9), last - 1) if kick >= 0 else None


def whole(name: str, of: list[BilinearRun]) -> np.ndarray:
    """One signal of all pieces; the sample at the kick is the one just after it."""
    return end_to_end([getattr(p, name) for p in of])


def end_to_end(parts: list[np.ndarray]) -> np.ndarray:
    """Pieces that share a sample with the next one."""
    return np.concatenate([*(p[:-1] for p in parts[:-1]), parts[-1]])


def fed_of(plant: BilinearPlant, L: np.ndarray, pieces: list[BilinearRun], d: int, tau: float) -> np.ndarray:
    """L ẏ (n_t, 2) for one row L (m,), true and as the differentiator gives it, whose state is number d."""
    y, z = (whole(name, pieces) for name in ("y", "z"))
    return np.column_stack([_rate(plant, pieces) @ L, (y @ L - z[:, d]) / tau])


def missed_of(plant: BilinearPlant, pieces: list[BilinearRun], dt: float, tau: float) -> np.ndarray:
    """The length (n_t,) of m = ẏ − (y − y_f)/τ with τ ẏ_f = y − y_f from y_f(0) = y(0): τ ṁ = τ ÿ − m, and a jump of y takes 1/τ of it.

    Between samples ẏ is taken as even in time; noise is held from one to the next, and a kick jumps at its sample.
    """
    rate, clean = _rate(plant, pieces), whole("x", pieces) @ plant.C.T
    jumps = np.diff(whole("y", pieces) - clean, axis=0)  # of the noise
    slopes, leaps, last = np.diff(rate, axis=0), np.zeros_like(jumps), 0
    for piece in pieces[:-1]:  # what a kick adds at its sample is no slope
        last += len(piece.t) - 1
        leaps[last - 1] = rate[last] - _rate(plant, [piece])[-1]
        slopes[last - 1] -= leaps[last - 1]
        jumps[last - 1] += clean[last] - piece.x[-1] @ plant.C.T
    kept, m = np.exp(-dt / tau), np.empty_like(rate)
    m[0] = rate[0]
    for k, step in enumerate((1 - kept) * tau / dt * slopes + leaps - jumps / tau):
        m[k + 1] = kept * m[k] + step
    return np.linalg.norm(m, axis=1)


def _rate(plant: BilinearPlant, pieces: list[BilinearRun]) -> np.ndarray:
    """The true ẏ (n_t, m)."""
    x, u = (whole(name, pieces) for name in ("x", "u"))
    rate = x @ plant.A.T + columns(u) @ plant.B.T
    for each, F in zip(columns(u).T, plant.parts, strict=True):
        rate += each[:, None] * (x @ F.T)
    return rate @ plant.C.T
