"""A sentence in both languages of the lab."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

LANGUAGES = ("en", "zh")


@dataclass(frozen=True)
class Text:
    """One sentence, in English and in Chinese; `text("zh")` picks one."""

    en: str
    zh: str

    def __post_init__(self) -> None:
        """Chinese has no space after its stops; sentences that are joined with one lose it."""
        if "\N{IDEOGRAPHIC FULL STOP} " in self.zh:
            object.__setattr__(self, "zh", self.zh.replace("\N{IDEOGRAPHIC FULL STOP} ", "\N{IDEOGRAPHIC FULL STOP}"))

    def __call__(self, language: str) -> str:
        return self.zh if language == "zh" else self.en

    def format(self, *args: object, **kwargs: object) -> Text:
        """Fill the same values into both sentences; a value that is itself a Text goes into each in its language."""
        def filled(words: str, language: str) -> str:
            return words.format(*(_said(a, language) for a in args), **{k: _said(a, language) for k, a in kwargs.items()})
        return Text(filled(self.en, "en"), filled(self.zh, "zh"))


def _said(value: object, language: str) -> object:
    return value(language) if isinstance(value, Text) else value


def wording(words: Text | str, language: str) -> str:
    """A label in one language; a plain string, such as a symbol with its unit, reads the same in both."""
    return words if isinstance(words, str) else words(language)


def same(words: str) -> Text:
    """A name, a symbol or a number that reads the same in both languages."""
    return Text(words, words)


def squared(unit: str) -> str:
    """The square of a unit: A², (m/s)²; 1 where there is none."""
    return "1" if not unit else f"{unit}²" if unit.isalpha() else f"({unit})²"


LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
GREEK = MappingProxyType({"theta": "θ", "omega": "ω", "phi": "φ", "alpha": "α", "beta": "β"})


def symbol(name: str) -> str:
    """The name of a signal as a formula has it: z12 → z₁₂, theta → θ. Other names stay as they are."""
    if name in GREEK:
        return GREEK[name]
    head = name.rstrip("0123456789")
    return head + name[len(head):].translate(LOWERED) if 1 <= len(head) <= 2 else name


NO_WORDS = same("")
