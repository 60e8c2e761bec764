"""Print lessons, runs and JSON."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..course.knobs import Choice, Knob, Number
from ..course.knobs import Poles as PolesKnob
from ..course.lesson import Lesson
from ..export.data.data import plain
from ..text import languages
from .terminal import shows


def print_lesson(lesson: Lesson) -> None:
    """A lesson in words: every knob as `run` takes it, and the tasks."""
    words = lesson.words["en"]
    place = lesson.place
    after = f"after {', '.join(place.needs)}" if place.needs else "needs none before"
    ways = "".join(f"; {way.title('en')}" for way in place.ways)
    standing = "draft" if lesson.draft else f"{place.minutes} min, {after}{ways}"
    print(f"{lesson.number}. {lesson.id}: {words.question}\n     {standing}")
    for knob in lesson.knobs:
        unit = f" {knob.unit}" if knob.unit else ""
        print(f"     --set {knob.name}={knob.show(knob.check(knob.default))}    {knob.label('en')}, "
              f"{_bounds(knob)}{unit}")
    for task in lesson.tasks:
        print(f"     task {task.id}: {words.tasks[task.id].title}")


def lesson_record(lesson: Lesson) -> dict[str, Any]:
    """A lesson as JSON: its words, knobs and tasks."""
    words = lesson.words
    return {
        "id": lesson.id, "number": lesson.number, "source": lesson.source,
        "title": {lang: prose.title for lang, prose in words.items()},
        "question": {lang: prose.question for lang, prose in words.items()},
        "draft": lesson.draft,
        "minutes": lesson.place.minutes, "needs": list(lesson.place.needs), "ways": [way.id for way in lesson.place.ways],
        "knobs": [_knob_record(knob) for knob in lesson.knobs],
        "tasks": [{"id": task.id, "title": {lang: prose.tasks[task.id].title for lang, prose in words.items()}}
                  for task in lesson.tasks],
        "final": lesson.job is not None,
    }


def _knob_record(knob: Knob) -> dict[str, Any]:
    record = {"name": knob.name, "kind": type(knob).__name__.lower(), "unit": knob.unit,
              "label": {code: knob.label(code) for code in languages()}, "default": plain(knob.check(knob.default))}
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


def print_json(record: Any) -> None:
    """A record as one line of strict JSON; letters that standard output cannot show are written as \\u escapes."""
    words = json.dumps(record, ensure_ascii=False, allow_nan=False)
    print(words if shows(words) else json.dumps(record, allow_nan=False), flush=True)


def print_run(lesson: Lesson, record: Mapping[str, Any]) -> None:
    """A run in words."""
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
        print(f"  {_said(check)}  {check['text']['en']}")
    if record["series"]:
        t = record["series"]["t"]
        print(f"series\n  {', '.join(record['series'])}: {len(t)} samples from {t[0]:g} to {t[-1]:g} s (use --json)")
    sys.stdout.flush()


def _said(check: Mapping[str, Any]) -> str:
    """What is said before a check; one that only says which case holds does not fail."""
    if check.get("informative"):
        return "yes  " if check["holds"] else "no   "
    return "holds" if check["holds"] else "FAILS"


def _pole(re: float | None, im: float | None) -> str:
    if re is None or im is None:
        return "not finite"
    return f"{re:.6g}" if im == 0 else f"{re:.6g}{im:+.6g}j"
