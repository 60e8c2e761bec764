"""Propagate a clipped loop exactly between switchings, and locate each switching."""

from __future__ import annotations

from dataclasses import field

import numpy as np
from scipy.linalg import matrix_balance

from ..systems.records import record
from ..systems.recursions import affine_scan
from .loop import Loop

__all__ = ["Mode", "Switcher"]

TERMS = 18  # of the Taylor series of e^{M h} with ‖M h‖₁ ≤ 1: remainder 1/18! ≈ 1.6e-16
LIMIT_ROUNDING = 16 * np.finfo(float).eps
SLACK = 1e-12  # relative to the limits: closer than this counts as on the limit
RINGING = 1.5  # |imaginary| over |real| part beyond which a mode swings more than once
CROSSING_SHARES = np.linspace(0.0, 1.0, 9)
POWERS = CROSSING_SHARES[:, None] ** np.arange(TERMS + 1)
STATE_LIMIT = 1e100  # a state beyond this is not followed
MAX_STEPS_AT_ONCE = 512  # grid steps tried at once in one mode
MAX_STEP_PIECES = 100_000  # pieces of a grid step
DOUBT = 0.25  # of the cubic term; an exponential that decays by a factor of 55 from end to end is off by a tenth of it


@record()
class Mode:
    """One way the inputs can be clipped: free (bool, m), the limits held, and the exact flow at dyadic parts of a step.

    flow[j] = (Φ, Φ₁) over h / 2^j; the last of them is short enough for `taylor` (TERMS·N × N), which maps ż to the
    coefficients of z(τ) − z(0) in powers 1 … TERMS of τ / h_last. From part `first` on, a ringing mode turns by less
    than a radian, so that u between two ends is told by its values and slopes there. What decays within a step is told so from
    part `looks` on, and after that from one doubling of the time to the next.
    """

    free: np.ndarray
    held: np.ndarray
    low: np.ndarray
    high: np.ndarray
    M: np.ndarray
    FM: np.ndarray
    flow: tuple[tuple[np.ndarray, np.ndarray], ...]
    taylor: np.ndarray
    short: float
    first: int
    looks: int


def _mode(loop: Loop, sign: np.ndarray, u_min: np.ndarray, u_max: np.ndarray, h: float) -> Mode:
    """Taylor series over a short part of the step and doublings up to h, in balanced coordinates (powers of two)."""
    free = sign == 0
    M = loop.closed(free)
    balanced, (scale, _) = matrix_balance(M, permute=False, separate=True)
    outer = scale[:, None] / scale
    halvings = max(0, int(np.ceil(np.log2(max(np.linalg.norm(balanced, 1) * h, 1e-300)))))
    short, N = h / 2**halvings, len(M)
    terms, part = np.empty((TERMS, N, N)), balanced * short
    terms[0] = short * np.eye(N)
    for k in range(1, TERMS):
        np.matmul(terms[k - 1], part, out=terms[k])
        terms[k] *= 1 / (k + 1)
    Phi1 = terms[::-1].sum(axis=0)
    flow = [(np.eye(N) + balanced @ Phi1, Phi1)]
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(halvings):
            Phi, Phi1 = flow[-1]
            flow.append((Phi @ Phi, Phi1 + Phi @ Phi1))
        flow = tuple((outer * Phi, outer * Phi1) for Phi, Phi1 in flow[::-1])
    first = looks = 0
    if np.linalg.norm(balanced, 1) * h > 1.0:  # else no |λ| h is beyond 1
        poles = np.linalg.eigvals(balanced)
        ringing = np.abs(poles.imag[np.abs(poles.imag) > RINGING * np.abs(poles.real)])
        first, looks = (int(np.ceil(np.log2(max(1.0, rates.max(initial=0.0) * h)))) for rates in (ringing, np.abs(poles.real)))
    held = np.where(sign > 0, u_max, np.where(sign < 0, u_min, 0.0))
    low = np.where(sign > 0, u_max, np.where(sign < 0, -np.inf, u_min))
    high = np.where(sign < 0, u_min, np.where(sign > 0, np.inf, u_max))
    return Mode(free, held, low, high, M, loop.F @ M, flow, (outer * terms).reshape(-1, N), short, first, min(max(first, looks), halvings))


def bounds(u0: np.ndarray, u1: np.ndarray, d0: np.ndarray, d1: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest value over a step of the cubic with these ends and slopes, by its Bernstein points.

    Wider by DOUBT of its cubic term: u is a sum of exponentials, and the cubic is off by less than that where one of them decays.
    """
    inner0, inner1 = u0 + d0 * (h / 3), u1 - d1 * (h / 3)
    low, high = np.minimum(inner0, inner1), np.maximum(inner0, inner1)
    doubt = DOUBT * np.abs(2 * (u0 - u1) + (d0 + d1) * h)
    return np.minimum(np.minimum(u0, u1), low) - doubt, np.maximum(np.maximum(u0, u1), high) + doubt


@record()
class Switcher:
    """Runs a loop with limits u_min, u_max (m,) on a grid of step h."""

    loop: Loop
    u_min: np.ndarray
    u_max: np.ndarray
    h: float
    modes: dict[bytes, Mode] = field(default_factory=dict)
    slack: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        finite = [np.where(np.isfinite(u), np.abs(u), 0.0) for u in (self.u_min, self.u_max)]
        object.__setattr__(self, "slack", SLACK * np.maximum(*finite))

    def mode_of(self, sign: np.ndarray) -> Mode:
        """The matrices of a mode, made once."""
        key = sign.tobytes()
        mode = self.modes.get(key)
        if mode is None:
            mode = self.modes[key] = _mode(self.loop, sign, self.u_min, self.u_max, self.h)
        return mode

    def mode_at(self, z: np.ndarray, r: np.ndarray, v: np.ndarray) -> Mode:
        """The mode the loop is in just after a state; on a limit the slope of u decides."""
        u = self.loop.F @ z + r
        sign = (u > self.u_max).astype(np.int8) - (u < self.u_min).astype(np.int8)
        slack = np.maximum(self.slack, LIMIT_ROUNDING * (np.abs(self.loop.F) @ np.abs(z)))  # u itself is no better known
        upper, lower = np.abs(u - self.u_max) <= slack, np.abs(u - self.u_min) <= slack
        if upper.any() or lower.any():
            mode = self.mode_of(sign)
            slope = mode.FM @ z + self.loop.F @ self.loop.forcing(mode.free, mode.held, r, v)
            sign = np.where(upper, slope > 0, np.where(lower, -(slope < 0).astype(np.int8), sign)).astype(np.int8)
        return self.mode_of(sign)

    def advance(self, z: np.ndarray, r: np.ndarray, v: np.ndarray, duration: float) -> np.ndarray:
        """The state after `duration` ≤ h with r and v held, through every switching on the way; ∞ where it cannot be followed."""
        left, guard = duration, 0
        while left > 1e-14 * self.h:
            guard += 1
            if guard > MAX_STEP_PIECES or not np.abs(z).max() < STATE_LIMIT or self.blurred(z):
                return np.full_like(z, np.inf)
            mode = self.mode_at(z, r, v)
            force = self.loop.forcing(mode.free, mode.held, r, v)
            z, used = self._stretch(mode, z, force, r, left)
            left -= used
        return z

    def blurred(self, z: np.ndarray) -> bool:
        """Whether a state is so large that rounding alone takes u from one limit to the other."""
        return bool(np.any(LIMIT_ROUNDING * (np.abs(self.loop.F) @ np.abs(z)) > self.u_max - self.u_min))

    def _stretch(self, mode: Mode, z: np.ndarray, force: np.ndarray, r: np.ndarray,
                 left: float) -> tuple[np.ndarray, float]:
        """Stay in one mode for the longest dyadic part of the step that holds no switching, or up to the switching."""
        F = self.loop.F
        pull = F @ force

        def end_of(level: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            Phi, Phi1 = mode.flow[level]
            then = Phi @ z + Phi1 @ force
            return then, F @ then + r, mode.FM @ then + pull

        u0, d0 = F @ z + r, mode.FM @ z + pull
        longest = mode.first
        while longest < len(mode.flow) and self.h / 2**longest > left * (1 + 1e-12):
            longest += 1
        for level in range(max(longest, min(mode.looks, len(mode.flow) - 1)), len(mode.flow)):
            then, u, d = end_of(level)
            part = self.h / 2**level
            if not self._stays(mode, u0, u, d0, d, part):
                continue
            while level > longest:  # on from there, each time twice as far
                later, u1, d1 = end_of(level - 1)
                if not self._stays(mode, u, u1, d, d1, part):
                    break
                then, u, d, level, part = later, u1, d1, level - 1, 2 * part
            return then, part
        part = min(mode.short, left)
        change = (mode.taylor @ (mode.M @ z + force)).reshape(TERMS, -1)
        coefficients = np.vstack([u0, change @ F.T])
        scale = part / mode.short
        leave = _first_exit(coefficients, mode.low - self.slack, mode.high + self.slack, scale)
        after = z + leave ** np.arange(1, TERMS + 1) @ change
        return after, left if leave * mode.short >= left * (1 - 1e-14) else leave * mode.short

    def _stays(self, mode: Mode, u0: np.ndarray, u1: np.ndarray, d0: np.ndarray, d1: np.ndarray, h: float) -> bool:
        least, greatest = bounds(u0, u1, d0, d1, h)
        return bool(np.all(least >= mode.low - self.slack) and np.all(greatest <= mode.high + self.slack))

    def run(self, z0: np.ndarray, r: np.ndarray, v: np.ndarray, jumps: np.ndarray | None,
            kicks: dict[int, list[tuple[float, np.ndarray]]], bound: float) -> np.ndarray:
        """All states on the grid: (steps + 1, N), fewer where they passed `bound`.

        r (steps, m), v (steps, p) held over each step; jumps (steps, N) at the end of each step or None;
        kicks: step → (time into it, jump). Stretches of grid steps in one mode are one affine scan.
        """
        steps = len(r)
        states = np.empty((steps + 1, len(z0)))
        states[0] = z0
        k, ahead = 0, 32
        stops = [*sorted(kicks), steps]
        while k < steps:
            if k == stops[0]:
                stops.pop(0)
            elif (good := self._scan(states, k, min(k + ahead, stops[0]), r, v, jumps, bound)) > k:
                ahead = min(2 * ahead, MAX_STEPS_AT_ONCE) if good == min(k + ahead, stops[0]) else 16
                k = good
                continue
            with np.errstate(over="ignore", invalid="ignore"):
                states[k + 1] = self.careful(states[k], r[k], v[k], kicks.get(k, []))
            if jumps is not None:
                states[k + 1] += jumps[k]
            k, ahead = k + 1, max(4, ahead // 2)
            if not np.max(np.abs(states[k])) < bound:
                return states[:k]
        return states

    def _scan(self, states: np.ndarray, k: int, end: int, r: np.ndarray, v: np.ndarray, jumps: np.ndarray | None,
              bound: float) -> int:
        """Fill states k+1 … as far as one mode carries and return the last index that is right."""
        mode = self.mode_at(states[k], r[k], v[k])
        if mode.first:
            return k
        force = self.loop.forcing(mode.free, mode.held, r[k:end], v[k:end])
        Phi, Phi1 = mode.flow[0]
        push = force @ Phi1.T
        if jumps is not None:
            push += jumps[k:end]
        path = affine_scan(Phi, push, states[k], end - k)
        with np.errstate(over="ignore", invalid="ignore"):
            before = path[1:] if jumps is None else path[1:] - jumps[k:end]
            good = self.keeps(mode, path[:-1], before, force, r[k:end])
            good &= np.abs(path[1:]).max(axis=1) < bound
        right = len(good) if good.all() else int(np.argmin(good))
        states[k + 1:k + 1 + right] = path[1:1 + right]
        return k + right

    def keeps(self, mode: Mode, now: np.ndarray, then: np.ndarray, force: np.ndarray, r: np.ndarray) -> np.ndarray:
        """Which of the steps from `now` to `then` (rows) stay in a mode: told from its part `looks` on, and at each doubling."""
        F = self.loop.F
        pull, kept, width = force @ F.T, np.ones(len(now), dtype=bool), self.h / 2**mode.looks
        u0, d0 = now @ F.T + r, now @ mode.FM.T + pull
        for level in range(mode.looks, -1, -1):
            Phi, Phi1 = mode.flow[level]
            at = now @ Phi.T + force @ Phi1.T if level else then
            u1, d1 = at @ F.T + r, at @ mode.FM.T + pull
            least, greatest = bounds(u0, u1, d0, d1, width)
            kept &= ((least >= mode.low - self.slack) & (greatest <= mode.high + self.slack)).all(axis=1)
            u0, d0, width = u1, d1, self.h / 2**level
        return kept

    def careful(self, z: np.ndarray, r: np.ndarray, v: np.ndarray, kicks: list[tuple[float, np.ndarray]]) -> np.ndarray:
        """One grid step through kicks (time into the step, jump) and switchings."""
        now = 0.0
        for moment, jump in kicks:
            z = self.advance(z, r, v, moment - now) + jump
            now = moment
        return self.advance(z, r, v, self.h - now)


def _first_exit(coefficients: np.ndarray, low: np.ndarray, high: np.ndarray, end: float) -> float:
    """The first s in (0, end] where a polynomial (column of coefficients, rising powers) leaves [low, high], or end."""
    first = end
    samples = CROSSING_SHARES * end
    values = POWERS @ (coefficients * end ** np.arange(TERMS + 1)[:, None])  # (9, m)
    for i, row in enumerate(values.T):
        for limit, side in ((high[i], 1.0), (low[i], -1.0)):
            if not np.isfinite(limit):
                continue
            over = side * (row - limit) > 0
            if over[1:].any():
                j = int(np.argmax(over[1:]))
                first = min(first, _root(coefficients[:, i].tolist(), float(limit), float(samples[j]), float(samples[j + 1])))
    return first


def _root(coefficients: list[float], limit: float, a: float, b: float) -> float:
    """Newton on a polynomial minus `limit`, kept inside the bracket (a, b] by bisection."""
    def value(s: float) -> tuple[float, float]:
        p = d = 0.0
        for c in reversed(coefficients):
            d = d * s + p
            p = p * s + c
        return p - limit, d

    inside = value(a)[0] if a else coefficients[0] - limit
    s = (a + b) / 2
    for _ in range(80):
        f, slope = value(s)
        if f == 0:
            break
        if f * inside > 0:
            a = s
        else:
            b = s
        trial = s - f / slope if slope else a
        new = trial if a < trial < b else (a + b) / 2
        if abs(new - s) <= 1e-15 * abs(b) + 1e-300:
            s = new
            break
        s = new
    return s
