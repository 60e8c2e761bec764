"""Build a lesson from `lesson.toml` and `lesson.md`, or one that shows what is wrong with them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any  # a value of a TOML file is `Any`

from observer_lab.course.figures.records import TableFigure
from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Design, Lesson, Outcome
from observer_lab.course.prose import Prose, ProseError, parse_prose
from observer_lab.course.reading.lesson_data import DATA_KEYS, read_data
from observer_lab.course.reading.scenes import check_shown
from observer_lab.course.reading.toml_table import LessonFileError, Table, read_table, refusal
from observer_lab.engine import EngineError
from observer_lab.text import OutsideFileError, Text, error_words, languages, read_outside_bytes, same, text
from observer_lab.text.schema import shown

from ..toolkit.knobs import run_knobs
from .exams import read_exams
from .figures import draw_all, figure_ids, read_figures
from .picture import read_picture
from .plant_source import read_plant
from .seeds import read_seeds
from .setup import read_setup
from .study import compute, derived
from .tasks import check_tasks, read_tasks

TOML, MARKDOWN = "lesson.toml", "lesson.md"
TOP_KEYS = (*DATA_KEYS, "plant", "parameters", "knobs", "model", "observer", "controller", "run", "figures", "tasks", "scenes",
            "exams", "cloud", "picture")
MAX_FILE_BYTES = 1_000_000
NOT_READ = text("This lesson cannot be read")
BEGINS = re.compile(r"<(?![\s\d=])|\\href")  # a tag, also one that begins where a text ends; a link in a formula
NAME = re.compile(r"[\w .,+/()°·²³⁻¹µ%-]{1,80}")
NAMES = ("id", "of")  # keys whose value stands in an attribute of the page
MARKUP = re.compile(r"[^\w\s.,:;()=+-]")


def read_lesson(folder: Path, number: int, trusted: bool, uploaded: bool = False) -> Lesson:
    """The lesson of a folder; `trusted` says whether its Python code may run. An `uploaded` one may hold no HTML.

    Raises LessonFileError.
    """
    top = read_table(TOML, _text_of(folder / TOML)).only(*TOP_KEYS)
    if uploaded:
        check_strings(top)
    source, parameters = read_plant(top, folder, trusted)
    setup = read_setup(top, source, parameters, read_picture(top, folder))
    knobs = (*parameters.knobs, *run_knobs(setup.horizon))
    draws, ids, tasks, words = read_figures(top, source), figure_ids(top), read_tasks(top, knobs), _words(folder, uploaded)
    for prose in words.values():
        _check_words(top, prose)
    data = read_data(top, top, knobs, [task.id for task in tasks], words["en"], MARKDOWN)
    data["answering"] = top.one_of("figure", ids, ids[0])
    lesson = Lesson(folder.name, number, knobs, partial(compute, setup), partial(draw_all, draws), tasks=tasks, source=words["en"].source,
                    words=words, derived=derived, seeds=read_seeds(top, setup), **data)
    _try_out(top, lesson, ids)
    exams = [read_exams(top, lesson, prose.exams) for prose in words.values()]
    return replace(lesson, exams=exams[0])


def _try_out(top: Table, lesson: Lesson, figures: Sequence[str]) -> None:
    """Compute and draw the start, look for what the scenes show, and try every task. Raises LessonFileError."""
    try:
        outcome = lesson.compute(lesson.start())
        lesson.figures(outcome)
    except LessonFileError:
        raise
    except (EngineError, KnobError) as problem:
        raise refusal(TOML, 1, error_words(problem)) from problem
    check_shown(top, figures, [board.id for board in outcome.boards], [formula.id for formula in outcome.formulas])
    check_tasks(top, lesson)


def _text_of(path: Path) -> str:
    try:
        return read_outside_bytes(path, MAX_FILE_BYTES).decode("utf-8")
    except FileNotFoundError:
        raise refusal(path.name, 1, text("The folder has no file {file}.", file=path.name)) from None
    except UnicodeDecodeError as problem:
        raise refusal(path.name, 1, text("The file is not UTF-8 text.")) from problem
    except OutsideFileError as problem:
        raise refusal(path.name, 1, text("The file is no plain file, or larger than {most} kB.", most=MAX_FILE_BYTES // 1000)) from problem
    except OSError as problem:
        raise refusal(path.name, 1, text("The file cannot be read.")) from problem


def _words(folder: Path, uploaded: bool) -> dict[str, Prose]:
    """The prose in every language: `lesson.zh.md` where there is one, else `lesson.md`."""
    found = {}
    for language in languages():
        path = folder / f"lesson.{language}.md"
        path = path if path.is_file() else folder / MARKDOWN
        words = _text_of(path)
        if uploaded:
            check_markdown(path.name, words)
        try:
            found[language] = parse_prose(words, path.name)
        except ProseError as problem:
            wrong = re.search(r"'(## [^']*)'", str(problem))
            line = words[:words.find(wrong[1])].count("\n") + 1 if wrong else 1
            raise refusal(path.name, line, same(str(problem))) from problem
    return found


def _check_words(top: Table, prose: Prose) -> None:
    """Every task and every scene has its words."""
    for key, told in (("tasks", prose.tasks), ("scenes", prose.scenes)):
        for table in top.tables(key):
            if (id := table.words("id")) not in told:
                raise table.refuse("id", text("{file} has no section “## {kind} {id}: title”.", file=MARKDOWN, kind=key[:-1], id=id))


def broken_lesson(id: str, number: int, why: Text) -> Lesson:
    """A lesson whose page says what is wrong with its files."""
    table = TableFigure("fault", NOT_READ, (text("What is wrong"),), ((why,),))
    words: Mapping[str, Prose] = {language: Prose(id, NOT_READ(language), plain_markdown(why(language)), "", (), (), "", (), {}, {}, "")
                                  for language in languages()}
    return Lesson(id, number, run_knobs(1.0), _nothing, lambda outcome: (table,), answer=0, tasks=(), source="", words=words, kick=False,
                  fault=why)


def _nothing(design: Design) -> Outcome:
    return Outcome(design, words=NOT_READ)


def check_markdown(file: str, words: str) -> None:
    """The words of a Markdown file hold no HTML. Raises LessonFileError."""
    found = BEGINS.search(words)
    if found is not None:
        raise refusal(file, words.count("\n", 0, found.start()) + 1, _why(words, found))


def check_strings(top: Table) -> None:
    """No string of a TOML file holds HTML, and an id is a plain name. Raises LessonFileError."""
    for place, value in top.data.items():
        for key, words in _strings(place, value):
            found = BEGINS.search(words)
            if found is not None:
                raise top.refuse(place, _why(words, found))
            if key in NAMES and not NAME.fullmatch(words):
                raise top.refuse(place, text(
                    "The name {name} must be short and plain; use letters, digits, spaces and signs such as + and %.", name=shown(words)))


def plain_markdown(words: str) -> str:
    """Words that Markdown and HTML show letter by letter."""
    return MARKUP.sub(lambda sign: f"&#{ord(sign[0])};", words)


def _strings(key: str, value: Any) -> Iterator[tuple[str, str]]:
    """Every string, keys included, with the key that it belongs to."""
    if isinstance(value, str):
        yield key, value
    elif isinstance(value, dict):
        for name, part in value.items():
            yield "", name
            yield from _strings(name, part)
    elif isinstance(value, list):
        for part in value:
            yield from _strings(key, part)


def _why(words: str, found: re.Match[str]) -> Text:
    return text("“{begin}” may begin HTML or a link, and this lesson may have none. Put a space after “<”.",
                begin=words[found.start():found.start() + 12].partition("\n")[0])
