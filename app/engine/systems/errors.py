"""Errors of the engine: one sentence each, saying what happened and what to change."""


class EngineError(ValueError):
    """Bad input to the engine; the message is a sentence fit to show to a student."""


class ShapeError(EngineError):
    """Matrices whose shapes do not agree."""


class PoleError(EngineError):
    """A request for poles that no gain can meet."""


class RiccatiError(EngineError):
    """A Riccati equation without a stabilising solution."""
