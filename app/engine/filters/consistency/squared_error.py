"""Compare normalised squared errors (NEES) and innovations (NIS) with χ²."""

from __future__ import annotations

import numpy as np
from scipy.special import gammaincinv

from ...systems.arrays import as_checked
from ...systems.errors import EngineError, ShapeError, phrase
from ...systems.gates.argument_checks import LEVEL, POSITIVE, RECORD, array, count, matrix, number, optional, takes
from ...systems.records import record

__all__ = ["SquaredError", "chi2_band", "independent_errors", "nees", "nis"]

Band = tuple[float, float]


@record()
class SquaredError:
    """Normalised squared errors ε = eᵀ P⁻¹ e of a record against χ² with `dof` degrees of freedom.

    values (n_t,): of each sample, or the mean over the runs at each sample; NaN where a measurement is missing.
    band: what each value, mean_band: what `mean` lies in with probability `level` if the filter is consistent.
    independent: how many independent samples of χ²(dof) the mean counts as. inside: share of the values in `band`.
    """

    values: np.ndarray
    dof: int
    level: float
    band: Band
    mean: float
    mean_band: Band
    independent: float
    inside: float

    @property
    def verdict(self) -> str:
        """"consistent", "overconfident" (errors larger than P says) or "cautious" (smaller)."""
        low, high = self.mean_band
        return "overconfident" if self.mean > high else "cautious" if self.mean < low else "consistent"


@takes(dof=number(0, 1_000_000_000.0), count=number(0, 1_000_000_000_000.0), level=LEVEL)
def chi2_band(dof: int, *, count: float = 1, level: float = 0.95) -> Band:
    """Where the mean of `count` independent χ²(dof) values lies with probability `level`, equal tails outside.

    Raises EngineError for a level outside (0, 1), or fewer than one degree of freedom or value.

    >>> np.round(chi2_band(1, count=100), 3)
    array([0.742, 1.296])
    """
    if not 0 < level < 1:
        raise EngineError("The level must lie between 0 and 1, for example 0.95.")
    if not (dof >= 1 and count > 0):
        raise EngineError("A χ² band needs at least one degree of freedom and one value.")
    tail = (1 - level) / 2
    low, high = 2 * gammaincinv(dof * count / 2, [tail, 1 - tail]) / count  # χ²(ν) is twice a gamma variable of shape ν/2
    return float(low), float(high)


@takes(innovations=RECORD, S=array(), level=LEVEL)
def nis(innovations: object, S: object, *, level: float = 0.95) -> SquaredError:
    """Normalised innovations squared νᵀS⁻¹ν, χ²(p) and independent of each other for a consistent filter.

    innovations ν (n_t, p); their covariances S = C P Cᵀ + R (p×p or n_t×p×p), not R alone. Rows with NaN are left out.
    Raises ShapeError, EngineError where an S is not positive definite.

    >>> nis(np.random.default_rng(0).standard_normal((500, 2)), np.eye(2)).verdict
    'consistent'
    """
    nu = record_of(innovations, phrase("The innovations"))
    values = squared(nu, covariances_of(S, nu.shape, "S"), "S")
    seen = np.isfinite(values)
    return _judged(values, values[seen], nu.shape[-1], float(seen.sum()), 1, level)


@takes(x=array(), xhat=array(), P=array(), level=LEVEL, independent=optional(POSITIVE))
def nees(x: object, xhat: object, P: object, *, level: float = 0.95, independent: float | None = None) -> SquaredError:
    """Normalised estimation errors squared (x − x̂)ᵀP⁻¹(x − x̂), χ²(n) at every sample for a consistent filter.

    x, x̂ of one run (n_t, n) or of many (runs, n_t, n); covariances P, of the same shape with n more, or (n_t, n, n) or
    (n, n) for all. Values are means over the runs. Errors at neighbouring samples depend on each other, so a record counts
    as fewer samples than it has. `independent`: how many for each run, from `independent_errors`; by default n_t over the
    correlation time of ε, estimated from the record, which a short record does badly. Raises ShapeError, EngineError.

    >>> e = np.random.default_rng(0).standard_normal((40, 500, 2))
    >>> nees(e, np.zeros_like(e), np.eye(2)).verdict
    'consistent'
    """
    true, estimate = np.asarray(x, dtype=float), np.asarray(xhat, dtype=float)
    if true.shape != estimate.shape or true.ndim not in (2, 3) or not true.size:
        raise ShapeError("x and x̂ must both be (n_t, n) or (runs, n_t, n); they are {true_shape}, "
                         "{estimate_shape}.",
                         true_shape=true.shape, estimate_shape=estimate.shape)
    e = (true - estimate).reshape(-1, *true.shape[-2:])
    P = np.asarray(P, dtype=float)
    if P.ndim == 4 and true.ndim == 2:
        raise ShapeError("P is given for many runs but x for one; give both for as many.")
    each = squared(e, covariances_of(P, e.shape, "P"), "P")
    if not np.isfinite(each).all():
        raise EngineError("x or x̂ holds NaN or infinity; cut the record where it diverged.")
    count = each.size / _correlation_time(each) if independent is None else independent * len(each)
    return _judged(each.mean(axis=0), each, e.shape[-1], count, len(each), level)


@takes(Phi=matrix(), P=matrix(), steps=count(1, 1_000_000), T=matrix())
def independent_errors(Phi: object, P: object, steps: int, *, T: object | None = None) -> float:
    """How many independent samples the NEES of `steps` successive errors are worth, if the filter is right.

    With e[k+1] = Φ e[k] + white noise and stationary covariance P, Φ = (I − M C) A after the update, ε = eᵀP⁻¹e has
    cov(ε[k], ε[k+l]) = 2‖W⁻¹ T Φˡ P Tᵀ W⁻ᵀ‖²_F, W Wᵀ = T P Tᵀ; so the mean of N has variance 2n/N′ with
    N′ = N n / Σ_l (1 − |l|/N) ‖·‖²_F. Φ, P n×n; T k×n for the error of k combinations of states alone, by default all.
    Exact in mean and variance; that the mean is then χ²(n N′)/N′ is Satterthwaite's approximation. Raises ShapeError.
    """
    Phi, P = as_checked(Phi), as_checked(P)
    T = np.eye(len(P)) if T is None else as_checked(T)
    if Phi.shape != P.shape or Phi.shape[0] != Phi.shape[1] or T.shape[1] != len(P):
        raise ShapeError("Φ and P must be n×n and T k×n; they are {phi_shape}, {p_shape}, {t_shape}.",
                         phi_shape=Phi.shape, p_shape=P.shape, t_shape=T.shape)
    seen = T @ P @ T.T
    if not (np.diag(seen) > 0).all():
        raise EngineError("P must be positive definite: a variance is zero or negative.")
    spread = np.sqrt(np.diag(seen))
    try:
        root = np.linalg.cholesky(seen / np.outer(spread, spread)) * spread[:, None]
    except np.linalg.LinAlgError as problem:
        raise EngineError("P is not positive definite; leave out states that are known exactly.") from problem
    if not np.abs(np.linalg.eigvals(Phi)).max() < 1:
        raise EngineError("These errors do not settle: an eigenvalue of Φ lies on or outside the unit circle.")
    left = np.linalg.solve(root, T)[None]  # W⁻¹ T Φˡ for l = 0, 1, …, twice as many each time
    power = Phi
    while len(left) < steps:
        left, power = np.concatenate([left, left @ power]), power @ power
    right = np.linalg.solve(root, T @ P).T
    sizes = ((left[:steps] @ right) ** 2).sum(axis=(1, 2))
    weights = 2 * (1 - np.arange(steps) / steps)
    weights[0] = 1.0
    return float(steps * len(T) / (weights @ sizes))


def record_of(value: object, name: str) -> np.ndarray:
    array = np.asarray(value, dtype=float)
    if array.ndim == 1:
        array = array[:, None]
    if array.ndim != 2 or not array.size:
        raise ShapeError("{name} must be (n_t, p), time first; the shape is {array_shape}.",
                         name=name, array_shape=array.shape)
    if np.isinf(array).any():
        raise EngineError("{name} hold infinity; cut the record where it diverged.", name=name)
    return array


def covariances_of(value: object, shape: tuple[int, ...], name: str) -> np.ndarray:
    array, size = np.asarray(value, dtype=float), shape[-1]
    if array.ndim == 0 and size == 1:
        array = array.reshape(1, 1)
    if array.ndim < 2 or array.shape[-2:] != (size, size) or array.shape[:-2] not in ((), shape[:-1], shape[-2:-1]):
        raise ShapeError("{name} must be {size}×{size}, or one such matrix a sample; its shape is {array_shape}.",
                         name=name, size=size, array_shape=array.shape)
    return array


def squared(e: np.ndarray, P: np.ndarray, name: str) -> np.ndarray:
    """eᵀP⁻¹e over the leading axes, the states brought to unit variance first."""
    variance = np.diagonal(P, axis1=-2, axis2=-1)
    if not (variance > 0).all():
        raise EngineError("{name} must be positive definite: a variance is zero or negative.", name=name)
    spread = np.sqrt(variance)
    try:
        factor = np.linalg.cholesky(P / (spread[..., :, None] * spread[..., None, :]))
    except np.linalg.LinAlgError as problem:
        raise EngineError("{name} is not positive definite; leave out states that are known exactly.", name=name) from problem
    scaled = e / spread
    if factor.ndim == 2:
        half = np.linalg.solve(factor, scaled.reshape(-1, len(factor)).T).T.reshape(e.shape)
    else:
        half = np.linalg.solve(np.broadcast_to(factor, (*e.shape, e.shape[-1])), scaled[..., None])[..., 0]
    return (half**2).sum(axis=-1)


def _judged(values: np.ndarray, single: np.ndarray, dof: int, independent: float, runs: int,
            level: float) -> SquaredError:
    if not single.size:
        raise EngineError("Not one complete sample is left to judge the filter by.")
    band = chi2_band(dof, count=runs, level=level)
    shown = values[np.isfinite(values)]
    inside = float(((shown >= band[0]) & (shown <= band[1])).mean())
    return SquaredError(values, dof, level, band, float(single.mean()), chi2_band(dof, count=independent, level=level),
                        independent,
                        inside)


def _correlation_time(each: np.ndarray) -> float:
    """Samples per independent sample, 1 + 2 Σ ρ_l, of series (runs, n_t), summed until a window of five times itself.

    Sokal's automatic windowing; the mean that the theory gives would bias nothing, the record's own is used.
    """
    steps = each.shape[1]
    away = each - each.mean()
    power = np.abs(np.fft.rfft(away, 2 * steps, axis=1)) ** 2
    rho = np.fft.irfft(power.mean(axis=0), 2 * steps)[:steps]
    if rho[0] <= 0:
        return 1.0
    times = 2 * np.cumsum(rho / rho[0]) - 1
    window = np.nonzero(np.arange(steps) >= 5 * times)[0]
    return float(np.clip(times[window[0]] if window.size else times[-1], 1.0, steps))
