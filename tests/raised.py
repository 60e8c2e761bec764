"""Every sentence that the source can raise, found in its syntax trees, with the words that may stand in each place.

A sentence is a tuple of parts: fixed text, or a `Hole` where a value goes. A hole knows the fixed words that reach it:
by calls of the function whose parameter it is, by makers of the record whose field it is, by what it is bound to.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PLAIN = frozenset({"EngineError", "ShapeError", "PoleError", "RiccatiError"})  # raised with one English sentence
MOST = 64  # forms of one sentence


@dataclass(frozen=True)
class Hole:
    """A place for a value, and the fixed words that may come there (none: numbers and names)."""

    words: frozenset[str] = frozenset()


Part = str | Hole
Sentence = tuple[Part, ...]


@dataclass(frozen=True)
class Raised:
    """One sentence and where it is made."""

    place: str
    sentence: Sentence

    @property
    def template(self) -> str:
        """The sentence with {} in each place."""
        return "".join(part if isinstance(part, str) else "{}" for part in self.sentence)


@dataclass(frozen=True)
class Scope:
    """What a name may mean at a place: the functions around it, innermost first, and the module."""

    module: ast.Module
    functions: tuple[ast.FunctionDef, ...]


def names_in(node: ast.AST) -> set[str]:
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}


def strings_in(node: ast.AST) -> frozenset[str]:
    """Fixed words that a loop runs over; over a text it runs letter by letter."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return frozenset(node.value)
    return frozenset(n.value for n in ast.walk(node) if isinstance(n, ast.Constant) and isinstance(n.value, str))


class Source:
    """The modules whose sentences are told to a person."""

    def __init__(self, paths: list[Path]) -> None:
        self.modules = {path: ast.parse(path.read_text(encoding="utf-8")) for path in paths}
        self.calls: dict[str, list[tuple[ast.Call, Scope]]] = {}
        self.fields: dict[tuple[int, str], list[str]] = {}  # of each record, those of text in `worded`
        self.worded: set[tuple[int, str]] = set()
        self.functions: dict[tuple[int, str], ast.FunctionDef] = {}
        self._known: dict[tuple[str, str], list[Sentence]] = {}  # what reaches a parameter or a field
        self.index()

    def index(self) -> None:
        """Note every call, function and record of the modules."""
        for module in self.modules.values():
            self._index(module, Scope(module, ()))

    def _index(self, node: ast.AST, scope: Scope) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.ClassDef):
                lines = [s for s in child.body if isinstance(s, ast.AnnAssign) and isinstance(s.target, ast.Name)]
                self.fields[id(scope.module), child.name] = [ast.unparse(s.target) for s in lines]
                self.worded |= {(id(scope.module), ast.unparse(s.target)) for s in lines if ast.unparse(s.annotation) == "str"}
            if isinstance(child, ast.FunctionDef):
                self.functions.setdefault((id(scope.module), child.name), child)
            if isinstance(child, ast.Call):
                func = child.func
                name = func.attr if isinstance(func, ast.Attribute) else getattr(func, "id", "")
                self.calls.setdefault(name, []).append((child, scope))
            inner = Scope(scope.module, (child, *scope.functions)) if isinstance(child, ast.FunctionDef) else scope
            self._index(child, inner)

    # --- sentences -------------------------------------------------------------------------------------------------
    def raised(self) -> Iterator[Raised]:
        """Every sentence that is given to one of the plain errors."""
        place = {module: path.relative_to(ROOT).as_posix() for path, module in self.modules.items()}
        for name in sorted(PLAIN):
            for call, scope in self.calls.get(name, ()):
                for sentence in self.forms(call.args[0], scope):
                    yield Raised(f"{place[scope.module]}:{call.lineno}", sentence)

    def forms(self, node: ast.expr, scope: Scope) -> list[Sentence]:
        """The sentences that an expression can be."""
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            return [(node.value,)]
        if isinstance(node, ast.JoinedStr):
            parts = [self.forms(part, scope) for part in node.values]
            return [sum(chosen, ()) for chosen in list(product(*parts))[:MOST]]
        if isinstance(node, ast.FormattedValue):
            return self._in_place(node.value, scope)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            return [a + b for a in self.forms(node.left, scope) for b in self.forms(node.right, scope)]
        if isinstance(node, ast.IfExp):
            return [form for branch in (node.body, node.orelse) for form in self.forms(branch, scope) if form != ("",)]
        if isinstance(node, ast.Tuple):  # (value, reason) that a function returns
            return self.forms(node.elts[-1], scope)
        return self._followed(node, scope) or [(Hole(),)]

    def _in_place(self, node: ast.expr, scope: Scope) -> list[Sentence]:
        """A value within a sentence: fixed alternatives are written out, anything else is a hole with its words."""
        if isinstance(node, ast.IfExp) and all(isinstance(b, ast.Constant) for b in (node.body, node.orelse)):
            return [(str(b.value),) for b in (node.body, node.orelse)]  # type: ignore[attr-defined]
        found = [form for form in self._followed(node, scope) if form != (Hole(),)]
        return [(Hole(frozenset(text for form in found for text in samples(form))),)]

    def _followed(self, node: ast.expr, scope: Scope) -> list[Sentence]:
        if isinstance(node, ast.Name):
            return self._named(node.id, scope)
        if isinstance(node, ast.Attribute):
            return self._field(node.attr, scope.module)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            return self._returned(node.func.id, scope.module)
        return []

    def _returned(self, name: str, module: ast.Module) -> list[Sentence]:
        """What a function of the same module returns, if that is a sentence or a word."""
        function = self.functions.get((id(module), name))
        if function is None or getattr(function.returns, "id", "") != "str":
            return []
        return [form for n in ast.walk(function) if isinstance(n, ast.Return) and n.value is not None
                for form in self.forms(n.value, Scope(module, (function,)))]

    def _named(self, name: str, scope: Scope) -> list[Sentence]:
        """What a name is bound to: by assignment, as a loop's variable, as a parameter, as a constant of the module."""
        for i, function in enumerate(scope.functions):
            outer = Scope(scope.module, scope.functions[i:])
            bound = self._bound(name, function, outer)
            if bound is not None:
                return bound
            parameters = (*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs)
            for parameter in parameters:
                if parameter.arg == name:
                    text = getattr(parameter.annotation, "id", "") == "str"
                    return self._given(function.name, [p.arg for p in parameters], name, scope.module) if text else []
        return self._bound(name, scope.module, Scope(scope.module, ())) or []

    def _bound(self, name: str, block: ast.AST, scope: Scope) -> list[Sentence] | None:
        found: list[Sentence] = []
        seen = False
        for node in ast.walk(block):
            pairs: list[tuple[ast.expr, ast.expr]] = []
            if isinstance(node, ast.Assign):
                pairs = [(target, node.value) for target in node.targets]
            for target, value in pairs:
                if isinstance(target, ast.Name) and target.id == name:
                    seen, found = True, found + self.forms(value, scope)
                elif isinstance(target, ast.Tuple) and any(getattr(t, "id", "") == name for t in target.elts):
                    last = getattr(target.elts[-1], "id", "") == name
                    seen, found = True, found + (self._followed(value, scope) if last else [])
            if isinstance(node, (ast.For, ast.comprehension)) and name in names_in(node.target):
                seen, found = True, found + [(text,) for text in strings_in(node.iter)]
        return found if seen else None

    def _given(self, function: str, names: list[str], name: str, module: ast.Module) -> list[Sentence]:
        """What is passed for a parameter, wherever the function is called."""
        home = str(id(module)) if function.startswith("_") else ""
        return self._once((f"{home}{function}()", name), (
            (call, names.index(name) - (names[0] == "self"), scope) for call, scope in self.calls.get(function, ())
            if not home or scope.module is module))

    def _field(self, field: str, module: ast.Module) -> list[Sentence]:
        """What the makers of a record of this module put into one of its fields, if that is text; `reason` of any."""
        records = [(maker, fields) for (home, maker), fields in self.fields.items()
                   if field in fields and (home, field) in self.worded and (home == id(module) or field == "reason")]
        return self._once((str(id(module)), field), (
            (call, fields.index(field), scope) for maker, fields in records for call, scope in self.calls.get(maker, ())))

    def _once(self, key: tuple[str, str], given: Iterable[tuple[ast.Call, int, Scope]]) -> list[Sentence]:
        """The arguments of some calls, looked up once; a function that calls itself adds nothing."""
        if key not in self._known:
            self._known[key] = []
            found = {form for call, place, scope in given for form in self._argument(call, place, key[1], scope)}
            self._known[key] = sorted(found, key=str)
        return self._known[key]

    def _argument(self, call: ast.Call, place: int, name: str, scope: Scope) -> list[Sentence]:
        given = [k.value for k in call.keywords if k.arg == name] or call.args[place:place + 1]
        return [form for value in given if not isinstance(value, ast.Starred)
                for form in self.forms(value, scope) if form != (Hole(),) and form != ("",)]


def samples(sentence: Sentence, start: int = 0) -> list[str]:
    """The sentence with its words in each place, and numbers that tell the other places apart."""
    numbers = iter(range(211 + start, 9999, 12))
    choices = [[part] if isinstance(part, str) else sorted(part.words) or [str(next(numbers))] for part in sentence]
    widest = max((len(c) for c in choices), default=1)
    return sorted({"".join(c[i % len(c)] for c in choices) for i in range(widest)})


@lru_cache(maxsize=1)
def source() -> Source:
    """Engine, plants, lessons and the tab; not the command line, which is in English."""
    folders = [p for folder in ("app/engine", "app/plants", "lessons") for p in (ROOT / folder).rglob("*.py")]
    return Source(sorted([*folders, *(ROOT / "app").glob("*.py")]))
