"""Make the files that a person can download: figures, data, scripts, sheet, or all as zip."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from ..course.figures.records import Figure
from ..course.lesson import Lesson, Outcome
from ..devices import DeviceError
from ..engine import EngineError
from ..text import SaidError, error_words, text
from .data.data import figure_csv, figure_json, json_text
from .devices.folders import device_files, zip_of
from .figures.figure import figures_as
from .figures.fonts import HAN, chinese_font
from .scripts.engine_notebook import engine_notebook
from .scripts.matlab import function_name, matlab_script
from .scripts.script import ScriptError, notebook, python_script
from .sheet.sheet import sheet

__all__ = [
    "FIGURE_FORMATS",
    "SCRIPTS",
    "DownloadContent",
    "File",
    "FileError",
    "all_in_one",
    "check_fonts_for",
    "device_file",
    "figure_file",
    "script_file",
    "sheet_file",
]

PICTURE_KINDS = ("png", "svg", "pdf")
FIGURE_FORMATS = (*PICTURE_KINDS, "csv", "json")
SCRIPTS: Mapping[str, tuple[Callable[[Lesson, Outcome, str, str], str], str]] = MappingProxyType({  # what writes it, end of its name
    "python": (python_script, ".py"), "notebook": (notebook, ".ipynb"), "matlab": (matlab_script, ".m"),
    "engine-notebook": (engine_notebook, "-engine.ipynb")})
BORN = (2020, 1, 1, 0, 0, 0)  # of every file in a zip, so that the same records give the same bytes
NO_FONT = text("The server has no font that holds Chinese, so this file would have boxes for words; switch the page to English for it.")


class FileError(SaidError):
    """A file that cannot be made; `text` says why in every language."""


@dataclass(frozen=True)
class File:
    """What a browser keeps: a name and bytes."""

    name: str
    content: bytes


@dataclass(frozen=True, eq=False)
class DownloadContent:
    """What a file is made of: all that the page shows now, its token, and the language of its words."""

    lesson: Lesson
    outcome: Outcome
    figures: Sequence[Figure]
    token: str
    language: str = "en"


def figure_file(taken: DownloadContent, figure: str, kind: str) -> File:
    """One figure, or all on one page for "", as one of FIGURE_FORMATS. Raises FileError."""
    chosen = [each for each in taken.figures if figure in ("", each.id)]
    if not chosen or kind not in FIGURE_FORMATS:
        raise FileError(text("There is no such figure here any more; open the dialog again."))
    name = f"{taken.lesson.id}{f'-{figure}' if figure else ''}.{kind}"
    if kind in PICTURE_KINDS:
        check_fonts_for(taken.language)
        return File(name, figures_as(chosen, kind, taken.language, taken.token))
    if len(chosen) == 1:
        return File(name, {"csv": figure_csv, "json": figure_json}[kind](chosen[0], taken.token, taken.language))
    if kind == "json":
        return File(name, (json_text(taken.outcome.design, taken.outcome, taken.token) + "\n").encode())
    raise FileError(text("One table holds one figure: choose a figure, or take all of them as one zip."))


def all_in_one(taken: DownloadContent) -> File:
    """A zip with every figure in every form, and the run as JSON. Raises FileError."""
    name, out = taken.lesson.id, io.BytesIO()
    files = [figure_file(taken, figure.id, kind) for figure in taken.figures for kind in FIGURE_FORMATS]
    files.append(File(f"{name}-run.json", (json_text(taken.outcome.design, taken.outcome, taken.token) + "\n").encode()))
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        for file in files:
            packed.writestr(zipfile.ZipInfo(f"{name}/{file.name}", BORN), file.content, zipfile.ZIP_DEFLATED)
    return File(f"{name}.zip", out.getvalue())


def script_file(taken: DownloadContent, kind: str) -> File:
    """The script of the design as one of SCRIPTS. Raises FileError where the lesson has none in that language."""
    write, ending = SCRIPTS[kind]
    name = function_name(taken.lesson) if kind == "matlab" else taken.lesson.id
    try:
        return File(f"{name}{ending}", (write(taken.lesson, taken.outcome, taken.token, taken.language) + "\n").encode())
    except ScriptError as problem:
        raise FileError(problem.text) from problem


def device_file(taken: DownloadContent, body: str) -> File:
    """The design as a folder of code for a device, zipped. Raises FileError where no device can run it."""
    folder = f"{taken.lesson.id}-{body}"
    try:
        return File(f"{folder}.zip", zip_of(folder, device_files(taken.lesson, taken.outcome, taken.token, body)))
    except (DeviceError, EngineError) as problem:
        raise FileError(error_words(problem)) from problem


def sheet_file(taken: DownloadContent) -> File:
    """The sheet of the lesson for print. Raises FileError."""
    check_fonts_for(taken.language)
    return File(f"{taken.lesson.id}-sheet.pdf", sheet(taken.lesson, taken.outcome, taken.figures, taken.token, taken.language))


def check_fonts_for(language: str) -> None:
    """Raises FileError where the words of a language could not be drawn."""
    if language.split("_")[0] in HAN and chinese_font() is None:
        raise FileError(NO_FONT)
