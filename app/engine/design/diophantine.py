"""Place poles by polynomials: solve A E + B F = Φ for a plant B/A and controller F/E."""

from __future__ import annotations

import numpy as np

from ..systems.errors import EngineError, PoleError, ShapeError, phrase
from ..systems.gates.argument_checks import count, takes, vector
from ..systems.plant import Plant
from ..systems.pole_sets import MIN_POLE
from ..systems.records import record
from .siso import coefficients, negated, polynomial_roots, rational

__all__ = ["Diophantine", "diophantine", "sylvester"]

WORST = 1e13  # condition of the scaled Sylvester matrix beyond which A and B count as having a common factor


@record()
class Diophantine:
    """The solution of A E + B F = Φ, coefficients from the highest power down; E and Φ are as monic as A makes them.

    residual: largest coefficient of A E + B F − Φ relative to the terms that make it up; condition: of the scaled
    Sylvester matrix.
    """

    A: np.ndarray
    B: np.ndarray
    E: np.ndarray
    F: np.ndarray
    desired: np.ndarray
    residual: float
    condition: float

    @property
    def strictly_proper(self) -> bool:
        """Whether deg F < deg E.

        >>> diophantine([1, 0, 0], [1], [1, 4, 6, 4, 1]).strictly_proper
        True
        """
        return len(self.F) < len(self.E)

    @property
    def poles(self) -> np.ndarray:
        """Roots of A E + B F, sorted by (real, imag)."""
        whole = np.polyadd(np.polymul(self.A, self.E), np.polymul(self.B, self.F))
        return np.sort_complex(polynomial_roots(whole))

    def controller(self) -> Plant:
        """u = −(F/E) y: a plant from y to u with the minus sign of the feedback inside."""
        return negated(rational(self.F, self.E))


@takes(A=vector(), B=vector(), degree=count(0, 2000))
def sylvester(A: object, B: object, degree: int) -> np.ndarray:
    """M with M (e; f) = coefficients of A E + B F, square (degree + 1): deg E = degree − n, deg F = n − 1, n = deg A."""
    a, b = (np.atleast_1d(np.asarray(p, dtype=float)) for p in (A, B))
    n = len(a) - 1
    if n < 0 or len(b) > n or degree < max(n, 2 * n - 1):
        raise ShapeError("A must be of a degree n above that of B, and the degree of Φ at least 2n − 1.")
    e, f = degree - n + 1, n
    M = np.zeros((degree + 1, e + f))
    for k in range(e):
        M[k:k + len(a), k] = a
    for k in range(f):
        first = degree + 1 - f + k - (len(b) - 1)
        M[first:first + len(b), e + k] = b
    return M


@takes(A=vector(), B=vector(), desired=vector())
def diophantine(A: object, B: object, desired: object) -> Diophantine:
    """E and F of least degree with A E + B F = Φ: the closed loop of B/A and u = −(F/E) y has exactly Φ's roots.

    A: degree n; B: degree below n; Φ: degree 2n − 1 for a proper controller, 2n or more for a strictly proper one;
    deg F ≤ n − 1, deg E = deg Φ − n. Powers of s are scaled by the size of Φ's roots, columns to unit size.
    Raises PoleError for a Φ of too low degree, EngineError where B/A is not strictly proper or A and B share a factor
    (named), which no controller can move. Source: report, eqs (27)–(30); Goodwin, Graebe and Salgado (2001), ch. 7.
    """
    a, b, phi = (_trimmed(p, name) for p, name in ((A, "A"), (B, "B"), (desired, "Φ")))
    n, degree = len(a) - 1, len(phi) - 1
    if n < 1 or len(b) - 1 >= n:
        raise EngineError("B/A must be strictly proper: the degree of B is {count}, that of A {n}.",
                          count=len(b) - 1, n=n)
    if degree < 2 * n - 1:
        raise PoleError("Φ has degree {degree}; a plant of order {n} needs at least {n2} poles, and {n3} for a "
                        "strictly proper controller.",
                        degree=degree, n=n, n2=2 * n - 1, n3=2 * n)
    scale = _frequency(phi)
    powers = scale ** np.arange(degree, -1.0, -1.0)
    scaled_a, scaled_b = (p * scale ** np.arange(len(p) - 1, -1.0, -1.0) for p in (a, b))
    M = sylvester(scaled_a, scaled_b, degree)
    right = phi * powers
    columns = np.linalg.norm(M, axis=0)
    columns[columns == 0] = 1.0
    M = M / columns
    condition = float(np.linalg.cond(M))
    if not condition < WORST:
        raise EngineError("A and B share the factor at s = {a}, or nearly so: no controller moves that pole; "
                          "cancel it in B/A first.",
                          a=_shared(a, b))
    solved = _refined(M, right) / columns
    e = degree - n + 1
    E = solved[:e] / scale ** np.arange(e - 1, -1.0, -1.0)
    F = solved[e:] / scale ** np.arange(n - 1, -1.0, -1.0)
    return Diophantine(a, b, E, F, phi, _residual(a, b, E, F, phi), condition)


def _refined(M: np.ndarray, right: np.ndarray) -> np.ndarray:
    """M⁻¹ right with two steps of iterative refinement, so that small coefficients of A E + B F are right too."""
    solved = np.linalg.solve(M, right)
    for _ in range(2):
        left = (right - M.astype(np.longdouble) @ solved).astype(float)
        solved = solved + np.linalg.solve(M, left)
    return solved


def _trimmed(polynomial: object, name: str) -> np.ndarray:
    p = coefficients(polynomial, name)
    if not p.size:
        raise EngineError("{name} must be a polynomial that is not zero.", name=name)
    return p


def _frequency(phi: np.ndarray) -> float:
    """The geometric mean of the roots that are not zero: where all powers of s weigh alike."""
    kept = np.trim_zeros(phi, "b")
    return float((abs(kept[-1]) / abs(kept[0])) ** (1 / max(len(kept) - 1, 1))) or 1.0


def _shared(a: np.ndarray, b: np.ndarray) -> str:
    poles, zeros = polynomial_roots(a), polynomial_roots(b)
    if not len(zeros):
        return phrase("unknown")
    gap = np.abs(poles[:, None] - zeros[None]) / np.maximum(np.abs(poles)[:, None], MIN_POLE)
    p = poles[np.unravel_index(gap.argmin(), gap.shape)[0]]
    return f"{p.real:.4g}" if abs(p.imag) <= 1e-9 * abs(p) else f"{p.real:.4g} ± {abs(p.imag):.4g}j"


def _residual(a: np.ndarray, b: np.ndarray, E: np.ndarray, F: np.ndarray, phi: np.ndarray) -> float:
    """Largest coefficient of A E + B F − Φ beside the sum of the sizes of its terms, nothing rounded on the way."""
    ratios = [[float(c).as_integer_ratio() for c in p] for p in (a, b, E, F, phi)]
    bits = max(under.bit_length() for p in ratios for _, under in p)  # every coefficient is a whole number of 2^-bits
    x, y, e, f, right = ([over * ((1 << bits) // under) for over, under in p] for p in ratios)
    gap = [-c << bits for c in right]
    size = [abs(c) for c in gap]
    for left, factor in ((x, e), (y, f)):
        first = len(phi) - (len(left) + len(factor) - 1)
        for i, c in enumerate(left):
            for j, d in enumerate(factor):
                gap[first + i + j] += c * d
                size[first + i + j] += abs(c * d)
    return max((abs(g) / s for g, s in zip(gap, size, strict=True) if s), default=0.0)
