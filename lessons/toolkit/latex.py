"""Write gains and poles for live formulas and sentences."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from observer_lab.course.figures.latex import MOST_ENTRIES, matrix, number
from observer_lab.text import superscript


def tiny(value: float) -> str:
    """The order of magnitude of a rounding error as words: 10⁻¹⁵, or 0."""
    if value == 0 or not np.isfinite(value):
        return "0" if value == 0 else "∞"
    return "10" + superscript(round(float(np.log10(abs(value)))))


def gain_words(symbol: str, M: np.ndarray) -> str:
    """A gain as LaTeX: its entries, or its size where they are too many to read."""
    return rf"{symbol} = {matrix(M)}" if M.size <= MOST_ENTRIES else rf"\| {symbol} \| = {number(float(np.linalg.norm(M, 2)))}"


def pole_words(poles: Sequence[complex]) -> str:
    """Poles as words: −4 ± 5j, −2."""
    near = [(p, 1e-6 * abs(p)) for p in poles]  # a double pole comes back split by the root of rounding
    names = [f"{p.real:.3g}" if abs(p.imag) <= tiny else f"{p.real:.3g} ± {p.imag:.3g}j" for p, tiny in near if p.imag >= -tiny]
    return ", ".join(names).replace("-", "−")
