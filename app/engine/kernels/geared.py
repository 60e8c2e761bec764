"""Step a loop with gear play until its contact or its clipping changes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

__all__ = ["Clipping", "GearPath", "Play", "Rounding", "contact_steps"]

TORQUE_ROUNDING = 1e-12  # as in simulation.contact


class GearPath(NamedTuple):
    """What is filled, states (steps, N), contact and v, and the jumps of the states, which may have no rows."""

    states: np.ndarray
    contact: np.ndarray
    v: np.ndarray
    jumps: np.ndarray


class Rounding(NamedTuple):
    """v rounds C z to whole multiples of `step` (0: not at all) and acts by E v."""

    E: np.ndarray
    C: np.ndarray
    step: float


class Clipping(NamedTuple):
    """F z + r is clipped as `key` (m,) says: 1 at its upper limit, −1 at its lower one."""

    F: np.ndarray
    r: np.ndarray
    low: np.ndarray
    high: np.ndarray
    key: np.ndarray


class Play(NamedTuple):
    """Contact holds while row·z + torque·g pushes, to rounding of |row| terms sizes·|z| + |torque|·|g|; without contact the two angles
    at `places` stay within `half` of each other. `half` = 0 always holds."""

    row: np.ndarray
    torque: np.ndarray
    sizes: np.ndarray
    places: np.ndarray
    half: float


def contact_steps(path, flow, push, rounding, clipping, play, side, bound, begin, end):
    """Fill the path from step `begin` on; the step at which something changes or is to be judged, at most `end`.

    z⁺ = Φ z + Φ₁ g + jump with `flow` = (Φ, Φ₁) and g = push + E v. It goes on while the clipping and the contact `side` hold and |z|
    stays below `bound`.
    """
    states, jumps, C, step, F, half = path.states, path.jumps, rounding.C, rounding.step, clipping.F, play.half
    N, m, p = states.shape[1], F.shape[0], C.shape[0]
    g, after = np.empty(N), np.empty(N)
    for k in range(begin, end):
        path.contact[k] = side
        for i in range(N):
            if not abs(states[k, i]) < bound:
                return k
        for i in range(m):
            u = 0.0
            for j in range(N):
                u += F[i, j] * states[k, j]
            u += clipping.r[k, i]
            if (1.0 if u > clipping.high[i] else 0.0) - (1.0 if u < clipping.low[i] else 0.0) != clipping.key[i]:
                return k
        for i in range(N):
            g[i] = push[k, i]
        if step > 0.0:
            for i in range(p):
                y = 0.0
                for j in range(N):
                    y += C[i, j] * states[k, j]
                y = step * np.rint(y / step) - y
                path.v[k, i] = y
                for j in range(N):
                    g[j] += rounding.E[j, i] * y
        for i in range(N):
            a = 0.0
            for j in range(N):
                a += flow[0, i, j] * states[k, j] + flow[1, i, j] * g[j]
            after[i] = a
        if half > 0.0 and not holds(play, side, after, g):
            return k
        for i in range(N):
            states[k + 1, i] = after[i] + (jumps[k, i] if jumps.shape[0] else 0.0)
    return end


def holds(play, side, after, g):
    """Whether the contact of that side, 0 for none, still holds at the next state."""
    if side == 0:
        return abs(after[play.places[0]] - after[play.places[1]]) <= play.half * (1 + TORQUE_ROUNDING)
    pushed, size = 0.0, 0.0
    for j in range(len(after)):
        pushed += play.row[j] * after[j] + play.torque[j] * g[j]
        size += play.sizes[j] * abs(after[j]) + abs(play.torque[j]) * abs(g[j])
    return side * pushed >= -TORQUE_ROUNDING * size
