"""A loop with clipped inputs along its grid, run by run: the switchings of `simulation.saturation`, compiled.

w = (z, q) holds the states z (N,) and what acts beside them, q = (1, r, v). For each mode s of clipping that has been
met there are, transposed so that `times` reads them row by row:
    flow[s, j] (w → z, u, u̇ after h/2ʲ; padded), read[s] (w → u, u̇ now; padded), rate[s] (w → ż),
    taylor[s] (ż → coefficients of z(τ) − z(0) in rising powers of τ/short[s]), F (z → u without r),
    within[s] (2, m) the limits of u in the mode with their slack, counts[s] (levels of flow, first that may be used).
slot tells the place s of a mode by its code Σ (sign + 1) 3ⁱ, −1 where it has not been met.
"""

from __future__ import annotations

import numpy as np

from .small import times

__all__ = ["march"]

HUGE = 1e100  # a state beyond this is not followed
ROUNDING = 16 * 2.0**-52
NEWTON = 80
SAMPLES = 8  # of a polynomial, between which it crosses a limit at most once
MOST = 100_000  # switchings within a step


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
    w, v, ud = np.empty(N + q.shape[1]), np.empty(width), np.empty(read.shape[2])
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
                if counts[s, 1] == 0:
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
                                change, line)
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
    return max(limits[2, i], ROUNDING * reach)


def stays(ud, v, N, m, within, h):
    """Whether u keeps within the limits over a step of length h, by the Bernstein points of its cubic."""
    for i in range(m):
        u0, u1 = ud[i], v[N + i]
        inner0, inner1 = u0 + ud[m + i] * (h / 3), u1 - v[N + m + i] * (h / 3)
        if not (min(min(u0, u1), min(inner0, inner1)) >= within[0, i]
                and max(max(u0, u1), max(inner0, inner1)) <= within[1, i]):
            return False
    return True


def careful(w, left, slot, limits, F, within, counts, flow, read, rate, taylor, short, h, v, ud, change, line):
    """Take w through every switching of the next `left` seconds; the last mode, or −1 − the code of a missing one."""
    m, N = F.shape
    least, s = 1e-14 * h, 0
    for _ in range(MOST):
        if not left > least:
            break
        s = mode_at(w, slot, limits, F, read, ud)
        if s < 0:
            return s
        part, moved = h, False
        for level in range(counts[s, 0]):
            if level >= counts[s, 1] and part <= left * (1 + 1e-12):
                times(flow[s, level], w, v)
                if stays(ud, v, N, m, within[s], part):
                    moved = True
                    break
            part /= 2
        if moved:
            for j in range(N):
                w[j] = v[j]
            left -= part
        else:
            left -= piece(w, min(short[s], left), left, F, within[s], rate[s], taylor[s], short[s], v, ud, change, line)
        most = 0.0
        for j in range(N):
            if not abs(w[j]) <= most:
                most = abs(w[j])
        if not most < HUGE:
            break
    return s


def piece(w, part, left, F, within, rate, taylor, short, v, ud, change, line):
    """Move w along its Taylor series for `part`, or until an input leaves its limits; the time that it took."""
    m, N = F.shape
    terms = line.shape[0]
    times(rate, w, v)
    times(taylor, v[:N], change)
    for i in range(m):
        line[0, i] = ud[i]
        for k in range(1, terms):
            a = 0.0
            for j in range(N):
                a += change[(k - 1) * N + j] * F[i, j]
            line[k, i] = a
    end = part / short
    leave = end
    for i in range(m):
        for side in range(2):
            if np.isfinite(within[side, i]):
                leave = min(leave, first_exit(line, i, within[side, i], 1.0 if side else -1.0, end))
    power = 1.0
    for k in range(terms - 1):
        power *= leave
        for j in range(N):
            w[j] += power * change[k * N + j]
    return left if leave * short >= left * (1 - 1e-14) else leave * short


def first_exit(line, i, limit, side, end):
    """The first s in (0, end] where side·(polynomial i − limit) turns positive, by Newton within a bracket; or end."""
    terms = line.shape[0]
    a = b = 0.0
    found = False
    for j in range(1, SAMPLES + 1):
        b = end * j / SAMPLES
        value = 0.0
        for k in range(terms - 1, -1, -1):
            value = value * b + line[k, i]
        if side * (value - limit) > 0:
            found = True
            break
        a = b
    if not found:
        return end
    s = 0.5 * (a + b)
    for _ in range(NEWTON):
        value = slope = 0.0
        for k in range(terms - 1, -1, -1):
            slope = slope * s + value
            value = value * s + line[k, i]
        value -= limit
        if value == 0:
            break
        if side * value > 0:
            b = s
        else:
            a = s
        new = s - value / slope if slope != 0 else a
        if not a < new < b:
            new = 0.5 * (a + b)
        done = abs(new - s) <= 1e-15 * abs(b) + 1e-300
        s = new
        if done:
            break
    return s
