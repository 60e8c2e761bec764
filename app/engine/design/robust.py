"""Place poles with several inputs such that the eigenvectors are well conditioned.

Every eigenvector of A − BK lies in a space S_λ of r = rank(B) dimensions. Two sweeps of Kautsky, Nichols and Van Dooren
(1985), method 0, give a start; then ‖X⁻¹‖_F is minimised over unit eigenvectors, which bounds the condition number
more closely than the determinant of X does. Most steps are an accelerated gradient of fixed length: no decisions, so
the gain is a smooth function of the poles (except where two minima change places). A few conjugate gradients finish.
All in real arithmetic: the pair x, x̄ stands in X as √2 Re x, √2 Im x, which changes X by a unitary factor only.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import get_lapack_funcs

from ..systems.pole_sets import Poles
from ..systems.records import record
from .eigenstructure import eigenvector_spaces, input_factors

__all__ = ["place_robustly"]

SWEEP_COUNT = 2
GLIDES, LENGTH, MOMENTUM = 20, 0.05, 0.8
DESCENTS = 3
ROOT2 = np.sqrt(2.0)
GETRF, GETRI = get_lapack_funcs(("getrf", "getri"), (np.eye(1),))


def place_robustly(A: np.ndarray, B: np.ndarray, poles: Poles) -> tuple[np.ndarray, float]:
    """Gain K (m×n) and the 2-norm condition number of the eigenvectors, for a controllable pair (A, B).

    K = B⁺(A − XΛX⁻¹). K depends on the poles and their order alone, all but smoothly, so it follows a dragged pole.
    The condition is infinite, and K zero, where no independent eigenvectors were found.
    """
    n = A.shape[0]
    _, U1, B_inverse = input_factors(B)
    if U1.shape[1] == 0:
        return B_inverse @ (A - _block_diagonal(poles)), 1.0
    ordered = np.concatenate([poles[poles.imag == 0], poles[poles.imag > 0]])
    pairs = int(np.count_nonzero(poles.imag > 0))
    spaces = eigenvector_spaces(A, U1, ordered if pairs else ordered.real)
    frame = _Frame(spaces, np.conj(np.swapaxes(spaces, 1, 2)), n - 2 * pairs)
    try:
        with np.errstate(all="ignore"):
            X = frame.columns(_descend(frame, _glide(frame, _sweep(frame))))
            singular = np.linalg.svd(X, compute_uv=False)
            if not singular[-1] > n * np.finfo(float).eps * singular[0]:
                return np.zeros((B.shape[1], n)), np.inf
            everything = np.concatenate([ordered, ordered[ordered.imag > 0].conj()])
            closed = np.linalg.solve(X.T, (X @ _block_diagonal(everything)).T).T
    except np.linalg.LinAlgError:
        return np.zeros((B.shape[1], n)), np.inf
    return B_inverse @ (A - closed), float(singular[0] / singular[-1])


@record()
class _Frame:
    """Admissible spaces: k bases S (k×n×r), their adjoints, and how many of the k poles are real (they come first).

    Coefficients c (k×r, unit rows) stand for the eigenvectors x_j = S_j c_j.
    """

    S: np.ndarray
    adjoint: np.ndarray
    real: int

    def columns(self, c: np.ndarray) -> np.ndarray:
        """X (n×n): real eigenvectors, then √2 Re x of the pairs, then √2 Im x of the pairs."""
        x = (self.S @ c[:, :, None])[:, :, 0].T
        if self.real == x.shape[1]:
            return x
        pairs = x[:, self.real :]
        return np.hstack([np.real(x[:, : self.real]), ROOT2 * np.real(pairs), ROOT2 * np.imag(pairs)])

    def coefficients(self, x: np.ndarray) -> np.ndarray:
        """Unit coefficients of the admissible vectors nearest to the rows of x (k×n)."""
        return _unit((self.adjoint @ x[:, :, None])[:, :, 0])

    def gradient(self, c: np.ndarray, Y: np.ndarray) -> np.ndarray:
        """Gradient of ‖Y‖_F², Y = X⁻¹, with respect to c, tangential to the unit spheres."""
        G = -2.0 * ((Y @ Y.T) @ Y)
        if self.real < c.shape[0]:
            k = c.shape[0]
            G = np.vstack([G[: self.real], ROOT2 * (G[self.real : k] + 1j * G[k:])])
        along = (self.adjoint @ G[:, :, None])[:, :, 0]
        return along - np.real(np.sum(along * c.conj(), axis=1))[:, None] * c


def _unit(c: np.ndarray) -> np.ndarray:
    return c / np.sqrt(np.real(np.sum(c * c.conj(), axis=1)))[:, None]


def _dot(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.real(np.vdot(a, b)))


def _sweep(frame: _Frame) -> np.ndarray:
    """Start: fixed orthonormal directions projected on the spaces, then method 0 with rank-one updates of X⁻¹."""
    k, n = frame.S.shape[:2]
    grid = np.arange(n)
    fixed = np.cos(np.pi * (grid[:, None] + 0.5) * grid[None] / n)
    aims = fixed[:, :k].T.astype(frame.S.dtype)
    if k > frame.real:
        aims[frame.real :] += 1j * fixed[:, k:].T
    c = frame.coefficients(aims)
    X = frame.columns(c)
    inverse = _inverse(X)
    for _ in range(SWEEP_COUNT):
        for j in range(k):
            away = inverse[j] if j < frame.real else inverse[j] + 1j * inverse[j + k - frame.real]
            c_j = frame.adjoint[j] @ away
            c[j] = c_j / np.sqrt(np.vdot(c_j, c_j).real)
            x = frame.S[j] @ c[j]
            if j < frame.real:
                _set_column(inverse, j, x.real)
            else:
                _set_column(inverse, j, ROOT2 * x.real)
                _set_column(inverse, j + k - frame.real, ROOT2 * x.imag)
    return c


def _inverse(X: np.ndarray) -> np.ndarray:
    """X⁻¹ straight from LAPACK: at ten states half the time of numpy's call. Raises LinAlgError where X is singular."""
    factors, pivots, info = GETRF(X)
    if info:
        raise np.linalg.LinAlgError("singular")
    return GETRI(factors, pivots)[0]


def _set_column(inverse: np.ndarray, j: int, x: np.ndarray) -> None:
    """X⁻¹ after column j of X became x (Sherman–Morrison)."""
    image = inverse @ x
    row = inverse[j] / image[j]
    image[j] -= 1.0
    inverse -= image[:, None] * row


def _glide(frame: _Frame, c: np.ndarray) -> np.ndarray:
    """Nesterov's accelerated gradient on log ‖X⁻¹‖_F², all steps of the same length."""
    pace = np.zeros_like(c)
    for _ in range(GLIDES):
        ahead = _unit(c + MOMENTUM * pace)
        Y = _inverse(frame.columns(ahead))
        new = _unit(ahead - (LENGTH / np.vdot(Y, Y)) * frame.gradient(ahead, Y))
        pace, c = new - c, new
    return c


def _descend(frame: _Frame, c: np.ndarray) -> np.ndarray:
    """Polak–Ribière conjugate gradients on ‖X⁻¹‖_F², the step by a parabola through two values and one slope."""

    def at(c: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        Y = _inverse(frame.columns(c))
        return float(np.vdot(Y, Y)), Y, c

    value, Y, c = at(c)
    g = frame.gradient(c, Y)
    gg = _dot(g, g)
    d, step = -g, 0.1 / np.sqrt(gg) if gg > 0 else 0.0
    for _ in range(DESCENTS):
        slope = _dot(g, d)
        if slope >= 0:
            d, slope = -g, -gg
        if not gg > 1e-20 * value**2:
            break
        trial = at(_unit(c + step * d))
        bend = trial[0] - value - slope * step
        best = min(-slope * step * step / (2 * bend), 4 * step) if bend > 0 else 2 * step
        candidate = at(_unit(c + best * d))
        if trial[0] < candidate[0]:
            candidate, best = trial, step
        if not candidate[0] < value:
            d, step = -g, step / 8
            continue
        (value, Y, c), step = candidate, best
        new = frame.gradient(c, Y)
        new_size = _dot(new, new)
        d = max(0.0, (new_size - _dot(new, g)) / gg) * d - new
        g, gg = new, new_size
    return c


def _block_diagonal(poles: Poles) -> np.ndarray:
    """The real normal matrix with these poles: a, and [[a, b], [−b, a]] for each pole and its first free conjugate."""
    M = np.diag(poles.real)
    lower = [i for i in range(poles.size) if poles[i].imag < 0]
    for i in np.flatnonzero(poles.imag > 0):
        j = next(k for k in lower if poles[k] == poles[i].conjugate())
        lower.remove(j)
        M[i, j], M[j, i] = poles[i].imag, -poles[i].imag
    return M
