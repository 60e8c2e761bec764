"""Write p-values in words and numbers, also those that rounding takes for zero."""

from __future__ import annotations

from observer_lab.text import Text, format_number, text

MIN_P_VALUE = 1e-300  # below it floating point runs out


def chance(p: float) -> str:
    """A p-value for a table."""
    return "< 10⁻³⁰⁰" if p < MIN_P_VALUE else format_number(p, ".2g")


def coloured(p: float) -> Text:
    """What is said of innovations that are not white."""
    if p < MIN_P_VALUE:
        return text("Coloured: p is below 10⁻³⁰⁰; each sample foretells the next.")
    return text("Coloured: p = {p_value:.1e}; each sample foretells the next.", p_value=p)
