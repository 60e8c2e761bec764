"""Rank questions, lessons, scenes and terms by the words that a person types."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from ... import engine
from ..lesson import Lesson
from .questions import questions

WORD = re.compile(r"[a-z0-9]+|[\u3400-\u9fff]+")
DULL = re.compile("an?|and|are|as|be|by|can|does|do|for|from|how|i|in|is|it|my|of|on|or|s|the|to|what|which|why|with")  # tell nothing
ENDINGS = ("ations", "ation", "ings", "ing", "ers", "er", "ies", "es", "ed", "s", "e")
SHORTEST_STEM, ALIKE = 3, 0.84  # letters that an ending leaves, and the share of letters in which two words agree
KINDS: tuple[tuple[str, float], ...] = (  # and how much each counts
    ("question", 1.0), ("lesson", 0.9), ("function", 0.8), ("term", 0.75), ("scene", 0.7))
FROM_TEXT, EXACT = 0.25, 0.5  # what a word counts that stands in the answer alone, and what the very phrase adds


@dataclass(frozen=True)
class Hit:
    """Something that can be found: `lesson` and `scene` open it, `name` is its name in the engine."""

    kind: str
    title: str
    lesson: str = ""
    scene: str = ""
    name: str = ""
    answer: str = ""
    forms: tuple[str, ...] = ()


def words_of(text: str) -> tuple[str, ...]:
    """The words of a text without their endings; of Chinese each pair of neighbouring characters."""
    out = list[str]()
    for found in WORD.findall(text.lower().replace("-", " ")):
        if found[0] >= "\u3400":
            out += [found[k:k + 2] for k in range(max(1, len(found) - 1))]
        elif not DULL.fullmatch(found):
            out.append(_stem(found))
    return tuple(out)


def _stem(word: str) -> str:
    ending = next((each for each in ENDINGS if word.endswith(each) and len(word) - len(each) >= SHORTEST_STEM), "")
    return word[:len(word) - len(ending)]


@dataclass(frozen=True)
class Finder:
    """All that can be found in one language."""

    hits: tuple[Hit, ...]

    def find(self, typed: str, most: int = 8) -> tuple[Hit, ...]:
        """The hits for what was typed, best first; none where no word is known."""
        wanted = tuple(part for word in words_of(typed) for part in self._parts(word))
        if not wanted:
            return ()
        scored = [(self._score(typed, wanted, k), hit) for k, hit in enumerate(self.hits)]
        best = sorted((each for each in scored if each[0] > 0), key=lambda each: -each[0])
        return tuple(hit for _, hit in best[:most])

    def _parts(self, word: str) -> tuple[str, ...]:
        """A word that nothing has, as the two known ones that it is written together from."""
        if word in self._rarity or any(_alike(word, frozenset((known,))) for known in self._rarity):
            return (word,)
        ways = ((_stem(word[:k]), _stem(word[k:])) for k in range(SHORTEST_STEM, len(word) - SHORTEST_STEM + 1))
        return next((way for way in ways if all(part in self._rarity for part in way)), (word,))

    @cached_property
    def _forms(self) -> tuple[tuple[frozenset[str], ...], ...]:
        return tuple(tuple(frozenset(words_of(form)) for form in (hit.title, *hit.forms)) for hit in self.hits)

    @cached_property
    def _texts(self) -> tuple[frozenset[str], ...]:
        return tuple(frozenset(words_of(hit.answer)) for hit in self.hits)

    @cached_property
    def _rarity(self) -> Mapping[str, float]:
        """How much a word tells: the logarithm of how few hits have it."""
        count: dict[str, int] = {}
        for forms in self._forms:
            for word in frozenset().union(*forms):
                count[word] = count.get(word, 0) + 1
        return {word: math.log(1 + len(self.hits) / times) for word, times in count.items()}

    def _score(self, typed: str, wanted: Sequence[str], k: int) -> float:
        hit, weight = self.hits[k], dict(KINDS)[self.hits[k].kind]
        asked = [(word, self._rarity.get(word, math.log(1 + len(self.hits)))) for word in wanted]
        whole = sum(rarity for _, rarity in asked)
        best = max((self._share(form, asked) for form in self._forms[k]), default=0.0)
        text = FROM_TEXT * sum(rarity for word, rarity in asked if word in self._texts[k]) / whole
        exact = EXACT * (typed.strip().lower() in {form.lower() for form in (hit.title, *hit.forms)})
        return weight * max(best / whole, text) + (weight * exact if best else 0.0)

    def _share(self, form: frozenset[str], asked: Sequence[tuple[str, float]]) -> float:
        """What of the words that were typed a form has, less where it says much else."""
        met = sum(rarity * _alike(word, form) for word, rarity in asked)
        return met * (0.7 + 0.3 * min(1.0, len(asked) / max(len(form), 1)))


def _alike(word: str, form: frozenset[str]) -> float:
    """1 where a form has the word, less for a word that is written nearly so."""
    if word in form:
        return 1.0
    near = difflib.get_close_matches(word, form, 1, ALIKE) if len(word) > SHORTEST_STEM else []
    return 0.7 if near else 0.0


def find_in_any(finders: Iterable[Finder], typed: str, most: int = 8) -> tuple[Hit, ...]:
    """The hits of the first finder that knows a word: so Chinese words find Chinese answers."""
    return next((found for each in finders if (found := each.find(typed, most))), ())


def functions() -> tuple[Hit, ...]:
    """The engine's functions and classes, by name and by the line that says what they do."""
    return tuple(Hit("function", name, name=name, answer=about, forms=(about,)) for name in engine.__all__
                 if (about := (getattr(engine, name).__doc__ or "").split("\n")[0].strip()))


def finder(lessons: Mapping[str, Lesson], language: str, more: Sequence[Hit] = ()) -> Finder:
    """What can be found in these lessons in a language, also by its English words, and `more`."""
    hits = list[Hit]()
    for own, english in zip(questions()[language].entries, questions()["en"].entries, strict=True):
        forms = tuple(dict.fromkeys((*own.phrases, english.title, *english.phrases)))
        hits.append(Hit("question", own.title, own.lesson, own.scene, own.name, own.answer, forms))
    for lesson in lessons.values():
        words, other = lesson.words[language], lesson.words["en"]
        hits.append(Hit("lesson", words.title, lesson.id, "", "", words.question, (lesson.id, other.title)))
        hits += [Hit("scene", words.scenes[scene.id].title, lesson.id, scene.id, "", words.scenes[scene.id].text,
                     (other.scenes[scene.id].title,)) for scene in lesson.path]
    glossary = next((lesson.words[language].glossary for lesson in lessons.values()), None)
    hits += [] if glossary is None else [Hit("term", each.term, "", "", "", each.text, each.forms) for each in glossary.entries]
    return Finder((*hits, *more))
