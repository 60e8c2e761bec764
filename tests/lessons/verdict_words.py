"""The verdict words of the pages: what each needs to be said, and what voids it.

A live sentence, caption, check or task's answer that holds one of these words is put before a witness in `verdict_witnesses*.py`.
A sentence with such a word and without a witness fails the law as well.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class VerdictWord:
    """A word of verdicts: how it is found in a sentence, the condition under which it may be said, and what voids it."""

    pattern: re.Pattern[str]
    condition: str
    voided_by: str


def _word(pattern: str, condition: str, voided_by: str) -> VerdictWord:
    return VerdictWord(re.compile(pattern, re.I), condition, voided_by)


VERDICT_WORDS: Mapping[str, VerdictWord] = MappingProxyType(
    {
        "unstable": _word(
            r"\bunstable\b|not in the left half plane|outside the unit circle",
            "the matrix of the loop that is run has a pole on or beyond the edge; said before all else",
            "rounding at the edge",
        ),
        "stable": _word(
            r"(?<!un)\bstable\b",
            "every pole of the loop that is run lies inside, delay and order of arrival counted",
            "delay, arrival order, limit",
        ),
        "grows": _word(
            r"\bgrows?\b|\bgrew\b|not all decay|does not decay|does not die",
            "the longer run is larger at its end",
            "zero size, noise, a kick at the end",
        ),
        "decays": _word(
            r"(?<!not )\b(?:decays?|dies down|dies|died)\b(?! down the)",
            "the longer run, without further kicks, falls below 2 % of its peak",
            "kick, wrong input, noise, instability",
        ),
        "settles": _word(
            r"\bsettle[sd]?\b|stays below|below 2 %|exceeds 2 %",
            "from the named time on, in three times the run, it stays in the named band",
            "noise, kick, instability",
        ),
        "recovers": _word(
            r"\brecovers?\b|\brecovered\b",
            "the limited run, followed until no limit acts again, comes to rest",
            "nothing: it is what is run, limit and kick included",
        ),
        "lost": _word(
            r"\blost\b|\bfalls?\b(?! below| by| as)|\bfallen\b",
            "the state has left the set from which any input could bring it back, or passed 45°",
            "the end of the run",
        ),
        "not decided": _word(r"not decided|does not decide|not yet", "neither of both is proved within the longest run", "nothing"),
        "bounded": _word(
            r"\bbounded\b|stays finite|without bound",
            "mean squares over many seeds, where the error is measured",
            "delay, order of arrival",
        ),
        "consistent": _word(
            r"\b(?:in)?consistent\b|the filter's own \dσ|in the χ² band|within \d√S|\bflagged\b",
            "NEES lies in its band as often as it should, NIS and whiteness agree",
            "few runs, a fit on the same data",
        ),
        "over-confident": _word(r"over-?confident|too small a covariance", "mean NEES is above its band", "few runs, lost runs"),
        "under-confident": _word(r"under-?confident|larger covariance than", "mean NEES is below its band", "few runs"),
        "white": _word(
            r"\bwhite(?:ness)?\b(?! ground| noise| displacement)",
            "correlations of innovations within their band",
            "parameters fitted to the same record",
        ),
        "follows": _word(
            r"\b(?:error|ε\||e) (?:still )?(?:follows|obeys|departs)|still follows|obeys A|leaves its|no longer autonomous|are autonomous",
            "the run's error and e^{(A−LC)t} e(0) agree to rounding, started anew after a kick",
            "kick, limit, noise, another model",
        ),
        "least": _word(
            r"(?<!at )\bleast\b(?! eigenvalue| \d| of |:)|\bbest\b|\bsmallest\b|no smaller|no filter has|optimal\b",
            "over all that is run, with its limits and friction, none named and the rest larger",
            "limit, friction, equal rivals",
        ),
        "identified": _word(
            r"\bidentified\b|diagnos\w+|is faulty|\bisolated\b|names no|detected\b",
            "the named part is the faulty one, after the fault",
            "no fault, before it",
        ),
        "found": _word(
            r"\bfound (?:to|after|for|within)\b|is not found|is known within|is never known|\bknown (?:after|within|to)",
            "from that time on the error stays in the band",
            "kick, noise, zero size",
        ),
        "unaffected": _word(
            r"unaffected|has no effect|does not depend|moves nothing|stays as it is",
            "two runs that differ in the cause alone agree to rounding",
            "noise, limit",
        ),
        "observable": _word(
            r"\b(?:un|not )?observable\b|\bhidden\b|\bfixed mode", "rank and distance by singular values of [λI − A; C]", "rounding"
        ),
        "tolerated": _word(r"\btolerat\w+|\bcan be lost\b", "the loop with that change is still stable", "several changes at once"),
    }
)


def words_in(sentence: str) -> tuple[str, ...]:
    """The verdict words of a sentence."""
    return tuple(name for name, word in VERDICT_WORDS.items() if word.pattern.search(sentence))
