"""Markdown with $LaTeX$ → what a viser page can draw: MathML inside Markdown or HTML."""

from __future__ import annotations

import html
import re
from functools import lru_cache

from latex2mathml.converter import convert


@lru_cache(maxsize=4096)
def mathml(latex: str, display: bool = False) -> str:
    """One equation as MathML. A formula that the converter refuses is shown as its source."""
    try:
        drawn = latex.replace("bmatrix", "matrix").replace("pmatrix", "matrix")  # the style sheet draws the brackets
        return convert(drawn, display="block" if display else "inline")
    except Exception:  # the converter raises many kinds of errors for malformed LaTeX
        return f"<code>{html.escape(latex)}</code>"


MINUS = re.compile(r"(?:(?<=[\s(\[,=≈<>，：（；～…])|^)-(?=\.?\d)")


def with_minus(words: str) -> str:
    """Words in which a hyphen that stands for a sign has become a minus: numbers are formatted with hyphens."""
    return MINUS.sub("−", words)


@lru_cache(maxsize=1024)
def render(markdown: str) -> str:
    """Markdown whose $…$ and $$…$$ have become MathML."""
    text = re.sub(r"\$\$(.+?)\$\$", lambda m: mathml(m[1].strip(), True), markdown, flags=re.S)
    return re.sub(r"\$(.+?)\$", lambda m: mathml(m[1].strip()), text, flags=re.S)
