"""Write a routine as structured text for a programmable controller: one function block."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence

from ...devices import DeviceDesign, DeviceError, Routine, Table
from ...devices.language import locals_of
from ...text import text
from .words import readme_text, template

__all__ = ["function_block", "structured_text_folder"]

OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}.items()
COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "=", ast.NotEq: "<>"}.items()
NO_FUNCTIONS = text("This filter calls functions of its own, which the function block does not hold; take C or MicroPython.")
ST_USE = ("add FB_Lab to the project and call it once each period; set y, read u. No compiler of a controller has checked it: "
          "the lab's own interpreter of this subset gives the same bits as its Python.")


def structured_text_folder(design: DeviceDesign, source: str, single: bool = False) -> Mapping[str, str]:
    """FB_Lab.st and its README."""
    return {"FB_Lab.st": function_block(design.routine, single), "README.md": readme_text(design, source, single, ST_USE)}


def function_block(routine: Routine, single: bool = False) -> str:
    """The block. Structured text tells no capitals apart, so each name gets its kind: m_ capital tables, v_ others, k_ whole numbers."""
    if any(isinstance(node, ast.FunctionDef) for node in ast.parse(routine.source).body):
        raise DeviceError(NO_FUNCTIONS)
    real = "REAL" if single else "LREAL"
    tables = set(routine.lengths)
    body = [node for node in ast.parse(routine.source).body if not isinstance(node, ast.FunctionDef)]
    indices = sorted({ast.unparse(node.target) for node in ast.walk(ast.Module(body, [])) if isinstance(node, ast.For)})
    numbers = list(locals_of(body))
    lengths = {each.name: len(each.values) for each in routine.states} | dict(routine.scratch)
    outside = {"y", "u", "xhat", "r"}
    return template("FB_Lab.st", "st").format(
        period=f"{routine.period:.9g}", p=len(routine.y_names) - 1, m=len(routine.u_names) - 1, real=real,
        u_how="VAR_OUTPUT" if routine.drives else "VAR_INPUT", n=routine.lengths["xhat"] - 1,
        r=f"VAR_INPUT\n    v_r : {_array(next(each for each in routine.states if each.name == 'r'), real)};\nEND_VAR"
        if routine.commanded else "",
        sizes="\n".join(f"    k_{name} : INT := {value};" for name, value in routine.sizes.items()),
        constants="\n".join(f"    {_name(each.name)} : {_array(each, real)};" for each in routine.constants),
        states="\n".join(f"    {_name(each.name)} : {_array(each, real)};" for each in routine.states if each.name not in outside),
        room="\n".join(f"    {_name(name)} : ARRAY[0..{length - 1}] OF {real};" for name, length in lengths.items()
                       if name not in outside and name in routine.scratch),
        indices="\n".join(f"    i_{name} : INT;" for name in indices), numbers="\n".join(f"    n_{name} : {real};" for name in numbers),
        body="\n".join(_block(body, tables, set(routine.sizes), 0)))


def _array(each: Table, real: str) -> str:
    return f"ARRAY[0..{len(each.values) - 1}] OF {real} := [{', '.join(_literal(v) for v in each.values)}]"


def _literal(value: float) -> str:
    said = repr(float(value))
    return said if "e" not in said or "." in said.split("e")[0] else said.replace("e", ".0e", 1)


def _name(name: str) -> str:
    return f"{'m' if name[0].isupper() else 'v'}_{name}"


def _block(body: Sequence[ast.stmt], tables: set[str], sizes: set[str], depth: int) -> Iterator[str]:
    pad = "    " * depth
    for node in body:
        match node:
            case ast.For(target=ast.Name(id=index), iter=ast.Call(args=bounds)):
                low, high = ("0", _index(bounds[0], sizes)) if len(bounds) == 1 else (_index(bounds[0], sizes), _index(bounds[1], sizes))
                yield f"{pad}FOR i_{index} := {low} TO {high} - 1 DO"
                yield from _block(node.body, tables, sizes, depth + 1)
                yield f"{pad}END_FOR;"
            case ast.If(test=test, body=inner, orelse=other):
                yield f"{pad}IF {_test(test, tables, sizes)} THEN"
                yield from _block(inner, tables, sizes, depth + 1)
                if other:
                    yield f"{pad}ELSE"
                    yield from _block(other, tables, sizes, depth + 1)
                yield f"{pad}END_IF;"
            case ast.Assign(targets=[target], value=value):
                yield f"{pad}{_number(target, tables, sizes)} := {_number(value, tables, sizes)};"


def _test(node: ast.expr, tables: set[str], sizes: set[str]) -> str:
    match node:
        case ast.BoolOp(op=op, values=values):
            return (" AND " if isinstance(op, ast.And) else " OR ").join(f"({_test(each, tables, sizes)})" for each in values)
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            sign = next(sign for kind, sign in COMPARISONS if isinstance(op, kind))
            whole = all(isinstance(each, ast.Name) and len(each.id) == 1 and each.id in "ijk" for each in (left, right))
            say = _index if whole else None
            return " ".join((say(left, sizes), sign, say(right, sizes)) if say else (
                _number(left, tables, sizes), sign, _number(right, tables, sizes)))
    raise AssertionError(ast.unparse(node))


def _number(node: ast.expr, tables: set[str], sizes: set[str]) -> str:
    match node:
        case ast.Constant(value=value):
            return _literal(value)
        case ast.Name(id=name):
            return f"n_{name}"
        case ast.Subscript(value=ast.Name(id=name), slice=index):
            return f"{_name(name)}[{_index(index, sizes)}]"
        case ast.BinOp(left=left, op=op, right=right):
            sign = next(sign for kind, sign in OPERATORS if isinstance(op, kind))
            return f"({_number(left, tables, sizes)} {sign} {_number(right, tables, sizes)})"
        case ast.UnaryOp(operand=operand):
            return f"(-{_number(operand, tables, sizes)})"
        case ast.Call(func=ast.Name(id=name), args=args):
            return f"{name.upper()}({', '.join(_number(each, tables, sizes) for each in args)})"
    raise AssertionError(ast.unparse(node))


def _index(node: ast.expr, sizes: set[str]) -> str:
    match node:
        case ast.Constant(value=value):
            return str(value)
        case ast.Name(id=name):
            return f"k_{name}" if name in sizes else f"i_{name}"
        case ast.BinOp(left=left, op=op, right=right):
            sign = next(sign for kind, sign in OPERATORS if isinstance(op, kind))
            return f"({_index(left, sizes)} {sign} {_index(right, sizes)})"
    raise AssertionError(ast.unparse(node))
