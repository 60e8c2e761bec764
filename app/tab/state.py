"""How a design is written down, so that it can travel: to a file, through a reload, and back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from ..engine import EngineError
from ..lesson.knobs import KnobError
from ..lesson.lesson import Design, Lesson
from ..plants.own import canonical, plant_of
from ..text import languages, listed, same, text, told
from .picture import State

VERSION = 1
LONGEST = 200_000  # characters of a written design that are read at all


def write_design(lesson: Lesson, design: Design) -> str:
    """The design as JSON: {"version", "lesson", "knobs": {name: text}}; the texts are what `--set` takes.

    A design with the user's own plant has that as "plant" too, in the form of a plant file.
    """
    return json.dumps(_plain(lesson, design), ensure_ascii=False)


def read_design(written: str, lessons: Mapping[str, Lesson]) -> Design:
    """The design that `write_design` wrote; knobs it does not name stay at their defaults. Raises KnobError."""
    try:
        data = json.loads(written) if len(written) <= LONGEST else None
    except (ValueError, RecursionError):
        data = None
    if not isinstance(data, dict) or not isinstance(data.get("knobs"), dict):
        raise KnobError(text("This is not a design of Observer Lab; save one with the app and give that."))
    if data.get("version") != VERSION:
        raise KnobError(text("This design has version {found}; this Observer Lab reads version {version}.",
                             found=data.get("version"), version=VERSION))
    lesson = lessons.get(str(data.get("lesson")))
    if lesson is None:
        name = str(data.get("lesson"))[:40]
        raise KnobError(text("There is no lesson {name}; there are {names}.", name=name, names=listed(map(same, lessons))))
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


def _plain(lesson: Lesson, design: Design) -> dict[str, object]:
    knobs = lesson.fit(design.plant).knobs if design.plant != lesson.plant else lesson.knobs
    show = {knob.name: knob.show for knob in knobs}
    return {"version": VERSION, "lesson": lesson.id, "knobs": {name: show[name](value) for name, value in design.values},
            **({"plant": json.loads(design.plant)} if design.plant else {})}


@dataclass(frozen=True)
class Tab:
    """What a reload brings back."""

    design: Design
    language: str
    lecture: bool
    predicted: int | None
    revealed: bool
    plant: str = ""


def write_tab(lesson: Lesson, design: Design, state: State) -> str:
    """The tab as JSON: the design and what the person has chosen around it."""
    mine = {"yours": json.loads(state.plant)} if state.plant and state.plant != design.plant else {}
    return json.dumps({**_plain(lesson, design), "language": state.language, "lecture": state.lecture,
                       "predicted": state.predicted, "revealed": state.revealed, **mine}, ensure_ascii=False)


def read_tab(written: str | None, lessons: Mapping[str, Lesson]) -> Tab | None:
    """The tab that `write_tab` wrote, None if there is none that can be read."""
    try:
        design = read_design(written or "", lessons)
        data = json.loads(written or "")
    except (KnobError, ValueError):
        return None
    options = len(lessons[design.lesson].words["en"].options)
    predicted = data.get("predicted")
    return Tab(design, data.get("language") if data.get("language") in languages() else "en", data.get("lecture") is True,
               predicted if isinstance(predicted, int) and -1 <= predicted < options else None,
               data.get("revealed") is True, _yours(data.get("yours")) or design.plant)


def _yours(plant: object) -> str:
    """The plant that the person brought and does not show just now."""
    try:
        return canonical(plant_of(json.dumps(plant))) if plant is not None else ""
    except EngineError:
        return ""
