"""Simulate many runs of a sampled loop: spectra with bands, signal sizes."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from ..kernels import compiled_kernel, run_in_threads
from ..kernels.sampled import sampled_steps
from ..systems.errors import EngineError
from ..systems.gates.argument_checks import SECONDS, SEED, count, instance, takes
from ..systems.records import record
from ..systems.recursions import affine_scan
from ..systems.spectrum import Spectrum
from .mechanics import thin_root
from .sampled_loop import SampledLoop
from .stepping import DIVERGENCE_LIMIT, fused, padded

__all__ = ["MonteCarlo", "simulate_trials", "welch_expectation"]

SAMPLES_PER_LOOK = 200  # samples between two looks at the caller
BATCH_RUNS = 50  # runs that go along in one product
MAX_BATCH_NUMBERS = 12_000_000  # recorded numbers of one batch


@record()
class MonteCarlo:
    """What `runs` runs of a loop gave; signals are the loop's outputs and after them its applied inputs.

    frequency (n_f,) in Hz; density (n_f, k): mean one-sided Welch density; spread (n_f, k): its standard deviation from
    run to run, so that the mean is known to spread/√runs. rms, peak (runs, k): of each run. clipped (runs,): share of
    samples with a command beyond the limit. diverged (runs,): runs that left every bound; they are not in the density.
    """

    runs: int
    frequency: np.ndarray
    density: np.ndarray
    spread: np.ndarray
    rms: np.ndarray
    peak: np.ndarray
    clipped: np.ndarray
    diverged: np.ndarray

    @property
    def spectrum(self) -> Spectrum:
        """The mean density."""
        return Spectrum(self.frequency, self.density)

    def band(self, *, times: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
        """Mean density ± `times` its standard error, (n_f, k) each; the lower edge is not negative."""
        error = times * self.spread / np.sqrt(max(self.runs - int(self.diverged.sum()), 1))
        return np.maximum(self.density - error, 0.0), self.density + error


@takes(loop=instance(SampledLoop), runs=count(1, 100_000), seconds=SECONDS, seed=SEED, segment=count(1, 10_000_000),
       together=count(1, 100_000))
def simulate_trials(loop: SampledLoop, runs: int, seconds: float, seed: int, *, segment: int | None = None,
                together: int = BATCH_RUNS) -> Iterator[tuple[float, MonteCarlo | None]]:
    """Run the loop `runs` times on fresh noise; yields (fraction, result so far), the result None until one batch is in.

    Every run starts from the loop's stationary covariance, so that no transient is in the spectra. `segment`: samples of
    a Welch segment (Hann, half overlap, mean removed), by default a power of two near half a run. A generator: it
    yields every few milliseconds and may be closed at any time. Raises EngineError for an unstable loop.
    """
    steps = round(seconds / loop.dt)
    length = 2 ** int(np.log2(max(steps // 2, 8))) if segment is None else int(segment)
    if not 8 <= length <= steps:
        raise EngineError("A Monte-Carlo needs at least one run, and a segment of 8 samples that is not longer "
                          "than a run.")
    signals = len(loop.outputs) + loop.U.shape[1]
    if steps * signals > MAX_BATCH_NUMBERS:
        raise EngineError("The run must have at least one sample and fit into memory; shorten it.")
    if min(together, runs) * steps * signals > MAX_BATCH_NUMBERS:
        together = max(1, MAX_BATCH_NUMBERS // (steps * signals))
    start, sums, done = thin_root(loop.covariance), _Sums(length // 2 + 1, signals), 0
    result = None
    for rng in np.random.default_rng(seed).spawn(-(-runs // together)):
        count = min(together, runs - done)
        record, clipped, gone = np.empty((count, signals, steps)), np.zeros(count), np.zeros(count, dtype=bool)
        for share in _batch(loop, start, rng, record, clipped, gone):
            yield (done + 0.8 * share * count) / runs, result
        for i in range(count):
            sums.add(*_one(record[i], loop.dt, length), clipped[i] / steps, gone[i])
            if i % 2:
                yield (done + 0.8 * count + 0.2 * (i + 1)) / runs, result
        done += count
        result = sums.result(loop.dt, length)
        yield done / runs, result


class _Sums:
    """Means and squares of the densities of the runs so far (Welford), and the sizes of each run."""

    def __init__(self, bins: int, signals: int) -> None:
        self.mean, self.squares = np.zeros((bins, signals)), np.zeros((bins, signals))
        self.kept, self.rms, self.peak, self.clipped, self.gone = 0, [], [], [], []

    def add(self, density: np.ndarray, rms: np.ndarray, peak: np.ndarray, clipped: float, gone: bool) -> None:
        self.rms.append(rms)
        self.peak.append(peak)
        self.clipped.append(clipped)
        self.gone.append(bool(gone))
        if not gone:
            self.kept += 1
            gap = density - self.mean
            self.mean += gap / self.kept
            self.squares += gap * (density - self.mean)

    def result(self, dt: float, length: int) -> MonteCarlo:
        spread = np.sqrt(self.squares / max(self.kept - 1, 1))
        return MonteCarlo(len(self.gone), np.arange(length // 2 + 1) / (length * dt), self.mean.copy(), spread,
                          np.array(self.rms), np.array(self.peak), np.array(self.clipped), np.array(self.gone))


def _batch(loop: SampledLoop, start: np.ndarray, rng: np.random.Generator, record: np.ndarray, clipped: np.ndarray,
           gone: np.ndarray) -> Iterator[float]:
    """All runs of a batch side by side, one product a sample; fills record (count, signals, steps) and the counts."""
    (count, _, steps), N, p, m = record.shape, loop.n, len(loop.Y), loop.U.shape[1]
    width, hardware = N + p + m, loop.hardware
    unit, limit = hardware.step or 1.0, float(hardware.limit)
    rounds, clips, straight = hardware.step > 0, bool(np.isfinite(limit)), bool(np.any(loop.T))
    now, path = np.empty((count, width)), np.empty((SAMPLES_PER_LOOK, count, width))
    now[:, :N] = rng.standard_normal((count, start.shape[1])) @ start.T
    now[:, N:N + p] = now[:, :N] @ loop.Y.T / unit + rng.standard_normal((count, p)) @ loop.sensor.T / unit
    now[:, N + p:] = now[:, :N] @ loop.U[0].T
    enter = _entries(loop, unit)
    ramp = np.zeros(N)
    ramp[loop.bias] = hardware.ramp * loop.dt
    drift = np.concatenate([ramp, loop.Y @ ramp / unit, loop.U[-1] @ ramp])
    step, direct = np.ascontiguousarray(fused(loop, 0, unit).T), np.ascontiguousarray(loop.T[0].T * unit)
    for k in range(0, steps, SAMPLES_PER_LOOK):
        size, quick = min(SAMPLES_PER_LOOK, steps - k), None
        push = (rng.standard_normal((size * count, enter.shape[0])) @ enter).reshape(size, count, width)
        if drift.any():
            push += drift
        if k >= loop.varying and (quick := compiled_kernel(sampled_steps)) is not None:
            work = partial(quick, now, push, padded(step), direct, limit, rounds, path[:size], clipped)
            run_in_threads(work, count, size)
        for j in range(size if quick is None else 0):
            read, asked = now[:, N:N + p], now[:, N + p:]
            if rounds:
                np.rint(read, out=read)
            if straight:
                asked += read @ direct
            if clips:
                clipped += (np.abs(asked) > limit).any(axis=1)
                np.minimum(asked, limit, out=asked)
                np.maximum(asked, -limit, out=asked)
            path[j] = now
            now = np.matmul(now, step)
            now += push[j]
            if k + j < loop.varying:
                i = k + j + 1
                now[:, N + p:] = now[:, :N] @ loop.U[i].T
                step, direct = np.ascontiguousarray(fused(loop, i, unit).T), np.ascontiguousarray(loop.T[i].T * unit)
        lost = ~(np.abs(now[:, :N]).max(axis=1, initial=0.0) < DIVERGENCE_LIMIT)  # readings are counted in steps of the converter
        if lost.any():
            gone |= lost
            now[lost] = 0.0
        seen = np.nan_to_num(path[:size], nan=0.0, posinf=0.0, neginf=0.0) if gone.any() else path[:size]
        record[:, :len(loop.outputs), k:k + size] = (seen[:, :, :N] @ loop.outputs.T).transpose(1, 2, 0)
        record[:, len(loop.outputs):, k:k + size] = seen[:, :, N + p:].transpose(1, 2, 0)
        yield (k + size) / steps


def _entries(loop: SampledLoop, unit: float) -> np.ndarray:
    """How one row of independent normals enters (w⁺, Y w⁺ + v, U w⁺): (r + p, width)."""
    r, p = loop.jump.shape[1], len(loop.Y)
    rows = np.zeros((r + p, loop.n + p + loop.U.shape[1]))
    rows[:r] = np.vstack([loop.jump, loop.Y @ loop.jump / unit, loop.U[-1] @ loop.jump]).T
    rows[r:, loop.n:loop.n + p] = loop.sensor.T / unit
    return rows


def _one(series: np.ndarray, dt: float, length: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Welch density (n_f, k), rms and peak of one run's signals (k, steps)."""
    window = np.hanning(length + 1)[:-1]
    total, count = 0.0, 0
    for begin in range(0, series.shape[1] - length + 1, length // 2):
        part = series[:, begin:begin + length]
        value = np.fft.rfft((part - part.mean(axis=1, keepdims=True)) * window, axis=1)
        total, count = total + value.real**2 + value.imag**2, count + 1
    density = np.asarray(total).T * (2 * dt / (count * float(np.sum(window**2))))
    density[0] /= 2
    if length % 2 == 0:
        density[-1] /= 2
    return density, np.sqrt(np.mean(series**2, axis=1)), np.max(np.abs(series), axis=1)


@takes(loop=instance(SampledLoop), length=count(2, 1_000_000))
def welch_expectation(loop: SampledLoop, length: int) -> Spectrum:
    """What Welch's method (Hann, `length` ≥ 2 samples) gives on average for the loop as long as it is linear: (n_f, k).

    The transform of window ⋆ window times R(τ) = C F_cᵀ… P Cᵀ, leakage and finite resolution included; only the removal
    of the mean, which touches the lowest two bins, is left out. Raises EngineError for an unstable loop.

    >>> from observer_lab.engine import compensator, sampled_loop
    >>> from observer_lab.engine.sampled import sampled_controller
    >>> loop = sampled_loop(P := Plant([[0]], [[1]], [[1]]), sampled_controller(compensator(P, [[1]], [[3]]), 0.1), [0])
    >>> float(welch_expectation(loop, 64).frequency[-1])
    5.0
    """
    window = np.hanning(length + 1)[:-1]
    overlap = np.fft.irfft(np.abs(np.fft.rfft(window, 2 * length)) ** 2, 2 * length)[:length]
    rows = np.vstack([loop.outputs, loop.feedback])
    noise, direct = loop.reading, np.vstack([np.zeros((len(loop.outputs), len(loop.Y))), loop.T[-1]])
    closed, P = loop.closed(), loop.covariance
    densities = []
    for row, through in zip(rows, direct, strict=True):
        first = closed @ P @ row + loop.noise_in @ noise @ through  # E[w(k+1) signal(k)]
        later = affine_scan(closed, None, first, length - 2) @ row
        R = np.concatenate([[row @ P @ row + through @ noise @ through], later]) * overlap
        spectrum = np.fft.rfft(np.concatenate([R, np.zeros(1), R[:0:-1]]))
        densities.append(np.real(spectrum)[::2])
    density = np.array(densities).T * (2 * loop.dt / float(np.sum(window**2)))
    density[0] /= 2
    if length % 2 == 0:
        density[-1] /= 2
    return Spectrum(np.arange(length // 2 + 1) / (length * loop.dt), density)
