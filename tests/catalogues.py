"""What the source says, as translators see it: every message with its context, found by Babel's extractor."""

from __future__ import annotations

import ast
import string
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from babel.messages.extract import extract_from_file

ROOT = Path(__file__).resolve().parent.parent
KEYWORDS = {"text": None, "phrase": None, "text_in": ((1, "c"), 2),
            **dict.fromkeys(("EngineError", "ShapeError", "PoleError", "RiccatiError"))}
SOURCES = sorted(p for folder in ("app", "lessons") for p in (ROOT / folder).rglob("*.py"))
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
    return found


def unreadable() -> Iterator[str]:
    """Calls whose message is not written out as one string: no extractor finds what they say."""
    for path in SOURCES:
        if path.is_relative_to(ROOT / "app" / "text") or path.name == "errors.py":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
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
