"""Summarise a study: table of runs, summary of each point, JSON."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from observer_lab.lessons import LESSONS

from ..export.data.data import plain
from .plan import Row, Study, record
from .points import CHECK_PREFIX, SEED_KNOB, grid_place, seed_at

QUANTILES = (0.05, 0.95)  # of the runs at a point lie below the band's edges
Z = 1.959963984540054  # of a normal variable, two-sided at 95 %


@dataclass(frozen=True, eq=False)
class Summary:
    """What a name came to at each point: arrays of the study's shape, NaN where no run gave a number.

    A metric has its median with the 5 and 95 % quantiles of its runs; a check the share of runs in which it holds, with
    Wilson's interval at 95 %.
    """

    name: str
    count: np.ndarray
    middle: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @property
    def is_check(self) -> bool:
        """Whether it counts the runs in which something holds."""
        return self.name.startswith(CHECK_PREFIX)


def summaries(study: Study, rows: Mapping[int, Row]) -> list[Summary]:
    """One for each name that is collected."""
    every = table(study, rows)
    return [_summary(name, every[:, k].reshape(study.points, study.runs), study.shape) for k, name in enumerate(study.collect)]


def table(study: Study, rows: Mapping[int, Row]) -> np.ndarray:
    """Every number, (runs, names); NaN where there is none."""
    return np.array([[np.nan if value is None else value for value in rows[index].values] for index in range(study.size)]
                    ).reshape(study.size, len(study.collect))


def _summary(name: str, values: np.ndarray, shape: tuple[int, ...]) -> Summary:
    known = ~np.isnan(values)
    count = known.sum(axis=1)
    middle, low, high = np.full((3, len(values)), np.nan)
    for k in np.flatnonzero(count):
        own = values[k][known[k]]
        if name.startswith(CHECK_PREFIX):
            middle[k], (low[k], high[k]) = own.mean(), wilson(int(own.sum()), len(own))
        else:
            middle[k], low[k], high[k] = (_quantile(own, share) for share in (0.5, *QUANTILES))
    return Summary(name, count.reshape(shape), *(each.reshape(shape) for each in (middle, low, high)))


def _quantile(values: np.ndarray, share: float) -> float:
    """The quantile between neighbours, also where some are infinite."""
    place = share * (len(values) - 1)
    below, ordered = int(place), np.sort(values).tolist()
    low, high, part = ordered[below], ordered[min(below + 1, len(values) - 1)], place - below
    return low if low == high or part == 0 else low + part * (high - low)


def wilson(holds: int, count: int) -> tuple[float, float]:
    """Wilson's interval of a share at 95 % (E. B. Wilson, 1927)."""
    share, part = holds / count, Z * Z / count
    middle, half = (share + part / 2) / (1 + part), Z * np.sqrt(share * (1 - share) / count + part / (4 * count)) / (1 + part)
    return float(max(middle - half, 0.0)), float(min(middle + half, 1.0))


# --- files -------------------------------------------------------------------------------------------------------------
def columns(study: Study) -> list[str]:
    """The columns of the table: what varies with its unit, the seed, what is collected, and why there is nothing."""
    lesson = LESSONS[study.lesson].fit(study.plant)
    units = {knob.name: knob.unit for knob in lesson.knobs}
    named = [f"{axis.name} [{units[axis.name]}]" if not axis.of_plant and units[axis.name] else axis.name for axis in study.axes]
    return ["point", *named, *([SEED_KNOB] if study.seeds or study.drawn else []), *study.collect, "problem"]


def cells(study: Study, row: Row) -> list[Any]:
    """A row of the table: numbers as they are, other values as `--set` takes them, None where there is nothing."""
    point, _, place = grid_place(study, row.index)
    seed = seed_at(study, row.index)
    return [point, *(shown(study, k, at) for k, at in enumerate(place)), *([] if seed is None else [seed]), *row.values, row.problem]


def shown(study: Study, axis: int, at: int) -> float | str:
    """A value of an axis: a number, or the words that `--set` takes."""
    here = study.axes[axis]
    value = here.values[at]
    if isinstance(value, float):
        return value
    return LESSONS[study.lesson].fit(study.plant).knob(here.name).show(value)


def save_table(study: Study, rows: Mapping[int, Row], path: str | Path, mark: str, token: str) -> None:
    """Write the runs as CSV (UTF-8, comma, full precision) below a line `# …` with the study's digest and the token of its design.

    Raises OSError if the file cannot be written.
    """
    with Path(path).open("w", encoding="utf-8", newline="") as file:
        file.write(f"# Observer Lab, study {mark}, state {token}\n")
        out = csv.writer(file, lineterminator="\n")
        out.writerow(columns(study))
        for index in range(study.size):
            out.writerow(["" if cell is None else repr(cell) if isinstance(cell, float) else cell for cell in cells(study, rows[index])])


def result_record(study: Study, rows: Mapping[int, Row], found: Sequence[Summary], mark: str, token: str,
           made_by: Mapping[str, str]) -> dict[str, Any]:
    """The whole study as plain data, ready for JSON; what is not finite is null."""
    return {
        "study": record(study), "digest": mark, "token": token, "programs": dict(made_by),
        "columns": columns(study), "rows": plain([cells(study, rows[index]) for index in range(study.size)]),
        "points": {each.name: {"count": plain(each.count), "middle": plain(each.middle), "low": plain(each.low), "high": plain(each.high)}
                   for each in found},
        "middle": "median of a metric, share of the runs in which a check holds",
        "low, high": "5 and 95 % quantiles of a metric, Wilson's interval at 95 % of a share",
    }
