"""The glossary: terms with a short explanation and a formula, found in texts by their word forms.

The form of `glossary.md`; a language of its own has `## id: term` and may leave out the formula, which is then the English one:

    # title
    ## term
    - other form; another form

    explanation in 15 to 40 words

    $formula$
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path

from ..text.languages import folder_of, languages

FILE = "glossary.md"


@dataclass(frozen=True)
class Entry:
    """One term: `forms` are the words by which it is found, the term itself first; `formula` is LaTeX."""

    id: str
    term: str
    forms: tuple[str, ...]
    text: str
    formula: str


@dataclass(frozen=True)
class Found:
    """A term in a text: text[start:end] is one of its forms."""

    start: int
    end: int
    entry: Entry


@dataclass(frozen=True)
class Glossary:
    """All terms of one language, in the order of the file."""

    language: str
    entries: tuple[Entry, ...]

    def find(self, text: str) -> tuple[Found, ...]:
        """The terms in a text, in order and without overlap; of forms that begin at one place the longest."""
        out: list[Found] = []
        for token in TOKEN.finditer(text):
            if out and token.start() < out[-1].end:
                continue
            hit = next(filter(None, (_matcher(form).match(text, token.start()) for form in self._forms.get(token[0].lower(), ()))), None)
            if hit is not None:
                out.append(Found(hit.start(), hit.end(), self._by_form[_key(hit[0])]))
        return tuple(out)

    def used(self, texts: Iterable[str]) -> tuple[Entry, ...]:
        """The entries whose terms stand in the words of these texts, not in their formulas, in the order of the first use."""
        return tuple(dict.fromkeys(found.entry for text in texts for found in self.find(KEPT.sub(" ", text))))

    def entry(self, word: str) -> Entry | None:
        """The entry of that id, term or form; None if there is none."""
        return next((each for each in self.entries if each.id == word.lower()), self._by_form.get(_key(word)))

    @cached_property
    def _by_form(self) -> Mapping[str, Entry]:
        return {_key(form): each for each in reversed(self.entries) for form in _inflected(each.forms)}

    @cached_property
    def _forms(self) -> Mapping[str, list[str]]:
        """The forms by their first token, the longest form first."""
        out: dict[str, list[str]] = {}
        for form in sorted({form for each in self.entries for form in _inflected(each.forms)}, key=lambda form: (-len(form), form)):
            token = TOKEN.match(form)
            assert token is not None, form
            out.setdefault(token[0].lower(), []).append(form)
        return out


TOKEN = re.compile(r"[A-Za-z\u00c0-\u024f]+|[^\s\-–]")  # a word in Latin letters, or one other sign


def _inflected(forms: Iterable[str]) -> Iterator[str]:
    """The forms and, of those in Latin letters, their plurals."""
    for form in forms:
        yield form
        if re.search(r"[a-zA-Z]$", form):
            yield _plural(form)


def _plural(form: str) -> str:
    for pattern, ending in ((r"[^aeiou]y$", "ies"), (r"ix$", "ices"), (r"is$", "es")):
        if re.search(pattern, form):
            return form[:-1] + ending if ending == "ies" else form[:-2] + ending
    return form + ("es" if re.search(r"(?:s|x|ch|sh)$", form) else "s")


def _key(form: str) -> str:
    """One spelling for a form: small letters, one kind of blank, hyphen and apostrophe."""
    return re.sub(r"[\s\-–]+", " ", form.lower().replace("'", "’"))


@lru_cache(maxsize=4096)
def _matcher(form: str) -> re.Pattern[str]:
    """A pattern for a form: an abbreviation as it is written, other words in any case, with blank or hyphen between them."""
    parts = [re.escape(part).replace("’", "['’]") for part in re.split(r"[\s\-–]+", form)]
    body = r"[\s\-–]+".join(parts)
    left = r"(?<![\w-])" if re.match(r"[A-Za-z]", form) else ""
    right = r"(?![A-Za-z0-9_])" if re.search(r"[A-Za-z]$", form) else ""
    exact = re.fullmatch(r"[A-Z]{2,}s?|[a-z][A-Z]|3σ|χ²", form) is not None
    return re.compile(f"{left}{body}{right}", re.NOFLAG if exact else re.IGNORECASE)


def read_glossary(folder: Path) -> dict[str, Glossary]:
    """The glossary by language: English from the folder, others from theirs; English where a language has none. Raises ProseError."""
    english = parse_glossary((folder / FILE).read_text(encoding="utf-8"), "en")
    formulas = {each.id: each.formula for each in english.entries}
    out = {}
    for language in languages():
        path = (folder_of(language) or folder) / FILE
        own = parse_glossary(path.read_text(encoding="utf-8"), language, formulas) if path.is_file() else english
        out[language] = replace(own, language=language)
    return out


@lru_cache(maxsize=8)
def glossaries_in(folder: Path) -> Mapping[str, Glossary]:
    """The glossary by language of the lessons in a folder; no terms where the folder has none. Raises ProseError."""
    if not (folder / FILE).is_file():
        return {language: Glossary(language, ()) for language in languages()}
    return read_glossary(folder)


def parse_glossary(text: str, language: str = "en", formulas: Mapping[str, str] | None = None) -> Glossary:
    """The entries of a file; `formulas` are those of entries that have none of their own. Raises ProseError."""
    entries = tuple(_entry(section, language, formulas or {}) for section in text.split("\n## ")[1:])
    for kind, keys in (("term", [each.id for each in entries]), ("form", [_key(form) for each in entries for form in each.forms])):
        twice = next((key for key in keys if keys.count(key) > 1), None)
        if twice is not None:
            raise ProseError(f"The {language} {FILE} has the {kind} {twice} twice; remove one.")
    return Glossary(language, entries)


def _entry(section: str, language: str, formulas: Mapping[str, str]) -> Entry:
    head, _, body = section.partition("\n")
    key, _, term = (part.strip() for part in head.partition(": "))
    term, forms, words, formula = term or key, "", [], ""
    for line in filter(None, map(str.strip, body.splitlines())):
        if line.startswith("- "):
            forms += ";" + line[2:]
        elif line.startswith("$") and line.endswith("$"):
            formula = line.strip("$")
        else:
            words.append(line)
    formula = formula or formulas.get(key.lower(), "")
    if not words or not formula:
        raise ProseError(f"The {language} {FILE} has no {'formula' if words else 'explanation'} for {term}; add it below its heading.")
    others = (form.strip() for form in forms.split(";"))
    return Entry(key.lower(), term, tuple(dict.fromkeys((term, *filter(None, others)))), " ".join(words), formula)


# --- in a page ---------------------------------------------------------------------------------------------------------
CLOSED = "math|code|pre|a|h[1-6]|abbr|svg|script|style|button|summary|select|textarea|title"
KEPT = re.compile(
    rf"<(?P<tag>{CLOSED})\b[^>]*>.*?(?:</(?P=tag)\s*>|\Z)"  # an element whose words stay as they are
    r"|<!--.*?(?:-->|\Z)|<[/!?A-Za-z][^>]*(?:>|\Z)|&#?\w+;"  # comments, other tags, entities
    r"|^(?P<fence>```|~~~).*?(?:^(?P=fence)[^\n]*$|\Z)|^#{1,6} [^\n]*$|^(?: {4}|\t)[^\n]*$"  # code and headings of Markdown
    r"|(?P<ticks>`+)(?!`).*?(?<!`)(?P=ticks)(?!`)|!?\[[^\]\n]*\](?:\([^)\n]*\)|\[[^\]\n]*\])|\[\[\w+\]\]"  # code, links, places
    r"|\$\$.+?\$\$|\$[^$\n]+\$|(?:https?://|www\.|doi:)\S+", re.S | re.M | re.I)


def explained(markup: str, glossary: Glossary) -> str:
    """Markdown or HTML whose terms stand, where each is first used, in an `<abbr>` that holds the explanation.

    Formulas, code, links, headings, tags and what they hold stay as they are, so a text that is explained twice does not change.
    """
    known = set(re.findall(r'data-term="([^"]*)"', markup))
    parts, at = [], 0
    for kept in KEPT.finditer(markup):
        parts += [_marked(markup[at:kept.start()], glossary, known), kept[0]]
        at = kept.end()
    return "".join([*parts, _marked(markup[at:], glossary, known)])


def _marked(text: str, glossary: Glossary, known: set[str]) -> str:
    """Plain words with the first use of each term marked; `known` are the terms marked before and grows."""
    parts, at = [], 0
    for found in glossary.find(text):
        key = as_attribute(found.entry.id)
        if key not in known:
            known.add(key)
            parts += [text[at:found.start], f'<abbr class="ol-term" tabindex="0" data-term="{key}" '
                      f'title="{as_attribute(found.entry.text)}">{text[found.start:found.end]}</abbr>']
            at = found.end
    return "".join([*parts, text[at:]])


def as_attribute(words: str) -> str:
    """Words as the value of an attribute, also where a page reads braces as code."""
    return html.escape(words).replace("{", "&#123;").replace("}", "&#125;")


class ProseError(ValueError):
    """A lesson's text file, or the glossary, that does not have the agreed form."""
