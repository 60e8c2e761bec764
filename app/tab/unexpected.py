"""What an error says that nobody foresaw: its kind, in words. The sentence of a library would help nobody here."""

from __future__ import annotations

from types import MappingProxyType

from ..text import Text, text

KINDS = MappingProxyType({
    "LinAlgError": text("a matrix is singular or an iteration did not converge"),
    "ZeroDivisionError": text("a division by zero"),
    "OverflowError": text("a number grew too large"),
    "FloatingPointError": text("a number is no longer finite"),
    "MemoryError": text("not enough memory"),
    "RecursionError": text("the input is nested too deeply"),
})


def kind_of(problem: BaseException) -> Text:
    """What kind of error this is, in a few words of both languages; its class is named where that is all there is."""
    name = type(problem).__name__
    return KINDS.get(name, text("an error in the program, {name}", name=name))
