"""Write the symbols of signals and units as formulas have them."""

from __future__ import annotations

from types import MappingProxyType

LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
GREEK = MappingProxyType({"theta": "θ", "omega": "ω", "phi": "φ", "alpha": "α", "beta": "β"})


def subscript(words: str) -> str:
    """Digits as subscripts: σ12 → σ₁₂."""
    return words.translate(LOWERED)


def squared_unit(unit: str) -> str:
    """The square of a unit: A², (m/s)²; 1 where there is none."""
    return "1" if not unit else f"{unit}²" if unit.isalpha() else f"({unit})²"


def symbol(name: str) -> str:
    """The name of a signal as a formula has it: z12 → z₁₂, theta → θ. Other names stay as they are."""
    if name in GREEK:
        return GREEK[name]
    head = name.rstrip("0123456789")
    return head + subscript(name[len(head):]) if 1 <= len(head) <= 2 else name
