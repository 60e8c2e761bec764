"""Write figures as one long CSV table and a run as strict JSON."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, assert_never

import numpy as np

from ...course.figures.records import Curve, Figure, LineFigure, MapFigure, MatrixFigure, PlaneFigure, TableFigure, axes_of
from ...course.lesson import Design, Outcome
from ...text import label_in_language, languages

__all__ = ["HEADER", "csv_rows", "distinct", "json_text", "plain", "run_record", "save_csv"]

HEADER = ("figure", "kind", "series", "x", "y", "value", "x_axis", "y_axis")
Row = tuple[str, str, str, float, float | str, float | str]
RUN_SERIES = ("t", "x", "xhat", "e", "u_asked", "u_applied", "y", "yhat", "w", "v")
PLAYED = ("t", "x", "xhat", "u")


def save_csv(figures: Sequence[Figure], path: str | Path, token: str = "") -> None:
    """Write the data of all figures as one table (UTF-8, comma, full precision: reading it back loses nothing).

    The header is `figure,kind,series,x,y,value,x_axis,y_axis`, below a line `# …` with the token of the state, if any. One row a
    point; the last two columns name the axes of its figure with their units:

    | kind | series | x | y | value |
    |---|---|---|---|---|
    | time | name of the curve | time in s | what is drawn | |
    | frequency | name of the curve | frequency in Hz | what is drawn | |
    | plane | name of the curve, or role and mark of a point | abscissa | ordinate | |
    | matrix | row and column by name | column from 0 | row from 0 | entry |
    | map | category | abscissa | ordinate | number of the category, −1 where nothing was computed |
    | table | name of the column | number of the row from 0 | | text of the cell |

    Names are the English ones; of several series with one name in a figure the later ones get " (2)", " (3)".
    Raises OSError if the file cannot be written.
    """
    with Path(path).open("w", encoding="utf-8", newline="") as file:
        if token:
            file.write(f"# Observer Lab, state {token}\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(HEADER)
        for figure in figures:
            axes = _axes(figure)
            for row in csv_rows([figure]):
                table.writerow([*(repr(cell) if isinstance(cell, float) else cell for cell in row), *axes])


def csv_rows(figures: Sequence[Figure]) -> Iterator[Row]:
    """The rows of `save_csv` below the header, numbers as Python floats."""
    for figure in figures:
        match figure:
            case LineFigure():
                yield from _curves(figure.id, "frequency" if figure.log_x else "time", figure.curves, figure.x)
            case PlaneFigure():
                yield from _curves(figure.id, "plane", figure.curves, None)
                for point in figure.points:
                    name = point.name("en") or f"{point.role} {point.mark}"
                    yield figure.id, "plane", name, float(point.x), float(point.y), ""
            case MatrixFigure():
                yield from _matrix(figure)
            case MapFigure():
                yield from _map(figure)
            case TableFigure():
                yield from _table(figure)
            case _:
                assert_never(figure)


def _axes(figure: Figure) -> tuple[str, str]:
    """What stands at a figure's axes, with units; nothing where it has none."""
    match figure:
        case MatrixFigure() | TableFigure():
            return "", ""
        case PlaneFigure() if figure.powers:
            return axes_of(figure)
        case LineFigure() | PlaneFigure() | MapFigure():
            return label_in_language(figure.x_label, "en"), label_in_language(figure.y_label, "en")
        case _:
            assert_never(figure)


def _curves(id: str, kind: str, curves: tuple[Curve, ...], common: np.ndarray | None) -> Iterator[Row]:
    names = distinct([curve.called("en") for curve in curves])
    for name, curve in zip(names, curves, strict=True):
        own = np.arange(len(curve.y)) if curve.x is None else curve.x
        for x, y in zip(own if common is None else common, curve.y, strict=True):
            yield id, kind, name, float(x), float(y), ""


def distinct(names: list[str]) -> list[str]:
    """The names, later ones of a kind with a number behind them: a, b, a (2)."""
    counts = [names[:k].count(name) for k, name in enumerate(names)]
    return [f"{name} ({count + 1})" if count else name for name, count in zip(names, counts, strict=True)]


def _matrix(figure: MatrixFigure) -> Iterator[Row]:
    matrix = np.asarray(figure.matrix, dtype=float)
    for (i, j), entry in np.ndenumerate(matrix):
        row = label_in_language(figure.rows[i], "en") if figure.rows else str(i)
        column = label_in_language(figure.columns[j], "en") if figure.columns else str(j)
        yield figure.id, "matrix", f"{row}, {column}", float(j), float(i), float(entry)


def _map(figure: MapFigure) -> Iterator[Row]:
    for (i, j), k in np.ndenumerate(np.asarray(figure.values)):
        name = figure.categories[int(k)][0]("en") if k >= 0 else ""
        yield figure.id, "map", name, float(figure.x[j]), float(figure.y[i]), float(k)


def _table(figure: TableFigure) -> Iterator[Row]:
    for i, row in enumerate(figure.rows):
        for column, cell in zip(figure.columns, row, strict=True):
            yield figure.id, "table", column("en"), float(i), "", cell if isinstance(cell, str) else cell("en")


def run_record(design: Design, outcome: Outcome) -> dict[str, Any]:
    """A run as plain data, ready for JSON: lesson, knobs, gains, poles, metrics, checks, series.

    Complex numbers are [re, im]; NaN and infinity, which JSON has not, are null. `series` holds the run's time-first
    arrays t (n_t,), x, xhat, e, u_asked, u_applied, y, yhat, w, v (n_t, …) in SI units; a lesson whose run is of
    another kind gives t, x, xhat, u as its stage plays them. It is empty where nothing moves. A design with the user's
    own plant has "plant" too, in the form of a plant file.
    """
    return {
        "lesson": design.lesson,
        "knobs": {name: plain(value) for name, value in design.values},
        "gains": plain(outcome.gains),
        "poles": {name: [plain(complex(p)) for p in poles] for name, poles in outcome.poles.items()},
        "metrics": plain(outcome.metrics),
        "checks": [{"id": c.id, "text": {code: c.text(code) for code in languages()}, "holds": bool(c.holds),
                    "value": plain(c.value), "informative": c.informative} for c in outcome.checks],
        "series": _series(outcome),
        **({"plant": json.loads(design.plant)} if design.plant else {}),
    }


def json_text(design: Design, outcome: Outcome, token: str) -> str:
    """`run_record` as one line of strict JSON, with the token from which it can be made again."""
    return json.dumps({"token": token, **run_record(design, outcome)}, ensure_ascii=False, allow_nan=False)


def _series(outcome: Outcome) -> dict[str, Any]:
    if outcome.run is not None:
        return {name: plain(getattr(outcome.run, name)) for name in RUN_SERIES}
    if outcome.stage is None:
        return {}
    return {name: plain(values) for name in PLAYED if (values := getattr(outcome.stage, name)) is not None}


def plain(value: Any) -> Any:
    """A value as JSON can hold it: arrays as lists, complex as [re, im], what is not finite as None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
