"""What `app.engine` promises: about sixty names, each with an example that runs, options by name, rooms for the rest."""

import ast
import doctest
import inspect
from pathlib import Path

import numpy as np
import pytest

import app.engine as engine

ROOT = Path(__file__).resolve().parents[2]
NAMES = {"np": np, **{name: getattr(engine, name) for name in engine.__all__}}


def test_the_flat_names_are_about_sixty():
    assert 55 <= len(engine.__all__) <= 70


@pytest.mark.parametrize("name", engine.__all__)
def test_every_name_has_an_example_of_at_most_five_lines_that_runs(name):
    (example,) = [t for t in doctest.DocTestFinder(recurse=False).find(NAMES[name], name, globs=dict(NAMES))]
    typed = sum(item.source.count("\n") for item in example.examples)
    assert 1 <= typed <= 5
    said: list[str] = []
    result = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=said.append)
    assert result.attempted == len(example.examples) and not result.failed, "".join(said)


@pytest.mark.parametrize("name", [n for n in engine.__all__ if inspect.isfunction(NAMES[n])])
def test_an_argument_with_a_default_is_given_by_name(name):
    early = [p.name for p in inspect.signature(NAMES[name]).parameters.values()
             if p.default is not p.empty and p.kind is not p.KEYWORD_ONLY]
    assert not early


def test_outside_the_engine_names_come_from_the_flat_list_or_from_a_room():
    """`from app.engine.filters import Track`, never `from app.engine.filters.track import Track`."""
    deep = []
    for path in [*(ROOT / "app").rglob("*.py"), *(ROOT / "lessons").rglob("*.py")]:
        if (ROOT / "app" / "engine") in path.parents:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                after = (node.module or "").split("engine", 1)
                if len(after) == 2 and after[0] in ("", "app.") and after[1].count(".") > 1:
                    deep.append(f"{path.relative_to(ROOT)}:{node.lineno} {node.module}")
    assert not deep, deep
