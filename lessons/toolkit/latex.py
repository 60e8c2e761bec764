"""Write gains, poles, shares and ratios for live formulas and sentences."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from observer_lab.course.figures.latex import MOST_ENTRIES, matrix, number
from observer_lab.text import Text, format_number, same, superscript, text


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


def percent(share: float) -> Text:
    """A share of 0 … 1 in per cent to three digits: "99.5", "100" only for all of it, "0" only for none."""
    value = 100 * share
    if 0 < value < 0.1:
        return text("less than 0.1")
    if 99.9 < value < 100 - 1e-9:
        return text("more than 99.9")
    return same(format_number(value, ".3g"))


MAX_PERCENT = 1000.0  # beyond it a multiple is said


def more(change: float) -> Text:
    """A relative change with its direction: "4 % larger", "0.3 % smaller", "larger by a factor of 26"."""
    if change >= MAX_PERCENT / 100:
        return text("larger by a factor of {times:.2g}", times=change + 1)
    return text("{change:.2g} % larger", change=100 * change) if change >= 0 else text("{change:.2g} % smaller", change=-100 * change)


def apart(share: float) -> Text:
    """A relative difference: "4 %", or "a factor of 671"."""
    return text("{share:.2g} %", share=100 * share) if 100 * share <= MAX_PERCENT else text("a factor of {times:.3g}", times=share + 1)
