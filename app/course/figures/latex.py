"""Write numbers and matrices as LaTeX for live formulas."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...colours import COLOURS

MOST_ENTRIES = 24  # of a matrix that is written out


def number(value: float, digits: int = 3) -> str:
    """A number for a live formula: short, with a true minus sign, powers of ten only where they help."""
    if value == 0 or not np.isfinite(value):
        return "0" if value == 0 else r"\infty"
    if abs(value) >= 10 ** max(5, digits) or abs(value) < 10 ** -min(digits, 4):
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return rf"{float(mantissa):g} \cdot 10^{{{int(exponent)}}}"
    short = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e" in short else short


def matrix(M: np.ndarray, digits: int = 3, changed: Sequence[tuple[int, int]] = ()) -> str:
    """A matrix as LaTeX with its present entries; `changed` ones stand out."""
    def entry(i: int, j: int) -> str:
        words = number(float(M[i, j]), digits)
        return rf"\color{{{COLOURS['estimate']}}}{{{words}}}" if (i, j) in changed else words
    rows = r" \\ ".join(" & ".join(entry(i, j) for j in range(M.shape[1])) for i in range(M.shape[0]))
    return rf"\begin{{bmatrix}} {rows} \end{{bmatrix}}"
