"""Read the questions that people ask: phrases as they are typed, and what answers them.

The form of `questions.md`; another language has no line with an arrow:

    # title
    ## id: question
    - phrase; another phrase
    → lesson/scene engine:name

    answer in at most 60 words
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from ...text.languages import folder_of, languages
from ..glossary import ProseError

FILE = "questions.md"
PART = re.compile(r"(?P<id>[a-z-]+): (?P<title>[^\n]+)\n- (?P<phrases>[^\n]+)\n"
                  r"(?:→ (?P<lesson>[\w-]+)/(?P<scene>[\w-]+)(?: engine:(?P<name>\w+))?\n)?\n(?P<answer>.+)", re.S)


@dataclass(frozen=True)
class AskedQuestion:
    """A question in one language, with the scene that answers it and the name in the engine, "" where there is none."""

    id: str
    title: str
    phrases: tuple[str, ...]
    answer: str
    lesson: str = ""
    scene: str = ""
    name: str = ""


@dataclass(frozen=True)
class Questions:
    """All questions of one language under the title of their page."""

    language: str
    title: str
    entries: tuple[AskedQuestion, ...]


def parse_questions(language: str, text: str) -> Questions:
    """The questions of a file. Raises ProseError."""
    title, *parts = text.strip().removeprefix("# ").split("\n## ")
    return Questions(language, title.strip(), tuple(_question(language, part.strip()) for part in parts))


def _question(language: str, part: str) -> AskedQuestion:
    found = PART.fullmatch(part)
    if found is None:
        raise ProseError(f"{FILE} ({language}): the question “{part[:40]}” lacks a phrase, a scene or an answer.")
    phrases = tuple(phrase.strip() for phrase in re.split("[;；]", found["phrases"]))
    return AskedQuestion(found["id"], found["title"], phrases, found["answer"].strip(), found["lesson"] or "", found["scene"] or "",
                         found["name"] or "")


@lru_cache(maxsize=1)
def questions() -> Mapping[str, Questions]:
    """The questions by language; one that a language lacks stands there in English. Raises ProseError."""
    english = parse_questions("en", (Path(__file__).parent / FILE).read_text(encoding="utf-8"))
    return {code: english if code == "en" else _translated(english, code) for code in languages()}


def _translated(english: Questions, language: str) -> Questions:
    folder = folder_of(language)
    path = None if folder is None else folder / FILE
    if path is None or not path.is_file():
        return english
    own = parse_questions(language, path.read_text(encoding="utf-8"))
    by_id = {each.id: each for each in own.entries}
    unknown = by_id.keys() - {each.id for each in english.entries}
    if unknown:
        raise ProseError(f"{FILE} ({language}): the English file has no question {min(unknown)}.")
    entries = tuple(replace(by_id.get(each.id, each), lesson=each.lesson, scene=each.scene, name=each.name) for each in english.entries)
    return Questions(language, own.title, entries)
