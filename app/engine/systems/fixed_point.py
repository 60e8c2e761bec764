"""Compute in fixed point with Python integers, as arrays of numbers · 2^bits."""

from __future__ import annotations

from math import frexp, ldexp

import numpy as np

__all__ = ["fixed", "number", "product", "whole"]


def whole(x: float, bits: int) -> int:
    """x · 2^bits, rounded down."""
    mantissa, exponent = frexp(x)
    shift = bits + exponent - 53
    digits = int(ldexp(mantissa, 53))
    return digits << shift if shift >= 0 else digits >> -shift


def fixed(M: np.ndarray, bits: int) -> np.ndarray:
    """M · 2^bits, entry by entry: an object array of the shape of M."""
    out = np.empty(M.shape, dtype=object)
    out.flat[:] = [whole(x, bits) for x in M.ravel().tolist()]
    return out


def number(re: np.ndarray, im: np.ndarray, bits: int) -> np.ndarray:
    """(re + j im) / 2^bits in complex doubles."""
    one = 1 << bits
    return (re / one).astype(float) + 1j * (im / one).astype(float)


def product(A: np.ndarray, B: np.ndarray, bits: int) -> np.ndarray:
    """A B of two matrices of that fixed point, rounded down once."""
    return (A @ B) >> bits
