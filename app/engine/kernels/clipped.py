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

import numpy as np

from .limit_crossings import piece
from .small_matrices import times

__all__ = ["march"]

STATE_LIMIT = 1e100  # a state beyond this is not followed
LIMIT_ROUNDING = 16 * 2.0**-52
MAX_PIECES = 100_000  # pieces of a step
DOUBT = 0.25  # as in simulation.saturation


def march(Z, at, end, out, q, jumps, judge, last, lost, slot, limits, F, within, counts, flow, read, rate, taylor,
          short, h, begin, stop):
    """Take runs begin … stop − 1 of Z (runs, N) from their steps at (runs,) to step `end`; a missing mode's code, or −1.

    out (end + 1, runs, N) keeps the states, or has no rows. judge = (n, near², far², rest, bound): last (runs,) is the
    last step at which ‖x‖² ≥ near², x the first n states; beyond far² or with another state beyond `rest` a run is lost
    and goes no further, nor where a state passes `bound`: `at` is then the last step before.
    """
    N = Z.shape[1]
    m, width = F.shape[0], flow.shape[3]
    n, near, far, rest, bound = int(judge[0]), judge[1], judge[2], judge[3], judge[4]
    w, v, ud, v2 = np.empty(N + q.shape[1]), np.empty(width), np.empty(read.shape[2]), np.empty(width)
    trial, change, line = np.empty(len(w)), np.empty(taylor.shape[2]), np.empty((taylor.shape[2] // N + 1, m))
    missing, held, small = -1, q.shape[0] == 1, min(rest, bound)
    for run in range(begin, stop):
        if lost[run]:
            continue
        for j in range(N):
            w[j] = Z[run, j]
        k, s, known = at[run], 0, False
        while k < end:
            if not (held and known):
                for j in range(q.shape[1]):
                    w[N + j] = q[0 if held else k, j]
            if not known:
                s = mode_at(w, slot, limits, F, read, ud)
            known = False
            if s >= 0:
                good = False
                if counts[s, 2] == 0:
                    times(flow[s, 0], w, v)
                    good = stays(ud, v, N, m, within[s], h)
                if good:
                    for j in range(N):
                        w[j] = v[j]
                    known = held and not jumps.shape[0]
                else:
                    for j in range(len(w)):
                        trial[j] = w[j]
                    s = careful(trial, h, slot, limits, F, within, counts, flow, read, rate, taylor, short, h, v, ud,
                                v2, change, line)
                    if s >= 0:
                        for j in range(N):
                            w[j] = trial[j]
            if s < 0:
                missing = -1 - s
                break
            if jumps.shape[0]:
                for j in range(N):
                    w[j] += jumps[k, j]
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
            if not most < bound:
                lost[run] = True
                break
            for i in range(m):  # well within its mode it goes on in it
                if known:
                    margin = limits[2, i] + max(limits[2, i], limits[3, i] * most)
                    known = within[s, 0, i] + margin < v[N + i] < within[s, 1, i] - margin
            if known:
                for i in range(2 * m):
                    ud[i] = v[N + i]
            k += 1
            if square >= near:
                last[run] = k
            if square > far or beyond > rest:
                lost[run] = True
                k = end
            if out.shape[0]:
                for j in range(N):
                    out[k, run, j] = w[j]
        at[run] = k
        for j in range(N):
            Z[run, j] = w[j]
    return missing


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


def mode_at(w, slot, limits, F, read, ud):
    """The place of the mode just after a state, ud = (u, u̇) in it; −1 − its code where it is missing.

    On a limit the slope of u decides.
    """
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


def careful(w, left, slot, limits, F, within, counts, flow, read, rate, taylor, short, h, v, ud, v2, change, line):
    """Take w through every switching of the next `left` seconds; the last mode, or −1 − the code of a missing one.

    w[0] is ∞ where it cannot be followed.
    """
    m, N = F.shape
    least, s = 1e-14 * h, 0
    for _ in range(MAX_PIECES):
        if not left > least:
            break
        most = np.sqrt(length2(w, N))
        if not most < STATE_LIMIT or blurred(w, most, limits, F):
            w[0] = np.inf
            return s
        s = mode_at(w, slot, limits, F, read, ud)
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
            left -= piece(w, min(short[s], left), left, F, within[s], rate[s], taylor[s], short[s], v, ud, change, line)
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
