"""Write and read what a tab stores in its browser to survive a reload.

It has been out of our hands when it comes back, so all of it is judged anew. The state of a lesson is judged when the lesson
is opened.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field

from ...course.course_map import Progress
from ...course.exercises.typed_answers import MAX_TYPED_CHARACTERS
from ...course.guiding.questions import COLUMNS
from ...course.knobs import KnobError
from ...course.lectures import Lecture, read_lecture, write_lecture
from ...course.lesson import Design, Lesson, Verdict
from ...course.pinned_designs import MAX_PINS as MOST_PINS
from ...course.pinned_designs import Pin
from ...course.scenes import MODES, Mode, entry_values
from ...engine import EngineError
from ...plants.own_plant import clean_plant_json
from ...text import languages, read_outside_json, text
from .history import read_steps, write_steps
from .lesson_state import LessonState
from .saved_state import LONGEST_NAME, MAX_OPTIONS, changed_knobs, check_state, design_as_plain_data, design_with_knobs
from .view import MOST_ANSWERS, MOST_VARIANTS, ExamAnswer, ExamState, State, TaskState

VERSION = 2
MAX_MEMORY_BYTES = 300_000  # bytes that a tab keeps; what was worked on longest ago is left out
SOLVED = text("Solved before the page was loaded again.")


@dataclass(frozen=True)
class TabMemory:
    """What came back: `lesson_states` are as they were written, by lesson."""

    lesson: str
    language: str = "en"
    lecture: bool = False
    dark: bool | None = None
    plant: str = ""
    key: str = ""
    word: str = ""
    fresh: str = ""
    withheld: bool = False
    mode: Mode | None = None
    talk: Lecture | None = None
    stop: int = 0
    hand_ins: Mapping[str, str] = field(default_factory=dict)
    lesson_states: Mapping[str, object] = field(default_factory=dict)
    own: tuple[str, tuple[str, ...]] = "", ()  # the .zip of lessons that was open, and their ids


def write_lesson_state(lesson: Lesson, kept: LessonState, state: State) -> str:
    """The state of a lesson as JSON: its present design and the steps about it, the prediction, and how far its tasks are."""
    history, began = kept.history, kept.began
    steps = write_steps(lesson, history)
    tasks = {name: [task.hints, task.solution, task.verdict is not None and task.verdict.solved]
             for name, task in state.tasks.items()}
    own = lesson.origin or lesson
    done = {name: changed_knobs(own, design) for name, design in state.done.items()}
    path = [state.scene, done, dict(state.chosen), *([] if began is None or began.plant else [changed_knobs(own, began)])]
    return json.dumps(
        {
            **design_as_plain_data(lesson, history.design),
            "predicted": state.predicted,
            "revealed": state.revealed,
            **({} if state.again is None else {"again": state.again}),
            "tasks": tasks,
            "exams": {name: [exam.variant, [[a.student, a.variant, a.said] for a in exam.answers]] for name, exam in state.exams.items()},
            **({"sketches": dict(state.sketches)} if state.sketches else {}),
            **({"path": path} if state.done or state.chosen or state.scene else {}),
            **({"pins": [[pin.name, design_as_plain_data(lesson, pin.design), pin.ghost] for pin in state.pins]} if state.pins else {}),
            **({"steps": steps} if steps else {}),
        },
        ensure_ascii=False,
    )


def write_memory(lesson: str, state: State, lesson_states: Iterable[tuple[str, str]]) -> str:
    """The tab as JSON: the lesson that is open and, latest first, as many written states of lessons as there is room for."""
    head = {"version": VERSION, "lesson": lesson, "language": state.language, "lecture": state.lecture,
            "dark": state.dark, "key": "" if state.learner else state.key, "word": state.word, "fresh": state.fresh,
            "withheld": state.withheld, "mode": state.mode}
    if state.talk is not None:
        head["talk"] = [write_lecture(state.talk), state.stop]
    if state.hand_ins:
        head["hand_ins"] = dict(state.hand_ins)
    if state.own is not None and state.own.file:
        head["own"] = [state.own.file, [*state.own.ids, *state.own.lost]]
    if state.plant:
        head["yours"] = json.loads(state.plant)
    start = json.dumps(head, ensure_ascii=False)[:-1] + ', "desks": {'
    left, parts = MAX_MEMORY_BYTES - _size(start) - 2, []
    for name, written in lesson_states:
        part = f"{json.dumps(name)}: {written}"
        left -= _size(part) + 2
        if left < 0:
            break
        parts.append(part)
    return start + ", ".join(parts) + "}}"


def read_memory(written: str | None, lessons: Mapping[str, Lesson], otherwise: str = "") -> TabMemory | None:
    """The tab that `write_memory` wrote, None if there is none that can be read.

    Where its lessons came from a file that is not open any more, their states are kept, and the tab opens on the lesson `otherwise`.
    """
    try:
        data = read_outside_json(written) if written and _size(written) <= MAX_MEMORY_BYTES else None
    except ValueError:
        return None
    if not isinstance(data, dict) or data.get("version") != VERSION:
        return None
    lesson, language, kept = data.get("lesson"), data.get("language"), data.get("desks")
    own = _own(data.get("own"))
    lesson = otherwise if own[0] and lesson not in lessons else lesson
    if not isinstance(lesson, str) or lesson not in lessons or not isinstance(kept, dict):
        return None
    return TabMemory(lesson, language if language in languages() else "en", data.get("lecture") is True,
                  dark if isinstance(dark := data.get("dark"), bool) else None,
                  _plant(data.get("yours")), _short(data.get("key")), _short(data.get("word")), _short(data.get("fresh")),
                  data.get("withheld") is True,
                  mode if (mode := data.get("mode")) in MODES else None, *_talk(data.get("talk"), lessons), _hand_ins(data.get("hand_ins")),
                  {name: each for name, each in kept.items() if name in lessons or name in own[1]}, own)


def _own(data: object) -> tuple[str, tuple[str, ...]]:
    """The .zip of lessons that was open, and their ids; neither where there was none."""
    match data:
        case [str(file), list(ids)]:
            return _short(file), tuple(id for id in ids if isinstance(id, str))
    return "", ()


def _talk(data: object, lessons: Mapping[str, Lesson]) -> tuple[Lecture | None, int]:
    """The lecture that was being given and its stop; none where it cannot be read."""
    match data:
        case [str(words), int(stop)]:
            with suppress(KnobError):
                talk = read_lecture(words, lessons)
                return talk, min(max(0, stop), len(talk.stops) - 1)
    return None, 0


def read_lesson_state(data: object, lesson: str, lessons: Mapping[str, Lesson]) -> LessonState | None:
    """The state that `write_lesson_state` wrote for a lesson, None if it is not one."""
    try:
        design = check_state(data, lessons).design
    except (KnobError, EngineError, RecursionError, OverflowError):
        return None
    if not isinstance(data, dict) or design.lesson != lesson:
        return None
    words = lessons[lesson].words["en"]
    predicted = _chosen(data.get("predicted"), len(words.options))
    return LessonState(
        read_steps(data.get("steps"), data, design, lessons),
        predicted,
        predicted is not None and data.get("revealed") is True,
        _chosen(data.get("again"), 0 if words.again is None else len(words.again.options)),
        _tasks(data.get("tasks"), lessons[lesson]),
        _exams(data.get("exams"), lessons[lesson]),
        _pins(data.get("pins"), lesson, lessons),
        False,
        *_scenes(data.get("path"), lessons[lesson]),
        sketches=_sketches(data.get("sketches"), lessons[lesson]),
        began=_began(data.get("path"), lessons[lesson]),
    )


def _scenes(data: object, lesson: Lesson) -> tuple[int, dict[str, Design], dict[str, int]]:
    """The scene that was open, those that were done, and the options chosen in them; the start of the path where it cannot be read.

    A scene that was done keeps the design of its run; a list of names, as it was written before, takes the path's own designs.
    """
    ids = [scene.id for scene in lesson.path]
    match data:
        case [int(scene), (list() | dict()) as done, dict(chosen), *_] if 0 <= scene < max(1, len(ids)):
            options = {name: index for name, index in chosen.items() if name in ids and type(index) is int and -1 <= index < MAX_OPTIONS}
            kept = {name: found for name in done if name in ids
                    if (found := _kept(done[name] if isinstance(done, dict) else None, ids.index(name), lesson)) is not None}
            return scene, kept, options
    return 0, {}, {}


def _sketches(data: object, lesson: Lesson) -> dict[str, tuple[float, ...]]:
    """The predictions that were drawn by hand; one that cannot be read is left out."""
    ids = {scene.id for scene in lesson.path}
    return {name: tuple(map(float, heights)) for name, heights in data.items() if name in ids and isinstance(heights, list)
            and 0 < len(heights) <= COLUMNS and all(type(h) in (int, float) and math.isfinite(h) for h in heights)
            } if isinstance(data, dict) else {}


def _began(data: object, lesson: Lesson) -> Design | None:
    """The design with which the open scene began, None where it cannot be read."""
    match data:
        case [int(scene), _, _, dict(knobs)] if 0 <= scene < len(lesson.path):
            return _kept(knobs, scene, lesson)
    return None


def _kept(knobs: object, index: int, lesson: Lesson) -> Design | None:
    """The design with which a scene was done, None where it cannot be read."""
    try:
        if knobs is None:
            return lesson.apply(lesson.start(), {**entry_values(lesson.path, index, lesson.start()), **lesson.path[index].play})
        return design_with_knobs(lesson, knobs) if isinstance(knobs, dict) else None
    except (KnobError, EngineError, RecursionError, OverflowError):
        return None


def _chosen(index: object, options: int) -> int | None:
    """The index of an option, −1 where it was skipped; None where it is neither."""
    return index if isinstance(index, int) and not isinstance(index, bool) and options and -1 <= index < options else None


def progress_in_saved_state(data: object) -> Progress:
    """What the written state of a lesson tells of a person's progress, before it is judged whole."""
    match data:
        case {"predicted": predicted, "tasks": dict(tasks)}:
            solved = sum(isinstance(task, list) and len(task) == 3 and task[2] is True for task in tasks.values())
            return Progress(predicted is not None, solved)
    return Progress()


def _tasks(data: object, lesson: Lesson) -> dict[str, TaskState]:
    out = {}
    for task in lesson.tasks:
        match data.get(task.id) if isinstance(data, dict) else None:
            case [int(hints), bool(solution), bool(solved)] if 0 <= hints <= 100:
                out[task.id] = TaskState(_solved(solved), hints, solution)
    return out


def _exams(data: object, lesson: Lesson) -> dict[str, ExamState]:
    out = {}
    for exam in lesson.exams:
        match data.get(exam.id) if isinstance(data, dict) else None:
            case [int(variant), list(answers)] if 1 <= variant <= MOST_VARIANTS:
                given = (ExamAnswer(_short(who), int(count), _short(said)) for who, count, said in _triples(answers[-MOST_ANSWERS:]))
                out[exam.id] = ExamState(variant, tuple(given))
    return out


def _hand_ins(data: object) -> dict[str, str]:
    """Tokens by the name of their item; whether they are signed is judged where a course is known."""
    return {name: token for name, token in data.items() if isinstance(token, str)} if isinstance(data, dict) else {}


def _triples(answers: list[object]) -> Iterator[tuple[str, int, str]]:
    for answer in answers:
        match answer:
            case [str(student), int(variant), str(said)] if 0 <= variant <= MOST_VARIANTS:
                yield student, int(variant), said


def _short(words: object) -> str:
    return words[:MAX_TYPED_CHARACTERS] if isinstance(words, str) else ""


def _pins(data: object, lesson: str, lessons: Mapping[str, Lesson]) -> tuple[Pin, ...]:
    """The pins that can still be read, each under a name of its own."""
    found: dict[str, Pin] = {}
    for entry in data[:MOST_PINS] if isinstance(data, list) else ():
        match entry:
            case [str(name), dict(written), *rest] if 0 < len(name) <= LONGEST_NAME:
                with suppress(KnobError, EngineError, RecursionError, OverflowError):
                    design = check_state(written, lessons).design
                    if design.lesson == lesson:
                        found[name] = Pin(name, design, rest == [True])
    return tuple(found.values())


def _solved(solved: object) -> Verdict | None:
    return Verdict(True, SOLVED) if solved is True else None


def _plant(data: object) -> str:
    """The plant that the person brought."""
    try:
        return clean_plant_json(json.dumps(data)) if data is not None else ""
    except (EngineError, RecursionError, OverflowError):
        return ""


def _size(written: str) -> int:
    return len(written.encode("utf-8", "surrogatepass"))
