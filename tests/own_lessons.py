"""Lessons as files, and a .zip of them, as somebody would write who follows the guide of own lessons."""

from __future__ import annotations

import io
import re
import tempfile
import zipfile
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

from observer_lab.cli.commands.new_lesson import FILES, write_template

GUIDE = (Path(__file__).parents[1] / "assets" / "lessons" / "README.md").read_text(encoding="utf-8").partition("## A nonlinear plant")[0]


@lru_cache(maxsize=16)
def first_files(id: str) -> dict[str, str]:
    """The files of the guide's first lesson, by their names."""
    with tempfile.TemporaryDirectory() as home:
        place = Path(home) / id
        write_template(FILES, place, {"@id@": id, "@title@": id, "@Title@": id.capitalize(), "@number@": "1"})
        return {path.name: path.read_text(encoding="utf-8") for path in place.iterdir()}


def whole_files(id: str) -> dict[str, str]:
    """That lesson with all that the guide adds: a path of scenes, a task, exams, a derivation."""
    files = dict(first_files(id))
    for name, kind in (("lesson.toml", "toml"), ("lesson.md", "markdown")):
        files[name] = "\n".join([files[name], *re.findall(rf"```{kind}\n(.*?)```", GUIDE, re.DOTALL)])
    return files


def zipped(lessons: Mapping[str, Mapping[str, str | bytes]]) -> bytes:
    """A .zip with these lessons' files."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        for id, files in lessons.items():
            for name, content in files.items():
                packed.writestr(f"{id}/{name}", content)
    return out.getvalue()
