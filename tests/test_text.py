"""Words: every message has its translation, with the same places; numbers are written as a language writes them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from babel.messages.pofile import read_po
from catalogues import places, said, unreadable

import observer_lab
from observer_lab.engine import EngineError, Plant, RiccatiError, lqr
from observer_lab.text import (
    NO_WORDS,
    Text,
    error_words,
    format_number,
    joined,
    languages,
    listed,
    name_of,
    same,
    superscript,
    text,
    text_in,
)
from observer_lab.text.languages import catalogue, decimal_sign
from observer_lab.text.message import COUNTED, IRREGULAR, NOUNS

OTHERS = [code for code in languages() if code != "en"]
HAN = re.compile(r"[\u4e00-\u9fff]")


def translations(language: str) -> dict[tuple[str, str], str]:
    return {(m.context or "", str(m.id)): str(m.string) for m in catalogue(language) if m.id}


def test_every_message_is_written_out_where_it_is_said() -> None:
    assert not list(unreadable())


@pytest.mark.parametrize("language", OTHERS)
def test_every_message_is_translated_and_no_translation_is_left_over(language: str) -> None:
    known, needed = translations(language), said()
    assert len(needed) > 500
    missing = [f"{needed[key]}: {key}" for key in sorted(set(needed) - set(known))]
    left = sorted(set(known) - set(needed))
    assert not missing, "\n".join(missing)
    assert not left, "\n".join(map(str, left))


@pytest.mark.parametrize("language", OTHERS)
def test_no_message_is_translated_in_two_ways(language: str) -> None:
    """Two catalogues that say different things of one English word: one of them wants a context, or the other's words."""
    seen: dict[tuple[str, str], set[str]] = {}
    for path in (Path(observer_lab.__file__).parent / "locale" / language).glob("*.po"):
        for message in read_po(path.read_text(encoding="utf-8").splitlines(keepends=True)):
            if message.id and message.string:
                seen.setdefault((message.context or "", str(message.id)), set()).add(str(message.string))
    assert {key: words for key, words in seen.items() if len(words) > 1} == {}


@pytest.mark.parametrize("language", OTHERS)
def test_a_translation_has_the_places_of_its_message_and_no_others(language: str) -> None:
    """A place may be left out where only English needs it (the s of a plural); none may be added."""
    wrong = []
    for (_, english), other in translations(language).items():
        if (places(english) or "{" in other.replace("{{", "")) and not places(other) <= places(english):
            wrong.append(f"{english!r}: {places(other) - places(english)}")
        lost = {name for name in places(english) - places(other) if name not in ("s", "es", "ies")}
        if lost:
            wrong.append(f"{english!r} loses {lost}")
    assert not wrong, "\n".join(wrong)


VERBS = frozenset((
    "as", "computes", "cuts", "delivers", "differs", "does", "estimates", "fails", "follows", "gives", "goes", "has", "holds",
    "is", "keeps", "lacks", "leads", "lies", "minus", "ms", "needs", "others", "says", "stands", "stays", "takes", "times",
    "was", "watches", "yes", "yours"))


def test_no_plural_verb_stands_behind_a_count_that_may_be_one() -> None:
    """The noun of `{n} samples are …` turns singular, its verb does not; a count that is many by what it tells may have one."""
    plural = re.compile(r"(?<!of its )\{\w+(?::[^{}]*)?\} (?P<noun>[a-z]+s) (?:are|have|were|do)\b")
    found = {english for _, english in said() for it in plural.finditer(english) if it["noun"] in NOUNS | IRREGULAR.keys()}
    assert {english for english in found if "too many" not in english and "more than" not in english and "{most}" not in english} == set()


def test_a_noun_behind_a_number_is_known_so_that_one_of_it_is_singular() -> None:
    """`{n} samples` says "1 sample" where n is 1; a new noun wants its place in app/text/message.py."""
    behind = {found["noun"]: english for _, english in said() for found in COUNTED.finditer(english)}
    assert {noun: english for noun, english in behind.items() if noun not in NOUNS | IRREGULAR.keys() | VERBS} == {}
    late = text("arrive {late} samples late", late=1)
    assert late() == "arrive 1 sample late" and late.format(late=2)() == "arrive 2 samples late" and "1" in late("zh")
    assert text("x0 must have {n} entries.", n=np.int64(1))() == "x0 must have 1 entry."
    assert text("{who} runs, {n:.1f} steps", who="1", n=1.0)() == "1 runs, 1.0 steps"


def test_a_message_is_a_record_of_its_id_and_values() -> None:
    message = text("{name} has {n:d} states, gain {k:.3g}.", name=same("P"), n=3, k=-1.25e-7)
    assert message == text("{name} has {n:d} states, gain {k:.3g}.", name=same("P"), n=3, k=-1.25e-7)
    assert hash(message) == hash(Text(message.id, message.values))
    assert message("en") == "P has 3 states, gain −1.25·10⁻⁷."


def test_one_english_word_with_two_meanings_has_a_context() -> None:
    assert text_in("axis", "rank").context == "axis" and text_in("axis", "rank") != text("rank")


@pytest.mark.parametrize("value, spec, words", [
    (-2.5, "g", "−2.5"), (1200.0, ".2g", "1200"), (3e-6, ".3g", "3·10⁻⁶"), (1e-15, ".0e", "10⁻¹⁵"), (np.inf, "g", "∞"),
    (-np.inf, "g", "−∞"), (7, "", "7"), (np.float64(0.25), ".2f", "0.25"), (-1 - 2j, ".3g", "−1−2j"), (1e6, ".3g", "10⁶"),
    (0.5, ".0%", "50%"), (-43718053745.3, ".1f", "−4.37·10¹⁰"), (123456.7, ".1f", "123456.7"), (-0.0014, ".2g", "−0.0014"),
    (-0.04, ".1f", "0.0"), (-0.0, ".3g", "0"), (-0.0, "g", "0"), (-0.06, ".1f", "−0.1"), (-0.0, "+.1f", "0.0"),
    (60.9685, "g", "60.97"), (31250.5, "g", "31250"), (147258.0, "g", "147258"), (0.0295, "g", "0.0295"),
])
def test_one_formatter_writes_numbers(value: complex, spec: str, words: str) -> None:
    assert format_number(value, spec) == words


def test_no_number_of_five_digits_stands_beside_one_in_powers_of_ten() -> None:
    """As in "1.01·10⁵ ± 10000", which the lesson on nonlinear filters said."""
    both = text("{times:.3g} ± {unsure:.1g}", times=101234.0, unsure=1e4)
    assert both("en") == both("zh") == "1.01·10⁵ ± 10⁴"
    rare, many = text("It costs {cost:.3g}.", cost=68500.0), text("One in {share:.2g}.", share=3e-7)
    assert rare("en") == "It costs 68500." and joined(rare, many)("en") == "It costs 6.85·10⁴. One in 3·10⁻⁷."
    assert joined(many, text("All {all}.", all=listed([rare, both])))("en").endswith("It costs 6.85·10⁴., 1.01·10⁵ ± 10⁴.")


def test_the_decimal_sign_is_the_languages() -> None:
    assert decimal_sign("de") == "," and format_number(1234.5, ",.1f", "de") == "1\N{NARROW NO-BREAK SPACE}234,5"
    assert decimal_sign("en") == decimal_sign("zh") == decimal_sign("xx-none") == "."


def test_a_language_names_itself() -> None:
    assert (name_of("en"), name_of("zh"), name_of("de")) == ("English", "中文", "Deutsch")


def test_sentences_are_joined_as_a_language_joins_them() -> None:
    both = joined(text("Nothing to undo."), NO_WORDS, text("Nothing to redo."))
    assert both("en") == "Nothing to undo. Nothing to redo." and " " not in both("zh")
    assert joined() == NO_WORDS and NO_WORDS("zh") == ""
    assert listed([same("a"), same("b"), same("c")])("en") == "a, b, c" and listed([same("a"), same("b")])("zh") == "a、b"


def test_an_error_of_the_engine_carries_its_message_and_values() -> None:
    with pytest.raises(EngineError) as caught:
        Plant([[1.0, 2.0]], [[1.0]], [[1.0]])
    assert str(caught.value) == "A must be square; it is 1×2."
    assert error_words(caught.value)("zh") == "A 必须是方阵，现为 1×2。"
    with pytest.raises(RiccatiError) as deep:
        lqr([[1, 0], [0, 2]], [[0], [1]], np.eye(2), [[1]])
    assert HAN.search(error_words(deep.value)("zh")) and "unc" not in error_words(deep.value)("zh")


def test_an_error_survives_a_copy_between_processes() -> None:
    import pickle

    problem = EngineError("{name} must be a list of numbers.", name="A")
    again = pickle.loads(pickle.dumps(problem))
    assert (str(again), again.message, dict(again.values)) == (str(problem), problem.message, {"name": "A"})


def test_raised_digits() -> None:
    assert superscript(-15) == "⁻¹⁵"
