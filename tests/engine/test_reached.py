"""Nothing in the engine is dead: the app reaches a name, another that is reached needs it, or its example promises it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator

from syntax import ROOT, Module, name_of

Defined = dict[str, list[ast.stmt]]  # name → where the engine defines it; one name may stand in two modules
EXAMPLE, SPOKEN = re.compile(r"^ *(?:>>>|\.\.\.) .*$", re.M), re.compile(r"[A-Za-z_]\w*")


def modules(*folders: str) -> list[Module]:
    """All Python below the folders."""
    paths = sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))
    return [Module(path, name_of(path), path.read_text(encoding="utf-8")) for path in paths]


def used(node: ast.AST) -> set[str]:
    """Every name that a piece of source speaks of: its own, of attributes, in quotes, imported, and in its examples."""
    out: set[str] = set()
    for part in ast.walk(node):
        if isinstance(part, ast.Name):
            out.add(part.id)
        elif isinstance(part, ast.Attribute):
            out.add(part.attr)
        elif isinstance(part, ast.ImportFrom):
            out |= {alias.name for alias in part.names}
        elif isinstance(part, ast.Constant) and isinstance(part.value, str):
            out |= {part.value} if part.value.isidentifier() else set(SPOKEN.findall("".join(EXAMPLE.findall(part.value))))
    return out


def targets(statement: ast.stmt) -> Iterator[str]:
    """The names that a statement at the top of a module defines."""
    if isinstance(statement, (ast.FunctionDef, ast.ClassDef)):
        yield statement.name
    elif isinstance(statement, (ast.Assign, ast.AnnAssign)):
        for target in statement.targets if isinstance(statement, ast.Assign) else [statement.target]:
            yield from (name.id for name in ast.walk(target) if isinstance(name, ast.Name))


def defined(engine: Iterable[Module]) -> Defined:
    """What the modules of the engine define at their top, by name."""
    out: Defined = {}
    for module in engine:
        for statement in module.tree.body:
            for name in targets(statement):
                if name != "__all__":
                    out.setdefault(name, []).append(statement)
    return out


def promised(node: ast.AST) -> bool:
    """Whether a function or class has an example that a test may run."""
    return isinstance(node, (ast.FunctionDef, ast.ClassDef)) and ">>>" in (ast.get_docstring(node) or "")


def reached(definitions: Defined, roots: set[str]) -> set[str]:
    """The names that the roots need, and what these need in turn."""
    found: set[str] = set()
    waiting = [name for name in definitions if name in roots]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += [other for node in definitions[name] for other in used(node) if other in definitions]
    return found


def idle(engine: list[Module], others: list[Module]) -> list[str]:
    """Names that nothing reaches: of functions, classes and tables at the top, and of public methods of classes."""
    definitions = defined(engine)
    run = [node for module in engine for node in module.tree.body if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)]
    roots = {name for name, nodes in definitions.items() if any(map(promised, nodes)) or name.startswith("__")}.union(
        *(used(m.tree) for m in others),
        *map(used, run))
    alive = reached(definitions, roots)
    spoken = roots.union(*(used(node) for name in alive for node in definitions[name]))
    methods = [(f"{name}.{part.name}", part) for name in alive for node in definitions[name] if isinstance(node, ast.ClassDef)
               for part in node.body if isinstance(part, ast.FunctionDef) and not part.name.startswith("__")]
    return sorted({name for name in definitions if name not in alive}
                  | {name for name, part in methods if part.name not in spoken and not promised(part)})


def test_every_name_of_the_engine_is_reached_from_the_app_or_promised_by_an_example() -> None:
    """Remove what nobody needs, or give it an example: then it is a promise of the library."""
    others = [module for module in modules("app", "lessons") if not module.name.startswith("observer_lab.engine")]
    assert idle(modules("app/engine"), others) == []


def test_the_rule_sees_what_is_dead_and_lets_pass_what_is_promised() -> None:
    source = ('TABLE = (1,)\ndef a():\n    return b() + TABLE[0]\ndef b(): ...\ndef c(): return d()\ndef d(): ...\n'
              'def e():\n    """Sum.\n\n    >>> e()\n    """\nclass F:\n    def g(self): ...\n    def h(self): ...\n')
    others = [Module(ROOT / "y.py", "y", "from x import a, F\na(F().g)")]
    assert idle([Module(ROOT / "x.py", "x", source)], others) == ["F.h", "c", "d"]
