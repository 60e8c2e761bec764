"""Write numbers as a language does, and the symbols of signals and units as formulas have them."""

from __future__ import annotations

import re
from decimal import Decimal
from numbers import Number as Written
from types import MappingProxyType

from .languages import decimal_sign

__all__ = ["GREEK", "LOWERED", "Written", "format_number", "has_powers", "squared_unit", "subscript", "superscript", "symbol"]

TO_SUPERSCRIPT = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
EXPONENT_NUMBER = re.compile(r"(\d+(?:\.\d+)?)e([+-]\d+)")
WRITTEN_OUT_POWERS = range(-3, 5)  # powers of ten that are written out
BESIDE = range(-3, 4)  # and those where another number of the sentence is written as a power of ten
SENTENCE_DIGITS = 4  # digits of a number in a sentence whose format asks for as many as it has: 60.97 of 60.9685
LARGE_NUMBER, INFINITE = 1e6, float("inf")  # from here on decimals would only be noise: −4.37·10¹⁰ instead of −43718053745.3
NEGATIVE_ZERO = re.compile(r"-(?=0(?:\.0*)?(?:e[+-]00)?%?$)")  # −0.04 rounded to one decimal is 0.0
POWERS = re.compile("10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]")
LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
GREEK = MappingProxyType({"theta": "θ", "omega": "ω", "phi": "φ", "alpha": "α", "beta": "β"})


def superscript(number: int | str) -> str:
    """Digits as a superscript: −15 → ⁻¹⁵."""
    return str(number).translate(TO_SUPERSCRIPT)


def has_powers(words: str) -> bool:
    """Whether a sentence has a number in powers of ten; then it writes out none of five digits: 1.01·10⁵ ± 10⁴."""
    return POWERS.search(words) is not None


def format_number(value: object, spec: str = "", language: str = "en", *, beside_powers: bool = False) -> str:
    """A number in a format of Python's, as the language writes it: −2.5, 1200, 3·10⁻⁶, ∞; 2,5 where the sign is a comma.

    Of a number rounded to less than its digits 12300 is written, but 1.23·10⁴ beside powers of ten.
    """
    plain = BESIDE if beside_powers else WRITTEN_OUT_POWERS
    if spec.endswith("f") and isinstance(value, (int, float)) and LARGE_NUMBER <= abs(value) < INFINITE:
        spec = ".3g"
    if spec == "g" and isinstance(value, (int, float)) and "." in f"{value:g}":
        spec = f".{SENTENCE_DIGITS}g"
    written = NEGATIVE_ZERO.sub("", format(value, spec))
    words = EXPONENT_NUMBER.sub(lambda found: _power(found, plain), written).replace("-", "−").replace("inf", "∞")
    sign = decimal_sign(language)
    if sign == "." or "." not in words:
        return words
    return words.replace(",", "\N{NARROW NO-BREAK SPACE}").replace(".", sign)


def _power(found: re.Match[str], plain: range) -> str:
    mantissa, power = found[1], int(found[2])
    if power in plain:
        return f"{Decimal(f'{mantissa}e{power}'):f}"
    return ("" if mantissa == "1" else f"{mantissa}·") + "10" + superscript(power)


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
