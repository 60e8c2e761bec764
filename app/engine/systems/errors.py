"""Define the engine's errors: one sentence that says what is wrong and what to change.

A sentence is a message with named values, `EngineError("A must be square; it is {rows}×{columns}.", rows=2, columns=3)`:
`str()` is the English, and whoever speaks another language has the message and the values to say it with.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType


class Phrase(str):
    """Words that stand within a sentence as a value: in English a string, with the message and values it is made of."""

    message: str
    values: Mapping[str, object]

    def __new__(cls, message: str, /, **values: object) -> Phrase:
        made = super().__new__(cls, message.format_map(values) if values else message)
        made.message, made.values = message, MappingProxyType(values)
        return made

    def __reduce__(self) -> tuple[object, ...]:
        return _again, (type(self), self.message, dict(self.values))


def phrase(message: str, /, **values: object) -> Phrase:
    """Words, such as "The delay", that a language says in its own way within a sentence."""
    return Phrase(message, **values)


class EngineError(ValueError):
    """Bad input to the engine; the message is a sentence fit to show to a student.

    >>> str(EngineError("The step must be positive; it is {dt}.", dt=-1))
    'The step must be positive; it is -1.'
    """

    def __init__(self, message: str, /, **values: object) -> None:
        if isinstance(message, Phrase):
            message, values = message.message, dict(message.values)
        super().__init__(message, values)
        self.message = message
        self.values: Mapping[str, object] = MappingProxyType(values)

    def __str__(self) -> str:
        return self.message.format_map(self.values) if self.values else self.message

    def __reduce__(self) -> tuple[object, ...]:
        return _again, (type(self), self.message, dict(self.values))


def _again(kind: type[EngineError | Phrase], message: str, values: dict[str, object]) -> EngineError | Phrase:
    return kind(message, **values)


class ShapeError(EngineError):
    """Matrices whose shapes do not agree.

    >>> Plant([[0, 1]], [[0], [1]], [[1, 0]])
    Traceback (most recent call last):
    observer_lab.engine.systems.errors.ShapeError: A must be square; it is 1×2.
    """


class PoleError(EngineError):
    """A request for poles that no gain can meet.

    >>> place([[0, 1], [0, 0]], [[0], [1]], [-1, -1 + 1j])
    Traceback (most recent call last):
    observer_lab.engine.systems.errors.PoleError: The complex pole -1 + 1j lacks its conjugate -1 - 1j: ...
    """


class RiccatiError(EngineError):
    """A Riccati equation without a stabilising solution.

    >>> lqr([[1]], [[0]], [[1]], [[1]])
    Traceback (most recent call last):
    observer_lab.engine.systems.errors.RiccatiError: The mode at 1 is not stable and is uncontrollable: no K ...
    """
