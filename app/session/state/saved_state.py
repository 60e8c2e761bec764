"""Write and read as JSON a tab's state, for links, files and reloads, and the designs a browser keeps.

One record for all of them, plain data that JSON can hold; `token` packs it for a link. It has been out of our hands when
it comes back, so all of it is judged anew.
"""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache

from ...course.knobs import KnobError, Pull
from ...course.lesson import Design, Lesson
from ...course.scenes import MODES, Mode
from ...engine import EngineError
from ...plants.examples import EXAMPLES, example
from ...plants.own_plant import clean_plant_json
from ...text import Text, error_words, languages, listed, read_outside_json, same, text

VERSION = 1
MAX_STATE_CHARACTERS = 200_000  # characters of a written state that are read at all
MAX_CAMERA_DISTANCE = 100.0  # stage units: no camera stands farther off
MAX_OPTIONS = 8  # of a question
LONGEST_NAME = 60  # characters of a figure tab's name
FIELDS = frozenset({"version", "lesson", "knobs", "plant", "defaults", "language", "print", "tab", "step", "camera", "withheld",
                    "mode", "scene", "answered"})
# what a tab keeps beside a design, read by `memory`
LESSON_FIELDS = frozenset({"predicted", "revealed", "again", "tasks", "exam", "exams", "pins", "steps", "path", "sketches"})
NO_STATE = text("This is not a design of Observer Lab; save one with the app and give that.")
TOO_LARGE = text("The design holds a number or a nesting too large for a computer; simplify it.")
OTHER_DEFAULTS = text("The lesson's defaults have changed since this was saved; what it does not name stands as it is today.")
MAX_SAVED_DESIGNS = 60  # designs that are kept
MAX_SAVED_BYTES = 60_000  # bytes that all of them take: what a browser keeps comes back in one message, which has its bound


@dataclass(frozen=True)
class SavedState:
    """What a link restores: the design, and how the page showed it.

    `tab` is the English name of the figures' tab, `step` the index of the opened step of thought, `camera` position and
    target in stage units; None where the page stood as it opens. `withheld` says that nothing is told of answers to exams.
    `notes` say what could not be taken over.
    """

    design: Design
    language: str = "en"
    lecture: bool = False
    tab: str | None = None
    step: int | None = None
    camera: tuple[float, ...] | None = None
    withheld: bool = False
    mode: Mode | None = None
    scene: str = ""  # its id; "" where the state names none
    answered: int | None = None  # that scene is done with this design: the option chosen, −1 without one
    notes: tuple[Text, ...] = ()


def write_state(lesson: Lesson, saved: SavedState) -> str:
    """A state as JSON: {"version", "lesson", "knobs": {name: text}, …}; the texts are what `--set` takes.

    Only knobs that differ from their defaults are named. An example plant is named too, the user's own is written out in
    the form of a plant file.
    """
    return json.dumps({"version": VERSION, **short(lesson, saved)}, ensure_ascii=False)


def read_state(written: str, lessons: Mapping[str, Lesson]) -> SavedState:
    """The state that `write_state` wrote; knobs it does not name stay at their defaults. Raises KnobError."""
    try:
        data = read_outside_json(written) if len(written) <= MAX_STATE_CHARACTERS else None
    except ValueError:
        data = None
    return check_state(data, lessons)


def check_state(data: object, lessons: Mapping[str, Lesson]) -> SavedState:
    """The state in plain data from a stranger. Raises KnobError, in one sentence."""
    if not isinstance(data, dict) or not isinstance(data.get("knobs"), dict):
        raise KnobError(NO_STATE)
    if data.get("version") != VERSION:
        raise KnobError(text("This design has version {found}; this Observer Lab reads version {version}.",
                             found=str(data.get("version"))[:40], version=VERSION))
    lesson = lessons.get(str(data.get("lesson")))
    if lesson is None:
        name = str(data.get("lesson"))[:40]
        raise KnobError(text("There is no lesson {name}; there are {names}.", name=name,
                             names=listed(map(same, lessons))))
    try:
        fitted = _with_plant(lesson, data.get("plant"))
        design, notes = _designed(fitted, data["knobs"])
        answered = _answered(data.get("answered"), _scene(data.get("scene"), lesson))
    except EngineError as problem:
        raise KnobError(error_words(problem)) from problem
    except (OverflowError, RecursionError) as problem:
        raise KnobError(TOO_LARGE) from problem
    strange = [str(key)[:40] for key in data if key not in FIELDS | LESSON_FIELDS]
    notes += [text("Left out, because this Observer Lab has no such part: {names}.", names=listed(map(same, strange[:5])))
              ] if strange else []
    notes += [OTHER_DEFAULTS] if data.get("defaults", defaults_of(lesson)) != defaults_of(lesson) else []
    language, tab, step = data.get("language"), data.get("tab"), data.get("step")
    return SavedState(design, language if isinstance(language, str) and language in languages() else "en", data.get("print") is True,
                 tab if isinstance(tab, str) and len(tab) <= LONGEST_NAME else None,
                 step if _index(step, len(lesson.words["en"].steps)) else None, _camera(data.get("camera")),
                 data.get("withheld") is True,
                 mode if (mode := data.get("mode")) in MODES else None, _scene(data.get("scene"), lesson), answered, tuple(notes))


def _designed(lesson: Lesson, knobs: Mapping[str, object]) -> tuple[Design, list[Text]]:
    """The lesson's design with these knobs, and a note on those that the lesson does not have (any more)."""
    known = {knob.name: knob for knob in lesson.knobs}
    strange = [name[:40] for name in knobs if name not in known]
    notes = [text("Left out, because lesson {id} has no such knob: {names}.", id=lesson.id,
                  names=listed(map(same, strange[:5])))] if strange else []
    changes = {name: known[name].parse(str(value)) for name, value in knobs.items() if name in known}
    return lesson.apply(lesson.start(), changes), notes


def _with_plant(lesson: Lesson, plant: object) -> Lesson:
    """The lesson for the plant that a state brings. What a file says of a plant passes the same gate as an upload."""
    if plant is None:
        return lesson
    return lesson.fit(example(plant) if isinstance(plant, str) else clean_plant_json(json.dumps(plant)))


def _scene(name: object, lesson: Lesson) -> str:
    return name if isinstance(name, str) and any(scene.id == name for scene in lesson.path) else ""


def _answered(option: object, scene: str) -> int | None:
    """The option with which a scene was answered, −1 where it asks for something else; None where it is not done."""
    return option if scene and type(option) is int and -1 <= option < MAX_OPTIONS else None


def _index(value: object, count: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < count


def _camera(value: object) -> tuple[float, ...] | None:
    """Position and target, None where they are no six numbers within reach or too near each other to look."""
    if not isinstance(value, list) or len(value) != 6 or not all(type(v) in (int, float) for v in value):
        return None
    if not all(math.isfinite(v) and abs(v) <= MAX_CAMERA_DISTANCE for v in value) or math.dist(value[:3], value[3:]) < 0.01:
        return None
    return tuple(map(float, value))


# --- writing -----------------------------------------------------------------------------------------------------------
def design_as_plain_data(lesson: Lesson, design: Design) -> dict[str, object]:
    """A whole design as plain data: every knob, and the user's own plant written out."""
    return {"version": VERSION, "lesson": lesson.id, "knobs": dict(_shown(_own(lesson, design), design)),
            **({"plant": json.loads(design.plant)} if design.plant else {})}


def short(lesson: Lesson, saved: SavedState) -> dict[str, object]:
    """A state as plain data, without what is as it is anyway."""
    design = saved.design
    own = _own(lesson, design)
    named = _example_of(design.plant)
    record = {"lesson": lesson.id, "knobs": changed_knobs(own, design),
              "plant": None if not design.plant else named or json.loads(design.plant), "defaults": defaults_of(lesson),
              "language": saved.language, "print": saved.lecture or None, "tab": saved.tab, "step": saved.step,
              "camera": None if saved.camera is None else [_rounded(v) for v in saved.camera], "withheld": saved.withheld or None,
              "mode": saved.mode, "scene": saved.scene or None, "answered": saved.answered}
    return {key: value for key, value in record.items() if value is not None}


def changed_knobs(lesson: Lesson, design: Design) -> dict[str, str]:
    """The knobs of a design that do not stand at their defaults, as the texts that `--set` takes."""
    start = dict(_shown(lesson, lesson.start()))
    return {name: words for name, words in _shown(lesson, design) if words != start[name]}


def design_with_knobs(lesson: Lesson, knobs: Mapping[str, object]) -> Design:
    """The design that `changed_knobs` wrote. Raises KnobError."""
    return _designed(lesson, knobs)[0]


def defaults_of(lesson: Lesson) -> str:
    """Four letters that change when a default of the lesson's own plant does, or a knob comes or goes."""
    return _letters(lesson.origin or lesson)


@lru_cache(maxsize=64)
def _letters(lesson: Lesson) -> str:
    hands = {knob.name for knob in lesson.knobs if isinstance(knob, Pull)}  # what nobody has pulled changes no run
    words = "".join(f"{name}={_coarse(value)};" for name, value in lesson.start().values if name not in hands)
    return f"{zlib.crc32(words.encode()) & 0xFFFF:04x}"


def _coarse(value: object) -> str:
    """A value to six digits: what the last bits of another machine's numerics move is no other default."""
    if isinstance(value, tuple):
        return ",".join(map(_coarse, value))
    return f"{value:.6g}" if isinstance(value, (float, complex)) else str(value)


@lru_cache(maxsize=64)
def _example_of(plant: str) -> str | None:
    """The name of the example that a plant is, None where it is none."""
    return next((key for key in EXAMPLES if plant == example(key)), None)


def _own(lesson: Lesson, design: Design) -> Lesson:
    return lesson.fit(design.plant) if design.plant != lesson.plant else lesson


def _shown(lesson: Lesson, design: Design) -> Iterator[tuple[str, str]]:
    show = {knob.name: knob.show for knob in lesson.knobs}
    yield from ((name, show[name](value)) for name, value in design.values)


def _rounded(value: float) -> float | int:
    short = round(value, 2)
    return int(short) if short == int(short) else short


@dataclass(frozen=True)
class SavedDesign:
    """A design under a name: `words` are those of a saved state, judged when it is opened."""

    name: str
    lesson: str
    words: str


def read_saved_designs(written: str | None, lessons: Mapping[str, Lesson]) -> tuple[SavedDesign, ...]:
    """What a browser says that it keeps; whatever is no design under a name is passed over."""
    try:
        data = read_outside_json(written) if written and len(written) <= 10 * MAX_SAVED_BYTES else None
    except ValueError:
        return ()
    found = [SavedDesign(name, lesson, words) for name, words in data.items() if (lesson := _lesson_of(name, words, lessons))
             ] if isinstance(data, dict) else []
    return tuple(found[:MAX_SAVED_DESIGNS])


def _lesson_of(name: str, words: object, lessons: Mapping[str, Lesson]) -> str | None:
    """The lesson of what is kept under a name, None if it is not one."""
    if not isinstance(words, str) or len(words) > MAX_STATE_CHARACTERS or not 0 < len(name) <= LONGEST_NAME or not name.isprintable():
        return None
    try:
        data = read_outside_json(words)
    except ValueError:
        return None
    lesson = data.get("lesson") if isinstance(data, dict) else None
    return lesson if isinstance(lesson, str) and lesson in lessons else None
