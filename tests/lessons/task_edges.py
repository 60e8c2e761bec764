"""Find where the verdict on a task turns: each number that its check compares is moved, nothing is computed again.

    python tests/lessons/task_edges.py [LESSON …]      prints the table that `task_edges.txt` holds
"""

from __future__ import annotations

import ast
import importlib
import inspect
import sys
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from observer_lab.course.lesson import Lesson, Outcome, Task
from observer_lab.lessons import LESSONS

TABLE = Path(__file__).with_name("task_edges.txt")
STEPS, GROWTH, FIRST_STEP = 64, 2.5, 1e-15  # of the walk away from the solved value, whose first step is a thousandth of it
DIGITS = 1e-9  # of an edge, relative
ORDERS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)
Edge = tuple[str, str]  # the expression that is compared, and "least" or "most"


@dataclass
class Seen:
    """The numbers that a check has compared, by their expressions; one of them may be replaced."""

    values: dict[str, set[float]] = field(default_factory=dict)
    instead: dict[str, float] = field(default_factory=dict)

    def __call__(self, expression: str, value: Any) -> Any:
        if isinstance(value, bool) or not hasattr(value, "__float__") or getattr(value, "size", 1) != 1:
            return value
        self.values.setdefault(expression, set()).add(float(value))
        return self.instead.get(expression, value)


class _Watch(ast.NodeTransformer):
    """Hands what each comparison measures to `_seen`: the middle of `low <= x <= high`, else the first that is no constant."""

    def __init__(self, constants: Collection[str]) -> None:
        self.constants = constants

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        self.generic_visit(node)
        operands = [node.left, *node.comparators]
        place = next((k for k in ([1] if len(operands) == 3 else [0, 1]) if not self._is_constant(operands[k])), None)
        if place is not None and all(isinstance(op, ORDERS) for op in node.ops):
            expression = ast.unparse(operands[place])
            operands[place] = ast.Call(ast.Name("_seen", ast.Load()), [ast.Constant(expression), operands[place]], [])
        return ast.Compare(operands[0], node.ops, operands[1:])


    def _is_constant(self, node: ast.expr) -> bool:
        names = {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}
        return names <= self.constants and not any(isinstance(each, ast.Call) for each in ast.walk(node))


def _watched(module: str, seen: Seen, **more: Any) -> dict[str, Any]:
    """The names of a module whose comparisons are watched."""
    source = importlib.import_module(module)
    constants = {name for name in vars(source) if name.isupper()}
    tree = ast.fix_missing_locations(_Watch(constants).visit(ast.parse(inspect.getsource(source))))
    names = {"__name__": module, "__package__": module.rpartition(".")[0], "_seen": seen}
    exec(compile(tree, module, "exec"), names)
    names.update(more)
    return names


@cache
def watched_tasks(lesson: str) -> tuple[Seen, tuple[Task[Any], ...]]:
    """The tasks of a lesson that ask the design, and what their checks compare."""
    seen = Seen()
    shared = _watched("observer_lab.lessons.toolkit.tasks", seen)["check_gentle_settling"]
    names = _watched(f"observer_lab.lessons.{lesson.replace('-', '_')}.tasks", seen, check_gentle_settling=shared)
    return seen, tuple(task for task in names["TASKS"] if task.solution)


@dataclass
class Trial:
    """A task at its own solution, whose compared numbers can be replaced."""

    lesson: Lesson
    task: Task[Any]
    seen: Seen

    def __post_init__(self) -> None:
        self.outcome: Outcome[Any] = self.lesson.compute(self.lesson.apply(self.lesson.start(), self.task.solution))
        self.seen.values.clear()
        assert self.holds({}), f"{self.task.id} is not solved"
        self.compared = {expression: next(iter(values)) for expression, values in self.seen.values.items() if len(values) == 1}

    def holds(self, instead: dict[str, float]) -> bool:
        """Whether the task is solved with other numbers in the place of those expressions."""
        self.seen.instead = instead
        try:
            return self.task.check(self.outcome).solved
        finally:
            self.seen.instead = {}

    def edges(self) -> Iterator[tuple[Edge, float]]:
        """Every value at which the verdict turns, nearest to the solved one."""
        for expression, start in self.compared.items():
            for name, sign in (("least", -1.0), ("most", 1.0)):
                edge = _edge(lambda value, e=expression: self.holds({e: value}), start, sign)
                if edge is not None:
                    yield (expression, name), edge


def _edge(holds: Callable[[float], bool], start: float, sign: float) -> float | None:
    step, inside = max(1e-3 * abs(start), FIRST_STEP), start
    for _ in range(STEPS):
        outside = start + sign * step
        if not holds(outside):
            return _bisected(holds, inside, outside)
        step, inside = step * GROWTH, outside
    return None


def _bisected(holds: Callable[[float], bool], inside: float, outside: float) -> float:
    while abs(outside - inside) > max(DIGITS * abs(inside), FIRST_STEP / 2):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if holds(middle) else (inside, middle)
    return inside


def trials(*ids: str) -> Iterator[Trial]:
    """Every task that asks the design, of these lessons or of all."""
    for lesson in LESSONS.values():
        if not ids or lesson.id in ids:
            seen, tasks = watched_tasks(lesson.id)
            yield from (Trial(lesson, task, seen) for task in tasks)


def declared() -> dict[tuple[str, str], dict[Edge, float]]:
    """The table: lesson and task → expression and side → edge."""
    table: dict[tuple[str, str], dict[Edge, float]] = {}
    for line in TABLE.read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            head, expression, side, value = line.split(" | ")
            lesson, task = head.split()
            table.setdefault((lesson, task), {})[expression, side] = float(value)
    return table


if __name__ == "__main__":
    for trial in trials(*sys.argv[1:]):
        for (expression, side), value in trial.edges():
            print(f"{trial.lesson.id} {trial.task.id} | {expression} | {side} | {round(value, 12) + 0.0:.7g}", flush=True)
