"""What an error says that nobody foresaw: its kind, in words. The sentence of a library would help nobody here."""

from __future__ import annotations

from types import MappingProxyType

from ..engine import EngineError
from ..lesson.knobs import KnobError
from ..text import Text, text, told

NOT_DONE = text("That could not be done ({kind}); everything stays as it was.")
BROKEN = text("The lesson could not compute this design ({kind}); the last good picture stays. Undo or change a knob.")
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


def refusal(problem: BaseException, command: bool) -> Text:
    """Why something was not done: in the words of the lesson or the engine, else that a command or a design failed, and how."""
    if isinstance(problem, (EngineError, KnobError)):
        return told(problem)
    return (NOT_DONE if command else BROKEN).format(kind=kind_of(problem))
