"""Compute the spectral density of a series and the response of a linear system."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.linalg import matrix_balance
from scipy.sparse.csgraph import connected_components

from .arrays import frozen
from .balance import balance, weighed_scale
from .errors import EngineError, ShapeError
from .gates.argument_checks import COUNT, PERIOD, POSITIVE, SERIES, array, choice, matrix, optional, takes
from .plant import as_matrix
from .records import record

__all__ = ["Spectrum", "amplitude_response", "frequency_response", "modal_coordinates", "psd"]

CANCELLATION = 1e-6  # of the sum of the sizes of the residues' terms: less is not told by them
ABSENT, FEW_POINTS = 1e-12, 64
CACHED_STATES = 40  # states of a system whose modes are kept
WORST_EIGENVECTORS = 1e6  # condition beyond which modal residues lose too many digits
WINDOWS = ("hann", "hamming", "blackman", "blackmanharris", "bartlett", "boxcar", "flattop")


@record()
class Spectrum:
    """A one-sided power spectral density: frequency (n_f,) in Hz, density (n_f, …) in units²/Hz."""

    frequency: np.ndarray
    density: np.ndarray

    @property
    def decibel(self) -> np.ndarray:
        """10 log₁₀ of the density.

        >>> Spectrum(np.array([1.0, 2.0]), np.array([1.0, 100.0])).decibel
        array([ 0., 20.])
        """
        return 10 * np.log10(np.maximum(self.density, np.finfo(float).tiny))

    def variance(self) -> np.ndarray:
        """The area under the density: Σ S Δf, the variance of the series it came from."""
        return self.density.sum(axis=0) * (self.frequency[1] - self.frequency[0])


@takes(series=array(), fs=POSITIVE, segment=optional(COUNT), window=choice(*WINDOWS))
def psd(series: object, fs: float, *, segment: int | None = None, window: str = "hann") -> Spectrum:
    """Welch's one-sided density of a series (n_t,) or (n_t, channels) sampled at fs Hz.

    Calibrated so that the area is the variance; white noise of variance σ² lies at 2σ²/fs. Segments of `segment`
    samples (default: an eighth of the record, at least 256 where there are as many) overlap by half, each without
    its mean. Raises EngineError for series shorter than 8 samples or not finite.

    >>> noise = np.random.default_rng(0).standard_normal((100_000, 1))
    >>> float(np.round(psd(noise, 100.0, segment=1000).density.mean(), 2))  # 2σ²/fs
    0.02
    """
    data = np.asarray(series, dtype=float)
    if data.ndim not in (1, 2) or len(data) < 8:
        raise EngineError("A spectrum needs a series of at least 8 samples, time first.")
    length = min(len(data), max(256, len(data) // 8)) if segment is None else int(segment)
    if not 8 <= length <= len(data):
        raise EngineError("A segment must hold between 8 and {count} samples; it holds {length}.",
                          count=len(data), length=length)
    from scipy import signal  # late: it brings all of scipy.stats, 0.6 s

    frequency, density = signal.welch(data, fs, window=window, nperseg=length, detrend="constant",
                                      scaling="density", axis=0)
    return Spectrum(frequency, density)


@takes(A=matrix("n n"), B=matrix("n m"), C=matrix("p n"))
def modal_coordinates(A: np.ndarray, B: np.ndarray, C: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Poles λ (n,), C V (p, n) and V⁻¹ B (n, m) with A V = V diag(λ): H = Σ (C vᵢ)(wᵢ B)/(s − λᵢ).

    A is balanced first, so that units of the states do not matter. None where the eigenvectors are ill conditioned.
    """
    if not len(A):
        return np.empty(0, dtype=complex), np.empty((len(C), 0), dtype=complex), np.empty((0, B.shape[1]), dtype=complex)
    if len(A) > CACHED_STATES:
        return _in_modes(A, B, C)
    a, b, c = (np.ascontiguousarray(M, dtype=float).tobytes() for M in (A, B, C))
    return _kept(a, b, c, len(A))


def _in_modes(A: np.ndarray, B: np.ndarray, C: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    balanced, (scale, _) = matrix_balance(A, permute=False, separate=True)
    if connected_components(A != 0, directed=False)[0] > 1:  # A alone does not say how large parts beside each other are
        scale = balance(A, B, C).states
        balanced = A * scale / scale[:, None]
    poles, vectors = np.linalg.eig(balanced)
    if np.linalg.cond(vectors) > WORST_EIGENVECTORS:
        return None
    return frozen(poles.astype(complex)), frozen((C * scale) @ vectors), frozen(np.linalg.solve(vectors, B / scale[:, None]))


@lru_cache(maxsize=64)
def _kept(a: bytes, b: bytes, c: bytes, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Of a plant or a controller that stays while a hand changes the world about it."""
    A, B, C = (np.frombuffer(M) for M in (a, b, c))
    return _in_modes(A.reshape(n, n), B.reshape(n, -1), C.reshape(-1, n))


@takes(A=matrix("n n"), B=matrix("n m"), C=matrix("p n"), D=matrix("p m"), omega=SERIES, dt=PERIOD)
def frequency_response(A: object, B: object, C: object, D: object, omega: object, *, dt: float = 0.0) -> np.ndarray:
    """H = C (λ I − A)⁻¹ B + D at λ = jω, or at e^{jω dt} where dt > 0: complex (n_ω, p, m), ω in rad/s.

    By modal residues, H = Σ (C vᵢ)(wᵢ B)/(λ − λᵢ) + D; by solving at each frequency where the eigenvectors are ill
    conditioned. Exactly on a pole the response is not finite. Raises ShapeError where the matrices disagree.

    >>> np.round(np.abs(frequency_response([[-1]], [[1]], [[1]], [[0]], [1.0])), 4)
    array([[[0.7071]]])
    """
    a, b, c, d = (as_matrix(value, name) for value, name in ((A, "A"), (B, "B"), (C, "C"), (D, "D")))
    n = len(a)
    if a.shape != (n, n) or len(b) != n or c.shape[1] != n or d.shape != (len(c), b.shape[1]):
        raise ShapeError("A n×n, B n×m, C p×n and D p×m must fit together; they are {a_shape}, {b_shape}, "
                         "{c_shape}, {d_shape}.",
                         a_shape=a.shape, b_shape=b.shape, c_shape=c.shape, d_shape=d.shape)
    w = np.atleast_1d(np.asarray(omega, dtype=float))
    if n == 0:
        return np.tile(d.astype(complex), (len(w), 1, 1))
    points = np.exp(1j * w * dt) if dt else 1j * w
    return response_at(modal_coordinates(a, b, c), a, b, c, d, points)


def response_at(modal: tuple[np.ndarray, np.ndarray, np.ndarray] | None, a: np.ndarray, b: np.ndarray, c: np.ndarray,
                d: np.ndarray, points: np.ndarray) -> np.ndarray:
    """C (λ I − A)⁻¹ B + D at each of `points` λ (n_λ,): (n_λ, p, m), from the `modal_coordinates` of A, B, C.

    Where residues cancel, as in the roll-off of a chain of lags, too few digits would be left: there it is solved.
    """
    if modal is None:
        return solved_response(a, b, c, d, points)
    poles, out, into = modal
    residues = (out.T[:, :, None] * into[:, None, :]).reshape(len(poles), -1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        weights = 1 / (points[:, None] - poles)
        found = (weights @ residues).reshape(len(points), *d.shape) + d
        terms = (np.abs(weights) @ np.abs(residues)).reshape(len(points), *d.shape)
        told = np.where(terms > 0, np.abs(found) / terms, 1.0)
    # an entry of a whole sweep that never rises above rounding is a channel that is not there
    there = (told.max(axis=0, initial=0.0) > ABSENT) | (len(points) <= FEW_POINTS)
    lost = np.flatnonzero(((told < CANCELLATION) & there).any(axis=(1, 2)) & np.isfinite(terms).all(axis=(1, 2)))
    if lost.size:
        found[lost] = solved_response(a, b, c, d, points[lost])
    return found


def solved_response(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, points: np.ndarray) -> np.ndarray:
    """C (λ I − A)⁻¹ B + D at each of `points` λ (n_λ,), infinite where λ is a pole: (n_λ, p, m).

    In balanced states, where each state of a chain has its own size, the elimination keeps relative accuracy.
    """
    own = weighed_scale(a, b, c)
    a, b, c = a * own / own[:, None], b / own[:, None], c * own
    pencil = points[:, None, None] * np.eye(len(a)) - a
    try:
        return c @ np.linalg.solve(pencil, b[None].astype(complex)) + d  # a stack on both sides: NumPy 1 takes a matrix for vectors
    except np.linalg.LinAlgError:
        rows = [_solved_once(p, b, c, d) for p in pencil]
        return np.array(rows)


def _solved_once(pencil: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    try:
        return c @ np.linalg.solve(pencil, b.astype(complex)) + d
    except np.linalg.LinAlgError:
        return np.full(d.shape, np.inf + 0j)


@takes(A=matrix("n n"), B=matrix("n m"), C=matrix("p n"), D=matrix("p m"), omega=SERIES, dt=PERIOD)
def amplitude_response(A: object, B: object, C: object, D: object, omega: object, *, dt: float = 0.0) -> np.ndarray:
    """|H(jω)| entry by entry, (n_ω, p, m): see `frequency_response`."""
    return np.abs(frequency_response(A, B, C, D, omega, dt=dt))
