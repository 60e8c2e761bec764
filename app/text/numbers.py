"""Numbers as a language writes them: true minus, powers of ten, the decimal sign."""

from __future__ import annotations

import re
from decimal import Decimal
from numbers import Number as Written

from .languages import decimal_sign

__all__ = ["Written", "raised", "written"]

RAISED = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
POWER = re.compile(r"(\d+(?:\.\d+)?)e([+-]\d+)")
PLAIN = range(-3, 5)  # powers of ten that are written out


def raised(number: int | str) -> str:
    """Digits as a superscript: −15 → ⁻¹⁵."""
    return str(number).translate(RAISED)


def written(value: object, spec: str = "", language: str = "en") -> str:
    """A number in a format of Python's, as the language writes it: −2.5, 1200, 3·10⁻⁶, ∞; 2,5 where the sign is a comma."""
    words = POWER.sub(_power, format(value, spec)).replace("-", "−").replace("inf", "∞")
    sign = decimal_sign(language)
    if sign == "." or "." not in words:
        return words
    return words.replace(",", "\N{NARROW NO-BREAK SPACE}").replace(".", sign)


def _power(found: re.Match[str]) -> str:
    mantissa, power = found[1], int(found[2])
    if power in PLAIN:
        return f"{Decimal(f'{mantissa}e{power}'):f}"
    return ("" if mantissa == "1" else f"{mantissa}·") + "10" + raised(power)
