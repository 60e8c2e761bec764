"""Write a routine as C99: the same operations in the same order, numbers as hexadecimal constants."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence

import numpy as np

from ...devices import Routine, Table
from ...devices.language import locals_of

__all__ = ["c_block", "c_functions", "c_number", "c_tables"]

OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}.items()
COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}.items()
PER_LINE = 4


def c_number(value: float, single: bool) -> str:
    """A number that the compiler reads back exactly."""
    with np.errstate(over="ignore"):
        value = float(np.float32(value)) if single else float(value)
    if value != value:
        return "(0.0F / 0.0F)" if single else "(0.0 / 0.0)"
    if abs(value) == float("inf"):
        return f"({'-' if value < 0 else ''}1.0F / 0.0F)" if single else f"({'-' if value < 0 else ''}1.0 / 0.0)"
    return value.hex() + ("F" if single else "")


def c_tables(tables: Sequence[Table], single: bool, how: str, prefix: str = "") -> str:
    """The tables as arrays, each with its note."""
    return "\n".join(_table(each, single, how, prefix) for each in tables)


def _table(each: Table, single: bool, how: str, prefix: str) -> str:
    numbers = [c_number(v, single) for v in each.values]
    rows = ",\n    ".join(", ".join(numbers[k:k + PER_LINE]) for k in range(0, len(numbers), PER_LINE))
    note = f"/* {each.note} */\n" if each.note else ""
    return f"{note}{how} {prefix}{each.name}[{len(numbers)}] = {{ /* {each.shape[0]} x {each.shape[1]} */\n    {rows}\n}};"


def c_functions(routine: Routine, single: bool) -> str:
    """The helper functions of a step."""
    tree = ast.parse(routine.source)
    return "\n".join(_helper(node, single) for node in tree.body if isinstance(node, ast.FunctionDef))


def _helper(node: ast.FunctionDef, single: bool) -> str:
    *body, last = node.body
    assert isinstance(last, ast.Return) and last.value is not None
    arguments = ", ".join(f"lab_real {each.arg}" for each in node.args.args)
    given = {each.arg for each in node.args.args}
    lines = [f"    lab_real {name};" for name in locals_of(body) if name not in given]
    lines += _block(body, single, 1)
    return "\n".join([f"static lab_real {node.name}({arguments})", "{", *lines, f"    return {_number(last.value, single)};", "}", ""])


def c_block(routine: Routine, single: bool) -> str:
    """The statements of a step, the declarations of its plain numbers before them."""
    body = [node for node in ast.parse(routine.source).body if not isinstance(node, ast.FunctionDef)]
    indices = sorted({ast.unparse(node.target) for node in ast.walk(ast.Module(body, [])) if isinstance(node, ast.For)})
    head = [f"    int {', '.join(indices)};"] if indices else []
    names = list(locals_of(body))
    head += [f"    lab_real {', '.join(names)};"] if names else []
    return "\n".join([*head, *_block(body, single, 1)])


def _block(body: Sequence[ast.stmt], single: bool, depth: int) -> Iterator[str]:
    pad = "    " * depth
    for node in body:
        match node:
            case ast.For(target=ast.Name(id=index), iter=ast.Call(args=bounds)):
                low, high = ("0", _index(bounds[0])) if len(bounds) == 1 else (_index(bounds[0]), _index(bounds[1]))
                yield f"{pad}for ({index} = {low}; {index} < {high}; {index}++) {{"
                yield from _block(node.body, single, depth + 1)
                yield f"{pad}}}"
            case ast.If(test=test, body=inner, orelse=other):
                yield f"{pad}if ({_test(test, single)}) {{"
                yield from _block(inner, single, depth + 1)
                if other:
                    yield f"{pad}}} else {{"
                    yield from _block(other, single, depth + 1)
                yield f"{pad}}}"
            case ast.Assign(targets=[target], value=value):
                yield f"{pad}{_number(target, single)} = {_bare(value, single)};"
            case _:
                raise AssertionError(ast.unparse(node))


def _test(node: ast.expr, single: bool) -> str:
    match node:
        case ast.BoolOp(op=op, values=values):
            return (" && " if isinstance(op, ast.And) else " || ").join(f"({_test(each, single)})" for each in values)
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            sign = next(sign for kind, sign in COMPARISONS if isinstance(op, kind))
            return f"{_number(left, single)} {sign} {_number(right, single)}"
    raise AssertionError(ast.unparse(node))


def _bare(node: ast.expr, single: bool) -> str:
    """A number without the outermost pair of brackets."""
    said = _number(node, single)
    return said[1:-1] if isinstance(node, ast.BinOp) else said


def _number(node: ast.expr, single: bool) -> str:
    match node:
        case ast.Constant(value=value):
            return str(value) if type(value) is int else c_number(value, single)
        case ast.Name(id=name):
            return name
        case ast.Subscript(value=ast.Name(id=name), slice=index):
            return f"{name}[{_index(index)}]"
        case ast.BinOp(left=left, op=op, right=right):
            sign = next(sign for kind, sign in OPERATORS if isinstance(op, kind))
            return f"({_number(left, single)} {sign} {_number(right, single)})"
        case ast.UnaryOp(operand=operand):
            return f"(-{_number(operand, single)})"
        case ast.Call(func=ast.Name(id=name), args=args):
            called = f"{name}f" if single and name in ("sqrt", "floor") else name
            return f"{called}({', '.join(_bare(each, single) for each in args)})"
    raise AssertionError(ast.unparse(node))


def _index(node: ast.expr) -> str:
    return ast.unparse(node)
