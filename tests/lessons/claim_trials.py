"""Every shown sentence at the knobs' stops and at random designs, before its witness.

`python tests/lessons/claim_trials.py [LESSON …]` tries 200 random designs of every lesson, and as many of those that `AIMED` names
with a knob held where its claims are made; it prints the claims that lie.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from attack import outcome_of, random_designs, single_moves
from witnesses import Shown, Witness
from witnesses_of_effort import WITNESSES as EFFORT
from witnesses_of_faults import WITNESSES as FAULTS
from witnesses_of_functions import WITNESSES as FUNCTIONS
from witnesses_of_loops import WITNESSES as LOOPS
from witnesses_of_noise import WITNESSES as NOISE
from witnesses_of_sensors import WITNESSES as SENSORS
from witnesses_of_the_arm import WITNESSES as ARM
from witnesses_of_variances import WITNESSES as VARIANCES

from observer_lab.course.figures.claims import Claim, claims_in
from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Design, Lesson, Outcome
from observer_lab.engine import EngineError
from observer_lab.lessons.showdown.controllers import ORDER
from observer_lab.lessons.showdown.equal_effort import equal_effort
from observer_lab.lessons.showdown.study import Trials
from observer_lab.text.numbers import has_powers

RANDOM = 200
TABLES = (LOOPS, SENSORS, VARIANCES, NOISE, FUNCTIONS, FAULTS, EFFORT, ARM)
WITNESSES: Mapping[str, Witness] = {said: witness for table in TABLES for said, witness in table.items()}  # by message
AIMED: Mapping[str, Mapping[str, Any]] = {"nonlinear": {"kick": -1.0}}  # no bound holds for a kick that no filter is told of
LONG = re.compile(r"(?<![\d.])\d{5,}")  # a number of five digits or more, written out
RAW = re.compile(r"\d[eE][+−-]?\d|\d-\d|[+−-] ?[+−-]\d|\d{8,}|(?:^|[ (])1 (?:sensors|poles|states|values|outputs|inputs)\b")
# as a computer writes: 1e-08, a plain minus, + −3, −43718053745.3, 1 sensors


def _at_one_effort(lesson: Lesson, outcome: Outcome) -> Outcome:
    """What the longer computation of the showdown says of equal effort, without the rest of it."""
    m, d, lqe = outcome.study, outcome.design, ORDER.index("lqe")
    if lesson.job is None or not m.spectra[lqe].stable:
        return outcome
    *_, (_, found) = equal_effort(m.world, m.five, d["v"], d["pair"], float(m.forces[lqe].max()))
    return lesson.job.shown(outcome, Trials((None,) * 5, equal=found))


AFTERWARDS: dict[str, Callable[[Lesson, Outcome], Outcome]] = {"showdown": _at_one_effort}


@dataclass
class Trial:
    """What was tried and what lied."""

    designs: int = 0
    tried: Counter[str] = field(default_factory=Counter)
    unseen: set[str] = field(default_factory=set)  # claims without a witness
    lies: dict[str, list[str]] = field(default_factory=dict)
    mixed: set[str] = field(default_factory=set)  # sentences with a number as no one writes it, or written out beside powers of ten


def extremes(lesson: Lesson) -> list[Design]:
    """The start, every knob at its stops and options by itself, and what solves each task: where sentences of success are said."""
    start = lesson.start()
    return [start, *(lesson.apply(start, dict(moves)) for moves in single_moves(lesson)),
            *(lesson.apply(start, dict(task.solution)) for task in lesson.tasks if task.solution)]


def aimed(lesson: Lesson, count: int, seed: int) -> Iterator[Design]:
    """Random designs where the claims of this lesson are made that any random design seldom makes; none for most lessons."""
    if held := AIMED.get(lesson.id):
        yield from (lesson.apply(design, dict(held)) for design in random_designs(lesson, count, seed))


def spoken(lesson: Lesson, design: Design) -> Iterator[tuple[Shown, object]]:
    """All that the page says of a design, each sentence where it stands; nothing where it refuses, at once or when it is looked at."""
    outcome = outcome_of(lesson, design)
    if outcome is not None:
        yield from spoken_of(lesson, outcome)


def spoken_of(lesson: Lesson, outcome: Outcome) -> Iterator[tuple[Shown, object]]:
    """The same of an outcome."""
    try:
        if lesson.id in AFTERWARDS:
            outcome = AFTERWARDS[lesson.id](lesson, outcome)
        alone = (outcome.live, *(formula.note for formula in outcome.formulas))
        figures = tuple(lesson.figures(outcome))
    except (EngineError, KnobError):
        return
    yield from ((Shown(lesson, outcome, None), said) for said in alone)
    yield from ((Shown(lesson, outcome, figure), figure.caption) for figure in figures)


def tried(lesson: Lesson, designs: Iterable[Design]) -> Trial:
    """Put every sentence of these designs before its witness."""
    found = Trial()
    for design in designs:
        outcome = outcome_of(lesson, design)
        found.designs += 1
        if outcome is not None:
            put_before_witnesses(lesson, outcome, found)
    return found


def put_before_witnesses(lesson: Lesson, outcome: Outcome, found: Trial) -> None:
    """Put every sentence about an outcome before its witness."""
    for shown, said in spoken_of(lesson, outcome):
        found.mixed |= {one for one in re.split(r"(?<=[.:;]) ", str(said))
                        if (LONG.search(one) and has_powers(one)) or RAW.search(one)}
        for words in claims_in(said):
            witness = WITNESSES.get(words.id)
            if witness is None:
                if isinstance(words, Claim):
                    found.unseen.add(words.id)
                continue
            found.tried[words.id] += 1
            try:
                witness(shown, words)
            except AssertionError as lie:
                start = lesson.start()
                where = {k: v for k, v in outcome.design.values if v != start[k]}
                found.lies.setdefault(words.id, []).append(f"{str(lie)[:160]}; {str(where)[:400]}")


if __name__ == "__main__":
    from observer_lab.lessons import LESSONS
    for name in sys.argv[1:] or LESSONS:
        told = tried(LESSONS[name], [*extremes(LESSONS[name]), *random_designs(LESSONS[name], RANDOM, 7),
                                    *aimed(LESSONS[name], RANDOM, 8)])
        print(f"{name}: {told.designs} designs, {len(told.tried)} claims tried {told.tried.total()} times, {len(told.lies)} lie")
        for claim, where in told.lies.items():
            print(f"   LIE ({len(where)} times) {claim}\n      " + "\n      ".join(where[:3]), flush=True)
        for sentence in sorted(told.mixed):
            print(f"   a number as no one writes it: {sentence}")
        for claim in sorted(told.unseen):
            print(f"   without a witness: {claim}")
