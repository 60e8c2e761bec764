"""Read a lecture: an ordered list of scenes of any lessons, with minutes and speaker's notes.

A lecture is a small TOML file. A title or a note is one text, or one text for each language:

    title = {en = "Separation in 30 minutes", de = "Trennung in 30 Minuten"}
    minutes = 30

    [[stops]]
    lesson = "separation"
    scene = "predict"
    minutes = 2.5
    note = "Ask for a show of hands."

`minutes` and `note` of a stop may be left out: then those of the scene hold.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..text import read_outside_toml, text
from ..text.schema import shown
from .knobs import KnobError
from .lesson import Lesson

LECTURE_KEYS, STOP_KEYS = ("title", "minutes", "stops"), ("lesson", "scene", "minutes", "note")
MAX_STOPS, MAX_MINUTES = 100, 240.0
MAX_TITLE_CHARS, MAX_NOTE_CHARS = 120, 1000
MAX_LECTURE_CHARS = 60_000  # characters of a lecture's file
PREPARED_FOLDER = Path(__file__).parents[2] / "assets" / "lectures"


@dataclass(frozen=True)
class Stop:
    """One scene of a lecture. `note` holds the speaker's note by language; it is empty where the scene's own note holds."""

    lesson: str
    scene: str
    note: Mapping[str, str]
    minutes: float


@dataclass(frozen=True)
class Lecture:
    """A lecture: its title by language, its stops in order, and the minutes it is planned for."""

    title: Mapping[str, str]
    stops: tuple[Stop, ...]
    minutes: float

    @property
    def planned(self) -> float:
        """The sum of the minutes of the stops."""
        return sum(stop.minutes for stop in self.stops)


def words_in(words: Mapping[str, str], language: str) -> str:
    """A title or note in a language, else in English, else in the language it has; "" where there is none."""
    return words.get(language) or words.get("en") or next(iter(words.values()), "")


def read_lecture(text_of_file: str, lessons: Mapping[str, Lesson]) -> Lecture:
    """The lecture of a TOML text, all of whose scenes exist in `lessons`. Raises KnobError, in one sentence."""
    if len(text_of_file) > MAX_LECTURE_CHARS:
        raise KnobError(text("The lecture is too long; it may have {most} characters.", most=MAX_LECTURE_CHARS))
    try:
        data = read_outside_toml(text_of_file)
    except tomllib.TOMLDecodeError as error:
        raise KnobError(text("The lecture is not a valid TOML file: {reason}.", reason=str(error)[:120])) from error
    for key in data:
        if key not in LECTURE_KEYS:
            raise KnobError(text("The lecture has an unknown key {key}; use {keys}.", key=shown(key), keys=", ".join(LECTURE_KEYS)))
    title = _words(data.get("title", ""), MAX_TITLE_CHARS)
    if not title:
        raise KnobError(text("The lecture needs a title of at most {most} characters.", most=MAX_TITLE_CHARS))
    stops = data.get("stops", [])
    if not isinstance(stops, list) or not 0 < len(stops) <= MAX_STOPS:
        raise KnobError(text("The number of stops must be from 1 to {most}; write each under [[stops]].", most=MAX_STOPS))
    found = tuple(_stop(number, stop, lessons) for number, stop in enumerate(stops, 1))
    minutes = _minutes(data.get("minutes", sum(stop.minutes for stop in found)), MAX_STOPS * MAX_MINUTES)
    if minutes is None:
        raise KnobError(text("The minutes of the lecture must be a positive number."))
    return Lecture(title, found, minutes)


def write_lecture(lecture: Lecture) -> str:
    """A lecture as the TOML text that `read_lecture` reads."""
    lines = [f"title = {_toml_words(lecture.title)}", f"minutes = {lecture.minutes:g}"]
    for stop in lecture.stops:
        lines += ["", "[[stops]]", f"lesson = {_toml_text(stop.lesson)}", f"scene = {_toml_text(stop.scene)}",
                  f"minutes = {stop.minutes:g}"]
        lines += [f"note = {_toml_words(stop.note)}"] if stop.note else []
    return "\n".join(lines) + "\n"


def prepared_lectures(lessons: Mapping[str, Lesson]) -> tuple[Lecture, ...]:
    """The lectures that come with the lab and whose scenes all exist in `lessons`, the shortest first."""
    found = []
    for words in _prepared_files():
        try:
            found.append(read_lecture(words, lessons))
        except KnobError:  # of lessons that are not here
            continue
    return tuple(sorted(found, key=lambda lecture: lecture.minutes))


@lru_cache(maxsize=1)
def _prepared_files() -> tuple[str, ...]:
    return tuple(path.read_text(encoding="utf-8") for path in sorted(PREPARED_FOLDER.glob("*.toml")))


def _toml_words(words: Mapping[str, str]) -> str:
    return "{" + ", ".join(f"{_toml_text(language)} = {_toml_text(said)}" for language, said in words.items()) + "}"


def _toml_text(words: str) -> str:
    return json.dumps(words, ensure_ascii=False).replace("\x7f", "\\u007f")  # of JSON's strings TOML reads all but this one


def _stop(number: int, data: object, lessons: Mapping[str, Lesson]) -> Stop:
    if not isinstance(data, dict):
        raise KnobError(text("Stop {number} must be a table under [[stops]].", number=number))
    for key in data:
        if key not in STOP_KEYS:
            raise KnobError(text("Stop {number} has an unknown key {key}; use {keys}.", number=number, key=shown(key),
                                 keys=", ".join(STOP_KEYS)))
    id, scene_id = data.get("lesson", ""), data.get("scene", "")
    lesson = lessons.get(id) if isinstance(id, str) else None
    if lesson is None:
        raise KnobError(text("Stop {number}: there is no lesson {lesson}; use one of {lessons}.", number=number, lesson=shown(id),
                             lessons=", ".join(lessons)))
    scene = next((scene for scene in lesson.path if scene.id == scene_id), None)
    if scene is None:
        raise KnobError(text("Stop {number}: the lesson {lesson} has no scene {scene}; use one of {scenes}.", number=number, lesson=id,
                             scene=shown(scene_id), scenes=", ".join(scene.id for scene in lesson.path) or "—"))
    minutes = _minutes(data.get("minutes", scene.minutes), MAX_MINUTES)
    if minutes is None:
        raise KnobError(text("Stop {number}: the minutes must be a positive number up to {most:g}.", number=number, most=MAX_MINUTES))
    note = _words(data.get("note", ""), MAX_NOTE_CHARS)
    if note is None:
        raise KnobError(text("Stop {number}: the note must be a text, or one text for each language, of at most {most} characters.",
                             number=number, most=MAX_NOTE_CHARS))
    return Stop(lesson.id, scene.id, note, minutes)


def _words(value: Any, most: int) -> dict[str, str] | None:
    """A text, or texts by language, as texts by language; None where it is something else or too long."""
    by_language = {"en": value} if isinstance(value, str) else value
    if not isinstance(by_language, dict):
        return None
    if not all(isinstance(words, str) and len(words) <= most for words in by_language.values()):
        return None
    return {language: words.strip() for language, words in by_language.items() if words.strip()}


def _minutes(value: object, most: float) -> float | None:
    """A positive number of minutes up to `most`, else None."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value <= most:
        return None
    return float(value)
