"""The two ways to place the poles of a controllable pair: robust eigenvectors, and deflation one pole at a time."""

from __future__ import annotations

import numpy as np

__all__ = ["controllable_split", "place_by_deflation", "place_robustly"]

RANK_TOLERANCE = 1e-12
SWEEPS = 12


def controllable_split(A: np.ndarray, B: np.ndarray, rtol: float = RANK_TOLERANCE) -> tuple[np.ndarray, int]:
    """Orthogonal Q (x = Q z) and the number of leading coordinates of z that the input reaches (staircase form).

    In z: A = [[A1, A12], [0, A2]], B = [[B1], [0]] with (A1, B1) controllable. Ranks are decided by singular values
    above rtol·‖B‖ in the first step and rtol·‖A‖ in the later ones.
    """
    n = A.shape[0]
    work, Q, block = A.copy(), np.eye(n), B
    floor = rtol * np.linalg.norm(B)
    reached = 0
    while reached < n:
        U, s, _ = np.linalg.svd(block)
        rank = int(np.count_nonzero(s > floor))
        if rank == 0:
            break
        work[reached:] = U.T @ work[reached:]
        work[:, reached:] = work[:, reached:] @ U
        Q[:, reached:] = Q[:, reached:] @ U
        block = work[reached + rank :, reached : reached + rank]
        reached += rank
        floor = rtol * np.linalg.norm(A)
    return Q, reached


def input_factors(B: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """U0 (n×r, orthonormal range of B), U1 (its complement) and the pseudo-inverse B⁺ (m×n)."""
    U, s, Vt = np.linalg.svd(B)
    r = int(np.count_nonzero(s > RANK_TOLERANCE * s[0])) if s.size else 0
    return U[:, :r], U[:, r:], (Vt[:r].T / s[:r]) @ U[:, :r].T


def eigenvector_spaces(A: np.ndarray, U1: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """For each λ an orthonormal basis (n×r) of the x with (A − λI)x in the range of B: the null space of U1ᵀ(A − λI)."""
    n, k = U1.shape
    stack = (U1.T @ A)[None] - poles[:, None, None] * U1.T[None]
    Q = np.linalg.qr(np.conj(np.swapaxes(stack, 1, 2)), mode="complete")[0]
    return Q[:, :, k:]


def place_robustly(A: np.ndarray, B: np.ndarray, poles: np.ndarray, sweeps: int = SWEEPS) -> tuple[np.ndarray, float]:
    """Gain K (m×n) and condition number of the eigenvectors: Kautsky, Nichols and Van Dooren (1985), method 0.

    Each eigenvector in turn becomes the vector of its admissible space nearest to the direction orthogonal to all the
    others; that direction is a row of X⁻¹, kept up to date by the Sherman–Morrison formula.
    The start depends on the poles alone and smoothly, so K moves smoothly while a pole is dragged.
    The condition is infinite where no independent eigenvectors were found.
    """
    n = A.shape[0]
    U0, U1, B_inverse = input_factors(B)
    if U1.shape[1] == 0:
        return B_inverse @ (A - _normal_matrix(poles)), 1.0
    lead = np.flatnonzero(poles.imag >= 0)
    complex_poles = bool(np.any(poles.imag != 0))
    asked = poles[lead] if complex_poles else poles[lead].real
    spaces = eigenvector_spaces(A, U1, asked)
    X, mates = _start(poles, lead, spaces, n)
    inverse = _inverse(X)
    if inverse is None:
        return np.zeros((B.shape[1], n)), np.inf
    for _ in range(sweeps):
        for j, S, mate in zip(lead, spaces, mates, strict=True):
            _turn(X, inverse, j, S)
            if mate >= 0:
                _set_column(X, inverse, mate, X[:, j].conj())
        if not np.all(np.isfinite(inverse)):
            return np.zeros((B.shape[1], n)), np.inf
    singular = np.linalg.svd(X, compute_uv=False)
    if singular[-1] <= n * np.finfo(float).eps * singular[0]:
        return np.zeros((B.shape[1], n)), np.inf
    closed = np.linalg.solve(X.T, (X * poles).T).T.real
    return B_inverse @ (A - closed), float(singular[0] / singular[-1])


def _start(poles, lead, spaces, n):
    """First eigenvectors: a fixed orthonormal set of directions projected on the admissible spaces."""
    k = np.arange(n)
    fixed = np.sqrt(2 / n) * np.cos(np.pi * (k[:, None] + 0.5) * k[None] / n)
    fixed[:, 0] /= np.sqrt(2)
    X = np.empty((n, n), dtype=spaces.dtype)
    mates = []
    free = [i for i in range(n) if poles[i].imag < 0]
    for j, S in zip(lead, spaces, strict=True):
        mate = -1
        aim = fixed[:, j].astype(X.dtype)
        if poles[j].imag > 0:
            mate = next(i for i in free if poles[i] == poles[j].conjugate())
            free.remove(mate)
            aim = aim + 1j * fixed[:, mate]
        x = S @ (S.conj().T @ aim)
        X[:, j] = x / np.linalg.norm(x)
        if mate >= 0:
            X[:, mate] = X[:, j].conj()
        mates.append(mate)
    return X, mates


def _inverse(X: np.ndarray) -> np.ndarray | None:
    try:
        return np.linalg.inv(X)
    except np.linalg.LinAlgError:
        return None


def _turn(X: np.ndarray, inverse: np.ndarray, j: int, S: np.ndarray) -> None:
    x = S @ (S.conj().T @ inverse[j].conj())
    x /= np.sqrt(np.vdot(x, x).real)
    _set_column(X, inverse, j, x)


def _set_column(X: np.ndarray, inverse: np.ndarray, j: int, x: np.ndarray) -> None:
    """Replace column j of X; Sherman–Morrison for the inverse."""
    image = inverse @ x
    row = inverse[j] / image[j]
    image[j] -= 1.0
    inverse -= image[:, None] * row
    X[:, j] = x


def _normal_matrix(poles: np.ndarray) -> np.ndarray:
    """A real normal matrix with these poles: 1×1 blocks and rotations [[a, b], [−b, a]]."""
    M = np.zeros((poles.size, poles.size))
    free = [i for i in range(poles.size) if poles[i].imag < 0]
    for i, pole in enumerate(poles):
        M[i, i] = pole.real
        if pole.imag > 0:
            j = next(k for k in free if poles[k] == pole.conjugate())
            free.remove(j)
            M[i, j], M[j, i] = pole.imag, -pole.imag
    return M


def place_by_deflation(A: np.ndarray, B: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """Gain K (m×n) that makes A − BK quasi-triangular in an orthonormal basis, one pole or pair after the other.

    With (A − λI)x = B f and Q = [q, Q₂] orthogonal, q along x: K = f (qᵀx)⁻¹ qᵀ + K₂ Q₂ᵀ, where K₂ places the other
    poles of (Q₂ᵀAQ₂, Q₂ᵀB). Works for any multiplicity (the closed loop is then defective) and for one input.
    Method: orthogonal deflation after Miminis and Paige (1982) and Varga (1981).
    """
    K, frame = np.zeros((B.shape[1], A.shape[0])), np.eye(A.shape[0])
    for pole in poles[poles.imag >= 0]:
        width = 2 if pole.imag > 0 else 1
        basis, f = _cheapest_vector(A, B, pole if width == 2 else pole.real)
        Q, R = np.linalg.qr(basis, mode="complete")
        K += np.linalg.solve(R[:width].T, f.T).T @ (frame @ Q[:, :width]).T
        rest = Q[:, width:]
        A, B, frame = rest.T @ A @ rest, rest.T @ B, frame @ rest
    return K


def _cheapest_vector(A: np.ndarray, B: np.ndarray, pole: complex | float) -> tuple[np.ndarray, np.ndarray]:
    """Real basis (n×1 or n×2) of an admissible eigenvector and its input directions f, the smallest there are."""
    _, U1, B_inverse = input_factors(B)
    S = eigenvector_spaces(A, U1, np.array([pole]))[0]
    image = B_inverse @ (A @ S - pole * S)
    turns = np.linalg.svd(image)[2].conj().T[:, ::-1]
    if not np.iscomplexobj(S):
        return S @ turns[:, :1], image @ turns[:, :1]
    choices = [turns[:, i] for i in range(turns.shape[1])]
    choices += [turns[:, i] + 1j * turns[:, k] for i in range(turns.shape[1]) for k in range(i)]
    best, basis, c = -1.0, None, choices[0]
    for c in choices:
        x = S @ c
        pair = np.column_stack([x.real, x.imag]) / np.linalg.norm(x)
        spread = np.linalg.svd(pair, compute_uv=False)[-1]
        if basis is None or spread > best:
            best, basis, f = spread, pair, image @ c / np.linalg.norm(x)
        if best > 0.1:
            break
    assert basis is not None
    return basis, np.column_stack([f.real, f.imag])
