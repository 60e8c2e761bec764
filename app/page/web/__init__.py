"""Read the page's own scripts and styles and write calls to the scripts.

A script is one function; what it must know from here goes into its only argument as JSON, never into its text.
"""

from __future__ import annotations

import base64
import json
from functools import cache
from pathlib import Path
from string import Template

from ...colours import COLOURS, DARK_COLOURS

FOLDER = Path(__file__).parent
MATH_FONT = "Observer Lab Math"  # as `math.css` names it
BREAKS = (("<", "\\u003c"), ("\u2028", "\\u2028"), ("\u2029", "\\u2029"))  # what would end an element or a line of a script


@cache
def path_of(name: str) -> Path:
    """Where one of the files stands; its name is unique in all the folders here. Raises LookupError."""
    found = list(FOLDER.glob(f"*/{name}"))
    if len(found) != 1:
        raise LookupError(f"There must be one file {name} of the page; there are {len(found)}.")
    return found[0]


@cache
def file_text(name: str) -> str:
    """The text of one of the files."""
    return path_of(name).read_text(encoding="utf-8")


def coloured_text(name: str) -> str:
    """The text of a file with the colour by day for each $role in it."""
    return Template(file_text(name)).substitute(COLOURS)


@cache
def font_rules() -> str:
    """The style sheet of the font of our formulas, with the font in it: a page asks no other host for one."""
    font = base64.b64encode(path_of("math.woff2").read_bytes()).decode("ascii")
    return f'@font-face{{font-family:"{MATH_FONT}";src:url(data:font/woff2;base64,{font}) format("woff2")}}{file_text("math.css")}'


@cache
def style_rules(*names: str) -> str:
    """The text of style sheets, under custom properties for all roles of colours, by day and in the dark."""
    day = ";".join(f"--ol-{role}:{colour}" for role, colour in COLOURS.items())
    dark = ";".join(f"--ol-{role}:{colour}" for role, colour in DARK_COLOURS.items() if colour != COLOURS[role])
    return "".join([f":root{{{day}}}\n:root[data-ol-theme=dark]{{{dark}}}\n", *map(file_text, names)])


def script_call(name: str, **given: object) -> str:
    """The source that calls a script's function with what it is given, under the script's name for whoever debugs it."""
    argument = json.dumps(given, ensure_ascii=False)
    for sign, written in BREAKS:
        argument = argument.replace(sign, written)
    return f"// {name}.js\n(\n{file_text(name + '.js')})({argument})"


def call_reporting_errors(name: str, **given: object) -> str:
    """The same for a page that stands: an error is reported by itself, since viser would drop with it all that came in the same batch."""
    head, _, rest = script_call(name, **given).partition("\n")
    return f"{head}\n(\n{file_text('apart.js')})({{script: () =>\n{rest}}})"
