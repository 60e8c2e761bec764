"""Write the guide of lessons as a folder that needs no server: `publish`."""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from ..options import CommandError, error_cause, whole_number

if TYPE_CHECKING:
    from ...page.record.recorded_screen import Look
    from ...static_pages.points import Points

HELP = "the guide of lessons as a folder for any web host, or to open by a double click"
THEMES = MappingProxyType({"light": (False,), "dark": (True,), "both": (False, True)})
POINTS = whole_number(2, 41, "is not a number of values; give one from 2 to 41")
WHOLE = "all"  # the course of all lessons


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `publish`."""
    from ...text.languages import languages

    parser.add_argument("lessons", nargs="*", metavar="LESSON", help="the lessons")
    parser.add_argument("--course", metavar="NAME", help=f"the lessons of a learning path instead, or {WHOLE}")
    parser.add_argument("-o", "--output", metavar="FOLDER", required=True, help="the folder to write; what stands there is used again")
    parser.add_argument("--lang", choices=[*languages(), "all"], default="all", help="language of the pages (default: all)")
    parser.add_argument("--theme", choices=list(THEMES), default="both", help="colours of the pages (default: both)")
    parser.add_argument("--points", type=POINTS, default=7, metavar="N", help="values of a slider that are computed (default %(default)s)")
    parser.add_argument("--grid", type=read_grid, default=(9, 7), metavar="N×M",
                        help="places of a pole along the real and the imaginary axis that are computed (default 9x7)")
    parser.add_argument("--workers", type=whole_number(1, 256, "is not a number of processes; give one from 1 to 256"), default=1,
                        metavar="N", help="lessons that are recorded at a time (default %(default)s)")
    parser.add_argument("--zip", action="store_true", help="write FOLDER.zip too, for a learning platform")


def read_grid(words: str) -> tuple[int, int]:
    """The reader of a grid such as 9x7."""
    across, sign, up = words.replace("×", "x").partition("x")
    if not sign:
        raise argparse.ArgumentTypeError(f"{words[:40]} is not a grid; give it as in 9x7")
    return POINTS(across), POINTS(up)


def execute(options: argparse.Namespace) -> int:
    """Record what the folder lacks, and write its page; prints the page's name and the line that embeds it. Raises CommandError."""
    from observer_lab.lessons import all_lessons

    from ...page.record.recorded_screen import WINDOWS, Look
    from ...static_pages.points import Points
    from ...static_pages.site import is_written, key_of, write_folder
    from ...text.languages import languages

    ids, spoken = _lessons(options.lessons, options.course), languages() if options.lang == "all" else [options.lang]
    looks = [Look(code, dark, width) for code in spoken for dark in THEMES[options.theme] for width in WINDOWS]
    points, folder = Points(options.points, *options.grid), Path(options.output)
    package = Path(__file__).parents[2]
    key = key_of([package, Path(sys.modules[all_lessons.__module__].__file__ or "").parent], ids, looks, points)
    lacking = [id for id in ids if not is_written(folder, id, key)]
    try:
        _record(ids, lacking, looks, points, folder, key, options.workers)
        write_folder({id: all_lessons()[id] for id in ids}, looks, folder)
        if options.zip:
            print(shutil.make_archive(str(folder), "zip", folder))
    except OSError as problem:
        raise CommandError(f"The folder {options.output[:200]} cannot be written ({error_cause(problem)}).") from problem
    print(folder / "index.html")
    print('<iframe src="index.html" width="100%" height="640" title="Observer Lab" allowfullscreen></iframe>')
    return 0


def _lessons(names: Sequence[str], course: str | None) -> list[str]:
    """The lessons that were asked for, each once. Raises CommandError."""
    from observer_lab.lessons import all_lessons

    from ...course.learning_paths import paths_with_lessons
    from ..inputs import find_lesson

    lessons = all_lessons()
    if bool(names) == (course is not None):
        raise CommandError("Give the lessons or --course NAME; see observer-lab publish --help.")
    if course is None:
        return list(dict.fromkeys(find_lesson(id, lessons).id for id in names))
    paths = {path.id: [lesson.id for lesson in on_it] for path, on_it in paths_with_lessons(lessons.values()).items()}
    paths[WHOLE] = list(lessons)
    if course not in paths:
        raise CommandError(f"There is no course {course[:40]}; there are {', '.join(paths)}.")
    return paths[course]


def _record(ids: Sequence[str], lacking: Sequence[str], looks: Sequence[Look], points: Points, folder: Path, key: str,
            workers: int) -> None:
    """Record the lessons that the folder lacks, several at a time where that is wanted."""
    done = len(ids) - len(lacking)
    if workers == 1 or len(lacking) < 2:
        for id in lacking:
            record(ids, id, looks, points, folder, key)
            done += 1
            _say(done, len(ids), id)
        return
    with ProcessPoolExecutor(min(workers, len(lacking))) as pool:
        waiting = {pool.submit(record, ids, id, looks, points, folder, key): id for id in lacking}
        for each in as_completed(waiting):
            each.result()
            done += 1
            _say(done, len(ids), waiting[each])


def record(ids: Sequence[str], id: str, looks: Sequence[Look], points: Points, folder: Path, key: str) -> None:
    """Record one lesson, in a process of its own or in this one."""
    from observer_lab.lessons import all_lessons

    from ...static_pages.site import record_lesson

    record_lesson({each: all_lessons()[each] for each in ids}, id, looks, points, folder, key)


def _say(done: int, count: int, id: str) -> None:
    bar = "█" * round(20 * done / count)
    print(f"{bar:<20} {done}/{count} {id}", file=sys.stderr, flush=True)
