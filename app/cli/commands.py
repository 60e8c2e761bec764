"""What the commands of the command line do. Each returns the exit status and prints to stdout."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lessons import LESSONS

from ..engine import EngineError, load_plant
from ..export.data import plain, run_record, save_csv
from ..lesson.figures import Figure
from ..lesson.knobs import Choice, Knob, KnobError, Number
from ..lesson.knobs import Poles as PolesKnob
from ..lesson.lesson import Design, Lesson, Outcome
from ..plants.examples import EXAMPLES, example
from ..plants.own import canonical
from ..tab.state import read_design


class InputError(Exception):
    """Input that a command cannot work with; the message is one sentence."""


@dataclass(frozen=True)
class RunRequest:
    """What `run` was asked for."""

    lesson: str
    changes: tuple[str, ...] = ()
    state: str | None = None
    final: bool = False
    figure: str | None = None
    csv: str | None = None
    plant: str | None = None


def list_lessons(as_json: bool) -> int:
    """Print every lesson with its knobs and tasks."""
    if as_json:
        _print_json([_lesson_record(lesson) for lesson in LESSONS.values()])
        return 0
    for lesson in LESSONS.values():
        words = lesson.words["en"]
        print(f"{lesson.number}. {lesson.id}: {words.question}")
        for knob in lesson.knobs:
            unit = f" {knob.unit}" if knob.unit else ""
            print(f"     --set {knob.name}={knob.show(knob.check(knob.default))}    {knob.label.en}, {_bounds(knob)}{unit}")
        for task in lesson.tasks:
            print(f"     task {task.id}: {words.tasks[task.id].title}")
    return 0


def run(request: RunRequest, as_json: bool) -> int:
    """Compute a design, write what was asked for, print the run; 1 if one of the lesson's checks does not hold."""
    design = _design(find_lesson(request.lesson), request)
    lesson = fitted(find_lesson(request.lesson), design.plant)
    try:
        outcome = _outcome(lesson, design, request.final)
        figures = lesson.figures(outcome)
    except EngineError as problem:
        raise InputError(f"This design cannot be computed: {problem}") from problem
    if request.figure is not None:
        _write(request.figure, lambda path: _save_figures(figures, path))
    if request.csv is not None:
        _write(request.csv, lambda path: save_csv(figures, path))
    record = run_record(design, outcome)
    _print_json(record) if as_json else _print_run(lesson, record)
    return 0 if all(check.holds for check in outcome.checks) else 1


def verify(as_json: bool) -> int:
    """Print every published number beside ours; 1 if one verdict is not what it should be."""
    from ..published import records, table, verify_all

    results = verify_all(records())
    if as_json:
        _print_json([result.record() for result in results])
    else:
        print(table(results))
    return 0 if all(result.holds for result in results) else 1


def find_lesson(id: str) -> Lesson:
    """The lesson of that id. Raises InputError naming those there are."""
    if id not in LESSONS:
        raise InputError(f"There is no lesson {id[:40]}; there are {', '.join(LESSONS)}.")
    return LESSONS[id]


def _design(lesson: Lesson, request: RunRequest) -> Design:
    if request.plant is not None and request.state is not None:
        raise InputError("Give --plant or --state, not both: a saved design brings its own plant.")
    try:
        if request.plant is not None:
            lesson = fitted(lesson, plant_in(request.plant))
        design = lesson.start() if request.state is None else _state(request.state, lesson)
        lesson = fitted(find_lesson(lesson.id), design.plant)
        for change in request.changes:
            name, equals, words = change.partition("=")
            if not equals:
                raise InputError(f"--set takes KNOB=VALUE; {change[:40]} has no equals sign.")
            design = lesson.apply(design, {name.strip(): lesson.knob(name.strip()).parse(words.strip())})
        return design
    except KnobError as problem:
        raise InputError(str(problem)) from problem
    except (OverflowError, RecursionError) as problem:
        raise InputError("The design holds a number or a nesting too large for a computer; simplify it.") from problem


def plant_in(name: str) -> str:
    """The canonical text of the plant in a file, or of an example of that name."""
    try:
        if name in EXAMPLES:
            return example(name)
        return canonical(load_plant(name))
    except EngineError as problem:
        raise InputError(str(problem)) from problem


def fitted(lesson: Lesson, plant: str) -> Lesson:
    """The lesson for that plant. Raises InputError where the two do not fit."""
    try:
        return lesson.fit(plant)
    except (EngineError, KnobError) as problem:
        raise InputError(str(problem)) from problem


def _state(name: str, lesson: Lesson) -> Design:
    """The design in a state file, which must belong to the lesson."""
    try:
        text = Path(name).read_text(encoding="utf-8")
    except UnicodeDecodeError as problem:
        raise InputError(f"The state file {name[:80]} is not text; give one that the app saved.") from problem
    except (OSError, ValueError) as problem:
        raise InputError(f"The state file {name[:80]} cannot be read ({cause(problem)}).") from problem
    design = read_design(text, LESSONS)
    if design.lesson != lesson.id:
        raise InputError(f"The state file {name[:80]} belongs to lesson {design.lesson}, not {lesson.id}.")
    return design


def _outcome(lesson: Lesson, design: Design, final: bool) -> Outcome:
    outcome = lesson.compute(design)
    if final and lesson.job is not None:
        for _, better in lesson.job.run(outcome):
            outcome = better
    return outcome


def _save_figures(figures: tuple[Figure, ...], path: str) -> None:
    from ..export.figure import ExportError, save_figures  # matplotlib is loaded only when a figure is drawn

    try:
        save_figures(figures, path)
    except ExportError as problem:
        raise InputError(str(problem)) from problem


def _write(path: str, save: Callable[[str], None]) -> None:
    try:
        save(path)
    except (OSError, ValueError) as problem:
        raise InputError(f"{path[:80]} cannot be written ({cause(problem)}); choose another place.") from problem


def cause(problem: Exception) -> str:
    words = getattr(problem, "strerror", None) or str(problem) or type(problem).__name__
    return words[:1].lower() + words[1:].rstrip(".")


def _lesson_record(lesson: Lesson) -> dict[str, Any]:
    words = lesson.words
    return {
        "id": lesson.id, "number": lesson.number, "source": lesson.source,
        "title": {lang: prose.title for lang, prose in words.items()},
        "question": {lang: prose.question for lang, prose in words.items()},
        "knobs": [_knob_record(knob) for knob in lesson.knobs],
        "tasks": [{"id": task.id, "title": {lang: prose.tasks[task.id].title for lang, prose in words.items()}}
                  for task in lesson.tasks],
        "final": lesson.job is not None,
    }


def _knob_record(knob: Knob) -> dict[str, Any]:
    record = {"name": knob.name, "kind": type(knob).__name__.lower(), "unit": knob.unit,
              "label": {"en": knob.label.en, "zh": knob.label.zh}, "default": plain(knob.check(knob.default))}
    for name in ("low", "high", "scale", "re_low", "re_high", "im_high"):
        if hasattr(knob, name):
            record[name] = plain(getattr(knob, name))
    if isinstance(knob, Choice):
        record["options"] = [name for name, _ in knob.options]
    return record


def _bounds(knob: Knob) -> str:
    if isinstance(knob, Number):
        return f"{knob.low:g} … {knob.high:g}"
    if isinstance(knob, Choice):
        return " | ".join(name for name, _ in knob.options)
    if isinstance(knob, PolesKnob):
        return f"{len(knob.default)} poles, {knob.re_low:g} ≤ Re ≤ {knob.re_high:g}, |Im| ≤ {knob.im_high:g}"
    return "t:value pairs" if hasattr(knob, "low") else "on | off"


def _print_json(record: Any) -> None:
    print(json.dumps(record, ensure_ascii=False, allow_nan=False), flush=True)


def _print_run(lesson: Lesson, record: Mapping[str, Any]) -> None:
    print(f"{lesson.number}. {lesson.id}: {lesson.words['en'].question}")
    print("knobs")
    for knob in lesson.knobs:
        print(f"  {knob.name} = {knob.show(knob.check(record['knobs'][knob.name]))}{' ' * bool(knob.unit)}{knob.unit}")
    print("gains")
    for name, gain in record["gains"].items():
        rows = np.array2string(np.asarray(gain), precision=6, max_line_width=10_000)
        print(f"  {name} = " + rows.replace("\n", "\n" + " " * (len(name) + 5)))
    print("poles")
    for name, poles in record["poles"].items():
        print(f"  {name}: " + ", ".join(_pole(*p) for p in poles))
    print("metrics")
    for name, value in record["metrics"].items():
        print(f"  {name} = {'not finite' if value is None else f'{value:.6g}'}")
    print("checks")
    for check in record["checks"]:
        print(f"  {'holds' if check['holds'] else 'FAILS'}  {check['text']['en']}")
    if record["series"]:
        t = record["series"]["t"]
        print(f"series\n  {', '.join(record['series'])}: {len(t)} samples from {t[0]:g} to {t[-1]:g} s (use --json)")
    sys.stdout.flush()


def _pole(re: float | None, im: float | None) -> str:
    if re is None or im is None:
        return "not finite"
    return f"{re:.6g}" if im == 0 else f"{re:.6g}{im:+.6g}j"
