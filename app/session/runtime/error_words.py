"""Describe an unforeseen error to the user by its kind, in plain words."""

from __future__ import annotations

from types import MappingProxyType

from ...course.knobs import KnobError
from ...engine import EngineError
from ...text import Text, error_words, text

NOT_DONE = text("That could not be done ({kind}); everything stays as it was.")
DESIGN_FAILED = text("The lesson could not compute this design ({kind}); the last good picture stays. Undo or change a knob.")
KEPT = text("{why} Your plant is kept for the lessons that take it.")
ERROR_KINDS = MappingProxyType({
    "LinAlgError": text("a matrix is singular or an iteration did not converge"),
    "ZeroDivisionError": text("a division by zero"),
    "OverflowError": text("a number grew too large"),
    "FloatingPointError": text("a number is no longer finite"),
    "MemoryError": text("not enough memory"),
    "RecursionError": text("the input is nested too deeply"),
})


def error_kind(problem: BaseException) -> Text:
    """What kind of error this is, in a few words of both languages; its class is named where that is all there is."""
    name = type(problem).__name__
    return ERROR_KINDS.get(name, text("an error in the program, {name}", name=name))


def refusal_message(problem: BaseException, command: bool) -> Text:
    """Why something was not done: in the words of the lesson or the engine, else that a command or a design failed, and how."""
    if isinstance(problem, (EngineError, KnobError)):
        return error_words(problem)
    return (NOT_DONE if command else DESIGN_FAILED).format(kind=error_kind(problem))


def kept_for_others(problem: BaseException) -> Text:
    """Why a lesson does not show a person's plant, and that the other lessons still have it."""
    return KEPT.format(why=refusal_message(problem, command=False))
