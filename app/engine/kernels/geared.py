"""Step a loop with gear play until its contact or its clipping changes."""

from __future__ import annotations

import numpy as np

__all__ = ["contact_steps"]

TORQUE_ROUNDING = 1e-12  # as in simulation.contact


def contact_steps(states, contact, v, flow, push, jumps, E, C, step, F, r, low, high, key, row, torque, sizes, places, half, side,
                  bound, begin, end):
    """Fill states, contact and v from step `begin` on; the step at which something changes or is to be judged, at most `end`.

    z⁺ = Φ z + Φ₁ (push + E v) + jump with `flow` = (Φ, Φ₁), v what rounding to whole multiples of `step` adds to C z (0: nothing). It goes
    on while F z + r is clipped as `key` (m,) says (1: at its upper limit, −1: at its lower one), |z| stays below `bound` and the
    contact `side` holds: row·z + torque·g pushes, to rounding of |row| terms sizes·|z| + |torque|·|g|, or without one the two angles
    at `places` stay within `half` of each other; `half` = 0 always holds. `jumps` may have no rows.
    """
    N, m, p = states.shape[1], F.shape[0], C.shape[0]
    g, after = np.empty(N), np.empty(N)
    for k in range(begin, end):
        contact[k] = side
        for i in range(N):
            if not abs(states[k, i]) < bound:
                return k
        for i in range(m):
            u = 0.0
            for j in range(N):
                u += F[i, j] * states[k, j]
            u += r[k, i]
            if (1.0 if u > high[i] else 0.0) - (1.0 if u < low[i] else 0.0) != key[i]:
                return k
        for i in range(N):
            g[i] = push[k, i]
        if step > 0.0:
            for i in range(p):
                y = 0.0
                for j in range(N):
                    y += C[i, j] * states[k, j]
                y = step * np.rint(y / step) - y
                v[k, i] = y
                for j in range(N):
                    g[j] += E[j, i] * y
        for i in range(N):
            a = 0.0
            for j in range(N):
                a += flow[0, i, j] * states[k, j] + flow[1, i, j] * g[j]
            after[i] = a
        if half > 0.0:
            if side == 0:
                if not abs(after[places[0]] - after[places[1]]) <= half * (1 + TORQUE_ROUNDING):
                    return k
            else:
                pushed, size = 0.0, 0.0
                for j in range(N):
                    pushed += row[j] * after[j] + torque[j] * g[j]
                    size += sizes[j] * abs(after[j]) + abs(torque[j]) * abs(g[j])
                if not side * pushed >= -TORQUE_ROUNDING * size:
                    return k
        for i in range(N):
            states[k + 1, i] = after[i] + (jumps[k, i] if jumps.shape[0] else 0.0)
    return end
