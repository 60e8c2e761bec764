"""Differentiate straight-line statements of the step language along with their values."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence

__all__ = ["with_slopes"]


def with_slopes(statements: Sequence[tuple[str, str]], variables: Sequence[str]) -> list[tuple[str, str]]:
    """Each statement (name, expression), followed by its slope in each variable, named `d_<name>_<variable>`; zero slopes are left out.

    Functions are lab_sin, lab_cos, lab_exp and sqrt; any name that is neither a variable nor assigned before is a constant.
    """
    known: dict[str, Mapping[str, ast.expr]] = {name: {name: ast.Constant(1.0)} for name in variables}
    out: list[tuple[str, str]] = []
    for name, words in statements:
        expression = ast.parse(words, mode="eval").body
        out.append((name, words))
        slopes: dict[str, ast.expr] = {}
        for variable in variables:
            slope = _slope(expression, variable, known)
            if slope is None:
                continue
            out.append((f"d_{name}_{variable}", ast.unparse(slope)))
            slopes[variable] = slope if isinstance(slope, ast.Constant) else ast.Name(f"d_{name}_{variable}")
        known[name] = slopes
    return out


def slope_of(statements: Sequence[tuple[str, str]], name: str, variable: str) -> str:
    """What stands for the slope of a name in a variable, in statements that `with_slopes` gave: its name or a number."""
    return f"d_{name}_{variable}" if any(each == f"d_{name}_{variable}" for each, _ in statements) else "0.0"


def _slope(node: ast.expr, variable: str, known: Mapping[str, Mapping[str, ast.expr]]) -> ast.expr | None:
    """The slope, None for zero."""
    match node:
        case ast.Constant():
            return None
        case ast.Name(id=name):
            return known.get(name, {}).get(variable)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            inner = _slope(operand, variable, known)
            return None if inner is None else _minus(inner)
        case ast.BinOp(left=left, op=op, right=right):
            first, second = (_slope(each, variable, known) for each in (left, right))
            if isinstance(op, ast.Add):
                return _sum(first, second)
            if isinstance(op, ast.Sub):
                return _sum(first, None if second is None else _minus(second))
            if isinstance(op, ast.Mult):
                return _sum(_product(first, right), _product(second, left))
            top = _sum(first, None if second is None else _minus(_product(second, node) or second))
            return None if top is None else ast.BinOp(top, ast.Div(), right)
        case ast.Call(func=ast.Name(id=name), args=[inner]):
            slope = _slope(inner, variable, known)
            if slope is None:
                return None
            outer = {"lab_sin": ast.Call(ast.Name("lab_cos"), [inner], []), "lab_cos": _minus(ast.Call(ast.Name("lab_sin"), [inner], [])),
                     "lab_exp": node, "sqrt": ast.BinOp(ast.Constant(0.5), ast.Div(), node)}[name]
            return _product(slope, outer)
    raise ValueError(f"{ast.unparse(node)} has no slope here")


def _sum(a: ast.expr | None, b: ast.expr | None) -> ast.expr | None:
    return b if a is None else a if b is None else ast.BinOp(a, ast.Add(), b)


def _product(slope: ast.expr | None, other: ast.expr) -> ast.expr | None:
    if slope is None:
        return None
    return other if isinstance(slope, ast.Constant) and slope.value == 1.0 else ast.BinOp(slope, ast.Mult(), other)


def _minus(a: ast.expr) -> ast.expr:
    return ast.UnaryOp(ast.USub(), a)
