"""The house keeps its promises: who may import whom, what is private stays private, nothing mutable is global."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = {"app", "lessons", "tests", "assets", ".ci"}
WORDS = ("app.text", "app.sentences")
LOWER = ("app.engine", *WORDS, "app.plants")
ALL = (*LOWER, "app.lesson", "app.tab", "app.export", "app.published", "app.view", "lessons")
# Layer → the layers it may import. A module belongs to the longest prefix of its name that is listed here.
MAY_IMPORT = {
    "app": (),
    "app.engine": ("app.engine",),
    "app.engine.systems": (),
    "app.engine.structure": ("app.engine.systems",),
    "app.engine.design": ("app.engine.structure", "app.engine.systems"),
    "app.engine.feedback": ("app.engine.design", "app.engine.systems"),
    "app.engine.simulation": ("app.engine.systems",),
    "app.engine.network": ("app.engine.systems",),
    "app.engine.filters": ("app.engine.design", "app.engine.simulation", "app.engine.systems"),
    "app.engine.observers": ("app.engine.filters", "app.engine.design", "app.engine.structure", "app.engine.systems"),
    "app.engine.sampled": ("app.engine.filters", "app.engine.feedback", "app.engine.design", "app.engine.systems"),
    "app.text": (),
    "app.sentences": ("app.text",),
    "app.plants": ("app.engine", *WORDS),
    "app.lesson": LOWER,
    "app.tab": (*LOWER, "app.lesson"),
    "app.export": ("app.engine", "app.text", "app.lesson"),
    "app.published": LOWER,
    "app.view": (*LOWER, "app.lesson", "app.tab", "app.export", "lessons"),
    "app.cli": ALL,
    "lessons": (*LOWER, "app.lesson"),
}
ENGINE_LIBRARIES = {"numpy", "scipy", "control"}
DISPLAYS = (ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp)
MUTABLE_MAKERS = {"list", "dict", "set", "bytearray", "defaultdict", "OrderedDict", "Counter", "deque"}


# --- reading -------------------------------------------------------------------------------------------------------
def name_of(path: Path) -> str:
    """The dotted name of a module below ROOT; a package is named without `__init__`."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(tree: ast.AST, module: str, package: bool) -> Iterator[str]:
    """Every module that a syntax tree imports, in full, also inside functions and behind TYPE_CHECKING.

    `from x import y` gives x.y: y may be a module.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = module.split(".")
                parts = parts[: len(parts) - node.level + (1 if package else 0)]
                base = ".".join([*parts, *([base] if base else [])])
            yield from (f"{base}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if called in ("import_module", "__import__"):
                yield str(node.args[0].value)


def within(name: str, prefix: str) -> bool:
    return name == prefix or name.startswith(prefix + ".")


def layer_of(name: str) -> str | None:
    """The layer of a module, None if it is not ours."""
    return max((layer for layer in MAY_IMPORT if within(name, layer)), key=len, default=None)


def forbidden_imports(source: str, module: str, package: bool = False) -> list[str]:
    """Imports of ours that the rule does not allow to `module`."""
    layer = layer_of(module)
    assert layer is not None, f"{module} belongs to no layer: add it to the rule"
    out = []
    for name in imports(ast.parse(source), module, package):
        target = layer_of(name)
        if target is None:
            continue
        if target == layer:
            if layer == "lessons" and not lesson_may(module, name):
                out.append(name)
        elif not any(within(target, allowed) for allowed in MAY_IMPORT[layer]):
            out.append(name)
    return out


def lesson_may(module: str, name: str) -> bool:
    """A lesson knows itself and the toolkit; only the table of contents knows the lessons."""
    own = ".".join(module.split(".")[:2])
    return module == "lessons" or within(name, own) or within(name, "lessons.toolkit")


def private_uses(source: str) -> list[str]:
    """Private names of other objects: x._y for any x but self and cls, imports of a._b, getattr(x, "_y")."""
    out = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute) and _private(node.attr):
            out += [] if _own(node.value) else [f"line {node.lineno}: .{node.attr}"]
        elif isinstance(node, ast.ImportFrom):
            names = [*(node.module or "").split("."), *(a.name for a in node.names)]
            out += [f"line {node.lineno}: {n}" for n in names if _private(n)] if _of_viser(node) else []
        elif isinstance(node, ast.Import):
            out += [f"line {node.lineno}: {a.name}" for a in node.names if any(map(_private, a.name.split(".")))]
        elif isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("getattr", "setattr", "hasattr", "delattr"):
            out += [f"line {node.lineno}: {a.value}" for a in node.args[1:2]
                    if isinstance(a, ast.Constant) and _private(str(a.value)) and not _own(node.args[0])]
    return out


def _private(name: str) -> bool:
    return name.startswith("_") and not (name.startswith("__") and name.endswith("__"))


def _own(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) and node.id in ("self", "cls")


def _of_viser(node: ast.ImportFrom) -> bool:
    return node.level == 0 and within(node.module or "", "viser")


def mutable_globals(source: str) -> list[str]:
    """Module-level names bound to a list, dict or set; `__all__` is read by Python itself and stays a list."""
    out = []
    for node in module_level(ast.parse(source)):
        if isinstance(node, ast.Assign):
            names, value = [ast.unparse(t) for t in node.targets], node.value
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            names, value = [ast.unparse(node.target)], node.value
        else:
            continue
        out += [f"line {node.lineno}: {n}" for n in names if n != "__all__" and _mutable(value)]
    return out


def module_level(tree: ast.Module) -> Iterator[ast.stmt]:
    """The statements that run at import, those inside if, try, with and for too."""
    todo: list[ast.stmt] = list(tree.body)
    while todo:
        node = todo.pop()
        yield node
        if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            todo += [child for child in ast.iter_child_nodes(node) if isinstance(child, ast.stmt)]
            todo += [s for h in getattr(node, "handlers", ()) for s in h.body]


def _mutable(value: ast.expr) -> bool:
    if isinstance(value, ast.Tuple):
        return any(_mutable(item) for item in value.elts)
    if isinstance(value, ast.Call):
        maker = value.func.attr if isinstance(value.func, ast.Attribute) else getattr(value.func, "id", "")
        return maker in MUTABLE_MAKERS
    return isinstance(value, DISPLAYS)


def tracked() -> list[Path]:
    """The files that git carries and that are there."""
    names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True).stdout.decode().split("\0")
    return [ROOT / name for name in names if name and (ROOT / name).is_file()]


OURS = sorted(p for folder in ("app", "lessons") for p in (ROOT / folder).rglob("*.py"))
ALL_PYTHON = sorted([*OURS, *(ROOT / "tests").rglob("*.py")])


def modules(paths: list[Path]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("path", paths, ids=[str(p.relative_to(ROOT)) for p in paths])


# --- the rules -----------------------------------------------------------------------------------------------------
@modules(OURS)
def test_imports_run_one_way_through_the_house(path: Path) -> None:
    wrong = forbidden_imports(path.read_text(encoding="utf-8"), name_of(path), path.name == "__init__.py")
    assert not wrong, f"{name_of(path)} may not import {wrong}"


@modules([p for p in OURS if within(name_of(p), "app.engine")])
def test_the_engine_stands_on_numpy_scipy_and_control_alone(path: Path) -> None:
    allowed = ENGINE_LIBRARIES | set(sys.stdlib_module_names)
    foreign = {name.split(".")[0] for name in imports(ast.parse(path.read_text(encoding="utf-8")), name_of(path),
                                                      path.name == "__init__.py")} - allowed - {"app"}
    assert not foreign


@modules(OURS)
def test_viser_is_imported_by_the_view_alone_and_matplotlib_by_the_export_alone(path: Path) -> None:
    names = list(imports(ast.parse(path.read_text(encoding="utf-8")), name_of(path), path.name == "__init__.py"))
    if not within(name_of(path), "app.view"):
        assert not [n for n in names if within(n, "viser")]
    if not within(name_of(path), "app.export"):
        assert not [n for n in names if within(n, "matplotlib")]


@modules([p for p in OURS if within(name_of(p), "app.view") and name_of(p) != "app.view.quirks"])
def test_private_names_of_viser_are_touched_in_quirks_alone(path: Path) -> None:
    assert not private_uses(path.read_text(encoding="utf-8"))


@modules(ALL_PYTHON)
def test_no_star_imports(path: Path) -> None:
    stars = [node.lineno for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
             if isinstance(node, ast.ImportFrom) and any(a.name == "*" for a in node.names)]
    assert not stars


@modules(OURS)
def test_no_mutable_globals(path: Path) -> None:
    """Wrap a table in MappingProxyType, a sequence in a tuple, a set in a frozenset."""
    source = path.read_text(encoding="utf-8")
    assert not mutable_globals(source)
    assert not [n.lineno for n in ast.walk(ast.parse(source)) if isinstance(n, ast.Global)]


def test_top_level_folders_are_those_agreed_and_no_others() -> None:
    there = {p.relative_to(ROOT).parts[0] for p in tracked() if len(p.relative_to(ROOT).parts) > 1}
    assert there == FOLDERS


MACHINE = re.compile(r"(?<![\w.}])/" + "(?:" + "|".join(["root", "work", "home", "Users", "tmp" + "/bash"]) + r")/\w"
                     + r"|\b[A-Z]:\\\\?" + "Users")


def test_no_tracked_file_names_a_path_of_some_machine() -> None:
    found = []
    for path in tracked():
        for number, line in enumerate(path.read_bytes().decode("utf-8", "ignore").splitlines(), 1):
            if MACHINE.search(line):
                found.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}")
    assert not found, found


# --- the rules catch what they are for -----------------------------------------------------------------------------
@pytest.mark.parametrize("module, source", [
    ("app.engine.systems.plant", "from ...text.words import Text"),
    ("app.engine.systems.plant", "import app.plants"),
    ("app.engine.systems.plant", "from ..design.optimal import lqr"),
    ("app.text.words", "from ..engine import Plant"),
    ("app.plants.chip", "from ..lesson.figures import Curve"),
    ("app.lesson.figures", "from ..tab.state import write_tab"),
    ("app.tab.session", "def f():\n    from ..view.screen import Screen"),
    ("app.export.image", "from ..tab.session import Session"),
    ("app.tab.session", "from lessons import LESSONS"),
    ("lessons.duality.lesson", "from ..separation.lesson import MODEL"),
    ("lessons.duality.lesson", "from app.tab.session import Session"),
    ("lessons.toolkit", "from .separation import lesson"),
    ("app.lesson.figures", "import importlib\nimportlib.import_module('app.tab.session')"),
])
def test_the_import_rule_sees_a_breach(module: str, source: str) -> None:
    assert forbidden_imports(source, module)


@pytest.mark.parametrize("module, source", [
    ("app.engine.systems.plant", "from .errors import EngineError\nimport numpy as np"),
    ("app.plants.chip", "from ..engine import Plant\nfrom ..text.words import Text"),
    ("lessons.duality.lesson", "from ..toolkit import gains\nfrom . import proofs\nfrom app.engine import place"),
    ("app.view.server", "from ..tab.session import Session\nfrom . import quirks"),
    ("app.cli", "from lessons import LESSONS\nfrom app.view.server import LabServer"),
])
def test_the_import_rule_lets_good_imports_pass(module: str, source: str) -> None:
    assert not forbidden_imports(source, module)


@pytest.mark.parametrize("source", [
    "client._websock_connection", "self._server._websock_server", "from viser import _messages",
    "import viser._messages as m", "from viser._messages import GuiUpdateMessage", "getattr(handle, '_impl')",
])
def test_the_privacy_rule_sees_a_breach(source: str) -> None:
    assert private_uses(source)
    assert not private_uses("class A:\n    def f(self):\n        return self._server.__class__, hasattr(self, '_live')")


@pytest.mark.parametrize("source", [
    "A = {}", "A: dict = {'a': 1}", "a = [1]", "A = {1, 2}", "A = dict(a=1)", "A = [x for x in b]",
    "if b:\n    A = []", "try:\n    pass\nexcept Exception:\n    A = {}", "A = ({}, 1)", "A = collections.deque()",
])
def test_the_rule_on_globals_sees_a_breach(source: str) -> None:
    assert mutable_globals(source)
    assert not mutable_globals("__all__ = ['a']\nA = MappingProxyType({'a': 1})\nB = (1, 2)\n"
                               "C = frozenset({1})\ndef f():\n    x = []\nclass D:\n    y = {}")


def test_the_path_rule_sees_a_breach() -> None:
    assert MACHINE.search("open('" + "/".join(["", "home", "someone", "x.txt"]) + "')")
    assert MACHINE.search("/".join(["", "root", "x"]))
    assert not MACHINE.search("https://example.org/home/page and f'{root}/glass'")
