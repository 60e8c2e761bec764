"""Define what linear filters share: the model, one step, a whole record."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import field
from functools import cached_property
from typing import Self

import numpy as np

from ...design.optimal import DiscreteFilter, dlqe
from ...systems.arrays import as_covariance, as_numbers
from ...systems.errors import EngineError, ShapeError
from ...systems.gates.argument_checks import (
    MOST_NUMBERS,
    RECORD,
    SECONDS,
    array,
    count,
    covariance,
    gated,
    instance,
    matrix,
    optional,
    passed,
)
from ...systems.gates.plant_gate import PLANT
from ...systems.noise import step_covariance
from ...systems.plant import Plant, as_matrix
from ...systems.records import record
from ...systems.sampling import discretise
from ..belief import BELIEF, Belief, Correction
from ..moments import moments_of
from ..track import Schedule, Track, as_record, means_along
from .compiled_schedule import Goal
from .timed_runs import Source, timed_run

__all__ = ["LinearFilter"]

STEADY_RTOL = 1e-9  # distance from the Riccati solution, in standard deviations squared, that counts as none


def _seen(value: object, name: str, sizes: dict[str, int]) -> np.ndarray:
    return as_numbers(value, name).astype(bool)


LOOK_EVERY = 8  # steps between two looks whether the filter has settled
FIRST_ROOM = 64  # steps stored before the arrays grow


@record()
class LinearFilter(ABC):
    """A filter for x[k+1] = A x[k] + B u[k] + w[k], y[k] = C x[k] + D u[k] + v[k], white w, v of covariances Q, R.

    A n×n, B n×m, C p×n, Q n×n ≥ 0, R p×p ≥ 0 (a number is that number times I), D p×m (zero if left out), dt in s
    (0: not said). Steps are pure: they take a belief and return a new one. A measurement that is NaN did not arrive;
    the sensors that did are used. `source` is the continuous plant with its noise, which `from_plant` keeps for irregular times.
    Raises ShapeError, EngineError for matrices that do not fit or are no covariances.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    D: np.ndarray = None  # type: ignore[assignment]  # always an array after construction
    dt: float = 0.0
    source: Source | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        passed(self, A=matrix(), Q=covariance(), R=covariance(), source=optional(instance(Source)))
        plant = Plant(self.A, self.B, self.C, self.D, self.dt)
        for name in ("A", "B", "C", "D", "dt"):
            object.__setattr__(self, name, getattr(plant, name))
        object.__setattr__(self, "Q", as_covariance(self.Q, "Q", plant.n))
        object.__setattr__(self, "R", as_covariance(self.R, "R", plant.p))

    @classmethod
    @gated(plant=PLANT, W=matrix(), V=covariance("p"), dt=optional(SECONDS), G=optional(matrix()))
    def from_plant(cls, plant: Plant, W: object, V: object, *, dt: float | None = None, G: object | None = None) -> Self:
        """The filter of a continuous plant sampled every dt seconds, its input held: an exact discretisation.

        A_d = e^{A dt}, B_d = ∫e^{As}ds B, Q = ∫e^{As} G W Gᵀ e^{Aᵀs} ds over one step, R = V/dt, for the intensities
        W (q×q) of w, which enters through G (n×q; default: I if W is n×n and n ≠ m, else B), and V (p×p) of v.
        A plant with dt > 0 is taken as it is, with W and V the covariances of a sample. Raises ShapeError, EngineError.
        """
        if G is None:
            G = np.eye(plant.n) if as_matrix(W, "W").shape[0] == plant.n != plant.m else plant.B
        G = as_matrix(G, "G")
        if G.shape[0] != plant.n:
            raise ShapeError("G must have {n} rows, one for each state; it has {rows}.", n=plant.n, rows=G.shape[0])
        noise = G @ as_covariance(W, "W", G.shape[1]) @ G.T
        V = as_covariance(V, "V", plant.p)
        if plant.dt:
            if dt is not None and abs(dt - plant.dt) > 1e-9 * plant.dt:
                raise EngineError("This plant is sampled every {dt:g} s; leave dt out or give the same.",
                                  dt=plant.dt)
            return cls(plant.A, plant.B, plant.C, noise, V, plant.D, plant.dt)
        if dt is None:
            raise EngineError("A continuous plant needs a sampling period dt > 0 in seconds for its discrete "
                              "filter.")
        sampled = discretise(plant, dt)
        return cls(sampled.A, sampled.B, sampled.C, step_covariance(plant.A, noise, dt), V / dt, sampled.D, dt,
                   Source(plant, noise))

    @property
    def n(self) -> int:
        """Number of states."""
        return self.A.shape[0]

    @cached_property
    def steady(self) -> DiscreteFilter:
        """The filter after infinitely many steps, from the Riccati equation. Raises RiccatiError where there is none."""
        return dlqe(self.A, np.eye(self.n), self.C, self.Q, self.R)

    @property
    def default_start(self) -> Belief:
        """Mean zero, with the steady covariance P[k|k−1] of the Riccati equation. Raises RiccatiError where there is none."""
        return Belief(np.zeros(self.n), self.steady.solution)

    # --- one step -----------------------------------------------------------------------------------------------------
    @gated(belief=BELIEF)
    def predict(self, belief: Belief, u: object | None = None) -> Belief:
        """x̂[k+1|k] = A x̂ + B u, P[k+1|k] = A P Aᵀ + Q: the belief one step later, before its measurement. u is (m,)."""
        mean = self.A @ self._fitting(belief).mean
        if u is not None:
            mean = mean + self.B @ self._input(u)
        return self.belief(mean, self.forward(self.spread(belief)))

    @gated(belief=BELIEF)
    def correct(self, belief: Belief, y: object, u: object | None = None) -> Correction:
        """The measurement y (p,) taken in: x̂ + M ν with ν = y − C x̂ − D u, M = P Cᵀ S⁻¹, S = C P Cᵀ + R."""
        nu = self._vector(y, "y", len(self.C)) - self.C @ self._fitting(belief).mean
        if u is not None:
            nu = nu - self.D @ self._input(u)
        if np.isinf(nu).any():
            raise EngineError("A measurement is infinite; give NaN where none arrived.")
        S, M, spread = self.corrected(self.spread(belief), np.isfinite(nu))
        return Correction(self.belief(belief.mean + M @ np.nan_to_num(nu), spread), nu, S, M)

    def update(self, belief: Belief, y: object, u: object | None = None) -> Belief:
        """The belief after the measurement y (p,); `correct` also says innovation, S and gain."""
        return self.correct(belief, y, u).belief

    # --- a record -----------------------------------------------------------------------------------------------------
    @gated(start=BELIEF, steps=count(0, MOST_NUMBERS // 4), seen=optional(_seen))
    def schedule(self, start: Belief, steps: int, *, seen: np.ndarray | None = None) -> Schedule:
        """Covariances and gains of `steps` samples from the belief before the first; no measurement changes them.

        Ends early where P[k|k−1] meets the Riccati solution to 1e-9 of its standard deviations: from there on the
        gain is constant. `seen` (steps, p; bool) says which measurements arrive; with it nothing is constant.
        """
        as_covariance(self._fitting(start).covariance, "P", self.n)
        spread, every = self.spread(start), np.ones(len(self.C), dtype=bool)
        if seen is not None and seen.shape != (steps, len(self.C)):
            raise ShapeError("{name} must be {value}×{columns}, one row a sample; its shape is {array_shape}.",
                             name="seen", value=steps, columns=len(self.C), array_shape=seen.shape)
        goal = self._goal() if seen is None else None
        n, p = self.n, len(self.C)
        if (stored := self.quickly((steps, n, p), spread, seen, goal)) is not None:
            return Schedule(steps, *stored)
        room, k = min(steps, FIRST_ROOM), -1
        stored = tuple(np.empty((room, *shape)) for shape in ((n, n), (n, n), (p, p), (n, p)))
        for k in range(steps):
            if k == room:
                room = min(steps, 2 * room)
                stored = tuple(np.concatenate([part, np.empty((room - k, *part.shape[1:]))]) for part in stored)
            priors, posteriors, covariances, gains = stored
            priors[k] = prior = self.covariance(spread)
            covariances[k], gains[k], spread = self.corrected(spread, every if seen is None else seen[k])
            posteriors[k] = self.covariance(spread)
            if goal is not None and k % LOOK_EVERY == 0 and (np.abs(prior - goal[0]) <= goal[1]).all():
                break
            spread = self.forward(spread)
        return Schedule(steps, *(part[:k + 1].copy() for part in stored))

    @gated(y=optional(RECORD), schedule=optional(instance(Schedule)), t=optional(array()), R=optional(array()), gate=optional(array()))
    def run(self, start: object, y: object = None, u: object | None = None, *, schedule: Schedule | None = None,
            t: object | None = None, R: object | None = None, gate: object | None = None) -> Track:
        """A record y (n_t, p) with the inputs u (n_t, m) filtered; `start` is the belief before the first measurement.

        `start` is a Belief or (mean, covariance); `run(y)` alone starts at zero with the steady covariance P[k|k−1]. Row k of u
        acts on sample k through D and is held until sample k + 1. A `schedule` made before for the same start and length
        saves the covariances (thousands of runs of one filter share it). t (n_t,) are times in s of a filter made by `from_plant`, in
        steps of any length. R is the noise of the readings, p×p or one such matrix a sample. A `gate`, as 0.999 or one a sample, is the
        share of good readings that it lets through: readings that surprise more are not used. Raises ShapeError, EngineError.
        """
        if y is None:
            start, y = self.default_start, RECORD(start, "y", {})
        start = BELIEF(start, "start", {})
        y = as_record(y, "y", len(self.C))
        known, push, inputs = y, None, None
        if u is not None:
            inputs = as_record(u, "u", self.B.shape[1], rows=len(y))
            if np.isnan(inputs).any():
                raise EngineError("u holds NaN; every input must be known.")
            known, push = y - inputs @ np.asarray(self.D).T, inputs @ self.B.T
        if t is not None or R is not None or gate is not None:
            if schedule is not None:
                raise EngineError("A schedule has its own times and noises; leave it out, or t, R and gate.")
            return timed_run(self, self._fitting(start), y, inputs, moments_of(len(y), self.R, t, R, gate))
        seen = np.isfinite(y)
        if not seen.all():
            schedule = self.schedule(start, len(y), seen=seen)
        elif schedule is None:
            schedule = self.schedule(start, len(y))
        elif schedule.steps != len(y):
            raise ShapeError("The schedule is for {steps} samples but the record has {count}; make one for this "
                             "record.",
                             steps=schedule.steps, count=len(y))
        return Track(*means_along(self.A, self.C, schedule, self._fitting(start).mean, known, push), schedule)

    def quickly(self, sizes: tuple[int, int, int], spread: np.ndarray, seen: np.ndarray | None,
                goal: Goal) -> tuple[np.ndarray, ...] | None:
        """What a `Schedule` holds of sizes = (steps, n, p), by a compiled kernel; None where there is none."""
        return None

    def _goal(self) -> Goal:
        """The Riccati solution and how near counts as there, None where it cannot be had."""
        try:
            P = self.steady.solution
        except EngineError:
            return None
        spread = np.sqrt(np.maximum(np.diag(P), 0.0))
        spread = np.maximum(spread, 1e-9 * spread.max(initial=0.0))
        return P, STEADY_RTOL * np.outer(spread, spread)

    def _fitting(self, belief: Belief) -> Belief:
        if belief.mean.size != self.n:
            raise ShapeError("The belief is about {mean_size} states but the filter has {n}; give both the same "
                             "number.",
                             mean_size=belief.mean.size, n=self.n)
        return belief

    def _vector(self, value: object, name: str, size: int) -> np.ndarray:
        vector = as_numbers(value, name, missing=True, infinite=True).reshape(-1)
        if vector.size != size:
            raise ShapeError("{name} must hold {size} numbers; it holds {vector_size}.",
                             name=name, size=size, vector_size=vector.size)
        return vector

    def _input(self, u: object) -> np.ndarray:
        vector = self._vector(u, "u", self.B.shape[1])
        if not np.isfinite(vector).all():
            raise EngineError("u holds NaN or infinity; every entry must be a finite number.")
        return vector

    # --- how the covariance is carried ---------------------------------------------------------------------------------
    @abstractmethod
    def spread(self, belief: Belief) -> np.ndarray:
        """What of a belief is carried along: P, or a root of it."""

    @abstractmethod
    def belief(self, mean: np.ndarray, spread: np.ndarray) -> Belief:
        """A belief from what is carried along."""

    @abstractmethod
    def covariance(self, spread: np.ndarray) -> np.ndarray:
        """P (n×n) from what is carried along."""

    @abstractmethod
    def forward(self, spread: np.ndarray, *, A: np.ndarray | None = None, Q: np.ndarray | None = None) -> np.ndarray:
        """What A P Aᵀ + Q is in what is carried along; A and Q are the filter's own if left out."""

    @abstractmethod
    def corrected(self, spread: np.ndarray, seen: np.ndarray, *, R: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """S (p×p), gain M (n×p; zero columns for sensors not seen), and the spread after the measurement; R is the filter's own if
        left out."""
