"""Say what a page opens on by what `serve` was asked for: lessons, plant, state, lecture, course."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from ..course.scenes import Mode
from .lesson_folder import first_whole, open_folder
from .options import COURSE_STORE, CommandError, stated_redis
from .records import RECORD, ReadingOptions, lesson_with

if TYPE_CHECKING:
    from observer_lab.lessons.from_files.folder import LessonFolder

    from ..course.handin.ledger import KeptHandIns
    from ..course.handin.served_course import ServedCourse
    from ..course.lectures import Lecture
    from ..course.lesson import Lesson

SANDBOX = "sandbox"  # the lesson that opens when a plant is brought and no lesson named


@dataclass(frozen=True)
class ServeRequest:
    """What `serve` was asked for."""

    host: str = "127.0.0.1"
    port: int = 8080
    lesson: str | None = None
    language: str = "en"
    max_sessions: int | None = None
    plant: str | None = None
    names: tuple[str, ...] = ()
    public: bool = False
    log_json: bool = False
    data_dir: str | None = None
    frames: tuple[str, ...] = ()
    state: str | None = None
    exam: bool = False
    workers: int = 1
    exact: bool = False
    mode: Mode = "guide"
    timeout: float = 90.0
    token: str | None = field(default=None, repr=False)
    data: str | None = None
    columns: str | None = None
    lecture: str | None = None
    course: str | None = None
    lessons: str | None = None
    trusted: bool = False
    room: bool = False
    at: str | None = None
    lti: str | None = None
    store: str | None = field(default=None, repr=False)
    proxies: tuple[str, ...] = ()
    idle: float = 3600.0  # s
    reading: ReadingOptions = field(default_factory=ReadingOptions)
    course_store: str | None = field(default=None, repr=False)
    uploads: bool = False  # whether a page may bring a .zip of lessons


@dataclass(frozen=True)
class Opening:
    """What a page opens on. `insists`: also where the browser was elsewhere before."""

    lessons: Mapping[str, Lesson]
    lesson: str
    plant: str
    state: str
    talk: Lecture | None
    course: ServedCourse | None
    ledger: KeptHandIns | None
    folder: LessonFolder | None
    insists: bool


def opening_of(request: ServeRequest) -> Opening:
    """What a page opens on. Raises CommandError where what was asked for does not go together or cannot be read."""
    from observer_lab.lessons import FIRST, OPENING, all_lessons

    from ..session.state.token import write_token
    from .courses import open_ledger, served_course
    from .inputs import find_lesson, fit_lesson, read_lecture_file, read_plant, read_saved_state

    plant = "" if request.plant is None else read_plant(request.plant)
    if request.data is not None and (request.plant or request.state):
        raise CommandError("Give --data without --plant and --state: the record brings its own model.")
    if request.state is not None and (request.lesson or request.plant):
        raise CommandError("Give --state without --lesson and --plant: a state brings its own.")
    if request.lecture is not None and (request.lesson or request.plant or request.state or request.data):
        raise CommandError("Give --lecture without --lesson, --plant, --state and --data: a lecture names its own lessons.")
    saved = None if request.state is None else read_saved_state(request.state)
    if request.course is not None and request.exam:
        raise CommandError("Give --course without --exam: the course file says what is withheld.")
    asked = request.course is not None or request.lti is not None
    ledger = open_ledger(request.data_dir, stated_redis(request.course_store, COURSE_STORE)) if asked else None
    if request.course_store is not None and ledger is None:
        raise CommandError("--course-store says where hand-ins are kept; give it with --course or --lti.")
    folder = None if request.lessons is None else open_folder(request.lessons, all_lessons(), request.trusted)
    own = {} if folder is None else folder.lessons()
    lessons = {**all_lessons(), **own}
    talk = None if request.lecture is None else read_lecture_file(request.lecture, lessons)
    course = None if request.course is None or ledger is None else served_course(request.course, ledger, lessons)
    first = first_whole(own) if own else SANDBOX if plant and SANDBOX in lessons else OPENING if request.mode == "lab" else FIRST
    lesson = saved.design.lesson if saved else request.lesson or (talk.stops[0].lesson if talk else first)
    opening = find_lesson(RECORD if request.data is not None and request.lesson is None else lesson, lessons)
    if request.data is not None:
        lessons = {**lessons, RECORD: lesson_with(find_lesson(RECORD), request.data, request.columns, request.reading)}
        opening = lessons[opening.id]
    state = "" if saved is None else write_token(opening, replace(saved, notes=()))
    try:
        fit_lesson(opening, saved.design.plant if saved else plant)
    except CommandError as problem:
        if saved:
            raise
        print(f"observer-lab: lesson {opening.id} does not take this plant: {problem} The other lessons have it.", file=sys.stderr)
    return Opening(lessons, opening.id, plant, state, talk, course, ledger, folder,
                   bool(request.lesson or own or plant or request.data or talk))
