"""Keep the last rows of a running plant and draw them as strips and as bodies on the stage."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri

from ..course.figures.records import Curve, Figure, LineFigure
from ..course.figures.scene import Stage, last_readings
from ..devices import Routine
from ..text import same, text
from .observer import Step

__all__ = ["Rows", "measured_states"]

KEPT = 400  # rows that are shown
LEVEL = 0.95  # probability of the bound of the NIS
MOST_READINGS = 4  # strips of single readings
LIVE = text("Live")
HELD_NOTE = text("Time 0 is the last line. A missing reading is drawn as the one before it.")
READING, INNOVATION = text("Reading {name}"), text("Innovation y − ŷ")
MEASURED, ESTIMATED = text("measured"), text("estimated")
NIS, BOUND = text("Normalised innovation squared (NIS)"), text("95 % bound")
NIS_NOTE = text("A consistent filter stays below the bound in 95 % of its samples.")
FAULT, FAULT_NOTE = text("Fault verdict"), text("0, 1, 2 … is the fault found; −1 is no alarm; −2 fits no fault or several.")
INPUT = text("Input that acts on the plant")
ESTIMATE = text("Estimate")


@dataclass(frozen=True, eq=False)
class Row:
    """One line with what the observer made of it."""

    step: Step
    yhat: np.ndarray


class Rows:
    """The last rows. The plant on the stage stands where the readings are; what nothing measures stands where the estimate is."""

    def __init__(self) -> None:
        self._rows: deque[Row] = deque(maxlen=KEPT)

    def take(self, step: Step) -> None:
        """One more."""
        v = step.innovation
        self._rows.append(Row(step, step.sample.y * np.nan if v is None else step.sample.y - v))

    def __len__(self) -> int:
        return len(self._rows)

    def times(self) -> np.ndarray:
        """The times of the rows in s, two at least."""
        t = np.array([row.step.sample.t for row in self._rows])
        return t if len(t) > 1 else np.array([0.0, 1.0]) + (t[0] if len(t) else 0.0)

    def figures(self, routine: Routine) -> tuple[Figure, ...]:
        """The strips: readings with their estimates, innovations, NIS or fault verdict, inputs."""
        t, p, m = routine.period * np.arange(1.0 - KEPT, 1.0), len(routine.y_names), len(routine.u_names)
        y, yhat, u = (self._filled([pick(row) for row in self._rows], size) for pick, size in (
            (lambda row: row.step.sample.y, p), (lambda row: row.yhat, p), (lambda row: row.step.sample.u, m)))
        shown: list[Figure] = []
        if "v" in routine.lengths:
            shown += [LineFigure(f"reading{k}", READING.format(name=name), t, (
                Curve(MEASURED, y[:, k], "plant"), Curve(ESTIMATED, yhat[:, k], "estimate", "dash")), caption=HELD_NOTE, tab=LIVE)
                for k, name in enumerate(routine.y_names[:MOST_READINGS])]
            shown.append(LineFigure("innovation", INNOVATION, t, tuple(
                Curve(same(name), y[:, k] - yhat[:, k], "error", ("solid", "dash", "dot")[k % 3]) for k, name in
                enumerate(routine.y_names)), tab=LIVE))
        else:
            shown += [LineFigure("readings", text("Readings"), t, tuple(
                Curve(same(name), y[:, k], "plant", ("solid", "dash", "dot")[k % 3]) for k, name in enumerate(routine.y_names)), tab=LIVE)]
        if "nis" in routine.lengths:
            nis = self._filled([[row.step.nis or 0.0] for row in self._rows], 1)[:, 0]
            bound = self._filled([[chdtri(max(int(np.sum(np.isfinite(row.step.sample.y))), 1), 1 - LEVEL)] for row in self._rows], 1)[:, 0]
            shown.append(LineFigure("nis", NIS, t, (Curve(NIS, nis, "error"), Curve(BOUND, bound, "reference", "dash")),
                                    caption=NIS_NOTE, tab=LIVE))
        if "fault" in routine.lengths:
            fault = self._filled([[-1.0 if row.step.fault is None else row.step.fault] for row in self._rows], 1)[:, 0]
            shown.append(LineFigure("fault", FAULT, t, (Curve(FAULT, fault, "error"),), caption=FAULT_NOTE, tab=LIVE,
                                    window=(-2.5, 2.5)))
        elif "v" not in routine.lengths:
            xhat = self._filled([row.step.xhat for row in self._rows], len(routine.x_names))
            shown.append(LineFigure("estimate", ESTIMATE, t, tuple(
                Curve(same(name), xhat[:, k], "estimate", ("solid", "dash", "dot")[k % 3]) for k, name in enumerate(routine.x_names)),
                tab=LIVE))
        shown.append(LineFigure("input", INPUT, t, tuple(
            Curve(same(name), u[:, k], "force", ("solid", "dash", "dot")[k % 3]) for k, name in enumerate(routine.u_names)), tab=LIVE))
        return tuple(shown)

    def stage(self, pattern: Stage | None, routine: Routine) -> Stage | None:
        """The pattern's body on the rows: where the readings are, and its ghost where the estimate is. None where no body shows them."""
        n = len(routine.x_names)
        pattern = pattern.plain if pattern is not None and pattern.plain is not None else pattern
        if pattern is None or pattern.xhat is None or pattern.xhat.shape[1] < n or n < 2 or not _has_readings(routine):
            return None
        rest = pattern.x[0, n:]
        if len(self._rows) < 2:
            return replace(pattern, t=np.array([0.0, 1.0]), x=pattern.x[[0, 0]], xhat=pattern.xhat[[0, 0]],
                           u=None if pattern.u is None else pattern.u[[0, 0]] * 0.0, spread=None, note=(), held=())
        xhat = np.array([row.step.xhat for row in self._rows])
        x = measured_states(routine, xhat, np.array([row.step.sample.y for row in self._rows]),
                            np.array([row.step.sample.u for row in self._rows]))
        assert x is not None
        u = None
        if pattern.u is not None and pattern.u.shape[1] == len(routine.u_names):
            u = np.array([row.step.sample.u for row in self._rows])
        t = self.times()
        beside = np.tile(rest, (len(x), 1))
        if pattern.readings:
            beside[:, -pattern.readings:] = last_readings(self._readings()[:, 0], pattern.readings)
        full = [np.hstack([part, beside]) for part in (x, xhat)]
        return replace(pattern, t=t - t[0], x=full[0], xhat=full[1], u=u, spread=None, note=(), held=())

    def _readings(self) -> np.ndarray:
        """The readings of all rows (N, p): a missing one is that before it, and zero where there is none."""
        y = np.array([row.step.sample.y for row in self._rows], dtype=float)
        seen = np.where(np.isfinite(y), np.arange(len(y))[:, None], 0)
        return np.nan_to_num(y[np.maximum.accumulate(seen, axis=0), np.arange(y.shape[1])])

    def _filled(self, rows: Sequence[object], size: int) -> np.ndarray:
        """KEPT rows without gaps: a missing value is drawn as the one before it, and what came before the first line as the first."""
        found = np.array(rows, dtype=float).reshape(-1, size)
        if not len(found):
            return np.zeros((KEPT, size))
        seen = np.where(np.isfinite(found), np.arange(len(found))[:, None], 0)
        full = np.nan_to_num(found[np.maximum.accumulate(seen, axis=0), np.arange(size)])
        return np.vstack([np.repeat(full[:1], KEPT - len(full), axis=0), full])


def measured_states(routine: Routine, xhat: np.ndarray, y: np.ndarray, u: np.ndarray) -> np.ndarray | None:
    """The states nearest to the estimates at which the readings are C x + D u, (N, n); None where the routine has no C.

    A missing reading moves nothing.
    """
    tables = {each.name: np.array(each.values).reshape(each.shape) for each in routine.constants}
    if not _has_readings(routine):
        return None
    C = tables["C"]
    gap = y - xhat @ C.T
    if "D" in tables and tables["D"].shape == (len(C), u.shape[1]):
        gap = gap - u @ tables["D"].T
    return xhat + np.nan_to_num(gap, nan=0.0) @ np.linalg.pinv(C).T


def _has_readings(routine: Routine) -> bool:
    """Whether the routine has a C that takes its states to its readings."""
    return any(each.name == "C" and each.shape == (len(routine.y_names), len(routine.x_names)) for each in routine.constants)
