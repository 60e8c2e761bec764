"""Check the step language: loops, branches and + − × ÷ √ over named numbers, a subset of Python.

A step is written once in this subset. Python runs it as it stands; `app/export/devices` writes it as C and as structured text, operation by
operation. No body may regroup a sum: every binary operation rounds once, in the order that the text gives.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

__all__ = ["COMPARISONS", "OPERATORS", "Names", "StepError", "check_step"]

OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div)
COMPARISONS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq)
FUNCTIONS = ("sqrt", "floor")  # exact or correctly rounded in every body


class StepError(ValueError):
    """A step that is not written in the step language."""


@dataclass(frozen=True)
class Names:
    """What a step may name: whole numbers, tables with their lengths, helper functions with their number of arguments."""

    sizes: Mapping[str, int]
    tables: Mapping[str, int]
    helpers: Mapping[str, int] = field(default_factory=dict)

    def takes(self, function: str) -> int | None:
        """How many numbers a function takes, None where there is none of that name."""
        return 1 if function in FUNCTIONS else self.helpers.get(function)


def check_step(source: str, sizes: Mapping[str, int], tables: Mapping[str, int]) -> ast.Module:
    """The parsed step. Raises StepError with the line where it leaves the language."""
    tree = ast.parse(source)
    helpers = {node.name: len(node.args.args) for node in tree.body if isinstance(node, ast.FunctionDef)}
    names = Names(sizes, tables, helpers)
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            _check_helper(node, names)
    _check_block([node for node in tree.body if not isinstance(node, ast.FunctionDef)], names, frozenset(), set())
    return tree


def _check_helper(node: ast.FunctionDef, names: Names) -> None:
    arguments = {each.arg for each in node.args.args}
    *body, last = node.body
    assigned = set(arguments)
    _check_block(body, Names(names.sizes, {}, names.helpers), frozenset(), assigned)
    if not isinstance(last, ast.Return) or last.value is None:
        raise StepError(f"line {last.lineno}: a helper must end by returning one number")
    _check_number(last.value, Names(names.sizes, {}, names.helpers), frozenset(), assigned)


def _check_block(body: list[ast.stmt], names: Names, indices: frozenset[str], known: set[str]) -> None:
    for node in body:
        match node:
            case ast.For(target=ast.Name(id=index), iter=ast.Call(func=ast.Name(id="range"), args=bounds, keywords=[]), orelse=[]) if (
                    1 <= len(bounds) <= 2):
                for bound in bounds:
                    _check_index(bound, names, indices)
                _check_block(node.body, names, indices | {index}, known)
            case ast.If(test=test, body=inner, orelse=other):
                _check_test(test, names, indices, known)
                _check_block(inner, names, indices, known)
                _check_block(other, names, indices, known)
            case ast.Assign(targets=[ast.Name(id=name)], value=value) if name not in names.tables | names.sizes and name not in indices:
                _check_number(value, names, indices, known)
                known.add(name)
            case ast.Assign(targets=[ast.Subscript() as target], value=value):
                _check_number(target, names, indices, known)
                _check_number(value, names, indices, known)
            case _:
                raise StepError(f"line {node.lineno}: {ast.unparse(node)[:60]!r} is no statement of the step language")


def _check_test(node: ast.expr, names: Names, indices: frozenset[str], known: set[str]) -> None:
    match node:
        case ast.BoolOp(values=values):
            for each in values:
                _check_test(each, names, indices, known)
        case ast.Compare(left=left, ops=[op], comparators=[right]) if isinstance(op, COMPARISONS):
            whole = all(isinstance(each, (ast.Name, ast.Constant)) and _is_whole(each, names, indices) for each in (left, right))
            for each in (left, right):
                if whole:
                    _check_index(each, names, indices)
                else:
                    _check_number(each, names, indices, known)
        case _:
            raise StepError(f"line {node.lineno}: {ast.unparse(node)[:60]!r} is no test of the step language")


def _is_whole(node: ast.expr, names: Names, indices: frozenset[str]) -> bool:
    return (isinstance(node, ast.Name) and (node.id in names.sizes or node.id in indices)) or (
        isinstance(node, ast.Constant) and type(node.value) is int)


def _check_number(node: ast.expr, names: Names, indices: frozenset[str], known: set[str]) -> None:
    match node:
        case ast.Constant(value=value) if type(value) is float:
            return
        case ast.Name(id=name) if name in known:
            return
        case ast.Subscript(value=ast.Name(id=name), slice=index) if name in names.tables:
            _check_index(index, names, indices)
        case ast.BinOp(left=left, op=op, right=right) if isinstance(op, OPERATORS):
            _check_number(left, names, indices, known)
            _check_number(right, names, indices, known)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            _check_number(operand, names, indices, known)
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if names.takes(name) == len(args):
            for each in args:
                _check_number(each, names, indices, known)
        case _:
            raise StepError(f"line {node.lineno}: {ast.unparse(node)[:60]!r} is no number of the step language")


def _check_index(node: ast.expr, names: Names, indices: frozenset[str]) -> None:
    match node:
        case ast.Constant(value=value) if type(value) is int:
            return
        case ast.Name(id=name) if name in names.sizes or name in indices:
            return
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.Mult(), right=right):
            _check_index(left, names, indices)
            _check_index(right, names, indices)
        case _:
            raise StepError(f"line {node.lineno}: {ast.unparse(node)[:60]!r} is no index of the step language")


def locals_of(body: list[ast.stmt]) -> Iterator[str]:
    """The plain numbers that a block assigns, each once, in order."""
    seen: set[str] = set()
    for node in ast.walk(ast.Module(body, [])):
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id not in seen:
            seen.add(node.targets[0].id)
            yield node.targets[0].id
