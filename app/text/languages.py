"""List the languages and load their catalogues; a new language needs no code.

A folder holds gettext catalogues (`*.po`) and two Markdown files a lesson, its words and the notes for its teacher. It
stands in `app/locale`, or in the folder that the environment variable OBSERVER_LAB_LOCALE names.
"""

from __future__ import annotations

import gettext
import io
import os
import re
from functools import lru_cache
from pathlib import Path

from babel import Locale, UnknownLocaleError
from babel.messages import Catalog, mofile, pofile

LOCALE_FOLDER = Path(__file__).parents[1] / "locale"
ELSEWHERE = "OBSERVER_LAB_LOCALE"


@lru_cache(maxsize=1)
def folders() -> tuple[tuple[str, Path], ...]:
    """Code and folder of every language but English, by code."""
    roots = [LOCALE_FOLDER, *([Path(os.environ[ELSEWHERE])] if os.environ.get(ELSEWHERE) else [])]
    found = {folder.name: folder for root in roots if root.is_dir() for folder in root.iterdir() if any(folder.glob("*.po"))}
    return tuple(sorted(found.items()))


def languages() -> tuple[str, ...]:
    """The codes of all languages, English first."""
    return ("en", *(code for code, _ in folders()))


def folder_of(language: str) -> Path | None:
    """Where a language's catalogues and lessons stand; None for English, whose words stand in the code."""
    return dict(folders()).get(language)


@lru_cache(maxsize=16)
def catalogue(language: str) -> Catalog:
    """All messages of a language in one catalogue; empty for English. Raises babel's PoFileError with the line."""
    whole = Catalog(locale=None)
    folder = folder_of(language)
    for path in sorted(folder.glob("*.po")) if folder else ():
        with path.open("rb") as file:
            part = pofile.read_po(file, abort_invalid=True, charset="utf-8")
        for message in part:
            if message.id and message.string and not message.fuzzy:
                whole.add(message.id, message.string, context=message.context)
    return whole


@lru_cache(maxsize=16)
def _compiled(language: str) -> gettext.NullTranslations:
    if folder_of(language) is None:
        return gettext.NullTranslations()
    file = io.BytesIO()
    mofile.write_mo(file, catalogue(language))
    file.seek(0)
    return gettext.GNUTranslations(file)


def translated(message: str, context: str, language: str) -> str:
    """The template of a message in a language, its English where there is none."""
    if language == "en" or not message:
        return message
    known = _compiled(language)
    return known.pgettext(context, message) if context else known.gettext(message)


WIDE_CHARACTERS = "\u3000-\u303f\u4e00-\u9fff\uff00-\uffef“”…"
BETWEEN = re.compile(f"(?<=[{WIDE_CHARACTERS}]) +(?=[{WIDE_CHARACTERS}])|(?<=[。，；：（]) +| +(?=[。，；：）])")


def closed_up(words: str, language: str) -> str:
    """A sentence without the spaces that Chinese does not write: between two of its signs, and beside its stops."""
    return BETWEEN.sub("", words) if language.startswith("zh") else words


def known_name(language: str) -> str:
    """What a language calls itself, as Babel knows it; its code where it does not."""
    locale = _locale(language)
    return language if locale is None else (locale.get_display_name() or language)


@lru_cache(maxsize=16)
def decimal_sign(language: str) -> str:
    """What stands between the units and the tenths of a number."""
    locale = _locale(language)
    return "." if locale is None else locale.number_symbols["latn"].get("decimal", ".")


def _locale(language: str) -> Locale | None:
    try:
        return Locale.parse(language, sep="-" if "-" in language else "_")
    except (UnknownLocaleError, ValueError):
        return None
