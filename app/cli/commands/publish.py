"""Write the guide of lessons as a folder that needs no server: `publish`."""

from __future__ import annotations

import argparse
import multiprocessing
import os
import shutil
import signal
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from queue import Queue
from types import MappingProxyType
from typing import TYPE_CHECKING

from ..options import THREADS, CommandError, add_own_lessons, error_cause, whole_number

if TYPE_CHECKING:
    from ...course.lectures import Lecture
    from ...course.lesson import Lesson
    from ...page.record.recorded_screen import Look
    from ...static_pages.points import Points
    from ...static_pages.store import Sources, Store

HELP = "the guide of lessons as a folder for any web host, or to open by a double click"
THEMES = MappingProxyType({"light": (False,), "dark": (True,), "both": (False, True)})
POINTS = whole_number(2, 41, "is not a number of values; give one from 2 to 41")
WHOLE = "all"  # the course of all lessons
STORE = "published"  # of the user's cache folder
PROGRESS_INTERVAL_S = 0.3  # s between two looks at how far the processes are


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `publish`."""
    from ...text.languages import languages

    parser.add_argument("lessons_asked", nargs="*", metavar="LESSON", help="the lessons")
    parser.add_argument("--course", metavar="NAME", help=f"the lessons of a learning path instead, or {WHOLE}")
    parser.add_argument("-o", "--output", metavar="FOLDER", required=True, help="the folder to write")
    parser.add_argument("--cache", metavar="FOLDER", type=Path,
                        help="where recorded lessons are kept (default: observer-lab/published in the user's cache folder). A lesson is "
                        "recorded again only when its sources, shared sources or options change")
    parser.add_argument("--lecture", metavar="FILE", help="the lessons of a lecture, and a page with its scenes in order: a TOML file")
    add_own_lessons(parser)
    parser.add_argument("--lang", choices=[*languages(), "all"], default="all", help="language of the pages (default: all)")
    parser.add_argument("--theme", choices=list(THEMES), default="both", help="colours of the pages (default: both)")
    parser.add_argument("--points", type=POINTS, default=7, metavar="N", help="values of a slider that are computed (default %(default)s)")
    parser.add_argument("--grid", type=read_grid, default=(9, 7), metavar="N×M",
                        help="places of a pole along the real and the imaginary axis that are computed, fewer where many poles move "
                             "(default 9x7)")
    parser.add_argument("--workers", type=whole_number(1, 256, "is not a number of processes; give one from 1 to 256"), default=1,
                        metavar="N", help="lessons that are recorded at a time (default %(default)s)")
    parser.add_argument("--zip", action="store_true", help="write FOLDER.zip too, for a learning platform")


def read_grid(words: str) -> tuple[int, int]:
    """The reader of a grid such as 9x7."""
    across, sign, up = words.replace("×", "x").partition("x")
    if not sign:
        raise argparse.ArgumentTypeError(f"{words[:40]} is not a grid; give it as in 9x7")
    return POINTS(across), POINTS(up)


@dataclass(frozen=True)
class Work:
    """What a process must know to record one of the lessons: `own` is a folder of lessons that are not of the course."""

    ids: tuple[str, ...]
    looks: tuple[Look, ...]
    points: Points
    store: Store
    own: str | None = None
    trusted: bool = False

    def lessons(self) -> dict[str, Lesson]:
        """The lessons of the folder."""
        from ..lesson_folder import lessons_with

        known = lessons_with(self.own, self.trusted)
        return {id: known[id] for id in self.ids}


def execute(options: argparse.Namespace) -> int:
    """Record what the store lacks, and write the folder; prints its page's name and the line that embeds it. Raises CommandError.

    130 if it was interrupted: the lessons that are recorded by then are kept.
    """
    if "numpy" not in sys.modules:  # a lesson's numbers need one thread, and every process records one lesson
        os.environ.update(dict.fromkeys(THREADS, "1"))
    from ...engine.kernels import user_cache
    from ...page.record.recorded_screen import WINDOWS, Look
    from ...static_pages.points import Points
    from ...static_pages.site import DATA, PAGE, write_folder
    from ...static_pages.store import Store
    from ...text.languages import languages
    from ..lesson_folder import lessons_of

    known = lessons_of(options)
    ids, lecture = _chosen(options, known)
    spoken = languages() if options.lang == "all" else [options.lang]
    looks = tuple(Look(code, dark, width) for code in spoken for dark in THEMES[options.theme] for width in WINDOWS)
    points, store, folder = Points(options.points, *options.grid), Store(options.cache or user_cache() / STORE), Path(options.output)
    work = Work(tuple(ids), looks, points, store, options.lessons, options.trust_code)
    keys = _sources(known, options.lessons).keys({id: known[id] for id in ids}, spoken, looks, points, options.trust_code)
    missing = [id for id in ids if not store.has(id, keys[id])]
    try:
        try:
            _record(work, {id: keys[id] for id in missing}, sum(len(known[id].path) for id in missing), options.workers)
        except KeyboardInterrupt:
            done = sum(store.has(id, keys[id]) for id in ids)
            print(f"\nobserver-lab: stopped with {done} of {len(ids)} lessons recorded; the same command goes on from there.",
                  file=sys.stderr)
            return 128 + signal.SIGINT
        for id in ids:
            store.copy(id, keys[id], folder / DATA / id)
        write_folder({id: known[id] for id in ids}, looks, folder, lecture)
        if options.zip:
            print(shutil.make_archive(str(folder), "zip", folder))
    except OSError as problem:
        raise CommandError(f"The folder {options.output[:200]} or the store {str(store.folder)[:200]} cannot be written "
                           f"({error_cause(problem)}).") from problem
    print(folder / PAGE)
    print('<iframe src="index.html" width="100%" height="640" title="Observer Lab" allowfullscreen></iframe>')
    return 0


def _chosen(options: argparse.Namespace, lessons: Mapping[str, Lesson]) -> tuple[list[str], Lecture | None]:
    """The lessons that were asked for, each once, and the lecture that names them. Raises CommandError."""
    from ..inputs import find_lesson, read_lecture_file

    if sum(map(bool, (options.lessons_asked, options.course, options.lecture))) != 1:
        raise CommandError("Give the lessons, or --course NAME, or --lecture FILE; see observer-lab publish --help.")
    lecture = read_lecture_file(options.lecture, lessons) if options.lecture else None
    names = [stop.lesson for stop in lecture.stops] if lecture else options.lessons_asked or _course(options.course, lessons)
    ids = list(dict.fromkeys(names))
    for lesson in (find_lesson(id, lessons) for id in ids):
        if lesson.fault.id:
            raise CommandError(f"The lesson {lesson.id} cannot be published: {lesson.fault('en')}")
        if not lesson.path:
            raise CommandError(f"The lesson {lesson.id} cannot be published: it has no scenes yet.")
    return ids, lecture


def _course(name: str, lessons: Mapping[str, Lesson]) -> list[str]:
    """The lessons of a learning path. Raises CommandError."""
    from ...course.learning_paths import paths_with_lessons

    paths = {path.id: [lesson.id for lesson in on_it] for path, on_it in paths_with_lessons(lessons.values()).items()}
    paths[WHOLE] = [lesson.id for lesson in lessons.values() if lesson.path and not lesson.fault.id]
    if name not in paths:
        raise CommandError(f"There is no course {name[:40]}; there are {', '.join(paths)}.")
    return paths[name]


def _sources(lessons: Mapping[str, Lesson], own: str | None) -> Sources:
    """Where the files stand on which recorded lessons depend."""
    from observer_lab.lessons import OPENING, all_lessons, folder

    from ...static_pages.store import Sources

    course = all_lessons()
    places = {id: folder(id) if id in course else Path(own or "") / id for id in lessons}
    return Sources(Path(__file__).parents[2], folder(OPENING).parent, places)


def _record(work: Work, keys: Mapping[str, str], scenes: int, workers: int) -> None:
    """Record lessons into the store, several at a time where that is wanted, and say how far it is."""
    from ..terminal import Progress

    if not keys:
        return
    progress, done = Progress(scenes, 0, what="scenes"), count(1)

    def advance() -> None:
        progress.tell(next(done))
    try:
        if workers == 1 or len(keys) == 1:
            for id, key in keys.items():
                record(work, id, key, advance)
        else:
            _on_processes(work, keys, min(workers, len(keys)), advance)
    finally:
        progress.end()


def _on_processes(work: Work, keys: Mapping[str, str], workers: int, advance: Callable[[], object]) -> None:
    """Record several lessons at a time. Raises CommandError where a process dies."""
    from ...study.executors import settle

    with multiprocessing.get_context("spawn").Manager() as manager:
        steps, others = manager.Queue(), set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), initializer=settle)
        waiting = set[Future[None]]()
        try:
            waiting = {pool.submit(record, work, id, key, Steps(steps)) for id, key in keys.items()}
            while waiting:
                done, waiting = wait(waiting, PROGRESS_INTERVAL_S, FIRST_COMPLETED)
                for _ in range(steps.qsize()):
                    steps.get()
                    advance()
                for each in done:
                    each.result()
        except BrokenProcessPool as problem:
            raise CommandError("A process that records a lesson has died, perhaps for want of memory; "
                               "try fewer with --workers.") from problem
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in set(multiprocessing.active_children()) - others if waiting else ():
                process.terminate()  # somebody has stopped us


@dataclass(frozen=True)
class Steps:
    """Tells another process that a scene is recorded."""

    queue: Queue[int]

    def __call__(self) -> None:
        self.queue.put(1)


def record(work: Work, id: str, key: str, advance: Callable[[], object]) -> None:
    """Record one lesson into the store, in a process of its own or in this one."""
    from ...static_pages.site import write_lesson

    lessons = work.lessons()
    work.store.keep(id, key, lambda write: write_lesson(lessons, id, work.looks, work.points, write, advance))
