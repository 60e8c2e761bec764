"""How a design is written down, so that it can travel: to a file, through a reload, and back."""

from __future__ import annotations

import json
from collections.abc import Mapping

from ..engine import EngineError
from ..lesson.knobs import KnobError
from ..lesson.lesson import Design, Lesson
from ..plants.own import canonical, plant_of
from ..text import listed, same, text, told

VERSION = 1
LONGEST = 200_000  # characters of a written design that are read at all


def write_design(lesson: Lesson, design: Design) -> str:
    """The design as JSON: {"version", "lesson", "knobs": {name: text}}; the texts are what `--set` takes.

    A design with the user's own plant has that as "plant" too, in the form of a plant file.
    """
    return json.dumps(plain(lesson, design), ensure_ascii=False)


def read_design(written: str, lessons: Mapping[str, Lesson]) -> Design:
    """The design that `write_design` wrote; knobs it does not name stay at their defaults. Raises KnobError."""
    try:
        data = json.loads(written) if len(written) <= LONGEST else None
    except (ValueError, RecursionError):
        data = None
    return from_plain(data, lessons)


def from_plain(data: object, lessons: Mapping[str, Lesson]) -> Design:
    """The design that `plain` gave; it has been out of our hands, and is judged anew. Raises KnobError."""
    if not isinstance(data, dict) or not isinstance(data.get("knobs"), dict):
        raise KnobError(text("This is not a design of Observer Lab; save one with the app and give that."))
    if data.get("version") != VERSION:
        raise KnobError(text("This design has version {found}; this Observer Lab reads version {version}.",
                             found=data.get("version"), version=VERSION))
    lesson = lessons.get(str(data.get("lesson")))
    if lesson is None:
        name = str(data.get("lesson"))[:40]
        raise KnobError(text("There is no lesson {name}; there are {names}.", name=name,
                             names=listed(map(same, lessons))))
    fitted = _with_plant(lesson, data.get("plant"))
    return fitted.apply(fitted.start(), {name: fitted.knob(name).parse(str(value)) for name, value in
                                         data["knobs"].items()})


def _with_plant(lesson: Lesson, plant: object) -> Lesson:
    """The lesson for the plant that a design brings. What a file says of a plant passes the same gate as an upload."""
    if plant is None:
        return lesson
    try:
        return lesson.fit(canonical(plant_of(json.dumps(plant))))
    except EngineError as problem:
        raise KnobError(told(problem)) from problem


def plain(lesson: Lesson, design: Design) -> dict[str, object]:
    """What `write_design` writes, before it is text."""
    knobs = lesson.fit(design.plant).knobs if design.plant != lesson.plant else lesson.knobs
    show = {knob.name: knob.show for knob in knobs}
    return {"version": VERSION, "lesson": lesson.id,
            "knobs": {name: show[name](value) for name, value in design.values},
            **({"plant": json.loads(design.plant)} if design.plant else {})}
