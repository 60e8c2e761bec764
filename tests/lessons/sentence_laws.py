"""Laws over one sentence that a page says of a design: numbers, units, shares, and a loop called stable that is not."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

from observer_lab.course.lesson import Outcome
from observer_lab.course.sentences import Sentence

Law = Callable[[str, Outcome], bool]  # whether a sentence, without its formulas, breaks it

SHARED = (r"time|runs?|samples?|records?|states?|cases|designs|windows|packets|losses|starts|readings|variance|energy|pairs|trials|"
          r"measurements|commands|the run|the covariance")
RAW = re.compile(r"\d[eE][+−-]?\d|(?<![\w.^_{-])-\.?\d|[+−-] ?[+−-]\d|\d{8,}|\d+\.\d{9,}")
SHARE = re.compile(rf"(\d[\d,.]*) % of (?:the |all |its )?(?:{SHARED})\b")
LARGE = re.compile(r"(\d[\d,]*(?:\.\d+)?|\d+(?:\.\d+)?·10[⁰¹²³⁴⁵⁶⁷⁸⁹]+) ?%")
FORMULA = re.compile(r"\$\$.+?\$\$|\$[^$\n]+\$|`[^`\n]+`", re.S)
STABLE = re.compile(r"^(?:The|This) (?:whole |closed )?loop (?:is|stays) stable\b", re.I)
UNSTABLE = re.compile(r"^(?:The|This) (?:whole |closed )?loop is unstable\b|^Unstable:", re.I)
MAX_PERCENT = 1000.0  # beyond it a sentence says "times"
GROWTH = MappingProxyType({"stable": lambda v: v > 0.5, "slowest_loop": lambda v: v < 0.0, "loop_radius": lambda v: v < 1.0,
                           "rightmost": lambda v: v < 0.0})  # what a metric says of the loop
ABOUT_NOW = re.compile(r"live|figure\.[\w-]+\.caption|check\.|formula\.|task\.[\w-]+\.verdict")  # not words that stay as they are
OF_NOW = ("a place without its value", "an unstable loop called stable", "a stable loop called unstable")
EDGE = 1e-6  # a loop so near to the edge of stability is neither


def percent(words: str) -> float:
    """The number before a per cent sign."""
    digits = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")
    mantissa, _, power = words.replace(",", "").partition("·10")
    return float(mantissa) * 10.0 ** int(power.translate(digits) or 0)


def loop_is_stable(outcome: Outcome) -> bool | None:
    """Whether the loop of the outcome is stable, None where no metric says so or it is at the edge."""
    for name, stable in GROWTH.items():
        if (value := outcome.metrics.get(name)) is not None and math.isfinite(value):
            return stable(value) if name == "stable" or abs(value - (name == "loop_radius")) > EDGE else None
    return None


def _parts(words: str) -> list[str]:
    return re.split(r"(?<=[.:;!?]) ", words)


LAWS: Mapping[str, Law] = MappingProxyType({
    "a number that is none": lambda words, _: bool(re.search(r"(?<!\w)(?:nan|NaN|inf)(?!\w)", words)),
    "a zero with a sign": lambda words, _: bool(re.search(r"[−-]0(?:\.0+)?(?![\d.,]*[\d·])", words)),
    "a number as a computer writes it": lambda words, _: bool(RAW.search(words)),
    "a place without its value": lambda words, _: bool(re.search(r"(?<![\^_])\{\w*(?::[^{}]*)?\}|\[\[\w+\]\]", words)),
    "a blank where a unit is missing": lambda words, _: bool(re.search(r"\S [.;,](?:\s|$)|\(\s*\)", words)),
    "a share over 100 %": lambda words, _: any(percent(share.rstrip(".,")) > 100.0 for share in SHARE.findall(words)),
    "a percentage over 1000": lambda words, _: any(percent(share) > MAX_PERCENT for share in LARGE.findall(words)),
    "a negative more": lambda words, _: bool(re.search(
        r"−\d[\d.,·⁰¹²³⁴⁵⁶⁷⁸⁹⁻]* ?%? (?:larger|smaller|more|less|higher|lower|longer|shorter|better|worse)\b", words)),
    "a share of nothing": lambda words, _: bool(re.search(r"\b0 of 0\b|% of (?:nothing|0)(?![\d.])|∞ %", words)),
    "an unstable loop called stable": lambda words, outcome: loop_is_stable(outcome) is False and any(map(STABLE.search, _parts(words))),
    "a stable loop called unstable": lambda words, outcome: loop_is_stable(outcome) is True and any(map(UNSTABLE.search, _parts(words))),
})


def broken(said: Sentence, outcome: Outcome) -> Iterator[str]:
    """The laws that a sentence breaks; a place of an exam in the prose is filled in when it is asked."""
    words, now = FORMULA.sub("x", said.text), ABOUT_NOW.match(said.where)
    for name, law in LAWS.items():
        if (now or name not in OF_NOW) and law(words, outcome):
            yield name
