"""Sentences about what was done to a plant on its way in, also as codes that a file can carry."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from types import MappingProxyType

from ..systems.errors import EngineError, Phrase, phrase

__all__ = ["coded", "decoded", "note"]

_MOST_NOTES, _LONGEST = 12, 200
_PLAIN = re.compile(r"[\w ,.…]*")
NOTES: Mapping[str, Phrase] = MappingProxyType({
    "descriptor": phrase("The file gives E; the lab uses E⁻¹A and E⁻¹B (condition number of E {condition:.2g})."),
    "pade": phrase("Delays of up to {longest:.3g} s are approximated by Padé fractions of order {order}; this adds {added} states."),
    "samples": phrase("The lab keeps delays of up to {longest} samples exactly and adds {added} states."),
    "minimal": phrase("The file gives a transfer function; the lab realises it with {after} states and cancels {gone} common poles and "
                      "zeros."),
    "realised": phrase("The file gives a transfer function; the lab realises it with {after} states, the least possible number."),
    "not_minimal": phrase("The file gives a transfer function; the lab realises it with {after} states, which may be more than needed."),
    "reduced": phrase("The file has {before} states; balanced truncation reduces them to {after}, with an H∞ error of at most {bound:.2g} "
                      "(largest Hankel value {largest:.2g})."),
    "unused": phrase("Not used from the file: {names}."),
})


def note(kind: str, /, **values: float | int | str) -> Phrase:
    """The sentence of a kind with its values."""
    return Phrase(NOTES[kind].message, **values)


def coded(notes: Iterable[str]) -> list[list[object]]:
    """Notes as JSON may carry them: [kind, values]; a sentence that is none of ours is left out."""
    kinds = {sentence.message: kind for kind, sentence in NOTES.items()}
    return [[kinds[said.message], dict(said.values)] for said in notes if isinstance(said, Phrase) and said.message in kinds]


def decoded(value: object) -> tuple[Phrase, ...]:
    """The notes of `coded`. Raises EngineError for anything else: a file may come from a stranger."""
    if not isinstance(value, list) or len(value) > _MOST_NOTES:
        raise _wrong()
    return tuple(_one(item) for item in value)


def _one(item: object) -> Phrase:
    match item:
        case [str(kind), dict(values)] if kind in NOTES and all(_fits(one) for one in values.values()):
            try:
                return note(kind, **values)
            except (KeyError, ValueError, IndexError, TypeError) as problem:
                raise _wrong() from problem
    raise _wrong()


def _fits(value: object) -> bool:
    return (isinstance(value, str) and len(value) <= _LONGEST and _PLAIN.fullmatch(value) is not None) or (
        isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300)


def _wrong() -> EngineError:
    return EngineError("The key changes is written by the lab itself; remove it from the file.")
