"""Every distinct sentence that lessons say, at knob ends and random designs, under three seeds of the noise.

`python tests/lessons/all_sentences.py N [LESSON …] [--lang CODE] [--shapes] [--live]` tries N random designs of each lesson besides its
knobs' ends, and prints count, place and sentence. `--shapes` counts sentences as one that differ in numbers alone, `--live` leaves
out the prose, which no knob changes.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from attack import outcome_of, random_designs, single_moves

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Design, Lesson
from observer_lab.course.sentences import Sentence, sentences
from observer_lab.engine import EngineError
from observer_lab.lessons import LESSONS

SEEDS = (1, 2, 3)
SEED = "seed"  # the knob that noise is drawn from
NUMBER = re.compile(r"[−+-]?\d[\d.,]*(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?|10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+|∞")
PROSE = re.compile(r"title|question|introduction|predict|again|step\.|derive\.|exam\.|source|reference\.|task\.[\w-]+(?:$|\.(?!verdict))")


def shape(words: str) -> str:
    """The sentence with # for each number."""
    return NUMBER.sub("#", words)


def designs(lesson: Lesson, count: int) -> Iterator[Design]:
    """The start, each knob at its ends, what solves the tasks and `count` random designs; each under three seeds where there is one."""
    start = lesson.start()
    tried = [start, *(lesson.apply(start, dict(moves)) for moves in single_moves(lesson)),
             *(lesson.apply(start, dict(task.solution)) for task in lesson.tasks if task.solution),
             *random_designs(lesson, count, lesson.number)]
    seeded = any(knob.name == SEED for knob in lesson.knobs)
    for design in tried:
        yield from (lesson.apply(design, {SEED: seed}) for seed in SEEDS) if seeded else (design,)


@dataclass
class Collected:
    """How often each sentence was said, and where first; how many designs were tried and how many refused."""

    counts: dict[str, int] = field(default_factory=dict)
    first: dict[str, Sentence] = field(default_factory=dict)
    tried: int = 0
    refused: int = 0

    def add(self, said: Iterable[Sentence], shapes: bool, live: bool) -> None:
        """Count what one design says, each sentence once."""
        for one in said:
            if not (live and PROSE.match(one.where)):
                key = shape(one.text) if shapes else one.text
                self.counts[key] = self.counts.get(key, 0) + 1
                self.first.setdefault(key, one)


def collected(lesson: Lesson, count: int, language: str = "en", shapes: bool = False, live: bool = False) -> Collected:
    """The sentences of a lesson over its designs."""
    found = Collected()
    for design in designs(lesson, count):
        found.tried += 1
        outcome = outcome_of(lesson, design)
        try:
            said = () if outcome is None else sentences(lesson, outcome, language)
        except (EngineError, KnobError):  # refused when it is looked at
            said = ()
        found.refused += not said
        found.add(said, shapes, live)
    return found


def main() -> None:
    """Print them, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int)
    parser.add_argument("lessons", nargs="*")
    parser.add_argument("--lang", default="en")
    parser.add_argument("--shapes", action="store_true")
    parser.add_argument("--live", action="store_true")
    asked = parser.parse_args()
    distinct, tried, refused, said = 0, 0, 0, 0
    for name in asked.lessons or LESSONS:
        found = collected(LESSONS[name], asked.count, asked.lang, asked.shapes, asked.live)
        print(f"## {name}: {len(found.counts)} distinct sentences, {found.tried} designs, {found.refused} refused", flush=True)
        for key, count in sorted(found.counts.items(), key=lambda pair: (found.first[pair[0]].where, -pair[1])):
            print(f"{count:6d}  {found.first[key].where}  {found.first[key].text}")
        distinct, tried, refused = distinct + len(found.counts), tried + found.tried, refused + found.refused
        said += sum(found.counts.values())
    print(f"{distinct} distinct sentences of {said} said by {tried} designs, {refused} refused")


if __name__ == "__main__":
    main()
