"""Step a sampled loop sample by sample, compiled where ready, else in NumPy."""

from __future__ import annotations

import numpy as np

from ..kernels import as_kernel_array, compiled_kernel
from ..kernels.sampled import sampled_steps
from .sampled_loop import SampledLoop

DIVERGENCE_LIMIT = 1e12


def held(loop: SampledLoop, w: np.ndarray, push: np.ndarray, v: np.ndarray) -> int:
    """Fill w[1 …] of a loop that clips or rounds; the last sample that is finite, −1 where no kernel is ready.

    The samples at which the controller still changes go the plain way.
    """
    quick, last, hardware = compiled_kernel(sampled_steps), len(w) - 1, loop.hardware
    if quick is None:
        return -1
    k = min(loop.varying, last)
    done = rounding(loop, w, push, v, 0, k)
    if done < k or k == last:
        return done
    unit = hardware.step or 1.0
    now, extra, step, direct = settled_steps(loop, w[k], push[k:last], v[k:last + 1], unit)
    path = np.empty((last - k, 1, now.shape[1]))
    quick(now, extra[:, None], step, direct, float(hardware.limit), hardware.step > 0, path, np.zeros(1), 0, 1)
    w[k:last], w[last] = path[:, 0, :loop.n], now[0, :loop.n]
    with np.errstate(invalid="ignore"):
        large = np.flatnonzero(~(np.abs(w[k + 1:]).max(axis=1) < DIVERGENCE_LIMIT))
    return k + int(large[0]) if len(large) else last


def settled_steps(loop: SampledLoop, w: np.ndarray, push: np.ndarray, v: np.ndarray,
                  unit: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """What `sampled_steps` takes of a settled loop at w (N,): now, what is added to each (w⁺, Y w⁺, U w⁺), step and direct."""
    N, p, noise = loop.n, len(loop.Y), v / unit
    now = np.concatenate([w, loop.Y @ w / unit + noise[0], loop.U[-1] @ w])[None]
    extra = np.empty((len(push), now.shape[1]))
    extra[:, :N] = push
    extra[:, N:N + p] = push @ (loop.Y.T / unit) + noise[1:]
    extra[:, N + p:] = push @ loop.U[-1].T
    return now, extra, padded(fused(loop, loop.varying, unit).T), as_kernel_array(loop.T[-1].T * unit)


def padded(step: np.ndarray) -> np.ndarray:
    """The step with columns to a multiple of eight."""
    wide = np.zeros((len(step), -(-step.shape[1] // 8) * 8))
    wide[:, :step.shape[1]] = step
    return wide


def rounding(loop: SampledLoop, w: np.ndarray, push: np.ndarray, v: np.ndarray, k: int, last: int) -> int:
    """Fill w[k + 1 … last] sample by sample, clipping and rounding; the last sample that is finite.

    One product a sample: (w, m, s) → (w⁺, Y w⁺, U w⁺). Readings are carried in steps of the converter.
    """
    if k >= last:
        return k
    N, p, m = loop.n, len(loop.Y), loop.U.shape[1]
    unit, limit = loop.hardware.step or 1.0, loop.hardware.limit
    rounds, clips, now, product = loop.hardware.step > 0, bool(np.isfinite(limit)), np.empty(N + p + m), np.empty(N + p + m)
    now[:N] = w[k]
    state, read, asked = now[:N], now[N:N + p], now[N + p:]
    noise, j = v[k:last + 1] / unit, -1
    i = min(k, loop.varying)
    read[:] = loop.Y @ state / unit + noise[0]
    asked[:] = loop.U[i] @ state
    direct, straight = loop.T[i] * unit, bool(np.any(loop.T))
    step, settled = fused(loop, k, unit), k >= loop.varying
    extra = np.empty((last - k, N + p + m))
    extra[:, :N] = push[k:last]
    extra[:, N:N + p] = extra[:, :N] @ (loop.Y.T / unit) + noise[1:]
    extra[:, N + p:] = extra[:, :N] @ loop.U[-1].T
    with np.errstate(over="ignore", invalid="ignore"):
        for j in range(last - k):
            if rounds:
                np.rint(read, out=read)
            if straight:
                asked += direct @ read
            if clips:
                np.minimum(asked, limit, out=asked)
                np.maximum(asked, -limit, out=asked)
            np.dot(step, now, out=product)
            np.add(product, extra[j], out=now)
            w[k + j + 1] = state
            if not settled:
                i = min(k + j + 1, loop.varying)
                asked[:] = loop.U[i] @ state
                direct, settled = loop.T[i] * unit, k + j + 1 >= loop.varying
                step = fused(loop, k + j + 1, unit)
            if j % 256 == 255 and not np.abs(state).max() < DIVERGENCE_LIMIT:
                break
        large = np.flatnonzero(~(np.abs(w[k + 1:k + j + 2]).max(axis=1) < DIVERGENCE_LIMIT))
    return k + int(large[0]) if len(large) else last


def stepping(loop: SampledLoop, w: np.ndarray, push: np.ndarray, direct: np.ndarray, read: np.ndarray, k: int,
              last: int) -> int:
    """Fill w[k + 1 … last] of the settled loop sample by sample, clipping only: one product (w, s) → (w⁺, u⁺) a sample.

    direct (n_t, m): T v; read (n_t, N): F_m v. Answers with the last sample that is finite.
    """
    N, m = loop.n, loop.U.shape[1]
    top = np.hstack([loop.F[-1] + loop.F_m[-1] @ loop.Y, loop.F_s[-1]])
    step = np.vstack([top, loop.feedback @ top])
    extra = np.empty((last - k, N + m))
    np.add(push[k:last], read[k:last], out=extra[:, :N])
    extra[:, N:] = extra[:, :N] @ loop.feedback.T + direct[k + 1:last + 1]
    high = np.full(m, loop.hardware.limit)
    low, now, product = -high, np.empty(N + m), np.empty(N + m)
    state, asked = now[:N], now[N:]
    state[:], asked[:] = w[k], loop.feedback @ w[k] + direct[k]
    with np.errstate(over="ignore", invalid="ignore"):
        for j in range(last - k):
            np.minimum(asked, high, out=asked)
            np.maximum(asked, low, out=asked)
            np.dot(step, now, out=product)
            np.add(product, extra[j], out=now)
            w[k + j + 1] = state
        large = np.flatnonzero(~(np.abs(w[k + 1:last + 1]).max(axis=1) < DIVERGENCE_LIMIT))
    return k + int(large[0]) if len(large) else last


def fused(loop: SampledLoop, k: int, unit: float) -> np.ndarray:
    """(w, m, s) → (w⁺, Y w⁺, U w⁺) at sample k, readings m in units of `unit`."""
    i, j = min(k, loop.varying), min(k + 1, loop.varying)
    top = np.hstack([loop.F[i], loop.F_m[i] * unit, loop.F_s[i]])
    return np.vstack([top, loop.Y @ top / unit, loop.U[j] @ top])
