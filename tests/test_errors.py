"""Errors and messages survive pickling and copying, so that a pool of workers loses no sentence."""

from __future__ import annotations

import copy
import importlib
import inspect
import pickle
import pkgutil
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import observer_lab
import observer_lab.lessons
from observer_lab.engine.systems.errors import EngineError, Phrase, phrase
from observer_lab.text import Text, error_words, joined, listed, same, text, text_in

COPIES: tuple[Callable[[Any], Any], ...] = (
    copy.copy, copy.deepcopy,
    *(lambda value, protocol=p: pickle.loads(pickle.dumps(value, protocol)) for p in range(pickle.HIGHEST_PROTOCOL + 1)))
MESSAGES = (phrase("The delay"), phrase("{kind} of {count}", kind=phrase("state"), count=3), text("Plain."), same("x₁"),
            text("{a} and {b:.3g}", a=phrase("The delay"), b=np.float64(1.25)), text_in("axis", "time"), listed([text("a"), same("b")]),
            joined(text("One."), text("Two {n}.", n=2)))


def _modules() -> Iterator[str]:
    for package in (observer_lab, observer_lab.lessons):
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not found.name.endswith("__main__"):
                yield found.name


def _own_errors() -> list[type[BaseException]]:
    """Every class of exception that a module of ours defines."""
    found = set()
    for name in _modules():
        module = importlib.import_module(name)
        found |= {kind for _, kind in inspect.getmembers(module, inspect.isclass)
                  if issubclass(kind, BaseException) and kind.__module__ == name}
    return sorted(found, key=lambda kind: (kind.__module__, kind.__qualname__))


def _made(kind: type[BaseException]) -> BaseException:
    """An error of a kind, with a sentence inside a sentence where it can have values."""
    within = EngineError("{name} must be {must}.", name=phrase("The step"), must=1.5)
    if issubclass(kind, EngineError) and "message" in inspect.signature(kind.__init__).parameters:
        return kind("{name} is {value}: {why}", name=phrase("The delay"), value=np.float64(-1.0), why=within)
    wanted = list(inspect.signature(kind.__init__).parameters.values())[1:]
    if wanted and wanted[0].name == "said":
        return kind(text("{why}", why=error_words(within)))
    if [one.name for one in wanted] == ["kind", "words"]:
        return kind("forged", "One sentence.")
    if [one.name for one in wanted] == ["place", "key", "value", "words"]:
        return kind(("course", 1), "points", -1.0, "{key} must be positive; it is {value}.")
    return kind("One sentence.") if wanted else kind()


@pytest.mark.slow
def test_every_error_keeps_its_sentence_in_a_pickle_and_in_a_copy() -> None:
    kinds = _own_errors()
    wanted = {"EngineError", "PoleError", "KnobError", "StepTimeout", "FileError", "ScriptError", "UnsuitablePlant"}
    assert wanted <= {kind.__name__ for kind in kinds}
    for kind in kinds:
        before = _made(kind)
        for again in COPIES:
            after = again(before)
            assert type(after) is kind and str(after) == str(before) and repr(after) == repr(before), kind
            assert all(error_words(after)(language) == error_words(before)(language) for language in ("en", "zh")), kind


@pytest.mark.parametrize("message", MESSAGES, ids=str)
def test_every_kind_of_message_says_the_same_after_a_pickle_and_a_copy(message: Phrase | Text) -> None:
    for again in COPIES:
        after = again(message)
        assert type(after) is type(message) and str(after) == str(message) and hash(after) == hash(message)
        said = after if isinstance(after, Text) else error_words(after)
        assert said("zh") == (message if isinstance(message, Text) else error_words(message))("zh")


def test_a_phrase_keeps_what_it_is_made_of() -> None:
    after = pickle.loads(pickle.dumps(phrase("{n} states", n=3)))
    assert (after.message, dict(after.values), after) == ("{n} states", {"n": 3}, "3 states")
