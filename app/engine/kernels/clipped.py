"""March runs of a loop with clipped inputs along the grid, as `simulation.saturation` does.

w = (z, q) holds the states z (N,) and what acts beside them, q = (1, r, v). For each mode s of clipping that has been
met there are, transposed so that `times` reads them row by row:
    flow[s, j] (w → z, u, u̇ after h/2ʲ; padded), read[s] (w → u, u̇ now; padded), rate[s] (w → ż),
    taylor[s] (ż → coefficients of z(τ) − z(0) in rising powers of τ/short[s]), F (z → u without r),
    within[s] (2, m) the limits of u in the mode with their slack, counts[s] (levels of flow, first that may be used, first that tells
    u by itself: longer ones are told from doubling to doubling).
slot tells the place s of a mode by its code Σ (sign + 1) 3ⁱ, −1 where it has not been met.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .limit_crossings import piece
from .small_matrices import times

__all__ = ["Modes", "Runs", "march"]

STATE_LIMIT = 1e100  # a state beyond this is not followed
LIMIT_ROUNDING = 16 * 2.0**-52
MAX_PIECES = 100_000  # pieces of a step
DOUBT = 0.25  # as in simulation.saturation


class Modes(NamedTuple):
    """The modes that have been met, as told above, and the grid's step h in s."""

    slot: np.ndarray
    limits: np.ndarray
    F: np.ndarray
    within: np.ndarray
    counts: np.ndarray
    flow: np.ndarray
    read: np.ndarray
    rate: np.ndarray
    taylor: np.ndarray
    short: np.ndarray
    h: float


class Runs(NamedTuple):
    """Runs Z (runs, N) and for each the step `at` which it stands, the `last` one that counts, and whether it is `lost`."""

    Z: np.ndarray
    at: np.ndarray
    last: np.ndarray
    lost: np.ndarray


class Room(NamedTuple):
    """Room to work in: what flows give, inputs with their slopes, a second flow, a trial state, and a Taylor series."""

    v: np.ndarray
    ud: np.ndarray
    v2: np.ndarray
    trial: np.ndarray
    change: np.ndarray
    line: np.ndarray


def march(runs, end, out, q, jumps, judge, modes, begin, stop):
    """Take runs begin … stop − 1 from their steps `at` to step `end`; a missing mode's code, or −1.

    out (end + 1, runs, N) keeps the states, or has no rows. judge = (n, near², far², rest, bound): `last` is the
    last step at which ‖x‖² ≥ near², x the first n states; beyond far² or with another state beyond `rest` a run is lost
    and goes no further, nor where a state passes `bound`: `at` is then the last step before.
    """
    N, held, missing = runs.Z.shape[1], q.shape[0] == 1, -1
    near, far, rest, bound = judge[1], judge[2], judge[3], judge[4]
    width, size = N + q.shape[1], modes.taylor.shape[2]
    room = Room(np.empty(modes.flow.shape[3]), np.empty(modes.read.shape[2]), np.empty(modes.flow.shape[3]), np.empty(width),
                np.empty(size), np.empty((size // N + 1, modes.F.shape[0])))
    w = np.empty(width)
    for run in range(begin, stop):
        if runs.lost[run]:
            continue
        for j in range(N):
            w[j] = runs.Z[run, j]
        k, s, known = runs.at[run], 0, False
        while k < end:
            if not (held and known):
                for j in range(q.shape[1]):
                    w[N + j] = q[0 if held else k, j]
            if not known:
                s = mode_at(w, modes, room.ud)
            if s >= 0:
                s, known = stepped(w, s, modes, room)
            if s < 0:
                missing = -1 - s
                break
            known = known and held and not jumps.shape[0]
            if jumps.shape[0]:
                for j in range(N):
                    w[j] += jumps[k, j]
            square, most, beyond = lengths(w, N, int(judge[0]), min(rest, bound))
            if not most < bound:
                runs.lost[run] = True
                break
            known = known and deep(room.v, s, most, modes)
            if known:
                for i in range(2 * modes.F.shape[0]):
                    room.ud[i] = room.v[N + i]
            k += 1
            if square >= near:
                runs.last[run] = k
            if square > far or beyond > rest:
                runs.lost[run] = True
                k = end
            if out.shape[0]:
                for j in range(N):
                    out[k, run, j] = w[j]
        runs.at[run] = k
        for j in range(N):
            runs.Z[run, j] = w[j]
    return missing


def stepped(w, s, modes, room):
    """Take w over a step from mode s; the mode at its end or −1 − the code of a missing one, and whether it stayed in s throughout."""
    m, N = modes.F.shape
    if modes.counts[s, 2] == 0:
        times(modes.flow[s, 0], w, room.v)
        if stays(room.ud, room.v, N, m, modes.within[s], modes.h):
            for j in range(N):
                w[j] = room.v[j]
            return s, True
    for j in range(len(w)):
        room.trial[j] = w[j]
    s = careful(room.trial, modes, room)
    if s >= 0:
        for j in range(N):
            w[j] = room.trial[j]
    return s, False


def lengths(w, N, n, small):
    """‖x‖² of the first n states, the largest of all and of the others; only bounds of these where ‖z‖ itself is below `small`."""
    square, most, beyond = 0.0, np.sqrt(length2(w, N)), 0.0
    for j in range(n):
        square += w[j] * w[j]
    if not most < small:  # ‖z‖ is at least its largest entry: only now look at each
        most = 0.0
        for j in range(N):
            size = abs(w[j])
            if not size <= most:
                most = size
            if j >= n and not size <= beyond:
                beyond = size
    return square, most, beyond


def deep(v, s, most, modes):
    """Whether every input is well within its mode, so that the next step begins in it."""
    m, N = modes.F.shape
    for i in range(m):
        margin = modes.limits[2, i] + max(modes.limits[2, i], modes.limits[3, i] * most)
        if not modes.within[s, 0, i] + margin < v[N + i] < modes.within[s, 1, i] - margin:
            return False
    return True


def length2(w, N):
    """‖z‖² of the first N entries."""
    a = b = c = d = 0.0
    even = N - N % 4
    for j in range(0, even, 4):
        a += w[j] * w[j]
        b += w[j + 1] * w[j + 1]
        c += w[j + 2] * w[j + 2]
        d += w[j + 3] * w[j + 3]
    for j in range(even, N):
        a += w[j] * w[j]
    return a + b + c + d


def mode_at(w, modes, ud):
    """The place of the mode just after a state, ud = (u, u̇) in it; −1 − its code where it is missing.

    On a limit the slope of u decides.
    """
    slot, limits, F, read = modes.slot, modes.limits, modes.F, modes.read
    m, N = F.shape
    times(read[0], w, ud)
    code, power, near, most = 0, 1, False, np.sqrt(length2(w, N))
    for i in range(m):
        u = ud[i]
        code += power * (2 if u > limits[1, i] else 0 if u < limits[0, i] else 1)
        power *= 3
        gap = min(abs(u - limits[1, i]), abs(u - limits[0, i]))
        if gap <= max(limits[2, i], limits[3, i] * most):
            near = near or gap <= slack_of(i, w, limits, F)
    s = slot[code]
    if s < 0:
        return -1 - code
    if s > 0:
        times(read[s], w, ud)
    if not near:
        return s
    code, power = 0, 1
    for i in range(m):
        u, slack = ud[i], slack_of(i, w, limits, F)
        if abs(u - limits[1, i]) <= slack:
            sign = 2 if ud[m + i] > 0 else 1
        elif abs(u - limits[0, i]) <= slack:
            sign = 0 if ud[m + i] < 0 else 1
        else:
            sign = 2 if u > limits[1, i] else 0 if u < limits[0, i] else 1
        code += power * sign
        power *= 3
    other = slot[code]
    if other < 0:
        return -1 - code
    if other != s:
        times(read[other], w, ud)
    return other


def slack_of(i, w, limits, F):
    """How near to its limit input i counts as on it: limits[2], or its own rounding, at most limits[3]·‖z‖."""
    reach = 0.0
    for j in range(F.shape[1]):
        reach += abs(F[i, j]) * abs(w[j])
    return max(limits[2, i], LIMIT_ROUNDING * reach)


def stays(ud, v, N, m, within, h):
    """Whether u keeps within the limits over a step of length h, by the Bernstein points of its cubic and DOUBT of its cubic term."""
    for i in range(m):
        u0, u1 = ud[i], v[N + i]
        inner0, inner1 = u0 + ud[m + i] * (h / 3), u1 - v[N + m + i] * (h / 3)
        doubt = DOUBT * abs(2 * (u0 - u1) + (ud[m + i] + v[N + m + i]) * h)
        if not (min(min(u0, u1), min(inner0, inner1)) - doubt >= within[0, i]
                and max(max(u0, u1), max(inner0, inner1)) + doubt <= within[1, i]):
            return False
    return True


def careful(w, modes, room):
    """Take w through every switching of the next h seconds; the last mode, or −1 − the code of a missing one.

    w[0] is ∞ where it cannot be followed.
    """
    counts, flow, within, h, v, v2, ud = modes.counts, modes.flow, modes.within, modes.h, room.v, room.v2, room.ud
    m, N = modes.F.shape
    left, least, s = h, 1e-14 * h, 0
    for _ in range(MAX_PIECES):
        if not left > least:
            break
        most = np.sqrt(length2(w, N))
        if not most < STATE_LIMIT or blurred(w, most, modes.limits, modes.F):
            w[0] = np.inf
            return s
        s = mode_at(w, modes, ud)
        if s < 0:
            return s
        longest, part = counts[s, 1], h / 2.0 ** counts[s, 1]
        while longest < counts[s, 0] and part > left * (1 + 1e-12):
            longest += 1
            part /= 2
        level, moved = longest, False
        while level < counts[s, 2]:
            level += 1
            part /= 2
        while level < counts[s, 0]:
            times(flow[s, level], w, v)
            if stays(ud, v, N, m, within[s], part):
                moved = True
                break
            level += 1
            part /= 2
        if moved:
            while level > longest:
                times(flow[s, level - 1], w, v2)
                if not stays(v[N:], v2, N, m, within[s], part):
                    break
                for j in range(len(v)):
                    v[j] = v2[j]
                level -= 1
                part *= 2
            for j in range(N):
                w[j] = v[j]
            left -= part
        else:
            left -= piece(w, left, modes, s, room)
    if left > least:
        w[0] = np.inf
    return s


def blurred(w, most, limits, F):
    """Whether a state is so large that rounding alone takes an input from one limit to the other; `most` is its length."""
    for i in range(F.shape[0]):
        span = limits[1, i] - limits[0, i]
        if limits[3, i] * most > span:
            reach = 0.0
            for j in range(F.shape[1]):
                reach += abs(F[i, j]) * abs(w[j])
            if LIMIT_ROUNDING * reach > span:
                return True
    return False
