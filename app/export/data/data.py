"""Write figures as one long CSV table and a run as strict JSON."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...course.figures.figure_record import Cell, Sheet
from ...course.figures.records import Figure
from ...course.lesson import Design, Outcome
from ...text import languages

__all__ = ["HEADER", "csv_rows", "figure_csv", "figure_json", "json_text", "plain", "run_record", "save_csv", "save_table"]

HEADER = ("figure", "kind", "series", "x", "y", "value", "x_axis", "y_axis")
Row = tuple[str, str, str, float, Cell, Cell]
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
            axes = figure.axes()
            for row in csv_rows([figure]):
                table.writerow([*(repr(cell) if isinstance(cell, float) else cell for cell in row), *axes])


def csv_rows(figures: Sequence[Figure]) -> Iterator[Row]:
    """The rows of `save_csv` below the header, numbers as Python floats."""
    return ((figure.id, figure.kind, *entry) for figure in figures for entry in figure.entries())


def figure_csv(figure: Figure, token: str, language: str = "en") -> bytes:
    """The table of a figure, below a line with the token; UTF-8, and marked as such where the heads are not ASCII.

    A spreadsheet needs the mark; `pandas.read_csv(name, comment="#")` and numpy's loaders pass both over.
    """
    return _table_csv(figure.table(language), f"# Observer Lab, state {token}\n")


def save_table(table: Sheet, path: str | Path) -> None:
    """Write a table as CSV (UTF-8, comma, full precision); the cell of a missing number is empty."""
    Path(path).write_bytes(_table_csv(table))


def _table_csv(table: Sheet, above: str = "") -> bytes:
    heads, rows = table
    out = io.StringIO()
    out.write(above)
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows([_cell(cell) for cell in row] for row in rows)
    written = out.getvalue()
    return written.encode("utf-8" if written.isascii() else "utf-8-sig")


def _cell(cell: Cell) -> Cell:
    return cell if not isinstance(cell, float) else "" if math.isnan(cell) else repr(cell)


def figure_json(figure: Figure, token: str, language: str = "en") -> bytes:
    """The same as strict JSON: token, figure, title, heads with their units, rows; null where a number is not finite."""
    heads, rows = figure.table(language)
    whole = {"token": token, "figure": figure.id, "title": figure.title(language), "heads": heads, "rows": plain(rows)}
    return (json.dumps(whole, ensure_ascii=False, allow_nan=False) + "\n").encode()


def run_record(design: Design, outcome: Outcome) -> dict[str, Any]:
    """A run as plain data, ready for JSON: lesson, knobs, gains, poles, metrics, checks, series.

    Complex numbers are [re, im]; NaN and infinity, which JSON has not, are null. `never` names the metrics of what does not
    happen at all, such as an error that does not settle. `series` holds the run's time-first
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
        "never": [name for name, value in outcome.metrics.items() if value == math.inf],
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
