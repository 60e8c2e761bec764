"""Names in docstrings and comments: whatever looks like a name of the code is one."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MODULES = sorted(path for room in ("app", "lessons") for path in (ROOT / room).rglob("*.py"))
CAPITALS = re.compile(r"(?<![\w$\\.{/&^=\[-])[A-Z][A-Z0-9_]{2,}(?![\w{}/&-]|\(\d)")  # shorter ones are matrices and units
COMMENT = re.compile(r"(?:^|\s)(#\s.*)")
QUOTED = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
NAME = re.compile(r"[A-Za-z_]\w*")
ABBREVIATIONS = frozenset((  # of the trade and of linters; places for values, variables of the environment; products of matrices
    "A12", "AIAA", "API", "ASCII", "ASD", "AVR", "AXQ", "B905", "C99", "CAB", "CARE", "CSV", "CUSUM", "DARE", "DGD", "DNS", "E731", "EKF",
    "FFFD", "FILE", "FMI", "FMU", "GET", "HEDL", "HKDF", "HMAC", "HTML", "HTTP", "IEEE", "IMM", "IMS", "JSON", "KNOB", "LAPACK", "LDK",
    "LQE", "LQG", "LQR", "LTI", "LTR", "MATLAB", "MCAP", "NEES", "NIS", "OBSERVER_LAB_KERNELS", "OBSERVER_LAB_LOCALE", "PBH", "PDF",
    "PNG", "PRK", "README", "RFC", "RLO", "RMS", "ROS", "RRGGBB", "RSA", "SBR", "SIS", "SISO", "SVG", "TAC", "TLS", "TOML", "UKF", "UTC",
    "VALUE", "XGX", "appendfsync", "jsonencode",
))


def said(source: str) -> list[tuple[int, str]]:
    """Line and words of each docstring and each comment of a module."""
    found = [(number, comment[1]) for number, line in enumerate(source.splitlines(), 1) if (comment := COMMENT.search(line))]
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and (words := ast.get_docstring(node)):
            found.append((node.body[0].lineno, words))
    return found


@cache
def tree_of(path: Path) -> ast.Module:
    """The syntax tree of a module."""
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def names_of(path: Path) -> frozenset[str]:
    """Every name in the code of a module, and the parts of its own path."""
    found = set(path.with_suffix("").relative_to(ROOT).parts)
    for node in ast.walk(tree_of(path)):
        match node:
            case ast.Name(id=name) | ast.arg(arg=name) | ast.Attribute(attr=name) | ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                found.add(name)
            case ast.AsyncFunctionDef(name=name) | ast.keyword(arg=str(name)) | ast.alias(asname=str(name)):
                found.add(name)
            case ast.alias(name=name):
                found |= set(name.split("."))
    return frozenset(found)


@cache
def written() -> frozenset[str]:
    """Every name of the code, and every word of a string that is no docstring: keys, options and fields of templates."""
    found: set[str] = set()
    for path in MODULES:
        found |= names_of(path)
        docs = set[int]()
        for node in ast.walk(tree_of(path)):
            if isinstance(node, ast.Expr):
                docs.add(id(node.value))
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
                found.update(NAME.findall(node.value))
    return frozenset(found)


@cache
def names_in(folder: Path) -> frozenset[str]:
    """Every name in the code of a folder's modules."""
    return frozenset().union(*(names_of(path) for path in MODULES if path.parent == folder))


def untrue(path: Path, source: str) -> list[str]:
    """What looks like a name in the words of a module and is none: capitals that its folder does not know, or words in back-quotes."""
    near, wrong = names_in(path.parent), []
    for line, words in said(source):
        wrong += [f"{line}: {name}" for name in CAPITALS.findall(QUOTED.sub("", words)) if name not in near and name not in ABBREVIATIONS]
        wrong += [f"{line}: `{name}`" for name in QUOTED.findall(words) if NAME.fullmatch(name) and name not in written() | ABBREVIATIONS]
    return wrong


def test_what_looks_like_a_name_is_one() -> None:
    wrong = [f"{path.relative_to(ROOT)}:{found}" for path in MODULES for found in untrue(path, path.read_text(encoding="utf-8"))]
    assert not wrong, "these words name what does not exist, or are abbreviations that ABBREVIATIONS lacks:\n" + "\n".join(wrong)


def test_a_name_that_is_gone_is_found() -> None:
    source = '"""At most LONG_GONE seconds; see `no_such_function`."""\n# HOLD_GONE, of MODULES\n'
    found = {"1: LONG_GONE", "1: `no_such_function`", "2: HOLD_GONE"}
    assert found <= set(untrue(MODULES[0], source))
