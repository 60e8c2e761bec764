"""Define one check for each kind of argument of a public call.

`@takes(A=matrix("n n"), B=matrix("n m"), dt=SECONDS)` above a function says what it takes; letters are sizes that must agree among
its arguments, with those of its `plant` n, m, p. Each room's `__init__` puts the gates in front; within the engine there are none.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from operator import length_hint
from typing import Any

import numpy as np

from ..arrays import MAX_ENTRIES, described
from ..errors import EngineError
from .array_checks import POLES, RECORD, SERIES, WHOLE, array, covariance, matrix, vector
from .checked_calls import Gate, Sizes, gated, gated_runs, passed, takes, takes_runs

__all__ = [
    "BOOLEAN",
    "COMPLEX",
    "COUNT",
    "FINITE",
    "FUNCTION",
    "GENERATOR",
    "HORIZON",
    "INTEGER",
    "LEVEL",
    "MOST_NUMBERS",
    "NAME",
    "PERIOD",
    "POLES",
    "POSITIVE",
    "RECORD",
    "SECONDS",
    "SEED",
    "SERIES",
    "SHARE",
    "WHOLE",
    "Gate",
    "Sizes",
    "array",
    "choice",
    "count",
    "covariance",
    "either",
    "gated",
    "gated_runs",
    "instance",
    "items",
    "matrix",
    "names",
    "number",
    "optional",
    "passed",
    "takes",
    "takes_runs",
    "vector",
]

MOST_NUMBERS = 40_000_000  # in what one call makes; 320 MB


# --- numbers -----------------------------------------------------------------------------------------------------------
def number(low: float = -np.inf, high: float = np.inf, *, above: float | None = None, infinite: bool = False) -> Gate:
    """A real number with low ≤ number ≤ high, and > `above` if given."""
    def gate(value: object, name: str, sizes: Sizes) -> float:
        found = real(value, name)
        if np.isnan(found) or (np.isinf(found) and not infinite):
            raise EngineError("{name} must be a finite number; it is {value}.", name=name, value=found)
        if above is not None and not found > above:
            raise EngineError("{name} must be above {above:g}; it is {value:.6g}.", name=name, above=above, value=found)
        if found < low:
            raise EngineError("{name} must be at least {low:g}; it is {value:.6g}.", name=name, low=low, value=found)
        if found > high:
            raise EngineError("{name} must be at most {high:g}; it is {value:.6g}.", name=name, high=high, value=found)
        return found
    return gate


def real(value: object, name: str) -> float:
    """The real number that a value is: a Python or NumPy number, or an array of no dimension; an imaginary part of zero is none."""
    try:
        if isinstance(value, str | bytes | bool | np.bool_) or np.ndim(value) or np.ma.is_masked(value):  # type: ignore[arg-type]
            raise TypeError
        if np.iscomplexobj(value):
            value = complex(value)  # type: ignore[arg-type]
            return float(value if value.imag else value.real)  # type: ignore[arg-type]  # a TypeError where it has an imaginary part
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError) as problem:
        raise EngineError("{name} must be a real number; {given} was given.", name=name, given=described(value)) from problem


def count(low: int = 0, high: int = MAX_ENTRIES, *, beside: str = "") -> Gate:
    """A whole number, low ≤ number ≤ high; high is shared by the sizes `beside` it, as "n n" for that many n×n matrices."""
    def gate(value: object, name: str, sizes: Sizes) -> int:
        most = high // max(1, math.prod(sizes.get(letter, 1) for letter in beside.split()))
        found = None if isinstance(value, bool | np.bool_) else real(value, name)
        if found is None or not found.is_integer() or not low <= found <= most:
            raise EngineError("{name} must be a whole number from {low} to {high}; it is {value}.", name=name, low=low, high=most,
                              value=value if found is None else f"{found:.10g}")
        return int(found)
    return gate


def _integer(value: object, name: str, sizes: Sizes) -> int:
    found = None if isinstance(value, bool | np.bool_) else real(value, name)
    if found is None or not found.is_integer() or abs(found) > 2**53:
        raise EngineError("{name} must be a whole number; it is {value}.", name=name, value=value if found is None else f"{found:.10g}")
    return int(found)


def _seed(value: Any, name: str, sizes: Sizes) -> Any:
    parts = list(value) if isinstance(value, list | tuple) else [value]
    if not parts or any(isinstance(v, bool | np.bool_) or not isinstance(v, int | np.integer) or v < 0 for v in parts):
        raise EngineError("{name} must be a whole number, zero or more.", name=name)
    return value


def _complex(value: object, name: str, sizes: Sizes) -> complex:
    try:
        if isinstance(value, str | bytes | list | tuple | bool) or np.ndim(value):  # type: ignore[arg-type]
            raise TypeError
        found = complex(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError) as problem:
        raise EngineError("{name} must be a real or complex number.", name=name) from problem
    if np.isnan(found):
        raise EngineError("{name} must be a real or complex number.", name=name)
    return found


FINITE = number()
COMPLEX: Gate = _complex
POSITIVE = number(above=0)
HORIZON = number(0, 1e18)  # s; 1e9 s in units of a nanosecond
SECONDS = number(above=0, high=1e18)
PERIOD = number(0, 1e18)  # 0: continuous time
LEVEL = SHARE = number(0, 1)
COUNT = count(1)
INTEGER: Gate = _integer  # of which the call itself says the range
SEED: Gate = _seed


# --- words and things --------------------------------------------------------------------------------------------------
def choice(*words: object) -> Gate:
    """One of a few words."""
    listed = ", ".join(f'"{word}"' if isinstance(word, str) else str(word) for word in words)

    def gate(value: object, name: str, sizes: Sizes) -> object:
        if not isinstance(value, str | int) or value not in words:
            raise EngineError("{name} must be one of {words}.", name=name, words=listed)
        return value
    return gate


def instance(*kinds: type) -> Gate:
    """A record of the engine, such as a Scenario."""
    listed = ", ".join(kind.__name__ for kind in kinds)

    def gate(value: Any, name: str, sizes: Sizes) -> Any:
        if not isinstance(value, kinds):
            raise EngineError("{name} must be a {kind}; {given} was given.", name=name, kind=listed, given=described(value))
        return value
    return gate


def items(one: Gate, most: int = MAX_ENTRIES) -> Gate:
    """A tuple of things that pass a gate each."""
    def gate(value: Any, name: str, sizes: Sizes) -> tuple[Any, ...]:
        listed = isinstance(value, Iterable) and not isinstance(value, str | bytes | dict | set) and not np.ma.is_masked(value)
        if not listed or length_hint(value) > most:
            raise EngineError("{name} must be a list; {given} was given.", name=name, given=described(value))
        return tuple(one(v, name, sizes) for v in value)
    return gate


def pair(first: Gate, second: Gate) -> Gate:
    """Two things in a row, as a time and a jump."""
    def gate(value: Any, name: str, sizes: Sizes) -> tuple[Any, Any]:
        row = isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim == 1 and not np.ma.is_masked(value))
        if not row or len(value) != 2:
            raise EngineError("{name} must be a pair; {given} was given.", name=name, given=described(value))
        return first(value[0], name, sizes), second(value[1], name, sizes)
    return gate


def optional(gate: Gate) -> Gate:
    """The same, or None."""
    return lambda value, name, sizes: None if value is None else gate(value, name, sizes)


def either(kind: type, otherwise: Gate) -> Gate:
    """A record of a kind as it is, anything else through the gate."""
    first = instance(kind)
    return lambda value, name, sizes: (first if isinstance(value, kind) else otherwise)(value, name, sizes)


def _boolean(value: object, name: str, sizes: Sizes) -> bool:
    if not isinstance(value, bool | np.bool_):
        raise EngineError("{name} must be True or False.", name=name)
    return bool(value)


def _function(value: object, name: str, sizes: Sizes) -> object:
    if not callable(value):
        raise EngineError("{name} must be a function; {given} was given.", name=name, given=described(value))
    return value


def _generator(value: object, name: str, sizes: Sizes) -> object:
    if not isinstance(value, np.random.Generator):
        raise EngineError("{name} must be a random generator, such as np.random.default_rng(0).", name=name)
    return value


def _name(value: object, name: str, sizes: Sizes) -> object:
    if not isinstance(value, str):
        raise EngineError("{name} must be text.", name=name)
    return value


ANY: Gate = lambda value, name, sizes: value  # noqa: E731
BOOLEAN: Gate = _boolean
FUNCTION: Gate = _function
GENERATOR: Gate = _generator
NAME: Gate = _name
names: Gate = items(NAME)
