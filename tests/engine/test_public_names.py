"""What `observer_lab.engine` promises: about seventy-five names, each with an example that runs, options by name, rooms for the rest."""

import ast
import doctest
import importlib
import inspect
import pkgutil
from pathlib import Path

import numpy as np
import pytest
from syntax import nodes

import observer_lab.engine as engine

ROOT = Path(__file__).resolve().parents[2]
NAMES = {"np": np, **{name: getattr(engine, name) for name in engine.__all__}}
ROOMS = sorted(found.name for found in pkgutil.walk_packages(engine.__path__, "observer_lab.engine.") if not found.ispkg)


def test_the_flat_names_are_about_seventy_five():
    assert 65 <= len(set(engine.__all__) - set(engine.aliases.__all__)) <= 80


def test_every_flat_name_has_an_example():
    assert [name for name in engine.__all__ if ">>>" not in (inspect.getdoc(NAMES[name]) or "")] == []


@pytest.mark.parametrize("name", [n for n in ROOMS if ">>>" in inspect.getsource(importlib.import_module(n))])
def test_every_example_of_a_module_has_at_most_five_lines_and_runs(name):
    module, room = importlib.import_module(name), importlib.import_module(name.rpartition(".")[0])  # examples call through the gates
    for example in doctest.DocTestFinder(exclude_empty=True).find(module, globs={**vars(module), **vars(room), **NAMES}):
        typed, said = sum(item.source.count("\n") for item in example.examples), list[str]()
        result = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=said.append)
        assert typed <= 5 and result.attempted == len(example.examples) and not result.failed, f"{example.name}: {typed}" + "".join(said)


OPERANDS = {"u", "N", "B", "C", "D", "T", "rows", "y"}  # matrices and records that stand in an equation are no options


def test_an_option_is_given_by_name_in_all_rooms():
    """Of functions and of methods alike."""
    early = []
    rooms = (importlib.import_module(f"observer_lab.engine.{found.name}") for found in pkgutil.iter_modules(engine.__path__))
    for room in (engine, *rooms):
        for name in getattr(room, "__all__", ()):
            thing = getattr(room, name)
            inside = [(f"{name}.{k}", getattr(v, "__func__", v)) for k, v in vars(thing).items()] if inspect.isclass(thing) else []
            for what, call in [(name, thing), *inside]:
                if getattr(call, "__module__", "").startswith("observer_lab.engine.aliases"):  # these have python-control's order
                    continue
                if inspect.isfunction(call) and not what.rpartition(".")[2].startswith("_"):
                    early += [f"{room.__name__}.{what}({p.name})" for p in inspect.signature(call).parameters.values()
                              if p.default is not p.empty and p.kind is not p.KEYWORD_ONLY and p.name not in OPERANDS]
    assert sorted(set(early)) == []


def test_outside_the_engine_names_come_from_the_flat_list_or_from_a_room():
    """`from observer_lab.engine.filters import Track`, never `from observer_lab.engine.filters.track import Track`."""
    deep = []
    for path in [*(ROOT / "app").rglob("*.py"), *(ROOT / "lessons").rglob("*.py")]:
        if (ROOT / "app" / "engine") in path.parents:
            continue
        for node in nodes(path.read_text(encoding="utf-8")):
            if isinstance(node, ast.ImportFrom):
                after = (node.module or "").split("engine", 1)
                if len(after) == 2 and after[0] in ("", "app.") and after[1].count(".") > 1:
                    deep.append(f"{path.relative_to(ROOT)}:{node.lineno} {node.module}")
    assert not deep, deep
