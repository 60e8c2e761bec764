"""One law over many things is one test: it tries them all and names each that breaks it, with what broke.

Of a law that `sampled.txt` names it tries the law's turn of them, and all with `--whole`.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterable
from typing import Any

import pytest
from _pytest.mark import ParameterSet
from sampling import SAMPLED, some


def holds_for_all(things: Iterable[Any], law: Callable[..., object], name: Callable[..., str] = str) -> None:
    """Apply a law to every thing, a tuple as its arguments; fail with one line for each that breaks it."""
    broken, tried = [], 0
    running = os.environ.get("PYTEST_CURRENT_TEST", "").partition(" (")[0].removeprefix("tests/")
    for thing in some(running, things, SAMPLED[running].every) if running in SAMPLED else things:
        tried += 1
        arguments = thing if isinstance(thing, tuple) else (thing,)
        try:
            law(*arguments)
        except (Exception, pytest.fail.Exception) as problem:
            broken.append(f"{name(*arguments)}: {type(problem).__name__}: {str(problem)[:2000]}")
    assert tried, "a law over nothing"
    assert not broken, f"{len(broken)} of {tried} break the law:\n" + "\n".join(broken)


def each(names: str | tuple[str, ...], values: Iterable[Any], ids: object = None) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Make one test of a law over many values, written like `parametrize`: `@each("low, high", [(0, 1), (2, 3)])`.

    For laws of microseconds, where a case of its own costs more than the law; what takes time stays parametrised. Fixtures
    are shared by all values.
    """
    keys = tuple(name.strip() for name in names.split(",")) if isinstance(names, str) else names
    table = list(values)

    def decorate(law: Callable[..., None]) -> Callable[..., None]:
        def test(**given: Any) -> None:
            def one(index: int) -> None:
                row = table[index]
                cells = tuple(row.values) if isinstance(row, ParameterSet) else tuple(row) if len(keys) > 1 else (row,)
                law(**given, **dict(zip(keys, cells, strict=True)))
            holds_for_all(range(len(table)), one, lambda index: f"{', '.join(keys)} = {str(table[index])[:80]}")
        signature = inspect.signature(law)
        test.__signature__ = signature.replace(  # type: ignore[attr-defined]
            parameters=[p.replace(kind=p.KEYWORD_ONLY) for p in signature.parameters.values() if p.name not in keys])
        test.__name__, test.__doc__, test.__module__ = law.__name__, law.__doc__, law.__module__
        test.pytestmark = list(getattr(law, "pytestmark", ()))  # type: ignore[attr-defined]
        return test
    return decorate
