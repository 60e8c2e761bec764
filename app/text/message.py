"""Define a message: its English, which is its id, and the values put into it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import reduce
from types import MappingProxyType

from .languages import closed_up, known_name, translated
from .numbers import Written, format_number, has_powers

COUNTED = re.compile(r"\{(?P<name>\w+)(?::(?P<spec>[^{}]*))?\} (?P<noun>[a-z]+s)\b")
IRREGULAR = MappingProxyType({"axes": "axis", "entries": "entry", "frequencies": "frequency"})
NOUNS = frozenset((
    "changes", "channels", "characters", "columns", "counts", "decimals", "designs", "dimensions", "directions", "gains",
    "inputs", "lessons", "members", "names", "numbers", "outputs", "perturbations", "pixels", "places", "points", "poles", "predictions",
    "readings", "rows", "runs", "samples", "scenes", "seconds", "seeds", "starts", "states", "steps", "stops", "votes",
    "windows", "years", "zeros"))


@dataclass(frozen=True)
class Text:
    """A message and its values, turned into a sentence by `message(language)`.

    `id` is the English template with {named:format} places; `context` tells apart two meanings of one English word.
    A value may be a number (written as the language writes numbers), a Text or an error of the engine (said in the
    language), or a string, which carries over as it is.
    """

    id: str
    values: tuple[tuple[str, object], ...] = ()
    context: str = ""

    def __call__(self, language: str = "en") -> str:
        words = self.said(language)
        return self.said(language, beside_powers=True) if self.values and has_powers(words) else words

    def said(self, language: str, *, beside_powers: bool = False) -> str:
        """The sentence; `beside_powers`: as a part of one that has numbers in powers of ten."""
        template = translated(self.id, self.context, language)
        if not self.values:
            return template
        if template == self.id:  # English, or not translated
            template = singular_if_one(template, dict(self.values))
        places = {name: _Place(value, language, beside_powers) for name, value in self.values}
        return closed_up(template.format_map(places), language)

    def __str__(self) -> str:
        return self("en")

    def format(self, **values: object) -> Text:
        """The same message with these values besides those that it has."""
        return Text(self.id, (*self.values, *values.items()), self.context)


class _Place:
    """A value on its way into a sentence: its format is applied in the language of the sentence."""

    def __init__(self, value: object, language: str, beside_powers: bool) -> None:
        self._value, self._language, self._beside_powers = value, language, beside_powers

    def __format__(self, spec: str) -> str:
        value, language, beside = self._value, self._language, self._beside_powers
        if isinstance(value, Text):
            return value.said(language, beside_powers=beside)
        if hasattr(value, "message") and hasattr(value, "values"):
            return error_words(value).said(language, beside_powers=beside)
        if isinstance(value, Written):
            return format_number(value, spec, language, beside_powers=beside)
        return format(value, spec)


def text(message: str, /, **values: object) -> Text:
    """A message with its values by name."""
    return Text(message, tuple(values.items()))


def text_in(context: str, message: str, /, **values: object) -> Text:
    """A message whose English alone does not say what is meant: the context, such as "axis", tells translators."""
    return Text(message, tuple(values.items()), context)


OWN_NAME = text_in("language", "English")  # to be translated by the name of the language itself


def name_of(language: str) -> str:
    """What a language calls itself: English, Deutsch."""
    name = OWN_NAME(language)
    return known_name(language) if name == OWN_NAME.id and language != "en" else name


VERBATIM = "{words}"
NO_WORDS = Text("")


def same(words: str) -> Text:
    """A name, a symbol or a number that reads the same in every language."""
    return Text(VERBATIM, (("words", words),)) if words else NO_WORDS


def joined(*texts: Text) -> Text:
    """Sentences one after the other, as a language joins them; empty ones are left out."""
    return _folded(lambda first, second: text("{first} {second}", first=first, second=second), texts)


def listed(texts: Iterable[Text]) -> Text:
    """Words in a row, as a language lists them: a, b, c."""
    return _folded(lambda first, second: text("{first}, {second}", first=first, second=second), texts)


def _folded(join: Callable[[Text, Text], Text], texts: Iterable[Text]) -> Text:
    said = [one for one in texts if one.id]
    return reduce(join, said) if said else NO_WORDS


def label_in_language(words: Text | str, language: str) -> str:
    """A label in one language; a plain string, such as a symbol with its unit, reads the same in all."""
    return words if isinstance(words, str) else words(language)


class SaidError(ValueError):
    """An error with its sentence in every language, `text`. It can be pickled and copied, whatever its subclass takes."""

    def __init__(self, said: Text) -> None:
        super().__init__(said("en"))
        self.text = said

    def __reduce__(self) -> tuple[object, ...]:
        return _raised_again, (type(self), self.text)


def _raised_again(kind: type[SaidError], said: Text) -> SaidError:
    made = kind.__new__(kind)
    SaidError.__init__(made, said)
    return made


def error_words(problem: object) -> Text:
    """What an error says, in every language: one of the engine carries its message and values, one of ours its text.

    Any other error is an English sentence that nobody translated.
    """
    own = getattr(problem, "text", None)
    if isinstance(own, Text):
        return own
    message, values = getattr(problem, "message", None), getattr(problem, "values", None)
    if isinstance(message, str) and isinstance(values, Mapping):
        return Text(message, tuple(values.items()))
    return same(str(problem))


def singular_if_one(template: str, values: Mapping[str, object]) -> str:
    """An English template, in which a noun behind a count of one stands in the singular."""
    def noun(found: re.Match[str]) -> str:
        value, words = values.get(found["name"]), found["noun"]
        one = words in NOUNS or words in IRREGULAR
        if not one or not isinstance(value, Written) or format_number(value, found["spec"] or "") != "1":
            return found[0]
        return found[0].removesuffix(words) + IRREGULAR.get(words, words[:-1])
    return COUNTED.sub(noun, template)
