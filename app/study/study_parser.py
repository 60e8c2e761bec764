"""Read a study from a JSON file and check every entry.

`observer-lab study --help` tells how it is written.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal, TypeVar

import msgspec
import numpy as np

from observer_lab.lessons import LESSONS

from ..course.knobs import Knob, KnobError, Number
from ..course.lesson import Lesson
from ..engine import EngineError
from ..plants.own_plant import clean_plant_json
from ..text.schema import MAX_SHOWN_CHARACTERS, Checked, Misfit, judge, says, shown
from .plan import MAX_STUDY_RUNS, Axis, Study, StudyError
from .points import SEED_KNOB, design_at, entry_of, matrices_of, numbers, outcome_of, seed_knob

LARGEST_SEED = 2**63 - 1
T = TypeVar("T")
Entries = Annotated[list[str], says("{key} is a list of entries such as A(2,1).")]
Named = Annotated[dict[str, Any], says("{key} is an object of names with their values.")]


class _Given(Checked, frozen=True):
    lesson: Any = None
    set: Named = msgspec.field(default_factory=dict)
    plant: Any = None
    vary: Named = msgspec.field(default_factory=dict)
    seeds: Any = None
    seed: Annotated[int, says(f"seed is a whole number from 0 to {LARGEST_SEED}; it cannot be {{value}}.", ge=0, le=LARGEST_SEED)] = 1
    collect: Annotated[list[str], says(
        "collect is a list of names, such as those of the metrics in observer-lab run --json.", min_length=1)] | None = None
    final: Annotated[bool, says("final is true or false.")] = False


class _Spread(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    low: Any = msgspec.field(default=None, name="from")
    high: Any = msgspec.field(default=None, name="to")
    count: Any = None
    scale: Annotated[Literal["linear", "log"], says("{key} is linear or log.")] | None = None
    values: Any = None
    times: Entries = []
    over: Entries = []


def read_study(words: str, plant_in: Callable[[str], str]) -> Study:
    """The study of a text; `plant_in` gives the canonical text of the plant in a file. Raises StudyError, and what it raises."""
    given = _judged(_parsed(words), _Given, "A study")
    name = given.lesson
    if not isinstance(name, str) or name not in LESSONS:
        raise StudyError(f"There is no lesson {str(name)[:MAX_SHOWN_CHARACTERS]}; there are {', '.join(LESSONS)}.")
    origin = LESSONS[name]
    try:
        plant = _plant(given.plant, plant_in)
        lesson = origin.fit(plant)
        changes = {knob: _value(lesson.knob(knob), value) for knob, value in given.set.items()}
        axes = tuple(_axis(lesson, plant, called, spread) for called, spread in given.vary.items())
        seeds, drawn = _seeds(lesson, given.seeds, {*changes, *(axis.name for axis in axes)})
    except (EngineError, KnobError, OverflowError) as problem:
        raise StudyError(str(problem)) from problem
    twice = [axis.name for axis in axes if axis.name in changes]
    if twice:
        raise StudyError(f"{twice[0]} is set and varied; do one of them.")
    if given.final and lesson.job is None:
        raise StudyError(f"Lesson {origin.id} has no long computation; leave out final.")
    study = Study(origin.id, plant, tuple(changes.items()), axes, seeds, drawn, given.seed, (), given.final)
    if study.size > MAX_STUDY_RUNS:
        raise StudyError(f"The study has {study.size} runs; at most {MAX_STUDY_RUNS} fit into one, so choose fewer values or seeds.")
    return _collecting(study, given.collect)


# --- parts -------------------------------------------------------------------------------------------------------------
def _parsed(words: str) -> Mapping[str, Any]:
    def no_constant(name: str) -> Any:
        raise StudyError(f"The study holds {name}, which is no finite number.")
    try:
        given = json.loads(words, parse_constant=no_constant, object_pairs_hook=_once)
    except StudyError:
        raise
    except (ValueError, RecursionError) as problem:
        where = f" (line {problem.lineno})" if isinstance(problem, json.JSONDecodeError) else ""
        raise StudyError(f"The study is no JSON{where}; see the example in its help.") from problem
    if not isinstance(given, dict):
        raise StudyError("The study is no JSON object; it begins with { and names a lesson.")
    return given


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in pairs:
        if name in found:
            raise StudyError(f"The study gives {name[:40]} twice.")
        found[name] = value
    return found


def _judged(given: object, kind: type[T], what: str) -> T:
    """A table of a study as its kind. Raises StudyError."""
    try:
        return judge(given, kind, f"{what} has no {{key}}; it has {{keys}}.")
    except Misfit as problem:
        raise StudyError(problem.words) from problem


def _plant(given: Any, plant_in: Callable[[str], str]) -> str:
    if given is None:
        return ""
    if isinstance(given, str):
        return plant_in(given)
    if isinstance(given, dict):
        return clean_plant_json(json.dumps(given))
    raise StudyError("plant is the name of a file or of an example, or a plant as such a file holds it.")


def _value(knob: Knob, value: Any) -> Any:
    return knob.parse(value) if isinstance(value, str) else knob.check(value)


def _axis(lesson: Lesson, plant: str, name: str, given: Any) -> Axis:
    """What varies. Raises StudyError, KnobError."""
    knob = next((knob for knob in lesson.knobs if knob.name == name), None)
    if not isinstance(given, (list, dict)):
        raise StudyError(f"{name[:40]} varies over a list of values, or over from, to and count.")
    spread = _judged({"values": given} if isinstance(given, list) else given, _Spread, f"A range of {name[:40]}")
    times, over = tuple(spread.times), tuple(spread.over)
    if knob is not None:
        if times or over:
            raise StudyError(f"{name} is a knob of the lesson; give the factor of the plant another name.")
        values, log = _spread(name, spread, isinstance(knob, Number) and knob.scale == "log")
        checked = tuple(_value(knob, value) for value in values)
    else:
        _of_plant(lesson, plant, name, (*times, *over))
        values, log = _spread(name, spread, False)
        checked = tuple(_number(name, value) for value in values)
        if over and 0.0 in checked:
            raise StudyError(f"{name[:40]} divides and cannot be 0.")
    if len(set(checked)) < len(checked):
        raise StudyError(f"Some of the {len(checked)} values of {name[:40]} are the same; choose fewer.")
    return Axis(name, checked, log, knob is None, times, over)


def _of_plant(lesson: Lesson, plant: str, name: str, entries: tuple[str, ...]) -> None:
    """Raises where a name that is no knob is nothing of the plant either."""
    if not plant:
        if not entries and "(" not in name:
            lesson.knob(name)  # says which knobs there are
        raise StudyError(f"{name[:40]} is of a plant of your own; name one as plant.")
    for entry in entries or (name,):
        if not entries and "(" not in name:
            names = ", ".join(knob.name for knob in lesson.knobs)
            raise StudyError(f"{name[:40]} is neither a knob ({names}) nor an entry such as A(2,1), and has neither times nor over.")
        entry_of(matrices_of(plant), entry)


def _spread(name: str, spread: _Spread, log: bool) -> tuple[list[Any], bool]:
    """The values of a list or of a range, and whether they are drawn over decades."""
    scale = spread.scale or ("log" if log else "linear")
    missing = [key for key, value in (("from", spread.low), ("to", spread.high), ("count", spread.count)) if value is None]
    if spread.values is not None:
        if not isinstance(spread.values, list) or not spread.values or len(spread.values) > MAX_STUDY_RUNS or len(missing) < 3:
            raise StudyError(f"{name[:40]} varies over a list of values that is not empty, or over from, to and count.")
        return spread.values, scale == "log"
    if missing:
        raise StudyError(f"The range of {name[:40]} lacks {', '.join(missing)}.")
    low, high = _number(name, spread.low), _number(name, spread.high)
    count = _whole(f"The count of {name[:40]}", spread.count, 1, MAX_STUDY_RUNS)
    if scale == "log" and not (low > 0 and high > 0):
        raise StudyError(f"A range of {name[:40]} over decades lies above 0; give another from or to, or the scale linear.")
    return (np.geomspace if scale == "log" else np.linspace)(low, high, count).tolist(), scale == "log"


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or abs(value) > 1e300 or not math.isfinite(value):
        raise StudyError(f"{shown(value)} is no number for {name[:40]}.")
    return float(value)


def _whole(what: str, value: Any, low: int, high: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise StudyError(f"{what} is a whole number from {low} to {high}; it cannot be {shown(value)}.")
    return value


def _seeds(lesson: Lesson, given: Any, taken: set[str]) -> tuple[tuple[float, ...], int]:
    """The seeds of every point, and how many are drawn for each instead."""
    if given is None:
        return (), 0
    knob = seed_knob(lesson)
    if SEED_KNOB in taken:
        raise StudyError("seed is a knob here; set or vary it, or give seeds.")
    if isinstance(given, (list, dict)):
        return _axis(lesson, "", SEED_KNOB, given).values, 0
    return (), _whole("seeds", given, 1, int(knob.high - knob.low) + 1)


def _collecting(study: Study, given: list[str] | None) -> Study:
    """The study with the names that it collects, which are those of its first and last run. Raises StudyError."""
    found: dict[str, float] = {}
    problems = []
    for index in sorted({0, study.size - 1}):
        try:
            lesson, design = design_at(study, index)
            found.update(numbers(outcome_of(lesson, design, study.final and index == 0)))
        except (EngineError, KnobError) as problem:
            problems.append(problem)
    if not found:
        raise StudyError(f"Neither the first nor the last run of the study can be computed: {problems[0]}")
    if given is None:
        return replace(study, collect=tuple(found))
    for name in given:
        if name not in found:
            raise StudyError(f"Lesson {study.lesson} gives no {name[:40]}; it gives {', '.join(found)}.")
    return replace(study, collect=tuple(dict.fromkeys(given)))
