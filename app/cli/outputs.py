"""Write the files of commands, each whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from ..course.figures.records import Figure
from ..course.knobs import KnobError
from ..engine import EngineError
from .options import CommandError, error_cause


def write_whole_file(name: str, save: Callable[[str], None]) -> None:
    """Write a file beside its place and move it there when it is whole. Raises CommandError where that fails."""
    try:
        path = Path(name)
        if path.exists() and not path.is_file():  # a device or a pipe has no place beside it
            save(name)
            return
        with tempfile.TemporaryDirectory(prefix=".observer-lab-", dir=path.parent) as folder:
            part = Path(folder) / path.name
            save(str(part))
            os.replace(part, path)
    except (EngineError, KnobError):  # a figure that is made only now
        raise
    except (OSError, ValueError) as problem:
        raise CommandError(f"{name[:80]} cannot be written ({error_cause(problem)}); choose another place.") from problem


def write_folder(name: str, files: Mapping[str, str | bytes]) -> None:
    """Write files into a folder, which is made where it is missing. Raises CommandError where that fails."""
    try:
        Path(name).mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise CommandError(f"{name[:80]} cannot be made a folder ({error_cause(problem)}); choose another place.") from problem
    for file, content in files.items():
        (Path(name) / file).parent.mkdir(parents=True, exist_ok=True)
        data = content.encode() if isinstance(content, str) else content
        write_whole_file(str(Path(name) / file), partial(save_bytes, data))


def save_page(figures: Sequence[Figure], path: str, language: str, token: str) -> None:
    """All figures on one page: .png, .svg or .pdf. Raises CommandError at another suffix."""
    from ..export.figures.figure import ExportError, save_figures  # matplotlib is loaded only when a figure is drawn

    try:
        save_figures(figures, path, language, token)
    except ExportError as problem:
        raise CommandError(str(problem)) from problem


def save_bytes(content: bytes, path: str) -> None:
    """A file as it is."""
    Path(path).write_bytes(content)


def save_words(words: str, path: str) -> None:
    """A text file."""
    Path(path).write_text(words + "\n", encoding="utf-8")


def save_code(link: str, path: str) -> None:
    """A link as a QR code: .svg or .png. Raises CommandError at another suffix, or where the link is too long."""
    import segno

    if Path(path).suffix.lower() not in (".svg", ".png"):
        raise CommandError(f"A QR code is written as .svg or .png; {Path(path).name[:80]} ends in neither.")
    try:
        segno.make(link, error="l", micro=False).save(path, scale=10, border=4)
    except segno.DataOverflowError as problem:
        raise CommandError("The link is too long for a QR code; give the state as a file with -o.") from problem
