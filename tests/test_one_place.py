"""What viser's page calls its parts is known in one folder, and what colour a role has in one module."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator

import pytest
from syntax import ROOT

from observer_lab.colours import COLOURS, DARK_COLOURS, rgb

KNOWS_VISER = ("app/page/web/viser_page/", "app/page/viser_private/")
GIVES_COLOURS = "app/colours.py"
NO_COLOURS = (GIVES_COLOURS, "app/engine/")  # the engine paints nothing
VISER = re.compile(
    r"mantine|tabler-|\bu-(?:over|under|legend|wrap|title|marker|series|axis)\b|\.uplot\b(?!\.)|uplot-|__viser|__VISER|data-dock|data-floating"
    r"|data-scrollarea|data-engine|data-testid|floating-panel|chevron|webgl-software|#root\b|mark-offset|button-padding|style\*="
    r"|messageQueue|requestRender|RenderRequest|sendMessage|sendCamera|nodeRefFromName|cameraControl|__r3f|backgroundMaterial|fragmentShader"
    r"|set_server|max-width: 36em|getElementsByClassName|[\"']\w+Message[\"']", re.I)
HEX = re.compile(r"(?<![\w&\\])#(?:[0-9a-fA-F]{3,4}|[0-9a-fA-F]{6}|[0-9a-fA-F]{8})\b")
SAY = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)  # what may begin with a docstring
FUNCTION = re.compile(r"\b(?:rgba?|hsla?)\(\s*[\d.]")


def files(*suffixes: str, folders: tuple[str, ...] = ("app", "lessons")) -> Iterator[tuple[str, str]]:
    """Path from the root and text of every file of a kind."""
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in suffixes:
                yield path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")


def strings(source: str) -> Iterator[tuple[int, str]]:
    """The strings of a module that are no docstrings, with their lines."""
    tree = ast.parse(source)
    said = {id(node.body[0].value) for node in ast.walk(tree) if isinstance(node, SAY) and node.body and isinstance(node.body[0], ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in said:
            yield node.lineno, node.value


def viser_names(name: str, text: str) -> list[str]:
    """Where a file names something of viser's page."""
    lines = strings(text) if name.endswith(".py") else enumerate(text.splitlines(), 1)
    return [f"{name}:{number}: {found[0]}" for number, line in lines for found in VISER.finditer(line)]


def bytes_in(source: str) -> list[int]:
    """The lines of a module where a tuple is three bytes of a colour, and no small numbers, shape of a picture or values of three names."""
    tree = ast.parse(source)
    unpacked = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple)}
    tuples = ((node.lineno, [part.value for part in node.elts if isinstance(part, ast.Constant) and type(part.value) is int])
              for node in ast.walk(tree) if isinstance(node, ast.Tuple) and len(node.elts) == 3 and id(node) not in unpacked)
    return [line for line, parts in tuples if len(parts) == 3 and 12 < max(parts) <= 255 and parts[-1] != 3]


def colours_in(name: str, text: str) -> list[str]:
    """Where a file gives a colour by its numbers."""
    lines = list(strings(text) if name.endswith(".py") else enumerate(text.splitlines(), 1))
    found = [f"{name}:{number}: {colour}" for number, line in lines for colour in (*HEX.findall(line), *FUNCTION.findall(line))]
    return found + ([f"{name}:{number}: three bytes" for number in bytes_in(text)] if name.endswith(".py") else [])


def test_names_of_visers_page_stand_in_one_folder() -> None:
    texts = files(".js", ".css", ".html", ".py")
    assert [place for name, text in texts if not name.startswith(KNOWS_VISER) for place in viser_names(name, text)] == []


def test_every_part_that_is_named_is_used_and_each_that_is_used_is_named() -> None:
    page = (ROOT / "app/page/web/viser_page/viser_dom.js").read_text(encoding="utf-8")
    table = page[page.index("lab.parts = {"):page.index("\n  };")]
    named = {f"data-ol-{re.sub('[A-Z]', lambda letter: '-' + letter[0].lower(), name)}": name
             for name in re.findall(r"\b(\w+): [`'FS]", table)}
    assert len(named) > 40
    texts = "".join(text for _, text in (*files(".js", ".css", ".html"), *files(".py", folders=("tests",)))).replace(table, "")
    styled = set(re.findall(r"\bdata-ol-[a-z-]+", texts)) - {"data-ol-theme", "data-ol-part", "data-ol-"}
    assert styled <= set(named)
    assert [name for attribute, name in named.items() if attribute not in styled and not re.search(rf"\b{name}\b", texts)] == []


def test_colours_are_given_in_one_module() -> None:
    texts = files(".js", ".css", ".html", ".svg", ".py")
    found = [place for name, text in texts if not name.startswith(NO_COLOURS) for place in colours_in(name, text)]
    assert found == []


def test_every_role_has_a_colour_by_day_and_in_the_dark_and_is_used() -> None:
    assert set(COLOURS) == set(DARK_COLOURS)
    assert all(re.fullmatch("#[0-9A-F]{6}(?:[0-9A-F]{2})?", colour) for table in (COLOURS, DARK_COLOURS) for colour in table.values())
    assert rgb("#0A10FF") == (10, 16, 255)
    texts = "".join(text for name, text in files(".js", ".css", ".svg", ".py") if name != GIVES_COLOURS)
    idle = [role for role in COLOURS if not re.search(rf"[\"'](?:glass)?{role}[\"']|--ol-{role}\b|\${role}\b", texts)
            and not (role.startswith("glass") and f'"{role.removeprefix("glass")}"' in texts)]
    assert idle == []


ANOTHER = "#7A1F5C"
CHANGED = """
import sys
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
import observer_lab
spec = find_spec("observer_lab.colours")
source = Path(spec.origin).read_text(encoding="utf-8")
lines = [k for k, line in enumerate(source.splitlines()) if sys.argv[1] in line]
assert len(lines) == 1, lines
colours = ModuleType("observer_lab.colours")
exec(compile(source.replace(sys.argv[1], sys.argv[2]), spec.origin, "exec"), colours.__dict__)
sys.modules["observer_lab.colours"] = observer_lab.colours = colours

import numpy as np
from observer_lab.course.figures.records import Curve
from observer_lab.export.figures.style import curve_style
from observer_lab.page.charts import charts, matrices
from observer_lab.page.charts.style_sheet import sheet
from observer_lab.page.web.html_page import app_page
from observer_lab.plants.spring_damper import BODY_PARTS
from observer_lab.text import text
curve = Curve(text("x"), np.zeros(3), "plant")
print("CSS", sheet(True, ("f",), True))
print("page", app_page("en").split("<style>")[0])
print("chart", charts._series(curve, "en", "", 1.0))
print("SVG", matrices._blends(np.ones((1, 1))))
print("export", curve_style(curve))
print("stage", [part.colour for part in BODY_PARTS])
"""


def test_the_plants_colour_is_one_line() -> None:
    """Another value in that line is another colour in CSS, chart, drawing, export and on the stage, and the old one is nowhere."""
    told = subprocess.run([sys.executable, "-c", CHANGED, COLOURS["plant"], ANOTHER], capture_output=True, text=True, check=True).stdout
    by_place = dict(line.split(" ", 1) for line in re.split(r"\n(?=CSS|page|chart|SVG|export|stage)", told))
    assert list(by_place) == ["CSS", "page", "chart", "SVG", "export", "stage"]
    for place, said in by_place.items():
        assert ANOTHER.lower() in said.lower().replace("%23", "#"), place
        assert COLOURS["plant"].lower() not in said.lower().replace("%23", "#"), place


@pytest.mark.parametrize("line", ["document.querySelector('.mantine-Paper-root')", ".u-over{}", "window.__viserMutable", "[data-dock-tab]",
                                  "page.messageQueue.push(m)", "{type: 'GuiUpdateMessage'}", ".uplot canvas"])
def test_the_rule_on_visers_page_sees_a_breach(line: str) -> None:
    assert viser_names("a.js", line) and not viser_names("a.js", "gui.add_uplot(viser.uplot.Series()) [data-ol-tab] queue")


def test_the_rule_on_colours_sees_a_breach() -> None:
    assert all(colours_in("a.css", line) for line in ("a{color:#fff}", "a{color:#0072B280}", "a{color:rgba(1,2,3,.5)}"))
    assert all(colours_in("a.py", line) for line in ("x = '#0072B2'", "x = (0, 114, 178)"))
    assert not colours_in("a.py", "'''#0072B2'''\nx = transpose(2, 0, 1), (0, 114), 'issue #12', '&#123;'")
