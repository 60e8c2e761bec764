"""One law over many things is one test: it tries them all and names each that breaks it, with what broke."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import pytest


def holds_for_all(things: Iterable[Any], law: Callable[..., object], name: Callable[..., str] = str) -> None:
    """Apply a law to every thing, a tuple as its arguments; fail with one line for each that breaks it."""
    broken, tried = [], 0
    for thing in things:
        tried += 1
        arguments = thing if isinstance(thing, tuple) else (thing,)
        try:
            law(*arguments)
        except (Exception, pytest.fail.Exception) as problem:
            broken.append(f"{name(*arguments)}: {type(problem).__name__}: {str(problem)[:2000]}")
    assert tried, "a law over nothing"
    assert not broken, f"{len(broken)} of {tried} break the law:\n" + "\n".join(broken)
