"""Words: a message is English with named values, and every other language a folder of gettext catalogues.

`text("Largest input applied: {peak:.3g} {unit}.", peak=peak, unit=unit)` gives a frozen record; called with a language it
is a sentence. The English is the id that translators see.
"""

from .languages import languages
from .message import NO_WORDS, Text, joined, listed, name_of, same, text, text_in, told, wording
from .numbers import raised, written
from .symbols import lowered, squared, symbol

__all__ = [
    "NO_WORDS",
    "Text",
    "joined",
    "languages",
    "listed",
    "lowered",
    "name_of",
    "raised",
    "same",
    "squared",
    "symbol",
    "text",
    "text_in",
    "told",
    "wording",
    "written",
]
