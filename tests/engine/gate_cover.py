"""Whether a gated function refuses once more what its gate refuses.

Every condition of an `if … raise` that can be read from the arguments alone is evaluated for right calls with one argument of nonsense, as
the gates give it or, where they refuse it, as it came. A part of a condition that holds for refused arguments and never for
accepted ones is one that the gate covers. Nothing of the function runs but its plain assignments.

    python tests/engine/gate_cover.py [part of a name]
"""

from __future__ import annotations

import ast
import inspect
import sys
import textwrap
import warnings
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

if __name__ == "__main__":
    here = Path(__file__).resolve()
    sys.path[:0] = [str(here.parents[2]), str(here.parents[1]), str(here.parent)]

from nonsense import NEVER, kinds
from public_calls import calls, the_call

PLAIN = frozenset({  # calls that make or compare without work
    "np.asarray", "np.atleast_1d", "np.atleast_2d", "np.array", "np.isfinite", "np.isnan", "np.all", "np.any", "np.abs", "np.ndim",
    "np.diag", "len", "int", "float", "list", "tuple", "set", "abs", "all", "any", "max", "min", "isinstance",
    "as_checked", "as_matrix", "as_numbers", "as_covariance", "np.zeros", "np.eye"})
METHODS = frozenset({"all", "any", "max", "min", "reshape", "astype", "ravel"})
MORE = (1, 2, 3, 5, 7, 0.3, 2.5, 40.0, 400, -0.5, 10**5)  # numbers beside the nonsense
PAIRS = ((0, 0), (1, 1), (0, 5), (5, 0), (-1, 0))
TIED = frozenset({"n", "m", "p"})  # fields of a plant that its gate looks at; of other records a gate sees the kind alone
UNKNOWN = object()
Values = dict[str, Any]


def bare(call: Any) -> Any:
    """The function behind the gates of a public one or of a method, None where there are none."""
    call = getattr(call, "__func__", call)
    if "taken" not in vars(call):
        return None
    while hasattr(call, "__wrapped__"):
        call = call.__wrapped__
    return call


def sets_of_arguments(function: Any, gates: Any, right: Values) -> Iterator[tuple[bool, Values]]:
    """Arguments as the function would get them, and whether the gates let them pass, for each argument of nonsense."""
    given = {name: value for name, value in right.items() if name != "self"}
    yield from _through(function, gates, given)
    lengths = {size for value in given.values() if isinstance(value, np.ndarray) for size in value.shape}
    for size in lengths:  # no states, no runs: an axis that several arguments share
        yield from _through(function, gates, {name: _without(value, size) for name, value in given.items()})
    for name in given:
        probes = [value for kind, _, value in kinds(given[name]) if (kind not in NEVER or kind == "NaN") and "sparse" not in kind]
        for nonsense in probes + list(_more(given[name])):
            yield from _through(function, gates, {**given, name: nonsense})


def _more(right: object) -> tuple[object, ...]:
    """Other values of the kind of a right one."""
    if isinstance(right, np.ndarray):
        return tuple(np.take(right, [], axis) for axis in range(right.ndim))
    return PAIRS if isinstance(right, tuple) and len(right) == 2 else MORE if isinstance(right, int | float) else ()


def _without(value: object, size: int) -> object:
    if not isinstance(value, np.ndarray) or size not in value.shape:
        return value
    return np.zeros([0 if length == size else length for length in value.shape])


def looks_inside(part: ast.expr, right: Values) -> bool:
    """Whether a condition reads a field of a record that no gate looks at."""
    return any(isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and is_dataclass(right.get(node.value.id))
               and node.attr not in TIED for node in ast.walk(part))


def _through(function: Any, gates: Any, given: Values) -> Iterator[tuple[bool, Values]]:
    sizes: dict[str, int] = {}
    out = dict(given)
    defaults = {name: parameter.default for name, parameter in inspect.signature(function).parameters.items()}
    try:
        for name in defaults:
            if name in gates and name in out and out[name] is not defaults[name]:
                out[name] = gates[name](out[name], name, sizes)
    except Exception:
        yield False, given
        return
    yield True, out


def readable(node: ast.AST) -> bool:
    """Whether an expression can be evaluated without work."""
    for part in ast.walk(node):
        if isinstance(part, ast.Call) and ast.unparse(part.func) not in PLAIN and not (
                isinstance(part.func, ast.Attribute) and part.func.attr in METHODS):
            return False
        if isinstance(part, ast.BinOp) and isinstance(part.op, ast.Pow | ast.Mult):
            return False
    return True


def parts_of(test: ast.expr) -> list[ast.expr]:
    """The alternatives of a condition: `a or b`, `not (a and b)`, `not a < b < c`."""
    match test:
        case ast.BoolOp(op=ast.Or()):
            return [part for value in test.values for part in parts_of(value)]
        case ast.UnaryOp(op=ast.Not(), operand=ast.BoolOp(op=ast.And()) as inner):
            return [part for value in inner.values for part in parts_of(ast.UnaryOp(ast.Not(), value))]
        case ast.UnaryOp(op=ast.Not(), operand=ast.Compare() as inner) if len(inner.ops) > 1:
            ends = [inner.left, *inner.comparators]
            return [ast.UnaryOp(ast.Not(), ast.Compare(a, [op], [b])) for a, op, b in zip(ends, inner.ops, ends[1:], strict=False)]
    return [test]


def judged(function: Any) -> list[tuple[list[ast.stmt], ast.expr]]:
    """The assignments before each refusal of a function, and a part of its condition."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    assert isinstance(tree, ast.FunctionDef)
    out: list[tuple[list[ast.stmt], ast.expr]] = []
    before: list[ast.stmt] = []
    for statement in tree.body:
        if isinstance(statement, ast.If) and any(isinstance(inner, ast.Raise) for inner in statement.body):
            out += [(list(before), part) for part in parts_of(statement.test)]
        before.append(statement)
    return out


def evaluated(function: Any, before: list[ast.stmt], part: ast.expr, values: Values) -> object:
    """What a part of a condition is for these arguments; UNKNOWN where it cannot be read from them."""
    names = {name: parameter.default for name, parameter in inspect.signature(function).parameters.items()} | values
    unknown: set[str] = set()

    def run(node: ast.AST) -> object:
        if not readable(node) or {n.id for n in ast.walk(node) if isinstance(n, ast.Name)} & unknown:
            return UNKNOWN
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                expression = ast.fix_missing_locations(ast.Expression(node))  # type: ignore[arg-type]
                return eval(compile(expression, "condition", "eval"), {**function.__globals__, **names})
        except Exception:
            return UNKNOWN
    for statement in before:
        if isinstance(statement, ast.Assign) and len(statement.targets) == 1:
            targets, value = statement.targets[0], statement.value
            pairs = (list(zip(targets.elts, value.elts, strict=True)) if isinstance(targets, ast.Tuple) and isinstance(value, ast.Tuple)
                     and len(targets.elts) == len(value.elts) else [(targets, value)])
            for target, right in pairs:
                found = run(right)
                if found is UNKNOWN or not isinstance(target, ast.Name):
                    unknown |= {n.id for n in ast.walk(target) if isinstance(n, ast.Name)}
                else:
                    names[target.id] = found
                    unknown.discard(target.id)
        else:
            unknown |= {n.id for n in ast.walk(statement) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    return run(part)


def covered(function: Any, gates: Any, right: Values) -> Iterator[str]:
    """The parts of its refusals that the gates of a function have judged already."""
    conditions = judged(function)
    if not conditions:
        return
    sets = list(sets_of_arguments(function, gates, right))
    for before, part in conditions:
        if looks_inside(part, right):
            continue
        seen: dict[bool, list[object]] = {True: [], False: []}
        for passed, values in sets:
            found = evaluated(function, before, part, values)
            if found is not UNKNOWN:
                with suppress(ValueError):  # an array of several answers
                    seen[passed].append(bool(found))
        if seen[True] and not any(seen[True]) and any(seen[False]):
            yield ast.unparse(part)


def findings(rooms: tuple[str, ...] = ("",)) -> Iterator[str]:
    """Each gated public function and method with what it judges twice."""
    for name in calls():
        call = the_call(name) if name.startswith(rooms) else None
        function = None if call is None or isinstance(call, type) else bare(call)
        if function is not None:
            gates = vars(getattr(call, "__func__", call))["taken"].gates
            yield from (f"{name}: if {part}" for part in covered(function, gates, calls()[name]))


if __name__ == "__main__":
    print("\n".join(findings(tuple(sys.argv[1:]) or ("",))) or "each gate judges once")
