"""Find directions gᵢ for which K = N T + M C can be solved, given the observer's poles."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from ..structure.coprime import CoprimeFactors
from ..systems.balance import weighed_scale
from ..systems.plant import Plant
from ..systems.pole_sets import Poles

__all__ = ["choose_directions", "full_stack", "gap", "linear_directions", "normalised", "row_condition",
           "seen_rows", "upper_half_poles"]

STARTS = 12
DIRECTION_RTOL = 1e-11


def upper_half_poles(poles: Poles) -> Poles:
    """The poles with Im s ≥ 0, in their order: one for each real pole and for each pair."""
    return poles[poles.imag >= 0]


def full_stack(factors: CoprimeFactors, C: np.ndarray, heads: Poles) -> np.ndarray:
    """All rows that some T and C can offer: C, H(sᵢ)ᵀ of real poles, Re H(sᵢ)ᵀ and −Im H(sᵢ)ᵀ of pairs."""
    return _stacked(C, heads, [factors.H_at(s if s.imag else s.real) for s in heads])


def _stacked(C: np.ndarray, heads: Poles, H: list[np.ndarray]) -> np.ndarray:
    rows = [C]
    for s, own in zip(heads, H, strict=True):
        rows += [np.real(own.T), -np.imag(own.T)] if s.imag else [own.T]
    return np.vstack(rows)


def normalised(g: np.ndarray) -> np.ndarray:
    """g of unit 2-norm, its largest entry real and positive: for one output always 1."""
    lead = g[np.argmax(np.abs(g) > (1 - 1e-9) * np.abs(g).max())]
    return g * (np.conj(lead) / abs(lead)) / np.linalg.norm(g)


def linear_directions(stack: np.ndarray, p: int, heads: Poles,
                      c: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """g (heads, p), N (1×q) and M (1×p) of one wanted row K = c stack: Rᵢ = nᵢ gᵢᵀ are read off the coefficients c."""
    M, k, g, N = c[:p], p, [], []
    for s in heads:
        R = c[k:k + p].astype(complex)
        k += p
        if s.imag:
            R = (R + 1j * c[k:k + p]) / 2
            k += p
        nothing = not np.abs(R).max() > 1e-14 * np.abs(c).max()
        direction = normalised(np.eye(p, dtype=complex)[0] if nothing else R)
        g.append(direction)
        n = 0.0 if nothing else R @ direction.conj()
        N += [2 * np.real(n), -2 * np.imag(n)] if s.imag else [np.real(n)]
    return np.array(g), np.array([N], dtype=float), M[None]


def solve_row(stack: np.ndarray, K: np.ndarray, shift: np.ndarray | None = None) -> tuple[np.ndarray, float]:
    """c with c stack ≈ K (row, n) nearest to `shift`, in rows of unit length, and ‖K − c stack‖/‖K‖."""
    length = np.linalg.norm(stack, axis=1)
    length = np.where(length > 0, length, 1.0)
    rows = stack / length[:, None]
    near = np.zeros(len(rows)) if shift is None else shift
    c = near + np.linalg.lstsq(rows.T, K - near @ rows, rcond=1e-12)[0]
    return c / length, float(np.linalg.norm(K - c @ rows) / np.linalg.norm(K))


def choose_directions(factors: CoprimeFactors, plant: Plant, K: np.ndarray, heads: Poles) -> np.ndarray:
    """g (heads, p) for K (r×n): exact for one row, else a well-spread choice, bent until K fits where it must.

    The best found is returned also where K cannot be met; the caller judges the residual.
    """
    C, p, n = plant.C, plant.p, plant.n
    if len(K) == 1:
        stack = _stacked(C, heads, [factors.exact_at(plant.A, C, s if s.imag else s.real)[0] for s in heads])
        return linear_directions(stack, p, heads, solve_row(stack, K[0])[0])[0]
    order = sum(2 if s.imag else 1 for s in heads)
    g = _spread(factors, C, heads)
    if order >= n - p or p == 1:
        return g
    rng = np.random.default_rng(0)
    best, least = g, np.inf
    for attempt in range(STARTS):
        start = g if attempt == 0 else rng.standard_normal(g.shape) + 1j * rng.standard_normal(g.shape)
        fit = least_squares(lambda v: gap(factors, C, K, heads, unpack(v, heads, p)).ravel(), pack(start, heads),
                            xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=200)
        if fit.cost < least:
            best, least = unpack(fit.x, heads, p), fit.cost
        if np.sqrt(2 * least) < DIRECTION_RTOL * np.linalg.norm(K):
            break
    return best


def seen_rows(A: np.ndarray, C: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal rows spanning those of C in balanced states (rank × n), and the balance d (n,): rows times d."""
    d = weighed_scale(A, np.zeros((len(A), 0)), C)
    _, s, Vt = np.linalg.svd(C * d)
    return Vt[:int(np.count_nonzero(s > 1e-10 * s[0]))], d


def row_condition(T: np.ndarray, seen: np.ndarray, d: np.ndarray) -> float:
    """Condition number of [T; C]: rows of T in balanced states of length one beside `seen`; n rows at most count."""
    rows = np.vstack([_unit(T * d), seen])
    s = np.linalg.svd(rows, compute_uv=False)
    return float(s[0] / s[-1]) if s[-1] > 0 else np.inf


def gap(factors: CoprimeFactors, C: np.ndarray, K: np.ndarray, heads: Poles, g: np.ndarray) -> np.ndarray:
    """K less its projection on the rows of [T; C] (r×n): zero where N and M exist (condition (11))."""
    Q = np.linalg.qr(_unit(np.vstack([C, t_rows(factors, heads, g)])).T)[0]
    return K - (K @ Q) @ Q.T


def t_rows(factors: CoprimeFactors, heads: Poles, g: np.ndarray) -> np.ndarray:
    """T′ (q×n) straight from the polynomials."""
    rows = []
    for s, direction in zip(heads, g, strict=True):
        t = factors.H_at(s if s.imag else s.real) @ (direction if s.imag else direction.real)
        rows += [t.real, t.imag] if s.imag else [t]
    return np.array(rows)


def l_rows(factors: CoprimeFactors, heads: Poles, g: np.ndarray) -> np.ndarray:
    """L′ (q×p) straight from the polynomials."""
    rows = []
    for s, direction in zip(heads, g, strict=True):
        l = -factors.L_at(s if s.imag else s.real) @ (direction if s.imag else direction.real)
        rows += [l.real, l.imag] if s.imag else [l]
    return np.array(rows)


def pack(g: np.ndarray, heads: Poles) -> np.ndarray:
    """Directions as one real vector: p numbers for a real pole, 2p for a pair."""
    return np.concatenate([np.concatenate([d.real, d.imag]) if s.imag else d.real
                           for s, d in zip(heads, g, strict=True)])


def unpack(v: np.ndarray, heads: Poles, p: int) -> np.ndarray:
    """Unit directions (heads, p) from one real vector."""
    out, k = [], 0
    for s in heads:
        d = v[k:k + p].astype(complex)
        k += p
        if s.imag:
            d = d + 1j * v[k:k + p]
            k += p
        out.append(normalised(d) if np.any(d) else np.eye(p, dtype=complex)[0])
    return np.array(out)


def _spread(factors: CoprimeFactors, C: np.ndarray, heads: Poles) -> np.ndarray:
    """Directions one after the other, each adding to [T; C] the rows that are farthest from those before."""
    basis, out = np.linalg.qr(C.T)[0], []
    for s in heads:
        H = factors.H_at(s if s.imag else s.real)
        H = H / np.linalg.norm(H)
        new = H - basis @ (basis.T @ H)
        turns = np.linalg.svd(new)[2].conj().T
        choices = [turns[:, 0]]
        if s.imag:  # Re t and Im t must both be new
            choices += [turns[:, 0] + 1j * turns[:, k] for k in range(1, turns.shape[1])]
            choices += [turns[:, 0] - 1j * turns[:, k] for k in range(1, turns.shape[1])]
        g = max(choices, key=lambda g: np.linalg.svd(_parts(new @ g / np.linalg.norm(g), s))[1][-1])
        out.append(normalised(g.astype(complex)))
        basis = np.linalg.qr(np.column_stack([basis, _unit(_parts(H @ out[-1], s)).T]))[0]
    return np.array(out)


def _parts(t: np.ndarray, s: complex) -> np.ndarray:
    return np.array([np.real(t), np.imag(t)]) if s.imag else np.real(t)[None]


def _unit(rows: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(rows, axis=1)
    return rows / np.where(length > 0, length, 1.0)[:, None]
