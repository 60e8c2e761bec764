"""Reading Python without running it: what a module imports, what is private, what is mutable and global."""

from __future__ import annotations

import ast
import gc
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = MappingProxyType({"app": ("observer_lab",), "lessons": ("observer_lab", "lessons")})  # folder → what it is installed as
DISPLAYS = (ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp)
MUTABLE_MAKERS = {"list", "dict", "set", "bytearray", "defaultdict", "OrderedDict", "Counter", "deque"}


@cache
def parsed(source: str) -> ast.Module:
    """The syntax tree of a source."""
    return ast.parse(source)


@cache
def nodes(source: str) -> tuple[ast.AST, ...]:
    """Every node of it, for all rules that walk through it; a million of them stay, and are not looked through for garbage."""
    gc.disable()
    found = tuple(ast.walk(parsed(source)))
    gc.freeze()
    gc.enable()
    return found


@dataclass(frozen=True)
class Module:
    """A file of Python as the rules see it."""

    path: Path
    name: str
    source: str

    @property
    def tree(self) -> ast.Module:
        return parsed(self.source)

    @property
    def nodes(self) -> tuple[ast.AST, ...]:
        return nodes(self.source)

    @property
    def package(self) -> bool:
        return self.path.name == "__init__.py"

    def imports(self) -> list[str]:
        return list(_imported(self))


@cache
def _imported(module: Module) -> tuple[str, ...]:
    return tuple(imports(module.tree, module.name, module.package))


def name_of(path: Path) -> str:
    """The name by which a module below ROOT is imported; a package is named without `__init__`."""
    folder, *inner = path.relative_to(ROOT).with_suffix("").parts
    parts = [*PACKAGES.get(folder, (folder,)), *inner]
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


def arrows(modules: Iterable[Module]) -> dict[str, set[str]]:
    """Which of the modules each of them imports; what is imported from a package counts as the package."""
    by_name = {m.name: m for m in modules}

    def owner(name: str) -> str:
        while name and name not in by_name:
            name = name.rpartition(".")[0]
        return name
    return {name: {owner(n) for n in m.imports()} - {"", name} for name, m in by_name.items()}


def circles(graph: Mapping[str, Iterable[str]]) -> list[list[str]]:
    """The groups of names that all reach each other along the arrows."""
    names = sorted(graph)
    place = {name: i for i, name in enumerate(names)}
    ends = np.array([(place[a], place[b]) for a in names for b in graph[a]], dtype=int).reshape(-1, 2)
    steps = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(len(names), len(names)))
    count, group = connected_components(steps.tocsr(), connection="strong")
    members = ([name for name, own in zip(names, group, strict=True) if own == k] for k in range(count))
    return sorted(circle for circle in members if len(circle) > 1)


def private_uses(source: str) -> list[str]:
    """Private names of other objects: x._y for any x but self and cls, imports of a._b, getattr(x, "_y")."""
    out = []
    for node in nodes(source):
        if isinstance(node, ast.Attribute) and _private(node.attr):
            out += [] if _own(node.value) else [f"line {node.lineno}: .{node.attr}"]
        elif isinstance(node, ast.ImportFrom):
            names = [*(node.module or "").split("."), *(a.name for a in node.names)]
            out += [f"line {node.lineno}: {n}" for n in names if _private(n)] if _of_viser(node) else []
        elif isinstance(node, ast.Import):
            out += [f"line {node.lineno}: {a.name}" for a in node.names if any(map(_private, a.name.split(".")))]
        elif isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("getattr", "setattr", "hasattr",
                                                                             "delattr"):
            out += [f"line {node.lineno}: {a.value}" for a in node.args[1:2]
                    if isinstance(a, ast.Constant) and _private(str(a.value)) and not _own(node.args[0])]
    return out


def _private(name: str) -> bool:
    return name.startswith("_") and not (name.startswith("__") and name.endswith("__"))


def _own(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) and node.id in ("self", "cls")


def _of_viser(node: ast.ImportFrom) -> bool:
    return node.level == 0 and within(node.module or "", "viser")


def replaced_names(source: str) -> list[str]:
    """What a module replaces in others while it runs: stand-ins of a test library, fields of imported names, classes of objects.

    Python's own modules have hooks that are made to be set, as `sys.stdout` is.
    """
    known, out = set[str](), []
    for node in nodes(source):
        if isinstance(node, ast.Import | ast.ImportFrom):
            ours = [(a, a.name if isinstance(node, ast.Import) else node.module or "") for a in node.names]
            known |= {(a.asname or a.name).partition(".")[0] for a, home in ours if home.partition(".")[0] not in sys.stdlib_module_names}
            named = [a.name for a in node.names] if isinstance(node, ast.Import) else [f"{node.module}.{a.name}" for a in node.names]
            out += [f"line {node.lineno}: {name}" for name in named if within(name, "unittest.mock")]
    for node in nodes(source):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store | ast.Del):
            root: ast.expr = node
            while isinstance(root, ast.Attribute):
                root = root.value
            if (isinstance(root, ast.Name) and root.id in known) or node.attr == "__class__":
                out.append(f"line {node.lineno}: {ast.unparse(node)}")
        elif isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("setattr", "delattr"):
            first = node.args[0]
            out += [f"line {node.lineno}: {first.id}"] if isinstance(first, ast.Name) and first.id in known else []
    return out


def mutable_globals(source: str) -> list[str]:
    """Module-level names bound to a list, dict or set; `__all__` is read by Python itself and stays a list."""
    out = []
    for node in module_level(parsed(source)):
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
