"""Law B: every verdict word that a page says of a design is put before a witness that does not use the lesson's code.

`python tests/lessons/verdict_law.py --whole [LESSON …]` tries 3 × 100 designs of each lesson (kick off, kick on, knobs at their ends)
and own plants, and prints the table words × lessons × tried × false. Without `--whole` it tries the sample of the suite.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
from attack import at_random, outcome_of, stops
from verdict_plants import OWN_PLANTS
from verdict_words import words_in

from observer_lab.course.knobs import Choice, Knob, KnobError, Switch
from observer_lab.course.lesson import Design, Lesson, Outcome
from observer_lab.course.sentences import live_parts
from observer_lab.engine import EngineError
from observer_lab.text import label_in_language

PLACES = re.compile(r"live|check\.|formula\.|figure\.[\w-]+\.caption|task\.[\w-]+\.verdict")
PARTS = re.compile(r"(?<=[.;!?]) (?=[A-ZÀ-ÿ])")
UNDECIDED = re.compile(r"not decided|does not decide|not yet decided")


@dataclass(frozen=True, eq=False)
class Said:
    """One sentence about an outcome: where it stands, and whether a check holds, None for all else."""

    lesson: Lesson
    outcome: Outcome
    where: str
    words: str
    holds: bool | None

    @property
    def true(self) -> bool:
        """Whether the page says that the sentence holds."""
        return self.holds is not False


Judge = Callable[[Said, re.Match[str]], None]  # fails with what is the case


@dataclass(frozen=True)
class Witness:
    """A judge of the sentences of a pattern, in these lessons (all, if none is named); None where the word is no verdict there."""

    pattern: re.Pattern[str]
    judge: Judge | None
    lessons: frozenset[str] = frozenset()
    where: str = ""

    def sees(self, one: Said) -> re.Match[str] | None:
        """The match of a sentence that it judges."""
        if (self.lessons and one.lesson.id not in self.lessons) or not one.where.startswith(self.where):
            return None
        return self.pattern.search(one.words)


def witness(pattern: str, judge: Judge | None, *lessons: str, where: str = "") -> Witness:
    """A witness by its pattern."""
    return Witness(re.compile(pattern), judge, frozenset(lessons), where)


@lru_cache(maxsize=1)
def witnesses() -> tuple[Witness, ...]:
    """All witnesses, the first that matches judges."""
    from verdict_witnesses import WITNESSES
    return WITNESSES


def said_of(lesson: Lesson, outcome: Outcome) -> Iterator[Said]:
    """Every sentence with a verdict word about an outcome."""
    holds = {f"check.{check.id}": bool(check.holds) for check in outcome.checks}
    for where, words in live_parts(lesson, outcome):
        if PLACES.fullmatch(where) or where.startswith(("check.", "formula.")):
            for part in PARTS.split(label_in_language(words, "en")):
                if words_in(part) and not part.startswith("Not satisfied"):  # it lists checks, which have witnesses
                    yield Said(lesson, outcome, where, part, holds.get(where))


@dataclass
class Found:
    """What was tried: by word how often, and which were false; sentences without a witness; designs refused."""

    designs: int = 0
    refused: int = 0
    tried: Counter[str] = field(default_factory=Counter)
    false: dict[str, list[str]] = field(default_factory=dict)
    unseen: Counter[str] = field(default_factory=Counter)
    designs_with: Counter[str] = field(default_factory=Counter)  # designs in which the word is said
    undecided: int = 0
    no_verdict: int = 0  # a number, a name or what a task asks for

    @property
    def false_count(self) -> int:
        return sum(map(len, self.false.values()))

    def try_outcome(self, lesson: Lesson, outcome: Outcome) -> None:
        """Put all that is said of an outcome before its witnesses."""
        seen: set[str] = set()
        parts = list(said_of(lesson, outcome))
        self.undecided += any(UNDECIDED.search(one.words) for one in parts)
        for one in parts:
            words = words_in(one.words)
            seen.update(words)
            match = next(((w, m) for w in witnesses() if (m := w.sees(one))), None)
            if match is None:
                self.unseen[shape_of(one)] += 1
                continue
            judge = match[0].judge
            if judge is None:
                self.no_verdict += 1
                continue
            self.tried.update(words)
            try:
                judge(one, match[1])
            except AssertionError as lie:
                moved = {k: v for k, v in outcome.design.values if v != lesson.start()[k]}
                plant = f" own {lesson.plant[:160]}" if lesson.plant else ""
                for word in words:
                    self.false.setdefault(word, []).append(f"{one.where}: {one.words}  ← {str(lie)[:200]}; {str(moved)[:500]}{plant}")
        self.designs_with.update(seen)


def shape_of(one: Said) -> str:
    """The sentence with # for each number, and its place."""
    return f"{one.where.split('.')[0]} {re.sub(r'[−+-]?[0-9][0-9.,·⁰¹²³⁴⁵⁶⁷⁸⁹⁻]*', '#', one.words)}"


def without_kick(lesson: Lesson, design: Design) -> Design:
    """The design without a kick."""
    return lesson.apply(design, {"kick": -1.0}) if any(knob.name == "kick" for knob in lesson.knobs) else design


def at_ends(knob: Knob, rng: np.random.Generator) -> Any:
    """An end of the knob, or any of its options."""
    ends = stops(knob)
    return ends[int(rng.integers(len(ends)))] if ends and not isinstance(knob, (Choice, Switch)) else at_random(knob, rng)


def designs(lesson: Lesson, count: int, seed: int) -> Iterator[Design]:
    """`count` designs at random without a kick, as many with one, and as many with most knobs at an end."""
    rng, start = np.random.default_rng((seed, lesson.number)), lesson.start()
    has_kick = any(knob.name == "kick" for knob in lesson.knobs)
    for _ in range(count):
        yield without_kick(lesson, lesson.apply(start, {knob.name: at_random(knob, rng) for knob in lesson.knobs}))
        design = lesson.apply(start, {knob.name: at_random(knob, rng) for knob in lesson.knobs})
        if has_kick and design["kick"] < 0:
            knob = lesson.knob("kick")
            design = lesson.apply(design, {"kick": knob.check(round(float(rng.uniform(0, knob.high)), 2))})  # type: ignore[attr-defined]
        yield design
        share = rng.uniform(0.2, 1.0)
        yield lesson.apply(start, {k.name: at_ends(k, rng) for k in lesson.knobs if rng.random() < share})


def own_lessons(lesson: Lesson) -> Iterator[Lesson]:
    """The lesson on each own plant that it takes."""
    if lesson.adapt is not None:
        for plant in OWN_PLANTS:
            try:
                yield lesson.fit(plant)
            except (EngineError, KnobError):
                continue


def every_design(lesson: Lesson, count: int, own: int, seed: int) -> Iterator[tuple[Lesson, Design]]:
    """The designs of a lesson and of its own plants."""
    yield lesson, lesson.start()
    yield from ((lesson, lesson.apply(lesson.start(), dict(task.solution))) for task in lesson.tasks if task.solution)
    yield from ((lesson, design) for design in designs(lesson, count, seed))
    if own:
        for each in own_lessons(lesson):
            yield each, each.start()
            yield from ((each, design) for design in designs(each, own, seed))


def tried(pairs: Iterable[tuple[Lesson, Design]]) -> Found:
    """Put all that is said of these designs before witnesses."""
    found = Found()
    for lesson, design in pairs:
        found.designs += 1
        outcome = outcome_of(lesson, design)
        if outcome is None:
            found.refused += 1
            continue
        try:
            found.try_outcome(lesson, outcome)
        except (EngineError, KnobError):  # refused when it is looked at
            found.refused += 1
    return found


def table(rows: Mapping[str, Found]) -> str:
    """Words × lessons × tried × false."""
    lines = []
    for name, found in rows.items():
        words = ", ".join(f"{word} {count}/{len(found.false.get(word, ()))}" for word, count in sorted(found.tried.items()))
        share = found.undecided / max(found.designs - found.refused, 1)
        lines.append(f"{name:18s} {found.designs:4d} designs, {found.refused:3d} refused, {found.tried.total():5d} tried, "
                     f"{found.false_count:3d} false, {found.no_verdict:4d} no verdict, {sum(found.unseen.values()):4d} without a witness, "
                     f"not decided {share:.1%}: {words}")
    return "\n".join(lines)


def main(arguments: list[str]) -> None:
    """Print the table, then what is false or has no witness."""
    from observer_lab.lessons import LESSONS
    whole = "--whole" in arguments
    count = next((int(a) for a in arguments if a.isdigit()), 100 if whole else 2)
    total: Mapping[str, Any] = MappingProxyType({})
    for name in [a for a in arguments if a in LESSONS] or LESSONS:
        found = tried(every_design(LESSONS[name], count, max(count // 20, 1), 44))
        total = {**total, name: found}
        print(table({name: found}), flush=True)
        for word, lies in found.false.items():
            print(f"   FALSE ({len(lies)}) {word}\n      " + "\n      ".join(lies[:3]), flush=True)
        for shape, times in found.unseen.most_common():
            print(f"   WITHOUT A WITNESS ({times}) {shape}", flush=True)
    print(f"{sum(f.designs for f in total.values())} designs, {sum(f.tried.total() for f in total.values())} tried, "
          f"{sum(f.false_count for f in total.values())} false")


if __name__ == "__main__":
    main(sys.argv[1:])
