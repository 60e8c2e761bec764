"""Build a lesson from `lesson.toml` and `lesson.md`, or one that shows what is wrong with them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path

from observer_lab.course.course_map import CoursePlace
from observer_lab.course.figures.records import TableFigure
from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Design, Lesson, Outcome
from observer_lab.course.prose import Prose, ProseError, parse_prose
from observer_lab.course.scenes import minutes_of
from observer_lab.engine import EngineError
from observer_lab.text import Text, error_words, languages, same, text

from ..toolkit.knobs import run_knobs
from .figures import draw_all, figure_ids, read_figures
from .plant_source import read_plant
from .scenes import read_path
from .setup import read_setup
from .study import compute
from .tasks import check_tasks, read_tasks
from .toml_table import LessonFileError, Table, read_table, refusal

TOML, MARKDOWN = "lesson.toml", "lesson.md"
TOP_KEYS = ("draft", "minutes", "answer", "figure", "plant", "parameters", "knobs", "model", "observer", "controller", "run", "figures",
            "tasks", "scenes")
MAX_FILE_BYTES = 1_000_000
DEFAULT_MINUTES = 45  # of a lesson without a path
NOT_READ = text("This lesson cannot be read")


def read_lesson(folder: Path, number: int, trusted: bool) -> Lesson:
    """The lesson of a folder; `trusted` says whether its Python code may run. Raises LessonFileError."""
    top = read_table(TOML, _text_of(folder / TOML)).only(*TOP_KEYS)
    source, parameters = read_plant(top, folder, trusted)
    setup = read_setup(top, source, parameters)
    knobs = (*parameters.knobs, *run_knobs(setup.horizon))
    draws, ids, tasks = read_figures(top, source), figure_ids(top), read_tasks(top, knobs)
    path, words = read_path(top, knobs, ids, tasks), _words(folder)
    for prose in words.values():
        _check_words(top, prose, tasks, path)
    options = len(words["en"].options)
    answer = top.number("answer")
    if answer not in range(1, options + 1):
        raise top.refuse("answer", text("answer must be the number of the right option, 1 to {most}; it is {answer:g}.", most=options,
                                        answer=answer))
    lesson = Lesson(
        folder.name, number, knobs, partial(compute, setup), partial(draw_all, draws), answer=int(answer) - 1, tasks=tasks,
        source=words["en"].source, words=words, answering=top.one_of("figure", ids, ids[0]), path=path, draft=top.switch("draft", False),
        place=CoursePlace(round(top.number("minutes", minutes_of(path, core=False) or DEFAULT_MINUTES))))
    _try_out(top, lesson)
    return lesson


def _try_out(top: Table, lesson: Lesson) -> None:
    """Compute and draw the start, and try every task. Raises LessonFileError."""
    try:
        lesson.figures(lesson.compute(lesson.start()))
    except LessonFileError:
        raise
    except (EngineError, KnobError) as problem:
        raise refusal(TOML, 1, error_words(problem)) from problem
    check_tasks(top, lesson)


def _text_of(path: Path) -> str:
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise refusal(path.name, 1, text("The file is larger than {most} kB.", most=MAX_FILE_BYTES // 1000))
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise refusal(path.name, 1, text("The folder has no file {file}.", file=path.name)) from None
    except UnicodeDecodeError as problem:
        raise refusal(path.name, 1, text("The file is not UTF-8 text.")) from problem
    except OSError as problem:
        raise refusal(path.name, 1, text("The file cannot be read.")) from problem


def _words(folder: Path) -> dict[str, Prose]:
    """The prose in every language: `lesson.zh.md` where there is one, else `lesson.md`."""
    found = {}
    for language in languages():
        path = folder / f"lesson.{language}.md"
        path = path if path.is_file() else folder / MARKDOWN
        words = _text_of(path)
        try:
            found[language] = parse_prose(words, path.name)
        except ProseError as problem:
            wrong = re.search(r"'(## [^']*)'", str(problem))
            line = words[:words.find(wrong[1])].count("\n") + 1 if wrong else 1
            raise refusal(path.name, line, same(str(problem))) from problem
    return found


def _check_words(top: Table, prose: Prose, tasks: Iterable, path: Iterable) -> None:
    """Every task and every scene has its words."""
    for key, items, told in (("tasks", tasks, prose.tasks), ("scenes", path, prose.scenes)):
        for table, item in zip(top.tables(key), items, strict=True):
            if item.id not in told:
                raise table.refuse("id", text("{file} has no section “## {kind} {id}: title”.", file=MARKDOWN, kind=key[:-1], id=item.id))


def broken_lesson(id: str, number: int, why: Text) -> Lesson:
    """A lesson whose page says what is wrong with its files."""
    table = TableFigure("fault", NOT_READ, (text("What is wrong"),), ((why,),))
    words: Mapping[str, Prose] = {language: Prose(id, NOT_READ(language), why(language), "", (), (), "", (), {}, {}, "")
                                  for language in languages()}
    return Lesson(id, number, run_knobs(1.0), _nothing, lambda outcome: (table,), answer=0, tasks=(), source="", words=words, kick=False,
                  fault=why)


def _nothing(design: Design) -> Outcome:
    return Outcome(design, words=NOT_READ)
