"""Break text with mathematics into lines and set it on a printed page.

matplotlib takes the font of a whole text from its mathematics, which has no Chinese: so words and formulas are measured and
set piece by piece.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure as Page
from matplotlib.mathtext import MathTextParser

from ..figures.style import NEVER_FIRST, escape_mathtext

__all__ = ["Piece", "lines_of", "readable", "set_line"]

MATHS = re.compile(r"(\$\$?.+?\$\$?)", re.DOTALL)
HAN = "[\u2e80-\u9fff\uff00-\uffef“”]"
PIECE = re.compile(rf"\s+|{HAN}|[^\s\u2e80-\u9fff\uff00-\uffef“”]+")
MATRIX = re.compile(r"\\begin\{+[bp]?matrix\}+(.+?)\\end\{+[bp]?matrix\}+", re.DOTALL)
LONE = re.compile(r"(\\(?:mathcal|mathsf|mathbf|mathrm|hat|bar|dot|tilde|ddot))\s+(\w|\\\w+)")
LATEX_RELATIONS = re.compile(r"\\(le|ge|ne)(?![a-zA-Z])")
PARSER = MathTextParser("path")


@dataclass(frozen=True)
class Piece:
    """A word, a Chinese character, a space or a formula; `width` in inches."""

    said: str
    maths: bool
    width: float

    @property
    def blank(self) -> bool:
        """Whether it is a space."""
        return not self.maths and self.said.isspace()


def readable(latex: str) -> str:
    """LaTeX as matplotlib reads it: one argument always in braces, and a matrix as its rows between semicolons."""
    latex = MATRIX.sub(lambda m: r"\left[" + r"\,;\;".join(r"\;\;".join(row.split("&")) for row in m[1].split(r"\\")) + r"\right]", latex)
    latex = LONE.sub(r"\1{\2}", latex.replace(r"\mathsf T", r"\mathsf{T}"))
    return LATEX_RELATIONS.sub(r"\\\1q ", latex).replace(r"\neq ", r"\neq ").strip()


def lines_of(markdown: str, wide: float, measure: Callable[[str, bool], float]) -> Iterator[tuple[Piece, ...]]:
    """The lines, at most `wide` inches each as far as their words allow; an empty one between two paragraphs.

    `measure(text, maths)` is the width of a text in inches.
    """
    for index, paragraph in enumerate(re.split(r"\n\s*\n", markdown.strip())):
        if index:
            yield ()
        yield from _broken(list(_pieces(paragraph, measure)), wide)


def _pieces(paragraph: str, measure: Callable[[str, bool], float]) -> Iterator[Piece]:
    for part in MATHS.split(re.sub(r"\*\*|(?<!\w)\*|\*(?!\w)|`", "", paragraph)):
        if part.startswith("$"):
            said = f"${readable(part.strip('$'))}$"
            yield Piece(said, True, measure(said, True)) if _parses(said) else Piece(part.strip("$"), False, measure(part, False))
            continue
        for found in PIECE.findall(part):
            said = " " if found.isspace() else found
            yield Piece(said, False, measure(said, False))


def _parses(maths: str) -> bool:
    try:
        PARSER.parse(maths)
    except ValueError:
        return False
    return True


def _broken(pieces: list[Piece], wide: float) -> Iterator[tuple[Piece, ...]]:
    """Lines that end where a line may: at a space, or beside a Chinese character that may begin one."""
    line: list[Piece] = []
    for group in _groups(pieces):
        if line and sum(p.width for p in (*line, *group)) - (group[-1].width if group[-1].blank else 0.0) > wide:
            yield tuple(line)
            line = []
        line += group if line else group[group[0].blank:]
    if line:
        yield tuple(line)


def _groups(pieces: list[Piece]) -> Iterator[list[Piece]]:
    """What must stay on one line: up to a space, or one Chinese character with the stop behind it."""
    group: list[Piece] = []
    for piece in pieces:
        if group and (group[-1].blank or ((_han(piece) or _han(group[-1])) and piece.said[0] not in NEVER_FIRST)) and not piece.blank:
            yield group
            group = []
        group.append(piece)
    if group:
        yield group


def _han(piece: Piece) -> bool:
    return not piece.maths and re.match(HAN, piece.said) is not None


def set_line(page: Page, line: tuple[Piece, ...], left: float, baseline: float, size: float, **look: Any) -> None:
    """Set a line on a page, `left` and `baseline` in inches from its lower left corner, in letters of `size` points."""
    wide, high = page.get_size_inches()
    said, x = "", left
    for k, piece in enumerate(line):
        if not piece.maths:  # neighbouring words are one text
            said += piece.said
        if said and (piece.maths or k == len(line) - 1):
            page.text(x / wide, baseline / high, escape_mathtext(said), fontsize=size, va="baseline", **look)
            x += sum(p.width for p in line[:k + (not piece.maths)]) - (x - left)
            said = ""
        if piece.maths:
            page.text(x / wide, baseline / high, piece.said, fontsize=size, va="baseline", **look)
            x += piece.width
