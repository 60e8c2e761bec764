"""Break a caption into lines, between words in English and between characters in Chinese."""

from __future__ import annotations

import re
import unicodedata

NEVER_FIRST = "，。；：、！？）》”’,.;:!?)%"


def text_width_em(text: str) -> float:
    """About how many em a text takes: 1 for a Chinese character, half of it for a Latin letter."""
    return sum(1.0 if unicodedata.east_asian_width(c) in "WF" else 0.0 if unicodedata.combining(c) else 0.5
               for c in text)


def wrap(text: str, em: float) -> list[str]:
    """The text in lines of at most `em` em, as far as its words allow."""
    lines, line = [], ""
    for piece in re.findall(r"[^\S\n]+|[\u2e80-\u9fff\uff00-\uffef“”]|[^\s\u2e80-\u9fff\uff00-\uffef“”]+", text):
        if line and text_width_em(line + piece.rstrip()) > em and piece[0] not in NEVER_FIRST:
            lines.append(line.rstrip())
            line = piece.lstrip()
        else:
            line += piece
    return [*lines, line.rstrip()] if line.strip() else lines
