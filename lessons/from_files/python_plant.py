"""Run the functions f and h of a lesson's Python file, only where the operator trusts the code."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any  # what f and h return is `Any` until it is checked

import numpy as np

from observer_lab.course.reading.toml_table import LessonFileError, Table, refusal
from observer_lab.engine.systems import Flow
from observer_lab.text import text

from .parameters import Entries, vector

Map = Callable[[Sequence[float], Sequence[float], SimpleNamespace], Any]
DIFFERENCE = 1e-6  # relative step of the central differences by which f and h are linearised
MAX_CODE_BYTES = 100_000
DIVERGED = 1e9


@dataclass(frozen=True, eq=False)
class PythonPlant:
    """ẋ = f(x, u, p), y = h(x, u, p), with the parameters p by name, and the point at which it is linearised."""

    file: str
    f: Map
    h: Map
    shape: tuple[int, int, int]  # states, inputs, outputs
    point: Entries
    push: Entries

    def at(self, values: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """State (n,) and input (m,) at which the plant is linearised."""
        return vector(self.point, values, self.shape[0]), vector(self.push, values, self.shape[1])

    def rate(self, x: np.ndarray, u: np.ndarray, values: SimpleNamespace) -> np.ndarray:
        """ẋ (n,). Raises LessonFileError where f fails."""
        return self._called(self.f, "f", x, u, values, self.shape[0])

    def output(self, x: np.ndarray, u: np.ndarray, values: SimpleNamespace) -> np.ndarray:
        """y (p,). Raises LessonFileError where h fails."""
        return self._called(self.h, "h", x, u, values, self.shape[2])

    def linear(self, values: Mapping[str, float]) -> tuple[np.ndarray, ...]:
        """A, B, C, D about the point, by central differences."""
        x, u = self.at(values)
        p = SimpleNamespace(**values)
        return (_slope(lambda v: self.rate(v, u, p), x, self.shape[0]), _slope(lambda v: self.rate(x, v, p), u, self.shape[0]),
                _slope(lambda v: self.output(v, u, p), x, self.shape[2]), _slope(lambda v: self.output(x, v, p), u, self.shape[2]))

    def _called(self, function: Map, name: str, x: np.ndarray, u: np.ndarray, values: SimpleNamespace, count: int) -> np.ndarray:
        try:
            found = np.asarray(function(x, u, values), dtype=float).reshape(-1)
        except Exception as problem:
            raise _refusal(self.file, problem) from problem
        if found.shape != (count,):
            line = getattr(getattr(function, "__code__", None), "co_firstlineno", 1)
            raise refusal(self.file, line, text("{name} must return {count} numbers; it returns {found}.", name=name, count=count,
                                                found=found.size))
        return found


def _refusal(file: str, problem: BaseException) -> LessonFileError:
    """The error of code, with the line of the file at which it arose."""
    lines = [frame.lineno for frame in traceback.extract_tb(problem.__traceback__) if frame.filename == file]
    line = problem.lineno if isinstance(problem, SyntaxError) else next(reversed(lines), 1)
    why = str(problem.msg if isinstance(problem, SyntaxError) else problem).partition("\n")[0][:120].rstrip(".") or "—"
    return refusal(file, line or 1, text("{kind}: {why}.", kind=type(problem).__name__, why=why))


def _slope(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray, rows: int) -> np.ndarray:
    columns = []
    for k in range(len(at)):
        step = np.zeros(len(at))
        step[k] = DIFFERENCE * max(1.0, abs(at[k]))
        columns.append((function(at + step) - function(at - step)) / (2 * step[k]))
    return np.column_stack(columns) if columns else np.zeros((rows, 0))


def read_python(table: Table, folder: Path, trusted: bool, shape: tuple[int, int, int], point: Entries, push: Entries) -> PythonPlant:
    """The functions of the file that `python` names. Raises LessonFileError, also where the operator does not trust code."""
    path = folder / table.words("python")
    if path.parent != folder or not path.is_file() or path.stat().st_size > MAX_CODE_BYTES:
        raise table.refuse("python", text("There is no Python file {file} beside this lesson.", file=path.name[:40]))
    if not trusted:
        raise table.refuse("python", text("{file} is Python code and is not run; start the server with --trust-code if you trust it.",
                                          file=path.name))
    space: dict[str, Any] = {"__name__": path.stem}
    try:
        exec(compile(path.read_text(encoding="utf-8"), path.name, "exec"), space)
    except BaseException as problem:  # also code that asks the process to exit
        raise _refusal(path.name, problem) from problem
    for name in ("f", "h"):
        if not callable(space.get(name)):
            raise refusal(path.name, 1, text("The file has no function {name}(x, u, p).", name=name))
    return PythonPlant(path.name, space["f"], space["h"], shape, point, push)


@dataclass(frozen=True, eq=False)
class NonlinearRun:
    """Arrays of a nonlinear run, time first: states, estimates, inputs, outputs; it ends early where it diverges."""

    t: np.ndarray
    x: np.ndarray
    xhat: np.ndarray
    u: np.ndarray
    y: np.ndarray
    yhat: np.ndarray


@dataclass(frozen=True, eq=False)
class LoopGiven:
    """What a nonlinear run starts from: gains, start, guess, reference, limit, noise, kick, grid."""

    K: np.ndarray
    L: np.ndarray
    start: np.ndarray
    guess: np.ndarray
    reference: np.ndarray
    limit: float
    readings: np.ndarray  # (n_t, p): the noise of each reading
    kick: tuple[float, np.ndarray]
    step: float


def simulate_loop(plant: PythonPlant, truth: Mapping[str, float], belief: Mapping[str, float], given: LoopGiven) -> NonlinearRun:
    """ẋ = f(x, u), x̂̇ = f̂(x̂, u) + L (y − ŷ), u = u₀ + r − K (x̂ − x₀) held over a step; Runge–Kutta of order four."""
    n, p_true, p_model = plant.shape[0], SimpleNamespace(**truth), SimpleNamespace(**belief)
    at, push = plant.at(belief)
    z = np.concatenate([given.start, given.guess])
    rows = []
    for k, noise in enumerate(given.readings):
        if given.kick[0] >= 0 and k == round(given.kick[0] / given.step):
            z = z + np.concatenate([given.kick[1], np.zeros(n)])
        x, xhat = z[:n], z[n:]
        u = np.clip(push + given.reference - given.K @ (xhat - at), -given.limit, given.limit)
        rows.append((x, xhat, u, plant.output(x, u, p_true) + noise, plant.output(xhat, u, p_model)))

        def rate(columns: np.ndarray, _: np.ndarray, u: np.ndarray = u, noise: np.ndarray = noise) -> np.ndarray:
            x, xhat = columns[:n, 0], columns[n:, 0]
            gap = plant.output(x, u, p_true) + noise - plant.output(xhat, u, p_model)
            return np.concatenate([plant.rate(x, u, p_true), plant.rate(xhat, u, p_model) + given.L @ gap])[:, None]
        z = Flow(rate, given.step)(z[:, None], np.zeros((0, 1)))[:, 0]
        if not np.all(np.abs(z) < DIVERGED):
            break
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    return NonlinearRun(given.step * np.arange(len(rows)), *columns)
