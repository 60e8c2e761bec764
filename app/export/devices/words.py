"""Write the words of generated code: templates, names safe in comments, the header of its lines."""

from __future__ import annotations

import re
from pathlib import Path

from ...devices import Routine

__all__ = ["column_names", "comment_word", "header_line", "identifier", "template"]

TEMPLATES = Path(__file__).parents[1] / "templates" / "devices"
LONGEST_WORD = 60  # characters of a name in a comment


def template(name: str, body: str = "c") -> str:
    """A file of a body's folder as it stands."""
    return (TEMPLATES / body / f"{name}.txt").read_text(encoding="utf-8")


def comment_word(word: str) -> str:
    """A signal's name as it may stand in a comment: letters, digits, blanks and a few signs, so that no name ends the comment."""
    return re.sub(r"[^\w \[\]().,^+-]", "_", word, flags=re.ASCII)[:LONGEST_WORD].strip() or "unnamed"


def identifier(word: str, taken: set[str]) -> str:
    """A name that every language here accepts, and that is not taken yet; it is added to `taken`."""
    plain = re.sub(r"\W+", "_", word, flags=re.ASCII).strip("_")[:30] or "signal"
    plain = f"s_{plain}" if plain[0].isdigit() else plain
    name, count = plain, 1
    while name.lower() in taken:
        count += 1
        name = f"{plain}_{count}"
    taken.add(name.lower())
    return name


def column_names(routine: Routine) -> list[str]:
    """The columns of a line: the time, every input, every reading."""
    taken: set[str] = set()
    inputs, readings = ([identifier(name, taken) for name in names] for names in (routine.u_names, routine.y_names))
    return ["t", *(f"u:{name}" for name in inputs), *(f"y:{name}" for name in readings)]


def header_line(routine: Routine) -> str:
    """The comment line that names the columns, as in `# t,u:force,y:angle`."""
    return "# " + ",".join(column_names(routine))
