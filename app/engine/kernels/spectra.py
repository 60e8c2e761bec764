"""Compute spectral densities, frequency by frequency."""

from __future__ import annotations

import numpy as np

__all__ = ["density_steps"]


def density_steps(K, P, G, reading, out):
    """Fill out (n_f, q + m): the squares, summed, of what unit noise of the ground does to outputs and inputs, and those of what each
    reading's noise does times `reading` (n_f, p), where u = K (y + v) closes y = P u + G n.

    K (n_f, m, p), P (n_f, p + q, m), G (n_f, p + q, r). The number of frequencies done: it ends where I − K P has no inverse.
    """
    m, p = K.shape[1:]
    rows, r = G.shape[1:]
    left, S, driven = np.empty((m, m), dtype=np.complex128), np.empty((m, p), dtype=np.complex128), np.empty(m, dtype=np.complex128)
    for k in range(len(K)):
        for i in range(m):
            for j in range(m):
                a = 1.0 + 0.0j if i == j else 0.0j
                for l in range(p):
                    a -= K[k, i, l] * P[k, l, j]
                left[i, j] = a
            for l in range(p):
                S[i, l] = K[k, i, l]
        if not divided(left, S):
            return k
        for i in range(rows - p + m):
            out[k, i] = 0.0
        for l in range(p):
            for i in range(m):
                out[k, rows - p + i] += reading[k, l] * (S[i, l].real**2 + S[i, l].imag**2)
            for i in range(p, rows):
                a = 0.0j
                for j in range(m):
                    a += P[k, i, j] * S[j, l]
                out[k, i - p] += reading[k, l] * (a.real**2 + a.imag**2)
        for j in range(r):
            for i in range(m):
                a = 0.0j
                for l in range(p):
                    a += S[i, l] * G[k, l, j]
                driven[i] = a
                out[k, rows - p + i] += a.real**2 + a.imag**2
            for i in range(p, rows):
                a = G[k, i, j]
                for l in range(m):
                    a += P[k, i, l] * driven[l]
                out[k, i - p] += a.real**2 + a.imag**2
    return len(K)


def divided(left, S):
    """S = left⁻¹ S by elimination, the largest entry of each column first; False where left has no inverse. Both are overwritten."""
    m, p = S.shape
    for i in range(m):
        best, high = i, -1.0
        for j in range(i, m):
            size = abs(left[j, i].real) + abs(left[j, i].imag)
            if size > high:
                best, high = j, size
        if not high > 0.0:
            return False
        if best != i:
            for j in range(m):
                left[i, j], left[best, j] = left[best, j], left[i, j]
            for l in range(p):
                S[i, l], S[best, l] = S[best, l], S[i, l]
        for j in range(i + 1, m):
            a = left[j, i] / left[i, i]
            for l in range(i + 1, m):
                left[j, l] -= a * left[i, l]
            for l in range(p):
                S[j, l] -= a * S[i, l]
    for i in range(m - 1, -1, -1):
        for l in range(p):
            a = S[i, l]
            for j in range(i + 1, m):
                a -= left[i, j] * S[j, l]
            S[i, l] = a / left[i, i]
    return True
