"""How small a p-value is, in words: one that rounding takes for zero is below something."""

from __future__ import annotations

from app.text import Text, text, written

LEAST = 1e-300  # below it floating point runs out


def chance(p: float) -> str:
    """A p-value for a table."""
    return "< 10⁻³⁰⁰" if p < LEAST else written(p, ".2g")


def coloured(p: float) -> Text:
    """What is said of innovations that are not white."""
    if p < LEAST:
        return text("Coloured: p is below 10⁻³⁰⁰; each sample foretells the next.")
    return text("Coloured: p = {p_value:.1e}; each sample foretells the next.", p_value=p)
