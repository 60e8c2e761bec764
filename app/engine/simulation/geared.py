"""Simulate a loop with backlash and encoder quantisation that its observer ignores."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from ..kernels import as_kernel_array, compiled_kernel
from ..kernels.geared import Clipping, GearPath, Play, Rounding, contact_steps
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import choice, count, instance, number, passed, takes, vector
from ..systems.plant import Plant
from ..systems.records import record
from .contact import Contact
from .disturbance import disturbances
from .loop import Loop, continuous_loop
from .scenario import Run, Scenario
from .simulate import DIVERGENCE_FACTOR

__all__ = ["Gear", "GearedRun", "simulate_geared"]

_INERTIA = number(above=0, high=1e100)
GATES = MappingProxyType({"angle": count(), "speed": count(), "inner": _INERTIA, "outer": _INERTIA, "load": vector("n"),
                          "gap": number(0, 1e100), "sensor": choice("inner", "outer"), "step": number(0, 1e100)})


@record()
class Gear:
    """Play between a driving (inner) and a driven (outer) body that the plant takes for one, all as seen at the driven one.

    `angle`, `speed`: their places in the plant's state; `inner`, `outer`: the two inertias, kg m²; `load` (n,): the torque on the
    outer body is load·x, N m, all other torques act on the inner one; `gap`: from flank to flank, rad. The sensor reads the inner
    or the outer angle in whole multiples of `step` (rad; 0: exactly). Raises EngineError.

    >>> Gear(0, 1, 0.5, 1.5, [0.0, 0.0], gap=0.02).sensor
    'inner'
    """

    angle: int
    speed: int
    inner: float
    outer: float
    load: Any
    gap: float = 0.0
    sensor: Literal["inner", "outer"] = "inner"
    step: float = 0.0

    def __post_init__(self) -> None:
        passed(self, **GATES)
        if self.angle == self.speed:
            raise EngineError("Angle and speed must be two states.")


@record()
class GearedRun:
    """`run`, its x that of the outer body, its v what the encoder reads beside the truth; `inner` (n_t,) the inner angle, rad.

    `contact` (n_t,): 1 where a flank pushes forward, −1 where one pushes back, 0 where none does.
    """

    run: Run
    inner: np.ndarray
    contact: np.ndarray


@takes(scenario=instance(Scenario), gear=instance(Gear))
def simulate_geared(scenario: Scenario, gear: Gear) -> GearedRun:
    """Run a continuous loop over a gear with play, the encoder read and the limits looked at once every dt.

    In between all is exact: ż = M z + g with g held, M one of two for contact and gap (Nordin and Gutman, Automatica 38 (2002)
    1633–1649; plastic impacts, changes of contact to dt/256). It begins in the middle of the gap, and impulses jump both bodies,
    at the nearest grid point. Raises EngineError for a scenario with noise, delay, sampling, or a plant that the gear does not fit.

    >>> P = Plant([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    >>> s = Scenario(P, K=[[4, 4]], L=[[9], [20]], x0=[1, 0], horizon=4.0)
    >>> bool(abs(simulate_geared(s, Gear(0, 1, 0.5, 0.5, [0, 0], gap=0.02)).run.x[-1, 0]) < 0.02)
    True
    """
    s, n = scenario, scenario.plant.n
    if s.discrete or s.lag or s.W is not None or s.V is not None or np.any(s.plant.D) or s.fed != "applied":
        raise EngineError("A run over a gear is continuous, without delay, noise or direct path, and its observer gets the applied input.")
    if max(gear.angle, gear.speed) >= n or len(gear.load) != n:
        raise ShapeError("Angle, speed and load of the gear must fit the {n} states of the plant.", n=n)
    wide = _opened(s, gear)
    loop = continuous_loop(wide)
    z, inner, contact, v = _march(wide, loop, gear)
    count = len(z)
    u_asked = z @ loop.F.T + (0.0 if s.reference is None else s.reference[:count])
    x, xhat = z[:, :n].copy(), z[:, n + 2:]
    x[:, [gear.angle, gear.speed]] = z[:, n:n + 2]
    applied = np.clip(u_asked, s.u_min, s.u_max)
    y, yhat = z[:, :n + 2] @ wide.plant.C.T + v, xhat @ s.model.C.T
    e = x - xhat if x.shape == xhat.shape else np.zeros((count, 0))
    run = Run(s, s.t[:count], x, xhat, e, u_asked, applied, y, yhat, np.zeros((count, 0)), v,
              None if count == s.n_t else float(s.dt * count), bool(np.any(applied != u_asked)))
    return GearedRun(run, inner, contact)


def _opened(s: Scenario, gear: Gear) -> Scenario:
    """The scenario with the outer body's angle and speed as two more states, and no contact between the two."""
    n, both = s.plant.n, gear.inner + gear.outer
    A, B, C = np.zeros((n + 2, n + 2)), np.zeros((n + 2, s.plant.m)), np.zeros((s.plant.p, n + 2))
    A[:n, :n], B[:n], C[:, :n] = s.plant.A, s.plant.B, s.plant.C
    load: np.ndarray = np.array(gear.load, dtype=float)
    A[gear.speed, :n] = (both * s.plant.A[gear.speed] - load) / gear.inner
    B[gear.speed] *= both / gear.inner
    A[n, n + 1] = 1.0
    A[n + 1, :n] = load / gear.outer
    for place, own in ((gear.angle, n), (gear.speed, n + 1)):  # the outer body's torque depends on its own motion
        A[n + 1, own] += A[n + 1, place]
        A[n + 1, place] = 0.0
    if gear.sensor == "outer":
        C[:, n], C[:, n + 1] = C[:, gear.angle], C[:, gear.speed]
        C[:, [gear.angle, gear.speed]] = 0.0
    impulses = tuple((t, _both(jump, gear)) for t, jump in s.impulses)
    return replace(s, plant=Plant(A, B, C), model=s.model, x0=_both(s.x0, gear), impulses=impulses, G=None)


def _both(x: np.ndarray, gear: Gear) -> np.ndarray:
    """A state or a jump of the plant with that of the outer body behind it."""
    return np.concatenate([x, x[[gear.angle, gear.speed]]])


def _march(s: Scenario, loop: Loop, gear: Gear) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """States (n_t, N), inner angle, contact (n_t,) and what the encoder adds to y (n_t, p)."""
    rounded = replace(s, impulses=tuple((s.dt * round(t / s.dt), jump) for t, jump in s.impulses))
    d, n = disturbances(rounded, loop), s.plant.n
    r = np.zeros((s.n_t, s.plant.m)) if s.reference is None else s.reference
    C = np.hstack([s.plant.C, np.zeros((s.plant.p, len(d.z0) - n))])
    bound = DIVERGENCE_FACTOR * max(1.0, float(np.max(np.abs(d.z0), initial=0.0)))
    modes: dict[tuple[int, ...], tuple[Contact, np.ndarray]] = {}
    F, E, step, low, high = loop.F, loop.E, gear.step, s.u_min.tolist(), s.u_max.tolist()
    states, contact, v = np.empty((s.n_t, len(d.z0))), np.zeros(s.n_t, dtype=int), np.zeros((s.n_t, s.plant.p))
    stretch = _Stretch(states, contact, v, d.jumps, r, loop, C, s, step, bound)
    states[0], side, k = d.z0, 0, 0
    while True:
        z, contact[k] = states[k], side
        if not np.abs(z).max() < bound:
            break
        if step:
            v[k] = [step * round(y / step) - y for y in (C @ z).tolist()]
        if k == s.n_t - 1:
            break
        key = tuple((u > most) - (u < least) for u, most, least in zip((F @ z + r[k]).tolist(), high, low, strict=True))
        if key not in modes:
            modes[key] = _mode(s, loop, gear, np.array(key), r)
        motion, push = modes[key]
        z, side = motion.advance(z, push[k] + E @ v[k] if step else push[k], side)
        states[k + 1] = z if d.jumps is None else z + d.jumps[k]
        k = stretch.go_on(k + 1, motion, push, key, side)
    count = k + 1 if np.abs(states[k]).max() < bound else k
    return states[:count], states[:count, gear.angle], contact[:count], v[:count]


def _mode(s: Scenario, loop: Loop, gear: Gear, sign: np.ndarray, r: np.ndarray) -> tuple[Contact, np.ndarray]:
    """The motion with some inputs at their limits, and what acts beside it (n_t, N)."""
    n, free = s.plant.n, sign == 0
    held = np.where(sign > 0, s.u_max, np.where(sign < 0, s.u_min, 0.0))
    motion = Contact(loop.closed(free), (gear.angle, gear.speed), (n - 2, n - 1), (gear.inner, gear.outer), gear.gap / 2, s.dt)
    return motion, loop.forcing(free, held, r, np.zeros((len(r), s.plant.p)))


class _Stretch:
    """The steps in which neither contact nor clipping changes, by a kernel; none without it."""

    def __init__(self, states: np.ndarray, contact: np.ndarray, v: np.ndarray, jumps: np.ndarray | None, r: np.ndarray, loop: Loop,
                 C: np.ndarray, s: Scenario, step: float, bound: float) -> None:
        self._work, self._last, self._bound = compiled_kernel(contact_steps), s.n_t - 1, bound
        if self._work is not None:
            self._path = GearPath(states, contact, v, as_kernel_array(np.empty((0, states.shape[1])) if jumps is None else jumps))
            self._rounding = Rounding(as_kernel_array(loop.E), as_kernel_array(C), float(step))
            self._clipping = tuple(map(as_kernel_array, (loop.F, r, s.u_min, s.u_max)))

    def go_on(self, k: int, motion: Contact, push: np.ndarray, key: tuple[int, ...], side: int) -> int:
        """The step up to which all is filled: k, or later."""
        if self._work is None:
            return k
        flow, torque = (motion.together if side or not motion.half else motion.apart)[0], np.abs(motion.torque)
        play = Play(as_kernel_array(motion.row), as_kernel_array(motion.torque), as_kernel_array(torque @ np.abs(motion.A)),
                    np.array([motion.inner[0], motion.outer[0]]), float(motion.half))
        return self._work(self._path, as_kernel_array(np.array(flow)), as_kernel_array(push), self._rounding,
                          Clipping(*self._clipping, np.array(key, dtype=float)), play, side, self._bound, k, self._last)
