"""The page's own scripts and styles are files of their own, and what Python tells them goes in as JSON."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path
from string import Template

import pytest
from hypothesis import given
from hypothesis import strategies as st

from observer_lab.colours import COLOURS
from observer_lab.page import web
from observer_lab.page.charts.style_sheet import sheet
from observer_lab.page.record.published_page import published_page, questions_page
from observer_lab.page.replay import replay
from observer_lab.page.screen.page_setup import PAGE_SCRIPTS
from observer_lab.page.votes.lecture_sheet import sheet_html
from observer_lab.page.web.html_page import app_page

VIEW = Path(web.FOLDER).parent
SCRIPTS = sorted(file.stem for file in web.FOLDER.glob("*/*.js"))
STYLES = sorted(file.name for file in web.FOLDER.glob("*/*.css"))
FUNCTION = re.compile(r"(?:// .*\n)+\((?:\{([\w, ]+)\})?\) => \{\n.*\n\}\n", re.S)
CODE = re.compile(r"\b(document|window|localStorage|sessionStorage)\.\w|=>\s*\{|\bfunction\s*\(|[\w-]+\s*\{[a-z-]{2,}:[^}]*\}")


def calls() -> dict[str, set[str]]:
    """Script → the names of what it is given, at every place of app/page that calls one."""
    out: dict[str, set[str]] = {}
    for file in VIEW.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("run_script", "viser_internals.run_script", "web.script_call"):
                for name in [a.value for a in node.args if isinstance(a, ast.Constant)]:
                    out.setdefault(name, set()).update(k.arg for k in node.keywords if k.arg)
    return out | {name: set() for name in PAGE_SCRIPTS} | {"apart": {"script"}}  # which holds another


def test_every_script_is_called_with_just_what_it_takes() -> None:
    assert sorted(calls()) == SCRIPTS
    for name, given_names in calls().items():
        found = FUNCTION.fullmatch(web.file_text(f"{name}.js"))
        assert found, f"{name}.js is one function under a line that says what it does"
        assert {word.strip() for word in (found[1] or "").split(",")} - {""} == given_names, name


@pytest.mark.parametrize("name", STYLES)
def test_every_style_is_used_and_closed(name: str) -> None:
    text = Template(web.file_text(name)).safe_substitute(COLOURS)
    pages = app_page("en") + replay.style() + published_page(["en"], [], [], "") + sheet_html((), {}, "en") + questions_page({}, "en", "")
    assert text.strip() in sheet(True, ("$figure",), True) + pages
    assert text.count("{") == text.count("}") and "<" not in text and "%(" not in text


def test_the_sheet_says_what_is_asked() -> None:
    plain, large, veiled, both = (sheet(hall, figures) for figures in ((), ("f",)) for hall in (False, True))
    veil = Template(web.file_text("veil.css")).substitute(figure="f")
    assert len({plain, large, veiled, both}) == 4
    assert plain == large.replace(web.file_text("lecture.css"), "") and veil in veiled and veil in both and "blur" not in plain


@given(st.text(), st.text())
def test_what_a_script_is_given_arrives_as_it_was_and_ends_nothing(key: str, text: str) -> None:
    source = web.script_call("remember", key=key, text=text)
    code = web.file_text("remember.js")
    assert source.startswith(f"// remember.js\n(\n{code})(") and source.endswith(")")
    argument = source.removeprefix(f"// remember.js\n(\n{code})(").removesuffix(")")
    assert json.loads(argument) == {"key": key, "text": text}
    assert not re.search("[<\u2028\u2029\n]", argument)


def test_no_script_and_no_style_sheet_stands_in_python() -> None:
    found = []
    for file in sorted(VIEW.rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        words = {id(d.value) for n in ast.walk(tree) if isinstance(n, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef))
                 for d in n.body[:1] if isinstance(d, ast.Expr)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in words and CODE.search(node.value):
                found.append(f"{file.name}:{node.lineno}: {node.value[:60]}")
    assert not found, found


@pytest.mark.parametrize("code", ["document.title = x", "(() => {", "function (a) {}", ".ol{color:red}", "sessionStorage.setItem(1)"])
def test_the_rule_on_code_in_python_sees_a_breach(code: str) -> None:
    assert CODE.search(code)
    assert not CODE.search('<div class="ol-note">the document. A window (x) {0}</div> {title: x}')


def test_what_has_the_colours_of_the_day_alone_is_styled_in_no_sheet_with_themes() -> None:
    """A rule of the page that stands before the app, in fixed colours, would paint what the app calls the same, in the dark too."""
    sheets = {path.name: path.read_text("utf-8") for path in (Path(web.__file__).parent / "styles").glob("*.css")}
    coloured = "".join(re.findall(r"([^{}]+)\{[^}]*\$\w+", sheets.pop("link.css")))
    fixed, themed = (set(re.findall(r"\.(ol-[\w-]+)", words)) for words in (coloured, "".join(sheets.values())))
    assert len(fixed) >= 3 and fixed & themed == set()
