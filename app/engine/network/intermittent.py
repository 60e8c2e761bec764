"""Compute the covariance with lost measurements, bounds of its mean, and the critical loss.

x[k+1] = A x + w, y = C x + v with covariances Q, R; a measurement is lost with probability `loss`, independently of
everything else. Source: Sinopoli, Schenato, Franceschetti, Poolla, Jordan, Sastry, "Kalman filtering with intermittent
observations", IEEE TAC 49 (2004); for the critical loss also Mo, Sinopoli, "Kalman filtering with intermittent
observations: tail distribution and critical value", IEEE TAC 57 (2012). Covariances P are those of x[k] − x̂[k|k−1], before
the measurement of sample k.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import schur

from ..systems.arrays import as_checked, symmetric
from ..systems.errors import EngineError, RiccatiError
from ..systems.gates.argument_checks import SHARE, array, count, covariance, gated, matrix, takes
from ..systems.lyapunov import settled_covariance
from ..systems.noise import root
from ..systems.records import record

__all__ = ["CriticalLoss", "corrected_covariance", "critical_loss", "intermittent_covariances", "intermittent_steps", "lossy_growth",
           "mare", "mean_bounds", "mean_lower_limit", "riccati_path", "riccati_step", "spectral_radius"]

RANK_RTOL = 1e-9  # relative singular value below which a sensor counts as blind
STEADY_RTOL = 1e-13
MAX_STEPS = 20_000
HOPELESS = 1e100  # times Q


@record(eq=True)
class CriticalLoss:
    """What share of the measurements may be lost.

    Below `safe` the upper bound of the mean covariance has a limit, above `lost` the lower bound has none. `critical` is the
    share itself, None where it is not known; 1 means that nothing unstable has to be watched.
    """

    safe: float
    lost: float
    critical: float | None

    @property
    def exact(self) -> bool:
        """Whether the two bounds agree."""
        return self.lost - self.safe <= 1e-12

    @gated(loss=SHARE)
    def bounded(self, loss: float) -> bool | None:
        """Whether the mean covariance stays bounded at this loss, None where neither the bounds nor theory decides."""
        edge = self.safe if self.critical is None else self.critical
        return True if loss < edge or edge >= 1 else None if self.critical is None and loss <= self.lost else False


# --- along a record --------------------------------------------------------------------------------------------------
@takes(A=matrix("n n"), C=matrix("p n"), Q=covariance("n"), R=covariance("p"), P0=covariance("n"), heard=array())
def intermittent_steps(A: object, C: object, Q: object, R: object, P0: object, heard: object) -> Iterator[np.ndarray]:
    """P[k|k−1] for k = 0 … N, each (…, n, n), of records `heard` (…, N; bool) that share one start P0 (n×n).

    Raises ShapeError, EngineError for matrices that do not fit or are no covariances.
    """
    A, C, Q, R = map(as_checked, (A, C, Q, R))
    heard = np.asarray(heard, dtype=float)
    if not heard.ndim or not np.all((heard >= 0) & (heard <= 1)):
        raise EngineError("A record of packets holds 1 for each that arrived and 0 for each that was lost.")
    P = np.broadcast_to(as_checked(P0), (*heard.shape[:-1], *A.shape))
    yield P
    for k in range(heard.shape[-1]):
        P = riccati_step(P, A, C, Q, R, heard[..., k])
        yield P


@takes(A=matrix("n n"), C=matrix("p n"), Q=covariance("n"), R=covariance("p"), P0=covariance("n"), heard=array())
def intermittent_covariances(A: object, C: object, Q: object, R: object, P0: object, heard: object) -> np.ndarray:
    """P[k|k−1] of each record, (…, N + 1, n, n); see `intermittent_steps`.

    >>> intermittent_covariances([[1]], [[1]], [[1]], [[1]], [[1]], [0, 1]).ravel()
    array([1.        , 2.        , 1.66666667])
    """
    return np.stack(list(intermittent_steps(A, C, Q, R, P0, heard)), axis=-3)


# --- the mean --------------------------------------------------------------------------------------------------------
@takes(A=matrix("n n"), C=matrix("p n"), Q=covariance("n"), R=covariance("p"), P0=covariance("n"), loss=array(), steps=count(0, 100_000))
def mean_bounds(A: object, C: object, Q: object, R: object, P0: object, loss: object,
                steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bound of the mean E P[k|k−1], k = 0 … steps, each (…, steps + 1, n, n), for losses `loss` (…).

    S ≤ E P ≤ V: S⁺ = loss A S Aᵀ + Q, as if a measurement told everything, and V⁺ = g_{1 − loss}(V), since the Riccati
    step is increasing and concave in P.
    """
    A, C, Q, R = map(as_checked, (A, C, Q, R))
    p = np.asarray(loss, dtype=float)
    if not np.all((p >= 0) & (p <= 1)):
        raise EngineError("A loss is a probability: choose it within 0 … 1.")
    start = np.broadcast_to(as_checked(P0), (*p.shape, *A.shape))
    lower = np.empty((*p.shape, steps + 1, *A.shape))
    lower[..., 0, :, :] = S = start
    for k in range(steps):
        lower[..., k + 1, :, :] = S = p[..., None, None] * (A @ S @ A.T) + Q
    upper = riccati_path(start, A, C, Q, R, np.broadcast_to(1 - p, (steps, *p.shape)))
    return lower, np.moveaxis(upper, 0, -3)


@takes(A=matrix("n n"), Q=covariance("n"), loss=SHARE)
def mean_lower_limit(A: object, Q: object, loss: float) -> np.ndarray:
    """S = loss A S Aᵀ + Q, n×n: below the mean covariance after many steps. Raises RiccatiError where there is none."""
    A = as_checked(A)
    p = float(loss)
    if p * spectral_radius(A) ** 2 >= 1:
        raise RiccatiError("More packets are lost than the critical share, so the mean covariance has no limit; "
                           "lose fewer packets.")
    return symmetric(settled_covariance(np.sqrt(p) * A, root(as_checked(Q)), dt=1.0))


@takes(A=matrix("n n"), C=matrix("p n"), Q=covariance("n"), R=covariance("p"), loss=SHARE)
def mare(A: object, C: object, Q: object, R: object, loss: float) -> np.ndarray:
    """X = g(X) = A X Aᵀ + Q − (1 − loss) A X Cᵀ(C X Cᵀ + R)⁻¹ C X Aᵀ, n×n: above the mean covariance after many steps.

    Steps of g from Q = g(0) until their gain L stabilises the linear map X ↦ loss A X Aᵀ + (1 − loss)(A − LC) X (A − LC)ᵀ
    + …, then Newton's method on it. Raises RiccatiError where there is no solution.
    """
    A, C, Q, R = map(as_checked, (A, C, Q, R))
    p = float(loss)
    if p > critical_loss(A, C).lost:
        raise _no_limit()
    X, look = Q, 16  # g(0)
    for k in range(MAX_STEPS):
        new = riccati_step(X, A, C, Q, R, 1 - p)
        done = np.abs(new - X).max() <= STEADY_RTOL * np.abs(new).max()
        X = new
        if done:
            return X
        if np.abs(X).max() > HOPELESS * np.abs(Q).max():
            break
        if k == look:
            look *= 2
            found = _newton(X, A, C, Q, R, p)
            if found is not None:
                return found
    raise _no_limit()


def _no_limit() -> RiccatiError:
    return RiccatiError("So many packets are lost that the modified Riccati equation has no solution; lose fewer packets.")


def _newton(X: np.ndarray, A: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray, p: float) -> np.ndarray | None:
    """The solution from the gain of X on, or None where that gain does not stabilise."""
    n, known = len(A), p * np.kron(A, A)
    for _ in range(30):
        AM = A @ corrected_covariance(X, C, R)[1]
        F = A - AM @ C
        T = known + (1 - p) * np.kron(F, F)
        if spectral_radius(T) >= 1 - 1e-12:
            return None
        new = np.linalg.solve(np.eye(n * n) - T, (Q + (1 - p) * AM @ R @ AM.T).ravel()).reshape(n, n)
        done = np.abs(new - X).max() <= STEADY_RTOL * np.abs(new).max()
        X = symmetric(new)
        if done:
            break
    return X


# --- how much may be lost ----------------------------------------------------------------------------------------------
@takes(A=matrix("n n"), C=matrix("p n"))
def critical_loss(A: object, C: object) -> CriticalLoss:
    """The critical loss of (A, C), or bounds of it.

    lost = 1/max|λ|² always. It is exact (safe = lost) where a single mode is unstable, or where C sees all unstable
    modes at once (as a square regular C does). With sensors of rank one safe = 1/∏|λᵤ|² over the unstable modes; else
    it is found by bisection on `lossy_growth`. critical = lost also where (A, C) is not degenerate (Mo and Sinopoli): the
    unstable modes of each modulus are seen apart in one reading, as where no two moduli agree. Raises EngineError where an
    unstable mode is hidden.

    >>> round(critical_loss([[1.25]], [[1]]).critical, 4)  # 1/a²
    0.64
    """
    A, C = as_checked(A), as_checked(C)
    Au, Cu = _unstable(A, C)
    n = len(Au)
    if n == 0:
        return CriticalLoss(1.0, 1.0, 1.0)
    seen = [Cu]
    for _ in range(n - 1):
        seen.append(seen[-1] @ Au)
    if _rank(np.vstack(seen)) < n:
        raise EngineError("An unstable mode is hidden from the sensors, so no share of packets is enough; move a "
                          "sensor.")
    moduli = np.abs(np.linalg.eigvals(Au))
    lost, rank = float(1 / moduli.max() ** 2), _rank(Cu)
    if n == 1 or rank == n:
        return CriticalLoss(lost, lost, lost)
    critical = None if _degenerate(Au, Cu) else lost
    if rank == 1:
        return CriticalLoss(float(1 / np.prod(moduli) ** 2), lost, critical)
    low, high = float(1 / np.prod(moduli) ** 2), lost
    while high - low > 1e-6:
        middle = (low + high) / 2
        low, high = (middle, high) if lossy_growth(Au, Cu, middle) < 1 else (low, middle)
    return CriticalLoss(low, lost, critical)


def _degenerate(A: np.ndarray, C: np.ndarray) -> bool:
    """Whether modes of one modulus (to 1e-6) look alike in a single reading, or A lacks eigenvectors to tell."""
    poles, shapes = np.linalg.eig(A)
    if _rank(shapes) < len(A):
        return True
    alike = np.abs(np.abs(poles)[:, None] - np.abs(poles)) <= 1e-6 * np.abs(poles)
    return any(_rank(C @ shapes[:, group]) < group.sum() for group in alike)


@takes(A=matrix("n n"), C=matrix("p n"), loss=SHARE, steps=count(1, 100_000))
def lossy_growth(A: object, C: object, loss: float, *, steps: int = 4000) -> float:
    """Growth a step of X ↦ A X Aᵀ − (1 − loss) A X Cᵀ(C X Cᵀ)⁺ C X Aᵀ, what noise no longer matters to.

    The modified Riccati equation has a solution where this is below 1: a test by power iteration, without inequalities
    of matrices. A should hold unstable modes only.
    """
    A, C = as_checked(A), as_checked(C)
    if not C.any():
        return spectral_radius(A) ** 2
    p, X, growth = float(loss), np.eye(len(A)), 0.0
    R = np.eye(len(C))
    for _ in range(steps):
        scale = 1e-13 * float(np.trace(C @ X @ C.T))
        new = riccati_step(X, A, C, np.zeros_like(X), scale * R, 1 - p)
        last, growth = growth, float(np.trace(new))
        X = new / growth
        if abs(growth - last) <= 1e-12 * growth:
            break
    return growth


@takes(matrix=matrix("n n"))
def spectral_radius(matrix: np.ndarray) -> float:
    """max|λ|."""
    return float(np.abs(np.linalg.eigvals(matrix)).max(initial=0.0))


def _unstable(A: np.ndarray, C: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The restriction of (A, C) to the modes outside the unit circle."""
    T, Z, count = schur(A, sort=lambda re, im: np.hypot(re, im) > 1 + 1e-9)  # type: ignore[misc]
    return T[:count, :count], C @ Z[:, :count]


def _rank(matrix: np.ndarray) -> int:
    values = np.linalg.svd(matrix, compute_uv=False)
    return int(np.sum(values > RANK_RTOL * values[0])) if values.size and values[0] > 0 else 0


@takes(P=array("… n n"), C=matrix("p n"), R=matrix("p p"))
def corrected_covariance(P: np.ndarray, C: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Covariances after a measurement in Joseph's form (…, n, n), and the filter gains M = P Cᵀ(C P Cᵀ + R)⁻¹ (…, n, p)."""
    CP = C @ P
    S = CP @ C.T + R
    try:
        if len(C) == 1 and not S.all():
            raise np.linalg.LinAlgError
        M = np.swapaxes(CP / S if len(C) == 1 else np.linalg.solve(S, CP), -1, -2)
    except np.linalg.LinAlgError:
        raise EngineError("The covariance S of the innovation is singular: give every sensor some noise R.") from None
    keep = np.eye(P.shape[-1]) - M @ C
    return keep @ P @ np.swapaxes(keep, -1, -2) + M @ R @ np.swapaxes(M, -1, -2), M


@takes(P=array("… n n"), A=matrix("n n"), C=matrix("p n"), Q=matrix("n n"), R=matrix("p p"), heard=array())
def riccati_step(P: np.ndarray, A: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray, heard: object) -> np.ndarray:
    """P⁺ = A ((1 − h) P + h P|y) Aᵀ + Q for covariances P (…, n, n), P|y being that after the measurement.

    `heard` h (…): 1 where the measurement arrived, 0 where it was lost. In between it is the modified Riccati operator
    g_h(P) of Sinopoli et al., which bounds the mean from above.
    """
    h = np.asarray(heard, dtype=float)[..., None, None]
    mixed = P + h * (corrected_covariance(P, C, R)[0] - P)
    moved = A @ mixed @ A.T
    return symmetric(moved) + Q


def riccati_path(P: np.ndarray, A: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray, heard: np.ndarray) -> np.ndarray:
    """P (…, n, n) and what `riccati_step` makes of it, one step for each of `heard` (N, …): (N + 1, …, n, n)."""
    path = np.empty((len(heard) + 1, *np.shape(P)))
    path[0] = P
    for k, share in enumerate(heard):
        path[k + 1] = P = riccati_step(P, A, C, Q, R, share)
    return path
