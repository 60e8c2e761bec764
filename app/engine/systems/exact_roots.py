"""Compute poles and roots in integer arithmetic where double precision is not enough.

A fixed point with some hundreds of bits takes the place of floating point: eigenvalues of a matrix come from its
characteristic polynomial, whose roots Aberth's iteration finds from near where they ought to be.
"""

from __future__ import annotations

from fractions import Fraction
from math import log2

import numpy as np

from .fixed_point import fixed, number, product, whole
from .records import record

__all__ = ["MAX_STATES", "ExactRoots", "exact_poles", "exact_roots"]

SPARE, EACH_STATE, EACH_COPY = 192, 6, 64  # bits kept beyond what the sizes of the roots take
MIN_ROOT = 2.0**-250  # a root that is smaller beside the matrix asks for no more bits
MAX_SWEEPS = 80
MAX_STATES = 30  # of which it does not take long
ROOT_STEP_RTOL, ROOT_DISTANCE_SHARE, NO_CHANGE_RTOL = (
    2.0**-55,
    1e-3,
    2.0**-70,
)  # of a root; of its distance from where it was sought; of a root again
FURTHEST = 6  # powers of the distance that are looked at around a simple root
GOLDEN = 2.399963229728653  # rad between one start and the next


@record()
class ExactRoots:
    """Roots (re + j im) · unit / 2^bits, re and im whole numbers (object arrays (n,)), unit a power of two."""

    re: np.ndarray
    im: np.ndarray
    bits: int
    unit: float

    @property
    def values(self) -> np.ndarray:
        """The roots, rounded to complex doubles (n,)."""
        return number(self.re, self.im, self.bits) * self.unit

    def distances(self, points: np.ndarray) -> np.ndarray:
        """|points[i] − root[j]|, (k, n), right however near they lie."""
        re, im = fixed(np.real(points) / self.unit, self.bits), fixed(np.imag(points) / self.unit, self.bits)
        return np.abs(number(re[:, None] - self.re, im[:, None] - self.im, self.bits)) * self.unit


def exact_poles(A: np.ndarray, B: np.ndarray, K: np.ndarray, near: np.ndarray, scale: np.ndarray) -> ExactRoots:
    """eig(A − BK) for the doubles A n×n, B n×m, K m×n, nothing rounded but beyond some hundreds of bits.

    `near` (n,): where they are sought, multiple ones repeated. `scale` (n,): powers of two that balance the states.
    """
    A, B, K = A * scale / scale[:, None], B / scale[:, None], K * scale
    size = np.abs(B).max(axis=0, initial=0.0)
    inputs = 2.0 ** np.round(np.log2(np.where(size > 0, size, 1.0)))
    B, K = B / inputs, K * inputs[:, None]
    largest = (np.abs(A) + np.abs(B) @ np.abs(K)).sum(axis=1).max(initial=0.0)
    unit, bits = _measure(near, float(largest))
    M = fixed(A / unit, bits)
    if B.size:
        M = M - product(fixed(B, bits), fixed(K / unit, bits), bits)
    return _found(_characteristic(_hessenberg(M, bits), bits), near, bits, unit)


def exact_roots(polynomial: np.ndarray, near: np.ndarray) -> ExactRoots:
    """Roots of a polynomial of doubles, the highest power first and not zero, sought from `near` (n,)."""
    unit, bits = _measure(near, 0.0)
    each = Fraction(unit)
    lead = Fraction(float(polynomial[0]))
    monic = [Fraction(float(c)) / lead / each**k for k, c in enumerate(polynomial)]
    return _found(np.array([(c.numerator << bits) // c.denominator for c in monic[::-1]], dtype=object), near, bits, unit)


def _measure(near: np.ndarray, largest: float) -> tuple[float, int]:
    """The unit in which no root and no entry is much above one, and the bits behind the point that all roots need."""
    sizes = np.abs(near)
    unit = 2.0 ** np.ceil(np.log2(max(largest, float(sizes.max(initial=0.0))) or 1.0))
    copies = int(np.unique(near, return_counts=True)[1].max(initial=1))
    depth = -np.log2(np.clip(sizes / unit, MIN_ROOT, 1.0)).sum()
    return float(unit), int(SPARE + EACH_COPY * copies + EACH_STATE * len(near) + depth)


def _hessenberg(M: np.ndarray, bits: int) -> np.ndarray:
    """M made zero below its first subdiagonal by similar steps, pivots as large as there are."""
    M = M.copy()
    for k in range(len(M) - 2):
        pivot = k + 1 + max(range(len(M) - k - 1), key=lambda i: abs(M[k + 1 + i, k]))
        if M[pivot, k] == 0:
            continue
        M[[k + 1, pivot]] = M[[pivot, k + 1]]
        M[:, [k + 1, pivot]] = M[:, [pivot, k + 1]]
        factor = (M[k + 2:, k] << bits) // M[k + 1, k]
        M[k + 2:, k + 1:] -= (factor[:, None] * M[k + 1, k + 1:]) >> bits
        M[k + 2:, k] = 0
        M[:, k + 1] += (M[:, k + 2:] @ factor) >> bits
    return M


def _characteristic(H: np.ndarray, bits: int) -> np.ndarray:
    """det(sI − H) of a Hessenberg matrix, from s⁰ up: p_k = (s − h_kk) p_{k−1} − Σ_i h_ik h_{i+1,i} ⋯ h_{k,k−1} p_{i−1}."""
    n = len(H)
    p = np.zeros((n + 1, n + 1), dtype=object)
    p[0, 0] = 1 << bits
    for k in range(n):
        p[k + 1, 1:] = p[k, :-1]
        p[k + 1] -= (H[k, k] * p[k]) >> bits
        below = 1 << bits
        for i in range(k - 1, -1, -1):
            below = (below * H[i + 1, i]) >> bits
            if below == 0:
                break
            p[k + 1] -= (((H[i, k] * below) >> bits) * p[i]) >> bits
    return p[n]


def _expanded(p: np.ndarray, re: np.ndarray, im: np.ndarray, bits: int, terms: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """The first Taylor coefficients of p, from s⁰ up, about each point, real and imaginary parts (k,) each."""
    rest = [(np.full(len(re), c, dtype=object), np.zeros(len(re), dtype=object)) for c in p[::-1]]
    found = []
    for _ in range(min(terms, len(p))):
        for k in range(1, len(rest)):
            a, b = rest[k - 1]
            rest[k] = rest[k][0] + ((a * re - b * im) >> bits), rest[k][1] + ((a * im + b * re) >> bits)
        found.append(rest.pop())
    return found


def _log2(re: int, im: int) -> float:
    """log₂ |re + j im|, −∞ for zero."""
    shift = max(max(abs(re).bit_length(), abs(im).bit_length()) - 60, 0)
    size = abs(complex(re >> shift, im >> shift))
    return log2(size) + shift if size else -np.inf


def _starts(p: np.ndarray, near: np.ndarray, bits: int) -> tuple[np.ndarray, np.ndarray]:
    """Points about each of `near` at the distance at which the polynomial has a root: min_k |c₀/c_k|^(1/k)."""
    re, im = fixed(np.real(near), bits), fixed(np.imag(near), bits)
    copies = int(np.unique(near, return_counts=True)[1].max())
    terms = [np.array([_log2(a, b) for a, b in zip(*c, strict=True)])
             for c in _expanded(p, re, im, bits, max(FURTHEST, copies) + 1)]
    with np.errstate(invalid="ignore"):
        reach = np.min([np.where(np.isfinite(c), (terms[0] - c) / k, np.inf) for k, c in enumerate(terms) if k], axis=0)
    at = np.exp(1j * GOLDEN * (np.arange(len(near)) + 0.5))
    for i in np.flatnonzero(np.isfinite(reach)):
        exponent = int(np.floor(reach[i]))
        push = 2.0 ** (reach[i] - exponent)
        re[i] += whole(float(at[i].real * push), bits + exponent)
        im[i] += whole(float(at[i].imag * push), bits + exponent)
    return re, im


def _found(p: np.ndarray, near: np.ndarray, bits: int, unit: float) -> ExactRoots:
    """Roots of the monic p by the iteration of Ehrlich and Aberth: Newton's step, pushed off from the other roots."""
    n = len(near)
    sought = near / unit
    if not n:
        return ExactRoots(np.empty(0, dtype=object), np.empty(0, dtype=object), bits, unit)
    re, im = _starts(p, sought, bits)
    home_re, home_im = fixed(np.real(sought), bits), fixed(np.imag(sought), bits)
    dust = (4 * n).bit_length()
    left = np.arange(n)
    for _ in range(MAX_SWEEPS):
        value, slope = _expanded(p, re[left], im[left], bits, 2)
        newton = np.array([_ratio(a, b, c, d, dust) for a, b, c, d in zip(value[0], value[1], slope[0], slope[1], strict=True)])
        apart = number(re[left, None] - re, im[left, None] - im, bits)
        with np.errstate(all="ignore"):
            push = np.where(apart != 0, 1 / apart, 0).sum(axis=1)
            step = newton / (1 - newton * push)
        step = np.where(np.isfinite(step), step, newton / n)
        re[left] -= fixed(np.real(step), bits)
        im[left] -= fixed(np.imag(step), bits)
        size = np.abs(number(re[left], im[left], bits))
        gone = np.abs(number(re[left] - home_re[left], im[left] - home_im[left], bits))
        left = left[
            ~((np.abs(step) <= ROOT_STEP_RTOL * size) & (np.abs(step) <= np.maximum(ROOT_DISTANCE_SHARE * gone, NO_CHANGE_RTOL * size)))
        ]
        if not left.size:
            break
    return ExactRoots(re, im, bits, unit)


def _ratio(a: int, b: int, c: int, d: int, dust: int) -> complex:
    """(a + jb)/(c + jd); zero where the first is below the rounding of `dust` bits."""
    top, bottom = max(abs(a).bit_length(), abs(b).bit_length()), max(abs(c).bit_length(), abs(d).bit_length())
    if top <= dust or not bottom:
        return 0j
    quotient = complex(a / (1 << top), b / (1 << top)) / complex(c / (1 << bottom), d / (1 << bottom))
    return quotient * 2.0 ** max(min(top - bottom, 1000), -1000)
