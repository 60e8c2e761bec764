"""Multiply and factorise small matrices by plain loops.

Several sums run beside each other, which a compiler keeps in its registers.
"""

from __future__ import annotations

import numpy as np

__all__ = ["factor", "product", "put", "solve_both", "solve_upper", "symmetrise", "times", "triangle", "turn"]


def times(M: np.ndarray, w: np.ndarray, out: np.ndarray) -> None:
    """out = Mᵀ w for M (rows, columns), w (rows,), out (columns,): four rows at a time; best with 8 or 16 columns."""
    rows, columns = M.shape
    for l in range(columns):
        out[l] = 0.0
    even = rows - rows % 4
    for j in range(0, even, 4):
        a, b, c, d = w[j], w[j + 1], w[j + 2], w[j + 3]
        for l in range(columns):
            out[l] += a * M[j, l] + b * M[j + 1, l] + c * M[j + 2, l] + d * M[j + 3, l]
    for j in range(even, rows):
        a = w[j]
        for l in range(columns):
            out[l] += a * M[j, l]


def product(X: np.ndarray, Y: np.ndarray, lower: bool, out: np.ndarray) -> None:
    """out = X Y for X (n, m), Y (m, p): two rows and four columns at a time.

    `lower`: the product is symmetric, and only its lower triangle and what stands beside it in the same four columns is made.
    """
    n, m, p = X.shape[0], Y.shape[0], Y.shape[1]
    wide, high = p - p % 4, n - n % 2
    for l in range(0, wide, 4):
        for i in range(l if lower else 0, high, 2):
            a = b = c = d = e = f = g = h = 0.0
            for j in range(m):
                x, y = X[i, j], X[i + 1, j]
                a += x * Y[j, l]
                b += x * Y[j, l + 1]
                c += x * Y[j, l + 2]
                d += x * Y[j, l + 3]
                e += y * Y[j, l]
                f += y * Y[j, l + 1]
                g += y * Y[j, l + 2]
                h += y * Y[j, l + 3]
            out[i, l], out[i, l + 1], out[i, l + 2], out[i, l + 3] = a, b, c, d
            out[i + 1, l], out[i + 1, l + 1], out[i + 1, l + 2], out[i + 1, l + 3] = e, f, g, h
    for l in range(wide, p):  # the columns that are left, four rows at a time
        first = l if lower else 0
        last = n - (n - first) % 4
        for i in range(first, last, 4):
            a = b = c = d = 0.0
            for j in range(m):
                x = Y[j, l]
                a += X[i, j] * x
                b += X[i + 1, j] * x
                c += X[i + 2, j] * x
                d += X[i + 3, j] * x
            out[i, l], out[i + 1, l], out[i + 2, l], out[i + 3, l] = a, b, c, d
        for i in range(last, n):
            a = 0.0
            for j in range(m):
                a += X[i, j] * Y[j, l]
            out[i, l] = a
    for i in range(high, n):
        for l in range(min(i + 1, wide) if lower else wide):
            a = 0.0
            for j in range(m):
                a += X[i, j] * Y[j, l]
            out[i, l] = a


def put(X: np.ndarray, out: np.ndarray) -> None:
    """out = X."""
    for i in range(X.shape[0]):
        for j in range(X.shape[1]):
            out[i, j] = X[i, j]


def turn(X: np.ndarray, out: np.ndarray) -> None:
    """out = Xᵀ."""
    for i in range(X.shape[0]):
        for j in range(X.shape[1]):
            out[j, i] = X[i, j]


def symmetrise(X: np.ndarray, plus: np.ndarray, out: np.ndarray) -> None:
    """out = X + plus for a symmetric `plus`, from the lower triangle of X."""
    for i in range(len(X)):
        for j in range(i + 1):
            out[i, j] = out[j, i] = X[i, j] + plus[i, j]


def factor(S: np.ndarray, L: np.ndarray) -> bool:
    """The Cholesky factor L of S in its lower triangle; False where S is not positive definite."""
    for j in range(len(S)):
        d = S[j, j]
        for l in range(j):
            d -= L[j, l] * L[j, l]
        if not d > 0.0:
            return False
        d = np.sqrt(d)
        L[j, j] = d
        for i in range(j + 1, len(S)):
            s = S[i, j]
            for l in range(j):
                s -= L[i, l] * L[j, l]
            L[i, j] = s / d
    return True


def solve_both(L: np.ndarray, X: np.ndarray) -> None:
    """X (p, n) ← (L Lᵀ)⁻¹ X."""
    p, n = X.shape
    for i in range(p):
        for j in range(i):
            a = L[i, j]
            for l in range(n):
                X[i, l] -= a * X[j, l]
        for l in range(n):
            X[i, l] /= L[i, i]
    solve_upper(L, X)


def solve_upper(L: np.ndarray, X: np.ndarray) -> None:
    """X (p, n) ← L⁻ᵀ X."""
    p, n = X.shape
    for i in range(p - 1, -1, -1):
        for j in range(i + 1, p):
            a = L[j, i]
            for l in range(n):
                X[i, l] -= a * X[j, l]
        for l in range(n):
            X[i, l] /= L[i, i]


def triangle(X: np.ndarray, columns: int, v: np.ndarray, w: np.ndarray) -> None:
    """The first `columns` columns of X (rows ≥ columns) ← R of its QR factors, by reflections; v (rows,), w (columns,)."""
    rows = len(X)
    for k in range(min(columns, rows - 1)):
        size = 0.0
        for i in range(k, rows):
            size = max(size, abs(X[i, k]))
        if size == 0.0:
            continue
        norm = 0.0
        for i in range(k, rows):
            v[i] = X[i, k] / size
            norm += v[i] * v[i]
        root = -np.sqrt(norm) if v[k] > 0 else np.sqrt(norm)
        v[k] -= root
        half = -root * v[k]  # of ‖v‖²
        for j in range(k, columns):
            w[j] = 0.0
        for i in range(k, rows):
            a = v[i]
            for j in range(k, columns):
                w[j] += a * X[i, j]
        for j in range(k, columns):
            w[j] /= half
        for i in range(k, rows):
            a = v[i]
            for j in range(k, columns):
                X[i, j] -= a * w[j]
        X[k, k] = root * size
        for i in range(k + 1, rows):
            X[i, k] = 0.0
