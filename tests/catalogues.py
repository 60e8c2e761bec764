"""What the source says, as translators see it: every message with its context, found by Babel's extractor."""

from __future__ import annotations

import ast
import re
import string
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from babel.messages.extract import extract_from_file
from syntax import nodes

from observer_lab.export.scripts.comment_translation import comments_of
from observer_lab.lessons import draft_folders

ROOT = Path(__file__).resolve().parent.parent
KEYWORDS = {"text": None, "phrase": None, "text_in": ((1, "c"), 2),
            **dict.fromkeys(("EngineError", "ShapeError", "PoleError", "RiccatiError"))}
DRAFTS = draft_folders()  # their words wait for a translation
SOURCES = sorted(p for folder in ("app", "lessons") for p in (ROOT / folder).rglob("*.py") if p.parent not in DRAFTS)
Message = tuple[str, str]  # context, English


@lru_cache(maxsize=1)
def said() -> dict[Message, str]:
    """Every message of the source and a place where it stands."""
    found: dict[Message, str] = {}
    for path in SOURCES:
        for line, message, _, context in extract_from_file("python", path, KEYWORDS):
            english = message[-1] if isinstance(message, tuple) else message
            if english:
                found.setdefault((context or "", english), f"{path.relative_to(ROOT)}:{line}")
    for comment, where in comments():
        if NAMED.search(comment):
            found.setdefault(("script", comment), where)
    return found


WRITERS = [ROOT / "app" / "export" / "scripts" / f"{name}.py"
           for name in ("gains", "matlab", "script", "code_record_script")]
NOTED = {"GivenValue": 2, "array_text": 2, "array": 2, "Code": 3}  # calls, and which of their arguments is a comment
NAMED = re.compile(r"[A-Za-z]{2}")  # a comment without a word reads the same in every language


def comments() -> Iterator[tuple[str, str]]:
    """What comments of exported scripts say, and where it stands: the parts, and what writers and lessons put beside numbers."""
    for path in sorted((ROOT / "app" / "export" / "templates").rglob("*.txt")):
        for comment in comments_of(path.read_text(encoding="utf-8"), "%" if "matlab" in path.parts else "#"):
            yield comment, path.name
    for path in (*WRITERS, *(ROOT / "lessons").glob("*/*.py")):
        for comment in _noted(nodes(path.read_text(encoding="utf-8")), path in WRITERS):
            yield comment, path.name


def _noted(all_nodes: tuple[ast.AST, ...], writer: bool) -> Iterator[str]:
    filled = {id(part) for node in all_nodes if isinstance(node, ast.JoinedStr) for part in node.values}
    for node in all_nodes:
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and len(node.args) > (at := NOTED.get(node.func.id, 99)):
            yield from (words for words in _written(node.args[at], filled) if not words.startswith(","))
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id.startswith("NOT_IN_SCRIPT"):
            yield from _written(node.value, filled)
        elif writer and isinstance(node, ast.Yield) and isinstance(node.value, ast.Tuple):
            yield from _written(node.value.elts[0], filled)
        elif writer and isinstance(node, ast.Constant) and isinstance(node.value, str):
            whole = re.match(r"^(?:#|%%?) ([^\n]{4,})$", node.value) if id(node) not in filled else None
            said = whole or re.search(r"  [#%] (.+?)(?:\n|$)", node.value)
            if said and not said[1].endswith(" "):  # else a value follows, and app/export/scripts/comment_translation.py has the whole
                yield said[1]


def _written(tree: ast.AST, filled: set[int]) -> Iterator[str]:
    """Strings that are written out below a node."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value and id(node) not in filled:
            yield node.value


def unreadable() -> Iterator[str]:
    """Calls whose message is not written out as one string: no extractor finds what they say."""
    for path in SOURCES:
        if path.is_relative_to(ROOT / "app" / "text") or path.name == "errors.py":
            continue
        for node in nodes(path.read_text(encoding="utf-8")):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in KEYWORDS and node.args:
                place = 1 if node.func.id == "text_in" else 0
                given = node.args[: place + 1]
                if isinstance(given[0], ast.Attribute):  # a phrase in a record, written out where the record is made
                    continue
                if not all(isinstance(a, ast.Constant) and isinstance(a.value, str) for a in given):
                    yield f"{path.relative_to(ROOT)}:{node.lineno}: {ast.unparse(node)[:100]}"


def places(template: str) -> set[str]:
    """The named places of a template."""
    return {name for _, name, _, _ in string.Formatter().parse(template) if name}
