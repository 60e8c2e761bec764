"""Every distinct sentence that lessons say, at knob ends and random designs, under three seeds of the noise, before the laws of truth.

`python tests/lessons/all_sentences.py N [LESSON …] [--lang CODE] [--shapes] [--live] [--broken]` tries N random designs of each lesson
besides its knobs' ends, and prints count, place and sentence, then what breaks a law or is refuted by its witness. `--shapes` counts
sentences as one that differ in numbers alone, `--live` leaves out the prose, which no knob changes, `--broken` prints the broken alone.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from attack import outcome_of, random_designs, single_moves
from claim_trials import Trial, put_before_witnesses
from sentence_laws import broken

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Design, Lesson, Outcome
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
    return seeded(lesson, tried)


def seeded(lesson: Lesson, tried: Iterable[Design]) -> Iterator[Design]:
    """Each design under three seeds, as it is where the lesson draws no noise."""
    has_seed = any(knob.name == SEED for knob in lesson.knobs)
    for design in tried:
        yield from (lesson.apply(design, {SEED: seed}) for seed in SEEDS) if has_seed else (design,)


@dataclass
class Collected:
    """How often each sentence was said, and where first; what breaks a law; how many designs were tried and how many refused."""

    counts: dict[str, int] = field(default_factory=dict)
    first: dict[str, Sentence] = field(default_factory=dict)
    false: dict[tuple[str, str], str] = field(default_factory=dict)  # (law, shape) → the first sentence that breaks it, and where
    judged: set[str] = field(default_factory=set)
    witnessed: Trial = field(default_factory=Trial)
    tried: int = 0
    refused: int = 0

    def add(self, said: Iterable[Sentence], outcome: Outcome, shapes: bool, live: bool) -> None:
        """Count what one design says, each sentence once, and try the laws over it."""
        for one in said:
            if not (live and PROSE.match(one.where)):
                key = shape(one.text) if shapes else one.text
                self.counts[key] = self.counts.get(key, 0) + 1
                self.first.setdefault(key, one)
                self.judge(one, outcome)

    def judge(self, one: Sentence, outcome: Outcome) -> None:
        """Try the laws over one sentence; prose, which is the same for every design, once."""
        if not (PROSE.match(one.where) and one.text in self.judged):
            self.judged.add(one.text)
            for law in broken(one, outcome):
                start = dict(outcome.design.values)
                self.false.setdefault((law, shape(one.text)), f"{one.where}: {one.text}   {str(start)[:600]}")


def collected(lesson: Lesson, tried: Iterable[Design], language: str = "en", shapes: bool = False, live: bool = False) -> Collected:
    """The sentences of a lesson over designs."""
    found = Collected()
    for design in tried:
        found.tried += 1
        outcome = outcome_of(lesson, design)
        try:
            said = () if outcome is None else sentences(lesson, outcome, language)
        except (EngineError, KnobError):  # refused when it is looked at
            said = ()
        if outcome is None or not said:
            found.refused += 1
            continue
        found.add(said, outcome, shapes, live)
        put_before_witnesses(lesson, outcome, found.witnessed)
    return found


def report(name: str, found: Collected, only_broken: bool) -> None:
    """Print the sentences of a lesson, and those that break a law."""
    print(f"## {name}: {len(found.counts)} distinct sentences, {found.tried} designs, {found.refused} refused, "
          f"{found.witnessed.tried.total()} claims before witnesses", flush=True)
    if not only_broken:
        for key, count in sorted(found.counts.items(), key=lambda pair: (found.first[pair[0]].where, -pair[1])):
            print(f"{count:6d}  {found.first[key].where}  {found.first[key].text}")
    for (law, _), where in found.false.items():
        print(f"   BROKEN {law}: {where}")
    for said, lies in found.witnessed.lies.items():
        print(f"   REFUTED ({len(lies)} times) {said}\n      " + "\n      ".join(lies[:2]))


def main() -> None:
    """Print them, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int)
    parser.add_argument("lessons", nargs="*")
    parser.add_argument("--lang", default="en")
    parser.add_argument("--shapes", action="store_true")
    parser.add_argument("--live", action="store_true")
    parser.add_argument("--broken", action="store_true")
    asked = parser.parse_args()
    distinct, tried, refused, said, false = 0, 0, 0, 0, 0
    for name in asked.lessons or LESSONS:
        lesson = LESSONS[name]
        found = collected(lesson, designs(lesson, asked.count), asked.lang, asked.shapes, asked.live)
        report(name, found, asked.broken)
        distinct, tried, refused = distinct + len(found.counts), tried + found.tried, refused + found.refused
        said, false = said + sum(found.counts.values()), false + len(found.false) + len(found.witnessed.lies)
    print(f"{distinct} distinct sentences of {said} said by {tried} designs, {refused} refused; {false} break a law or are refuted")


if __name__ == "__main__":
    main()
