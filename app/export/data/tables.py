"""Write one figure's data as CSV or JSON, with units and the token of its state."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Sequence
from typing import assert_never

import numpy as np

from ...course.figures.records import Curve, Figure, LineFigure, MapFigure, MatrixFigure, PlaneFigure, TableFigure, axes_of
from ...text import label_in_language
from .data import distinct, plain

__all__ = ["figure_csv", "figure_json", "table"]

UNIT = re.compile(r"\[[^\[\]]+\]\s*$")
Cell = str | float
Rows = list[Sequence[Cell]]


def figure_csv(figure: Figure, token: str, language: str = "en") -> bytes:
    """The table of a figure, below a line with the token; UTF-8, and marked as such where the heads are not ASCII.

    A spreadsheet needs the mark; `pandas.read_csv(name, comment="#")` and numpy's loaders pass both over.
    """
    heads, rows = table(figure, language)
    out = io.StringIO()
    out.write(f"# Observer Lab, state {token}\n")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows([repr(cell) if isinstance(cell, float) else cell for cell in row] for row in rows)
    written = out.getvalue()
    return written.encode("utf-8" if written.isascii() else "utf-8-sig")


def figure_json(figure: Figure, token: str, language: str = "en") -> bytes:
    """The same as strict JSON: token, figure, title, heads with their units, rows; null where a number is not finite."""
    heads, rows = table(figure, language)
    whole = {"token": token, "figure": figure.id, "title": figure.title(language), "heads": heads, "rows": plain(rows)}
    return (json.dumps(whole, ensure_ascii=False, allow_nan=False) + "\n").encode()


def table(figure: Figure, language: str = "en") -> tuple[list[str], Rows]:
    """Heads and rows: a column a curve over time or frequency; a row a point, an entry or a cell for what has no common x."""
    match figure:
        case LineFigure():
            return _lines(figure, language)
        case PlaneFigure():
            return ["series", *axes_of(figure, language)], _plane(figure, language)
        case MatrixFigure():
            return _matrix(figure, language)
        case MapFigure():
            return [*axes_of(figure, language), "category"], _map(figure, language)
        case TableFigure():
            return ([column(language) for column in figure.columns],
                    [tuple(label_in_language(cell, language) for cell in row) for row in figure.rows])
        case _:
            assert_never(figure)


def _lines(figure: LineFigure, language: str) -> tuple[list[str], Rows]:
    names = [_with_unit(curve.called(language), label_in_language(figure.y_label, language)) for curve in figure.curves]
    columns = [np.asarray(figure.x, dtype=float), *(np.asarray(curve.y, dtype=float) for curve in figure.curves)]
    return [figure.x_label, *distinct(names)], [tuple(map(float, row)) for row in zip(*columns, strict=True)]


def _matrix(figure: MatrixFigure, language: str) -> tuple[list[str], Rows]:
    matrix = np.asarray(figure.matrix, dtype=float)
    named = [label_in_language(name, language) for name in figure.columns] or [str(j) for j in range(matrix.shape[1])]
    beside = [label_in_language(name, language) for name in figure.rows] or [str(i) for i in range(matrix.shape[0])]
    return ["", *distinct(named)], [(name, *map(float, row)) for name, row in zip(beside, matrix, strict=True)]


def _map(figure: MapFigure, language: str) -> Rows:
    names = [name(language) for name, _ in figure.categories]
    return [(float(x), float(y), names[int(k)] if k >= 0 else "")
            for y, row in zip(figure.y, np.asarray(figure.values), strict=True) for x, k in zip(figure.x, row, strict=True)]


def _with_unit(name: str, axis: str) -> str:
    """A curve's name with the unit of its axis, where it has none of its own."""
    unit = UNIT.search(axis)
    return name if unit is None or UNIT.search(name) else f"{name} {unit[0]}".strip()


def _plane(figure: PlaneFigure, language: str) -> Rows:
    rows: Rows = []
    for name, curve in zip(distinct([c.called(language) for c in figure.curves]), figure.curves, strict=True):
        rows += [(name, float(x), float(y)) for x, y in zip(_xs(curve), curve.y, strict=True)]
    return rows + [(p.name(language) or f"{p.role} {p.mark}", float(p.x), float(p.y)) for p in figure.points]


def _xs(curve: Curve) -> np.ndarray:
    return np.arange(len(curve.y), dtype=float) if curve.x is None else curve.x
