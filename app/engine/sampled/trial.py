"""Simulate one sampled run and measure recovery, overshoot, peak and input energy."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..systems.arrays import as_checked, frozen
from ..systems.errors import EngineError, ShapeError, phrase
from ..systems.gates.argument_checks import FINITE, SEED, array, count, instance, items, matrix, number, pair, takes
from ..systems.plant import as_matrix
from ..systems.records import record
from ..systems.recursions import affine_scan
from .sampled_loop import SampledLoop
from .stepping import DIVERGENCE_LIMIT, held, rounding, stepping

__all__ = ["ResponseMeasures", "Trial", "response_measures", "simulate_trial", "trial_draws"]

MOST_NUMBERS = 40_000_000  # state numbers in one run
FIRST_BLOCK_SAMPLES = 256  # samples of the first block
SHORT_BLOCK_SAMPLES = 160  # a block that ends sooner is followed by BURST samples one by one, which takes less time
KEPT_DRAWS = 4000  # samples of a run whose draws are kept for the next with its seed
BURST = 128  # twice as many each time, until a block of four times SHORT_BLOCK_SAMPLES is met


@record()
class Trial:
    """A run at the samples, time first and ended early where it diverged.

    t (n_t,), x (n_t, n) of the plant, w (n_t, N) of the whole loop, outputs (n_t, q) as the loop records them, read
    (n_t, p) what the controller was shown, asked and applied (n_t, m) its commands before and after clipping.
    """

    loop: SampledLoop
    t: np.ndarray
    w: np.ndarray
    outputs: np.ndarray
    read: np.ndarray
    asked: np.ndarray
    applied: np.ndarray
    diverged: bool

    @property
    def x(self) -> np.ndarray:
        """The plant's states."""
        return self.w[:, self.loop.x]


@record(eq=True)
class ResponseMeasures:
    """A response to a step or an impulse: recovery s (None: not within the run), overshoot, peak and energy of u.

    recovery: from when on |y − final| stays within `band`; overshoot: how far y passes `final` to the other side, in
    units of its largest deviation on the first side; peak: largest |u| of all inputs (N); energy: Σ ∫ u² dt (N² s).
    """

    recovery: float | None
    overshoot: float
    largest: float
    peak: float
    energy: float


@takes(loop=instance(SampledLoop), steps=count(1, 10_000_000), seed=SEED, start=matrix(), disturbance=matrix(),
       kicks=items(pair(count(0), matrix())))
def simulate_trial(loop: SampledLoop, steps: int, *, seed: int | None = None, start: object | None = None,
                   disturbance: object | None = None, kicks: tuple[tuple[int, object], ...] = ()) -> Trial:
    """`steps` samples from the state `start` (N,), by default rest, with the noise of a seed (None: none).

    disturbance (n_t, d): the known disturbances, held over each sample. kicks: (sample, jump of the plant's state (n,)).
    Linear stretches run in parallel blocks and are exact; a loop that clips or rounds goes sample by sample where it
    must. Loops with the same plant feel the same noise from the same seed. Raises ShapeError, EngineError.

    >>> from observer_lab.engine.sampled import sampled_controller
    >>> loop = sampled_loop(P := Plant([[0]], [[1]], [[1]]), sampled_controller(compensator(P, [[1]], [[3]]), 0.1), [0])
    >>> bool(abs(simulate_trial(loop, 200, start=np.eye(loop.n)[0]).x[-1, 0]) < 1e-6)
    True
    """
    kicks = tuple((k, _jump(loop, jump)) for k, jump in kicks)
    if steps * loop.n > MOST_NUMBERS:
        raise EngineError("The run must have at least one sample and fit into memory; shorten it.")
    push, v = _forcing(loop, steps, seed, disturbance, kicks)
    w0 = np.zeros(loop.n) if start is None else as_checked(start).ravel().copy()
    if w0.size != loop.n:
        raise ShapeError("The start must have {n} entries; it has {w0_size}.", n=loop.n, w0_size=w0.size)
    for k, jump in kicks:
        if k == 0:
            w0[loop.x] += jump
    w = np.empty((steps, loop.n))
    w[0] = w0
    done = held(loop, w, push, v) if loop.hardware.step > 0 or np.isfinite(loop.hardware.limit) else -1
    if done < 0:
        done = rounding(loop, w, push, v, 0, steps - 1) if loop.hardware.step > 0 else _clipping(loop, w, push, v)
    w = w[:done + 1]
    read, asked, applied = _seen(loop, w, v[:len(w)])
    return Trial(loop, loop.dt * np.arange(len(w)), w, w @ loop.outputs.T, read, asked, applied, len(w) < steps)


def _jump(loop: SampledLoop, jump: object) -> np.ndarray:
    """The jump (n,) of a kick."""
    jump, n = as_matrix(jump, phrase("The jump of a kick")).ravel(), loop.x.stop - loop.x.start
    if jump.size != n:
        raise ShapeError("The jump of a kick must have {n} entries; it has {jump_size}.", n=n, jump_size=jump.size)
    return jump


def _forcing(loop: SampledLoop, steps: int, seed: int | None, disturbance: object | None,
             kicks: tuple[tuple[int, np.ndarray], ...]) -> tuple[np.ndarray, np.ndarray]:
    """What jumps onto w at the end of each sample (n_t, N), and the noise of each reading (n_t, p)."""
    push, v = np.zeros((steps, loop.n)), np.zeros((steps, len(loop.Y)))
    if seed is not None:
        from_ground, from_sensors, from_bias = trial_draws(loop, steps, seed)
        ways = from_ground.shape[1]
        push = from_ground @ loop.jump[:, :ways].T
        if from_bias.shape[1]:
            push += from_bias @ loop.jump[:, ways:].T
        v = from_sensors @ loop.sensor.T
    if loop.hardware.ramp:
        push[:, loop.bias] += loop.hardware.ramp * loop.dt
    if disturbance is not None:
        given = as_matrix(disturbance, phrase("The disturbance"))
        if given.shape != (steps, loop.Gamma.shape[1]):
            raise ShapeError("The disturbance must be {steps}×{columns}; its shape is {given_shape}.",
                             steps=steps, columns=loop.Gamma.shape[1], given_shape=given.shape)
        push += given @ loop.Gamma.T
    for k, jump in kicks:
        if not 0 <= k < steps:
            raise EngineError("A kick must come at a sample of the run.")
        if k > 0:
            push[k - 1, loop.x] += jump
    return push, v


@takes(loop=instance(SampledLoop), steps=count(1, 10_000_000), seed=SEED)
def trial_draws(loop: SampledLoop, steps: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The normal numbers of `simulate_trial`: (steps, ways) that `jump` brings in from the ground, (steps, p) of the sensors, and
    (steps, p) of biases that walk, else (steps, 0).

    Each column has a generator of its own: a longer run begins as a shorter one, and where rounding gives `jump` one way more on
    another machine the others stay what they are.

    >>> from observer_lab.engine import compensator, sampled_loop
    >>> from observer_lab.engine.sampled import sampled_controller
    >>> loop = sampled_loop(P := Plant([[0]], [[1]], [[1]]), sampled_controller(compensator(P, [[1]], [[3]]), 0.1), [0], V=[[1]])
    >>> [draws.shape for draws in trial_draws(loop, 5, 0)]
    [(5, 0), (5, 1), (5, 0)]
    """
    p = len(loop.Y)
    walks = p if loop.hardware.walk > 0 else 0
    ground, sensors, bias = (_kept_draws if steps <= KEPT_DRAWS else _draws)(seed, steps, loop.jump.shape[1] - walks, p, walks)
    return ground, sensors, bias


def _draws(seed: int, steps: int, *columns: int) -> tuple[np.ndarray, ...]:
    return tuple(frozen(np.array([way.standard_normal(steps) for way in rng.spawn(wide)]).reshape(wide, steps).T)
                 for rng, wide in zip(np.random.default_rng(seed).spawn(3), columns, strict=True))


_kept_draws = lru_cache(maxsize=4)(_draws)  # of the seed that a hand leaves alone while it moves what they drive


def _seen(loop: SampledLoop, w: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What the controller read, asked for and got, from the states."""
    read = w @ loop.Y.T + v
    if loop.hardware.step > 0:
        read = loop.hardware.step * np.rint(read / loop.hardware.step)
    asked = w @ loop.U[-1].T + read @ loop.T[-1].T
    for k in range(min(loop.varying, len(w))):
        asked[k] = loop.U[k] @ w[k] + loop.T[k] @ read[k]
    limit = loop.hardware.limit
    return read, asked, asked if np.isinf(limit) else np.clip(asked, -limit, limit)


def _clipping(loop: SampledLoop, w: np.ndarray, push: np.ndarray, v: np.ndarray) -> int:
    """Fill w in blocks: as long as the same commands are clipped to the same side, the loop is affine.

    A block goes on to the first sample at which that changes; where it changes all the time, sample by sample.
    """
    last, limit = len(w) - 1, loop.hardware.limit
    k = min(loop.varying, last)
    done = rounding(loop, w, push, v, 0, k)
    if done < k:
        return done
    if np.isinf(limit):
        path = affine_scan(loop.closed(), push[k:last] + v[k:last] @ loop.noise_in.T, w[k], last - k)
        with np.errstate(invalid="ignore"):
            if max(path.max(), -path.min()) < DIVERGENCE_LIMIT:
                w[k:] = path
                return last
            good = int(np.argmin(np.abs(path).max(axis=1) < DIVERGENCE_LIMIT))
        w[k:k + good] = path[:good]
        return k + good - 1
    direct, read, modes, ahead, burst = v @ loop.T[-1].T, v @ loop.F_m[-1].T, {}, FIRST_BLOCK_SAMPLES, BURST
    while k < last:
        asked = loop.feedback @ w[k] + direct[k]
        side = (asked > limit).astype(int) - (asked < -limit)
        key = tuple(side)
        if key not in modes:
            modes[key] = _affine(loop, side)
        step, enter, shift = modes[key]
        stop = min(k + ahead, last)
        path = affine_scan(step, push[k:stop] + v[k:stop] @ enter.T + shift, w[k], stop - k)
        with np.errstate(over="ignore", invalid="ignore"):  # a diverging block may leave the floats before it is cut
            asked = path @ loop.feedback.T + direct[k:stop + 1]
        other = ((asked > limit).astype(int) - (asked < -limit) != side).any(axis=1)
        good = int(np.argmax(other)) + 1 if other.any() else len(path)
        with np.errstate(invalid="ignore"):
            large = np.flatnonzero(~(np.abs(path[:good]).max(axis=1) < DIVERGENCE_LIMIT))
        if len(large):
            w[k:k + large[0]] = path[:large[0]]
            return k + int(large[0]) - 1
        w[k:k + good] = path[:good]
        k += good - 1
        ahead = 2 * ahead if good == len(path) else max(SHORT_BLOCK_SAMPLES, 2 * good)
        if good > 4 * SHORT_BLOCK_SAMPLES:
            burst = BURST
        elif good <= SHORT_BLOCK_SAMPLES and k < last:
            stop, burst = min(k + burst, last), 2 * burst
            done = stepping(loop, w, push, direct, read, k, stop)
            if done < stop:
                return done
            k = stop
    return last


def _affine(loop: SampledLoop, side: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Step, entry of v and shift of the settled loop while the commands with side ±1 stand at that limit."""
    free = side == 0
    carried = loop.F_s[-1][:, free]
    step = loop.F[-1] + loop.F_m[-1] @ loop.Y + carried @ loop.feedback[free]
    shift = loop.F_s[-1][:, ~free] @ (loop.hardware.limit * side[~free]) if not free.all() else np.zeros(loop.n)
    return step, loop.F_m[-1] + carried @ loop.T[-1][free], shift


@takes(t=array(), y=array(), u=array(), band=number(0), final=FINITE)
def response_measures(t: np.ndarray, y: np.ndarray, u: np.ndarray, band: float, *,
                      final: float = 0.0) -> ResponseMeasures:
    """Recovery, overshoot, peak and energy of one response y (n_t,) with inputs u (n_t, m), each held up to the next t.

    The first side is the side of the first excursion beyond `band`, or of the largest deviation if there is none. Raises
    ShapeError.
    """
    t, y, u = (np.asarray(value, dtype=float) for value in (t, y, u))
    if y.ndim != 1 or not y.size or t.shape != y.shape or u.ndim != 2 or len(u) != len(y) \
            or not all(np.isfinite(value).all() for value in (t, y, u)):
        raise ShapeError("A response needs finite t and y (n_t,) and u (n_t, m), at least one sample; they are "
                         "{t_shape}, {y_shape} and {u_shape}.", t_shape=t.shape, y_shape=y.shape, u_shape=u.shape)
    gap = y - final
    outside = np.flatnonzero(~(np.abs(gap) <= band))
    side = float(np.sign(gap[outside[0]])) if len(outside) else float(np.sign(gap[np.argmax(np.abs(gap))]))
    first, other = float(np.max(side * gap, initial=0.0)), float(np.max(-side * gap, initial=0.0))
    late = outside[-1] if len(outside) else -1
    recovery = None if late >= len(gap) - 1 else float(t[late + 1] - t[0])
    power = np.sum(u**2, axis=1)
    return ResponseMeasures(recovery, other / first if first > 0 else 0.0, float(np.max(np.abs(gap), initial=0.0)),
                            float(np.max(np.abs(u), initial=0.0)), float(np.sum(power[:-1] * np.diff(t))))
