"""The page's own files: scripts and styles that every browser gets, as they are.

A script is one function; what it must know from here goes into its only argument as JSON, never into its text.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

FOLDER = Path(__file__).parent
BREAKS = (("<", "\\u003c"), ("\u2028", "\\u2028"), ("\u2029", "\\u2029"))  # what would end an element or a line of a script


@cache
def source(name: str) -> str:
    """The text of one of the files."""
    return (FOLDER / name).read_text(encoding="utf-8")


def call(name: str, **given: object) -> str:
    """The source that calls a script's function with what it is given, under the script's name for whoever debugs it."""
    argument = json.dumps(given, ensure_ascii=False)
    for sign, written in BREAKS:
        argument = argument.replace(sign, written)
    return f"// {name}.js\n(\n{source(name + '.js')})({argument})"


def apart(name: str, **given: object) -> str:
    """The same for a page that stands: an error is reported by itself, since viser would drop with it all that came in the same batch."""
    head, _, rest = call(name, **given).partition("\n")
    return f"{head}\n(\n{source('apart.js')})({{script: () =>\n{rest}}})"
