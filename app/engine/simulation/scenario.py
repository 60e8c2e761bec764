"""Define a scenario and the run that it leads to, as frozen records."""

from __future__ import annotations

from dataclasses import field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..plotting import plot_signals
from ..systems.arrays import as_covariance, as_numbers, frozen
from ..systems.errors import EngineError, ShapeError, phrase
from ..systems.gates.argument_checks import (
    ANY,
    BOOLEAN,
    MOST_NUMBERS,
    SEED,
    choice,
    gated,
    items,
    matrix,
    number,
    optional,
    pair,
    passed,
    real,
)
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant, as_matrix
from ..systems.records import record

if TYPE_CHECKING:
    from ..plotting import Axes

__all__ = ["Run", "Scenario"]

Given = Any  # an array after construction, whatever was given
_MAYBE = optional(matrix())
GATES = MappingProxyType({"plant": PLANT, "K": _MAYBE, "L": _MAYBE, "model": optional(PLANT), "x0": _MAYBE,
                          "xhat0": _MAYBE, "sampled": BOOLEAN, "reference": _MAYBE, "state_feedback": BOOLEAN, "W": _MAYBE, "V": _MAYBE,
                          "fed": choice("applied", "commanded"), "G": _MAYBE, "seed": SEED, "impulses": items(pair(ANY, matrix()))})


def _matrix(value: object, name: str, shape: tuple[int, int], what: str) -> np.ndarray:
    matrix = as_matrix(value, name)
    if matrix.shape != shape:
        raise ShapeError("{name} must be {shape}×{shape2} ({what}); it is {rows}×{columns}.",
                         name=name, shape=shape[0], shape2=shape[1], what=what, rows=matrix.shape[0],
                         columns=matrix.shape[1])
    return matrix


def _vector(value: object, name: str, length: int) -> np.ndarray:
    vector = as_matrix(np.zeros(length) if value is None else value, name).ravel()
    if vector.size != length:
        raise ShapeError("{name} must have {length} entries; it has {vector_size}.",
                         name=name, length=length, vector_size=vector.size)
    return vector


def _limit(value: Any, name: str, m: int, none: float) -> np.ndarray:
    try:
        limit = np.array(np.broadcast_to(as_numbers(none if value is None else value, name, infinite=True), (m,)))
    except ValueError as problem:
        if isinstance(problem, EngineError):
            raise
        raise ShapeError("{name} must be one number or {m} numbers, one for each input.", name=name, m=m) from problem
    return frozen(limit)


def _positive(value: Any, name: str, zero_allowed: bool = False) -> float:
    number = real(value, name)
    if not np.isfinite(number) or number < 0 or (number == 0 and not zero_allowed):
        if zero_allowed:
            raise EngineError("{name} must be a non-negative number of seconds.", name=name)
        raise EngineError("{name} must be a positive number of seconds.", name=name)
    return number


@record()
class Scenario:
    """One run of the loop ẋ = A x + B u + G w, y = C x + D u + v with x̂̇ = Aₘ x̂ + Bₘ u + L (y − Cₘ x̂ − Dₘ u).

    The controller asks for u = r − K x̂ (u = r − K x with `state_feedback`); the actuator clips it to
    [u_min, u_max] and delays it by `delay` seconds (whole dt; before that the plant gets zero input).
    The observer is fed the clipped input (`fed="applied"`) or the asked one (`"commanded"`), never the delay.

    K: m×n (None: open loop), L: n×p (None: an open-loop copy of the plant). `model` is what observer and
    controller believe (None: the truth); its order may differ from the plant's, K, L and xhat0 go with the model.
    `reference`: (n_t, m) or (m,), held between grid points. `impulses`: (time s, jump of the plant state (n,)).
    W (q×q), V (p×p): intensities of w and v; a number is that number times I. w enters through G (n×q), by
    default B where W is m×m and I where W is n×n. With `sampled` (or a plant with dt > 0) observer and
    controller run once every dt with a held input. A plant with dt > 0 takes W, V as covariances of a sample.
    Everything but reference, W, V and G is an array (or a Plant) after construction.
    Raises ShapeError or EngineError, one sentence each.

    >>> Scenario(Plant([[0]], [[1]], [[1]]), [[1]], [[2]], x0=[1.0], horizon=2.0).horizon
    2.0
    """

    plant: Plant
    K: Given = None
    L: Given = None
    model: Given = None
    x0: Given = None
    xhat0: Given = None
    horizon: float = 10.0
    dt: float = 0.01
    sampled: bool = False
    reference: Given = None
    state_feedback: bool = False
    u_min: Given = None
    u_max: Given = None
    fed: Literal["applied", "commanded"] = "applied"
    W: Given = None
    V: Given = None
    G: Given = None
    seed: int = 0
    delay: float = 0.0
    impulses: tuple[tuple[float, Given], ...] = ()
    n_t: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        passed(self, **GATES)
        plant = self.plant
        model = plant if self.model is None else self.model
        if (model.m, model.p) != (plant.m, plant.p):
            raise ShapeError("The model has {m} inputs and {p} outputs but the plant has {m2} and {p2}; they must "
                             "agree.",
                             m=model.m, p=model.p, m2=plant.m, p2=plant.p)
        if model.dt != plant.dt:
            raise EngineError("Model and plant must both be continuous, or share one sampling period.")
        dt, horizon = _positive(self.dt, "dt"), _positive(self.horizon, phrase("The horizon"))
        if plant.dt and abs(dt - plant.dt) > 1e-9 * dt:
            raise EngineError("This plant is sampled every {dt:g} s; the scenario's dt must be the same.",
                              dt=plant.dt)
        if horizon < dt * (1 - 1e-9):
            raise EngineError("The horizon ({horizon:g} s) is shorter than one step of {dt:g} s; make it longer.",
                              horizon=horizon, dt=dt)
        if horizon / dt * (plant.n + model.n) > MOST_NUMBERS:
            raise EngineError("{horizon:.3g} steps are too many for one run; lengthen dt or shorten the horizon.",
                              horizon=horizon / dt)
        if self.state_feedback and model.n != plant.n:
            raise ShapeError("State feedback needs a gain for the plant's own states: model and plant differ in "
                             "order.")
        delay = _positive(self.delay, phrase("The delay"), zero_allowed=True)
        if delay > horizon:
            raise EngineError("The delay ({delay:g} s) is longer than the horizon ({horizon:g} s); shorten it.",
                              delay=delay, horizon=horizon)
        if abs(delay / dt - round(delay / dt)) > 1e-6 * max(1.0, delay / dt):
            raise EngineError("The delay must be a whole number of steps; choose {near:.6g} s instead of {delay:.6g} s.",
                              near=dt * round(delay / dt), delay=delay)
        n_t = round(horizon / dt) + 1
        u_min, u_max = _limit(self.u_min, "u_min", plant.m, -np.inf), _limit(self.u_max, "u_max", plant.m, np.inf)
        if np.any(u_min >= u_max):
            raise EngineError("u_min must lie below u_max for every input.")
        values = {
            "model": model, "horizon": horizon, "dt": dt, "n_t": n_t, "u_min": u_min, "u_max": u_max,
            "delay": delay,
            "K": _matrix(np.zeros((plant.m, model.n)) if self.K is None else self.K, "K", (plant.m, model.n), "m×n"),
            "L": _matrix(np.zeros((model.n, plant.p)) if self.L is None else self.L, "L", (model.n, plant.p), "n×p"),
            "x0": _vector(self.x0, "x0", plant.n), "xhat0": _vector(self.xhat0, "xhat0", model.n),
            "reference": self._reference(n_t), "impulses": self._impulses(), **self._noise(),
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    def _reference(self, n_t: int) -> np.ndarray | None:
        if self.reference is None:
            return None
        given = as_matrix(self.reference, phrase("The reference"))
        m = self.plant.m
        if given.shape == (1, m):
            return as_matrix(np.broadcast_to(given, (n_t, m)), phrase("The reference"))
        if given.shape == (1, n_t) and m == 1:
            return as_matrix(given.T, phrase("The reference"))
        if given.shape != (n_t, m):
            raise ShapeError("The reference must be {n_t}×{m}, a row for every grid point; it is {rows}×{columns}.",
                             n_t=n_t, m=m, rows=given.shape[0], columns=given.shape[1])
        return given

    def _impulses(self) -> tuple[tuple[float, np.ndarray], ...]:
        return tuple((_positive(time, phrase("The time of an impulse"), zero_allowed=True),
                      _vector(jump, phrase("The jump of an impulse"), self.plant.n)) for time, jump in self.impulses)

    def _noise(self) -> dict[str, np.ndarray | None]:
        plant, W, G = self.plant, self.W, self.G
        if G is not None:
            G = as_matrix(G, "G")
            if G.shape[0] != plant.n:
                raise ShapeError("G must have {n} rows, one for each state; it has {rows}.",
                                 n=plant.n, rows=G.shape[0])
        elif W is not None:
            G = np.eye(plant.n) if as_matrix(W, "W").shape[0] == plant.n != plant.m else plant.B
        return {"G": G, "W": None if W is None or G is None else as_covariance(W, "W", G.shape[1]),
                "V": None if self.V is None else as_covariance(self.V, "V", plant.p)}

    @property
    def t(self) -> np.ndarray:
        """The grid 0, dt, 2 dt … (n_t,) in seconds."""
        return self.dt * np.arange(self.n_t)

    @property
    def discrete(self) -> bool:
        """Whether observer and controller run once every dt."""
        return bool(self.sampled or self.plant.dt)

    @property
    def limited(self) -> bool:
        """Whether any input has a finite limit."""
        return bool(np.any(np.isfinite(self.u_min)) or np.any(np.isfinite(self.u_max)))

    @property
    def lag(self) -> int:
        """The delay in whole steps."""
        return round(self.delay / self.dt)


@record()
class Run:
    """A simulated run; arrays are time-first, finite, and end early where the run diverged.

    t (n_t,), x (n_t, n), xhat (n_t, n_model), e = x − x̂ (n_t, n; no columns if the orders differ),
    u_asked, u_applied (n_t, m; u_applied is what reaches the plant: clipped and delayed), y, yhat (n_t, p),
    w (n_t, q) mean of w over the step that follows, v (n_t, p) held over the step that follows.
    At an impulse the sample is the one just after it.
    """

    scenario: Scenario
    t: np.ndarray
    x: np.ndarray
    xhat: np.ndarray
    e: np.ndarray
    u_asked: np.ndarray
    u_applied: np.ndarray
    y: np.ndarray
    yhat: np.ndarray
    w: np.ndarray
    v: np.ndarray
    diverged_at: float | None
    saturated: bool
    made_of: Any = field(default=None, repr=False)  # the loop and the disturbances, for who asks more of the same run

    def plot(self) -> list[Axes]:
        """States with their estimates, one panel each, and the inputs that reached the plant."""
        plant, names = self.scenario.plant, (self.scenario.plant.state_names, self.scenario.plant.input_names)
        panels = {name: {name: self.x[:, i]} | ({f"{name}, estimate": self.xhat[:, i]} if self.e.shape[1] else {})
                  for i, name in enumerate(names[0][:plant.n])}
        return plot_signals(self.t, panels | {"inputs": {name: self.u_applied[:, i] for i, name in enumerate(names[1])}})

    @gated(time=number(-1e9, 1e9))
    def index(self, time: float) -> int:
        """The grid point at or just before `time`, kept inside the run."""
        return int(np.clip(np.floor(time / self.scenario.dt + 1e-9), 0, len(self.t) - 1))
