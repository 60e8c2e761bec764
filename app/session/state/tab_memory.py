"""Write and read what a tab stores in its browser to survive a reload.

It has been out of our hands when it comes back, so all of it is judged anew. A desk is judged when its lesson is
opened.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field

from ...course.course_map import Progress
from ...course.exercises.typed_answers import MAX_TYPED_CHARACTERS
from ...course.knobs import KnobError
from ...course.lectures import Lecture, read_lecture, write_lecture
from ...course.lesson import Lesson, Verdict
from ...course.pinned_designs import MAX_PINS as MOST_PINS
from ...course.pinned_designs import Pin
from ...course.scenes import MODES, Mode
from ...engine import EngineError
from ...plants.own_plant import clean_plant_json
from ...text import languages, read_outside_json, text
from .history import History
from .history_codec import read_steps, write_steps
from .lesson_state import LessonState
from .saved_state import LONGEST_NAME, check_state, design_as_plain_data
from .view import MOST_ANSWERS, MOST_VARIANTS, ExamAnswer, ExamState, State, TaskState

VERSION = 2
MAX_MEMORY_BYTES = 300_000  # bytes that a tab keeps; what was worked on longest ago is left out
MAX_OPTIONS = 8  # of a question
SOLVED = text("Solved before the page was loaded again.")


@dataclass(frozen=True)
class TabMemory:
    """What came back: `desks` are as they were written, by lesson."""

    lesson: str
    language: str = "en"
    lecture: bool = False
    dark: bool | None = None
    plant: str = ""
    key: str = ""
    fresh: str = ""
    withheld: bool = False
    mode: Mode | None = None
    talk: Lecture | None = None
    stop: int = 0
    hand_ins: Mapping[str, str] = field(default_factory=dict)
    desks: Mapping[str, object] = field(default_factory=dict)


def write_lesson_state(lesson: Lesson, history: History, state: State) -> str:
    """The desk of a lesson as JSON: its present design and the steps about it, the prediction, and how far its tasks are."""
    steps = write_steps(lesson, history)
    tasks = {name: [task.hints, task.solution, task.verdict is not None and task.verdict.solved]
             for name, task in state.tasks.items()}
    return json.dumps(
        {
            **design_as_plain_data(lesson, history.design),
            "predicted": state.predicted,
            "revealed": state.revealed,
            **({} if state.again is None else {"again": state.again}),
            "tasks": tasks,
            "exams": {name: [exam.variant, [[a.student, a.variant, a.said] for a in exam.answers]] for name, exam in state.exams.items()},
            **({"path": [state.scene, sorted(state.done), dict(state.chosen)]} if state.done or state.chosen or state.scene else {}),
            **({"pins": [[pin.name, design_as_plain_data(lesson, pin.design), pin.ghost] for pin in state.pins]} if state.pins else {}),
            **({"steps": steps} if steps else {}),
        },
        ensure_ascii=False,
    )


def write_memory(lesson: str, state: State, desks: Iterable[tuple[str, str]]) -> str:
    """The tab as JSON: the lesson that is open and, latest first, as many written desks as there is room for."""
    head = {"version": VERSION, "lesson": lesson, "language": state.language, "lecture": state.lecture,
            "dark": state.dark, "key": "" if state.learner else state.key, "fresh": state.fresh,
            "withheld": state.withheld, "mode": state.mode}
    if state.talk is not None:
        head["talk"] = [write_lecture(state.talk), state.stop]
    if state.hand_ins:
        head["hand_ins"] = dict(state.hand_ins)
    if state.plant:
        head["yours"] = json.loads(state.plant)
    start = json.dumps(head, ensure_ascii=False)[:-1] + ', "desks": {'
    left, parts = MAX_MEMORY_BYTES - _size(start) - 2, []
    for name, desk in desks:
        part = f"{json.dumps(name)}: {desk}"
        left -= _size(part) + 2
        if left < 0:
            break
        parts.append(part)
    return start + ", ".join(parts) + "}}"


def read_memory(written: str | None, lessons: Mapping[str, Lesson]) -> TabMemory | None:
    """The tab that `write_memory` wrote, None if there is none that can be read."""
    try:
        data = read_outside_json(written) if written and _size(written) <= MAX_MEMORY_BYTES else None
    except ValueError:
        return None
    if not isinstance(data, dict) or data.get("version") != VERSION:
        return None
    lesson, language, desks = data.get("lesson"), data.get("language"), data.get("desks")
    if not isinstance(lesson, str) or lesson not in lessons or not isinstance(desks, dict):
        return None
    return TabMemory(lesson, language if language in languages() else "en", data.get("lecture") is True,
                  dark if isinstance(dark := data.get("dark"), bool) else None,
                  _plant(data.get("yours")), _short(data.get("key")), _short(data.get("fresh")), data.get("withheld") is True,
                  mode if (mode := data.get("mode")) in MODES else None, *_talk(data.get("talk"), lessons), _hand_ins(data.get("hand_ins")),
                  {name: desk for name, desk in desks.items() if name in lessons})


def _talk(data: object, lessons: Mapping[str, Lesson]) -> tuple[Lecture | None, int]:
    """The lecture that was being given and its stop; none where it cannot be read."""
    match data:
        case [str(words), int(stop)]:
            with suppress(KnobError):
                talk = read_lecture(words, lessons)
                return talk, min(max(0, stop), len(talk.stops) - 1)
    return None, 0


def read_lesson_state(data: object, lesson: str, lessons: Mapping[str, Lesson]) -> LessonState | None:
    """The desk that `write_lesson_state` wrote for a lesson, None if it is not one."""
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
    )


def _scenes(data: object, lesson: Lesson) -> tuple[int, frozenset[str], dict[str, int]]:
    """The scene that was open, those that were done, and the options chosen in them; the start of the path where it cannot be read."""
    ids = {scene.id for scene in lesson.path}
    match data:
        case [int(scene), list(done), dict(chosen)] if 0 <= scene < max(1, len(ids)):
            options = {name: index for name, index in chosen.items() if name in ids and type(index) is int and -1 <= index < MAX_OPTIONS}
            return scene, frozenset(name for name in done if isinstance(name, str) and name in ids), options
    return 0, frozenset(), {}


def _chosen(index: object, options: int) -> int | None:
    """The index of an option, −1 where it was skipped; None where it is neither."""
    return index if isinstance(index, int) and not isinstance(index, bool) and options and -1 <= index < options else None


def progress_in_saved_state(data: object) -> Progress:
    """What a written desk tells of a person's progress, before it is judged whole."""
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
