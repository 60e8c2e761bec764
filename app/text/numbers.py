"""Numbers as a language writes them: true minus, powers of ten, the decimal sign."""

from __future__ import annotations

import re
from decimal import Decimal
from numbers import Number as Written

from .languages import decimal_sign

__all__ = ["Written", "has_powers", "raised", "written"]

RAISED = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
POWER = re.compile(r"(\d+(?:\.\d+)?)e([+-]\d+)")
PLAIN = range(-3, 5)  # powers of ten that are written out
BESIDE = range(-3, 4)  # and those where another number of the sentence is written as a power of ten
SHORT = 4  # digits of a number in a sentence whose format asks for as many as it has: 60.97 of 60.9685
LARGE, INFINITE = 1e6, float("inf")  # from here on decimals would only be noise: −4.37·10¹⁰ instead of −43718053745.3
POWERS = re.compile("10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]")


def raised(number: int | str) -> str:
    """Digits as a superscript: −15 → ⁻¹⁵."""
    return str(number).translate(RAISED)


def has_powers(words: str) -> bool:
    """Whether a sentence has a number in powers of ten; then it writes out none of five digits: 1.01·10⁵ ± 10⁴."""
    return POWERS.search(words) is not None


def written(value: object, spec: str = "", language: str = "en", *, beside_powers: bool = False) -> str:
    """A number in a format of Python's, as the language writes it: −2.5, 1200, 3·10⁻⁶, ∞; 2,5 where the sign is a comma.

    Of a number rounded to less than its digits 12300 is written, but 1.23·10⁴ beside powers of ten.
    """
    plain = BESIDE if beside_powers else PLAIN
    if spec.endswith("f") and isinstance(value, (int, float)) and LARGE <= abs(value) < INFINITE:
        spec = ".3g"
    if spec == "g" and isinstance(value, (int, float)) and "." in f"{value:g}":
        spec = f".{SHORT}g"
    words = POWER.sub(lambda found: _power(found, plain), format(value, spec)).replace("-", "−").replace("inf", "∞")
    sign = decimal_sign(language)
    if sign == "." or "." not in words:
        return words
    return words.replace(",", "\N{NARROW NO-BREAK SPACE}").replace(".", sign)


def _power(found: re.Match[str], plain: range) -> str:
    mantissa, power = found[1], int(found[2])
    if power in plain:
        return f"{Decimal(f'{mantissa}e{power}'):f}"
    return ("" if mantissa == "1" else f"{mantissa}·") + "10" + raised(power)
