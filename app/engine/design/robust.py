"""Place poles with several inputs such that the eigenvectors are well conditioned.

Every eigenvector of A − BK lies in a space S_λ of r = rank(B) dimensions. Two sweeps of Kautsky, Nichols and Van Dooren
(1985), method 0, give a start; then ‖X⁻¹‖_F is minimised over unit eigenvectors, which bounds the condition number
more closely than the determinant of X does. Most steps are an accelerated gradient of fixed length: no decisions, so
the gain is a smooth function of the poles (except where two minima change places). A few conjugate gradients finish.
All in real arithmetic: the pair x, x̄ stands in X as √2 Re x, √2 Im x, which changes X by a unitary factor only.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import get_lapack_funcs

from ..systems.pole_sets import Poles
from ..systems.records import record
from .eigenstructure import eigenvector_spaces, input_factors

__all__ = ["place_pairs_robustly", "place_robustly"]

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
    return place_pairs_robustly([(A, B)], poles)[0]


def place_pairs_robustly(pairs: Sequence[tuple[np.ndarray, np.ndarray]], poles: Poles) -> list[tuple[np.ndarray, float]]:
    """What `place_robustly` gives for each pair (A, B) of one size, found side by side in little more than the time of one."""
    ordered = np.concatenate([poles[poles.imag == 0], poles[poles.imag > 0]])
    goal = _block_diagonal(np.concatenate([ordered, ordered[ordered.imag > 0].conj()]))
    factors = [input_factors(B) for _, B in pairs]
    if len({U1.shape for _, U1, _ in factors}) > 1:
        return [place_robustly(*pair, poles) for pair in pairs]
    if factors[0][1].shape[1] == 0:
        return [(inverse @ (A - _block_diagonal(poles)), 1.0) for (A, _), (_, _, inverse) in zip(pairs, factors, strict=True)]
    complex_ones = int(np.count_nonzero(ordered.imag > 0))
    frame = _frame(np.stack([eigenvector_spaces(A, U1, ordered if complex_ones else ordered.real)
                             for (A, _), (_, U1, _) in zip(pairs, factors, strict=True)]), complex_ones)
    try:
        with np.errstate(all="ignore"):
            glided = _glide(frame, np.stack([_sweep(one) for one in frame.apart()]))
    except np.linalg.LinAlgError:
        none = [(np.zeros(B.shape[::-1]), np.inf) for _, B in pairs]
        return none if len(pairs) == 1 else [place_robustly(*pair, poles) for pair in pairs]
    return [_gain(A, inverse, one, c, goal)
            for (A, _), (_, _, inverse), one, c in zip(pairs, factors, frame.apart(), glided, strict=True)]


def _gain(A: np.ndarray, B_inverse: np.ndarray, frame: _Frame, c: np.ndarray, goal: np.ndarray) -> tuple[np.ndarray, float]:
    n = len(A)
    try:
        with np.errstate(all="ignore"):
            X = frame.X(_descend(frame, c))
            singular = np.linalg.svd(X, compute_uv=False)
            if not singular[-1] > n * np.finfo(float).eps * singular[0]:
                return np.zeros_like(B_inverse), np.inf
            closed = np.linalg.solve(X.T, (X @ goal).T).T
    except np.linalg.LinAlgError:
        return np.zeros_like(B_inverse), np.inf
    return B_inverse @ (A - closed), float(singular[0] / singular[-1])


@record()
class _Frame:
    """The admissible eigenvectors: column j of X is columns[j] (n×s) times the unit coefficients (s,) of its pole.

    The k poles come with the real ones first; columns k to n are the second ones, √2 Im x, of the pairs. Several plants of one size
    stand side by side: then columns are q×n×n×s, coefficients q×k×s, and so on.
    """

    columns: np.ndarray
    k: int
    real: int

    def apart(self) -> list[_Frame]:
        """The frame of each of several plants."""
        return [_Frame(columns, self.k, self.real) for columns in self.columns]

    def X(self, c: np.ndarray) -> np.ndarray:
        """X (n×n) from coefficients c (k×s): real eigenvectors, then √2 Re x of the pairs, then √2 Im x of the pairs."""
        each = np.concatenate([c, c[..., self.real :, :]], axis=-2)
        return (self.columns @ each[..., None])[..., 0].swapaxes(-1, -2)

    def along(self, rows: np.ndarray) -> np.ndarray:
        """What n rows, one to a column of X, are in the coefficients (k×s)."""
        each = (rows[..., None, :] @ self.columns)[..., 0, :]
        along = each[..., : self.k, :]
        along[..., self.real :, :] += each[..., self.k :, :]
        return along

    def gradient(self, c: np.ndarray, Y: np.ndarray) -> np.ndarray:
        """Gradient of ‖Y‖_F², Y = X⁻¹, with respect to c, tangential to the unit spheres."""
        along = self.along(-2.0 * ((Y @ Y.swapaxes(-1, -2)) @ Y))
        return along - np.add.reduce(along * c, axis=-1)[..., None] * c


def _frame(spaces: np.ndarray, pairs: int) -> _Frame:
    """Bases S (q×k×n×r) of the admissible spaces in real numbers: x = S c has Re x = Re S Re c − Im S Im c, and so on."""
    k = spaces.shape[1]
    real = k - pairs
    if not pairs:
        return _Frame(spaces, k, real)
    first, second = np.real(spaces), np.imag(spaces)
    alone = np.concatenate([first, 0 * second], axis=-1)[:, :real]
    upper, lower = (ROOT2 * np.concatenate(halves, axis=-1)[:, real:] for halves in ((first, -second), (second, first)))
    return _Frame(np.concatenate([alone, upper, lower], axis=1), k, real)


def _unit(c: np.ndarray) -> np.ndarray:
    return c / np.sqrt(np.add.reduce(c * c, axis=-1))[..., None]


def _sweep(frame: _Frame) -> np.ndarray:
    """Start: fixed orthonormal directions projected on the spaces, then method 0 with rank-one updates of X⁻¹."""
    n = len(frame.columns)
    grid = np.arange(n)
    c = _unit(frame.along(np.cos(np.pi * (grid[:, None] + 0.5) * grid[None] / n).T))
    inverse = _inverse(frame.X(c))
    for _ in range(SWEEP_COUNT):
        for j in range(frame.k):
            mine = [j] if j < frame.real else [j, j + frame.k - frame.real]
            away = sum(inverse[i] @ frame.columns[i] for i in mine)
            c[j] = away / np.sqrt(away @ away)
            for i in mine:
                _set_column(inverse, i, frame.columns[i] @ c[j])
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
    """Nesterov's accelerated gradient on log ‖X⁻¹‖_F², all steps of the same length, for q plants (q×k×s) side by side."""
    pace = np.zeros_like(c)
    Y = np.empty_like(frame.X(c))
    for _ in range(GLIDES):
        ahead = _unit(c + MOMENTUM * pace)
        for at, X in zip(Y, frame.X(ahead), strict=True):
            at[:] = _inverse(X)
        new = _unit(ahead - (LENGTH / np.add.reduce(Y * Y, axis=(-1, -2)))[:, None, None] * frame.gradient(ahead, Y))
        pace, c = new - c, new
    return c


def _descend(frame: _Frame, c: np.ndarray) -> np.ndarray:
    """Polak–Ribière conjugate gradients on ‖X⁻¹‖_F², the step by a parabola through two values and one slope."""

    def at(c: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        Y = _inverse(frame.X(c))
        return float(np.vdot(Y, Y)), Y, c

    value, Y, c = at(c)
    g = frame.gradient(c, Y)
    gg = np.vdot(g, g)
    d, step = -g, 0.1 / np.sqrt(gg) if gg > 0 else 0.0
    for _ in range(DESCENTS):
        slope = np.vdot(g, d)
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
        new_size = np.vdot(new, new)
        d = max(0.0, (new_size - np.vdot(new, g)) / gg) * d - new
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
