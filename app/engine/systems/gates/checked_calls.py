"""Check the arguments of a public call before any work, and its answer for overflow."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, is_dataclass
from typing import Any, ParamSpec, TypeVar

import numpy as np

from ..errors import EngineError

__all__ = ["Gate", "Sizes", "Taken", "gated", "gated_runs", "passed", "takes", "takes_runs", "with_checks"]

Sizes = dict[str, int]
Gate = Callable[[Any, str, Sizes], Any]
P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True)
class Taken:
    """What a public function takes: a gate for each argument, what judges its answer, and the time its equations are in."""

    gates: Mapping[str, Gate]
    answer: Callable[..., Any]
    time: str


def takes(time: str = "", /, **gates: Gate) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Write beside a public function what it takes; its room puts the gates in front of what it gives away.

    The function itself stays as it is: callers within the engine hold arrays already and pay nothing. `time` is "continuous"
    or "sampled" where a plant of the other kind must be refused.
    """
    return _marked(Taken(gates, _within_range, time))


def takes_runs(**gates: Gate) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """The same for a step of many runs, some of which may go astray: the caller judges what is then not finite."""
    return _marked(Taken(gates, _as_it_comes, ""))


def _marked(taken: Taken) -> Callable[[Callable[P, R]], Callable[P, R]]:
    def mark(call: Callable[P, R]) -> Callable[P, R]:
        vars(call)["taken"] = taken
        return call
    return mark


def gated(**gates: Gate) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A method whose arguments pass their gates first; one that is its own default passes as it is."""
    return lambda call: with_checks(call, Taken(gates, _within_range, ""))


def gated_runs(**gates: Gate) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """The same for a method that steps many runs: what is then not finite is the caller's to judge."""
    return lambda call: with_checks(call, Taken(gates, _as_it_comes, ""))


def with_checks(call: Callable[P, R], taken: Taken) -> Callable[P, R]:
    """The call with the gates in front; an argument that is its own default passes as it is."""
    parameters = inspect.signature(call).parameters
    gates, answer = taken.gates, taken.answer
    order = tuple((place, name, gates.get(name), parameter.default) for place, (name, parameter) in enumerate(parameters.items()))

    @functools.wraps(call)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        sizes: Sizes = {}
        given, named = list(args), dict(kwargs)
        for place, name, gate, default in order:
            if gate is None:
                continue
            if place < len(given):
                if given[place] is not default:
                    given[place] = gate(given[place], name, sizes)
            elif name in named and named[name] is not default:
                named[name] = gate(named[name], name, sizes)
        return answer(call, given, named)
    vars(checked)["taken"] = taken
    return checked


def _as_it_comes(call: Callable[..., R], given: list[Any], named: dict[str, Any]) -> R:
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return call(*given, **named)


def _within_range(call: Callable[..., R], given: list[Any], named: dict[str, Any]) -> R:
    """What the call gives back; EngineError where its numbers overflowed on the way and the answer is not finite."""
    heard: list[str] = []
    with np.errstate(over="call", invalid="call", divide="call", call=lambda kind, flag: heard.append(kind)):
        try:
            found = call(*given, **named)
        except EngineError:
            raise
        except (ArithmeticError, ValueError) as problem:
            if heard or isinstance(problem, ArithmeticError | np.linalg.LinAlgError):
                raise _out_of_range() from problem
            raise
    if inspect.isgenerator(found):
        return _steps_within_range(found)  # type: ignore[return-value]
    if heard and not _finite(found):
        raise _out_of_range()
    return found


def _steps_within_range(steps: Generator[Any]) -> Generator[Any]:
    end: Any = object()
    try:
        while (step := _within_range(next, [steps, end], {})) is not end:
            yield step
    finally:
        steps.close()


def _out_of_range() -> EngineError:
    return EngineError("These numbers are too large or too far apart to be computed with; choose other units or sizes nearer to 1.")


def _finite(found: object) -> bool:
    """Whether the arrays and numbers of an answer are finite, those within its records and tuples too."""
    if isinstance(found, np.ndarray | float | complex | np.number):
        return bool(np.isfinite(found).all()) if not isinstance(found, np.ndarray) or found.dtype.kind in "fc" else True
    if isinstance(found, tuple | list):
        return all(map(_finite, found))
    return all(map(_finite, vars(found).values())) if is_dataclass(found) else True


def passed(record: Any, **gates: Gate) -> None:
    """The same for the fields of a frozen record that is being made: each becomes what its gate gives back."""
    sizes: Sizes = {}
    for name, gate in gates.items():
        value = getattr(record, name)
        if value is not getattr(type(record), name, record):  # a field left out has the default of its class
            object.__setattr__(record, name, gate(value, name, sizes))
