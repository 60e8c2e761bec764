"""Files to take away: each is of its kind, says its state, and holds what the records hold."""

from __future__ import annotations

import csv
import io
import json
import re
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from laws import holds_for_all
from matplotlib.mathtext import MathTextParser

from observer_lab.cli import main
from observer_lab.course.figures.records import LineFigure
from observer_lab.export import files
from observer_lab.export.sheet.typeset import MATHS, Piece, lines_of, readable
from observer_lab.lessons import LESSONS
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token
from observer_lab.text import languages

MAGIC = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF", "csv": b"# Obs", "json": b"{"}
PARSER = MathTextParser("path")


def taken(lesson: str, language: str = "en") -> files.DownloadContent:
    own = LESSONS[lesson]
    outcome = own.compute(own.start())
    return files.DownloadContent(own, outcome, tuple(own.figures(outcome)), write_token(own, SavedState(own.start())), language)


@pytest.mark.slow
def test_every_kind_of_file_is_what_it_says_and_holds_its_token() -> None:
    """A zip holds every figure in every form, the run."""
    all_of_it = replace(taken("duality", "zh"), figures=taken("duality").figures[:1] + taken("duality").figures[4:5])
    packed = files.all_in_one(all_of_it)
    with zipfile.ZipFile(io.BytesIO(packed.content)) as zipped:
        inside = {name: zipped.read(name) for name in zipped.namelist()}
    assert len(inside) == 2 * len(files.FIGURE_FORMATS) + 1 and packed.name == "duality.zip"
    for name, content in inside.items():
        kind = name.rpartition(".")[2]
        assert content.lstrip("\ufeff".encode()).startswith(MAGIC[kind]), name
        assert all_of_it.token.encode() in content, name


def test_a_table_has_the_curves_number_for_number_under_heads_with_units() -> None:
    def law(lesson: str) -> None:
        bad = []
        for figure in (own := taken(lesson)).figures:
            heads, rows = figure.table()
            bad += [figure.id] if any(len(row) != len(heads) for row in rows) or (rows and len(set(heads)) != len(heads)) else []
            if not isinstance(figure, LineFigure):
                continue
            read = list(csv.reader(files.figure_file(own, figure.id, "csv").content.decode("utf-8-sig").splitlines()[1:]))
            numbers = np.array(read[1:], dtype=float)
            same = np.array_equal(numbers, np.column_stack([figure.x, *(c.y for c in figure.curves)]), equal_nan=True)
            bad += [] if same and read[0] == heads and "[" in heads[0] else [f"{figure.id} as CSV"]
            loaded = json.loads(files.figure_file(own, figure.id, "json").content)
            bad += [] if loaded["heads"] == heads and len(loaded["rows"]) == len(rows) and loaded["token"] == own.token else [figure.id]
        assert not bad
    holds_for_all(["separation", "kalman", "saturation"], law)


@pytest.mark.slow
def test_every_formula_of_a_sheet_can_be_set_and_no_line_is_too_long() -> None:
    """Widths of half an em a letter: what a line says is what its paragraph says, and only a single word may stick out."""
    def law(lesson: str) -> None:
        bad = []
        for language in languages():
            words = LESSONS[lesson].words[language]
            for said in (words.question, words.introduction, *(task.statement for task in words.tasks.values())):
                formulas = [f"${readable(part.strip('$'))}$" for part in MATHS.split(said) if part.startswith("$")]
                bad += [formula for formula in formulas if not _parses(formula)]
                lines = list(lines_of(said, 40.0, lambda piece, maths: 0.5 * len(piece)))
                told = "".join(piece.said for line in lines for piece in line)
                bad += [f"{language}: {said[:30]}"] * (_bare(told) != _bare("".join(
                    f"${readable(part.strip('$'))}$" if part.startswith("$") else part for part in MATHS.split(said))))
                bad += [f"{language}: a line of {said[:30]}" for line in lines if _wide(line) > 40.0 and len(line) > 2]
        assert not bad
    holds_for_all(LESSONS, law)


def _parses(formula: str) -> bool:
    try:
        PARSER.parse(formula)
    except ValueError:
        return False
    return True


def _wide(line: tuple[Piece, ...]) -> float:
    return sum(piece.width for piece in (line[:-1] if line and line[-1].blank else line))


def _bare(said: str) -> str:
    return "".join(c for c in said if not c.isspace() and c not in "*`$")


@pytest.mark.slow
def test_the_sheet_is_a_book_of_pages_made_alike_each_time(tmp_path: Path) -> None:
    file = tmp_path / "sheet.pdf"
    assert main(["export", "weak-states", "--to", "pdf", "--lang", "zh", "-o", str(file)]) == 0
    book = file.read_bytes()
    assert book.startswith(b"%PDF") and len(re.findall(rb"/Type /Page\b", book)) >= 2
    short = replace(taken("weak-states", "zh"), figures=())
    assert files.sheet_file(short).content == files.sheet_file(short).content


def test_what_cannot_be_made_is_said_in_every_language() -> None:
    own = taken("showdown")
    own = replace(own, lesson=replace(own.lesson, code=None))
    for ask in (lambda: files.script_file(own, "matlab"), lambda: files.figure_file(own, "nothing", "png"),
                lambda: files.figure_file(own, "", "csv"), lambda: files.figure_file(own, "", "exe")):
        with pytest.raises(files.FileError) as problem:
            ask()
        assert problem.value.text("zh") != problem.value.text("en") and str(problem.value).endswith(".")
