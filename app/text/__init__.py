"""Translate messages: English with named values, and gettext catalogues for other languages.

`text("Largest input applied: {peak:.3g} {unit}.", peak=peak, unit=unit)` gives a frozen record; called with a language it
is a sentence. The English is the id that translators see.
"""

from .languages import languages
from .message import NO_WORDS, SaidError, Text, error_words, joined, label_in_language, listed, name_of, same, text, text_in
from .numbers import format_number, squared_unit, subscript, superscript, symbol
from .outside_files import OutsideFileError, read_outside_bytes, read_outside_json, read_outside_toml, replace_surrogates

__all__ = [
    "NO_WORDS",
    "OutsideFileError",
    "SaidError",
    "Text",
    "error_words",
    "format_number",
    "joined",
    "label_in_language",
    "languages",
    "listed",
    "name_of",
    "read_outside_bytes",
    "read_outside_json",
    "read_outside_toml",
    "replace_surrogates",
    "same",
    "squared_unit",
    "subscript",
    "superscript",
    "symbol",
    "text",
    "text_in",
]
