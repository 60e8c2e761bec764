"""Put an English noun into the singular behind a count of one."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

from .numbers import Written, format_number

__all__ = ["IRREGULAR", "NOUNS", "singular_if_one"]

COUNTED = re.compile(r"\{(?P<name>\w+)(?::(?P<spec>[^{}]*))?\} (?P<noun>[a-z]+s)\b")
IRREGULAR = MappingProxyType({"axes": "axis", "entries": "entry", "frequencies": "frequency"})
NOUNS = frozenset((
    "changes", "channels", "characters", "columns", "counts", "decimals", "designs", "dimensions", "directions", "gains",
    "inputs", "lessons", "members", "names", "numbers", "outputs", "perturbations", "pixels", "places", "points", "poles", "predictions",
    "readings", "rows", "runs", "samples", "scenes", "seconds", "seeds", "starts", "states", "steps", "stops", "votes",
    "windows", "years", "zeros"))


def singular_if_one(template: str, values: Mapping[str, object]) -> str:
    """An English template, in which a noun behind a count of one stands in the singular."""
    def noun(found: re.Match[str]) -> str:
        value, words = values.get(found["name"]), found["noun"]
        one = words in NOUNS or words in IRREGULAR
        if not one or not isinstance(value, Written) or format_number(value, found["spec"] or "") != "1":
            return found[0]
        return found[0].removesuffix(words) + IRREGULAR.get(words, words[:-1])
    return COUNTED.sub(noun, template)
