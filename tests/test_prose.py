"""The form of a lesson's words: what is read, what is missing, what the page can draw."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from laws import each

import lessons
from observer_lab.course.prose import ExamWords, ProseError, parse_prose, read_prose
from observer_lab.page.words import phrases
from observer_lab.page.words.prose import mathml, render_markdown, with_minus
from observer_lab.text import Text, same, text

GOOD = """# A title
> A question
> over two lines?
Some $x$ words.

A second paragraph.
## predict
What happens?
- one
  > not one
  > for $x > 1$
- two
  goes on
- three
  > nor three
### reveal
It was so.
## step First: with a colon
Text of the first.
## step Second
- a list
- in a step
## task do-it: Do it
The statement.
- hint one
- hint two
### solution
The solution.
## exam square: The square
What is $[[a]]$ in $x^{2}$?
### derivation
$$[[a]]^2=[[answer]]$$
## source
Here.
"""


def test_every_part_is_read() -> None:
    prose = parse_prose(GOOD)
    assert (prose.title, prose.question) == ("A title", "A question over two lines?")
    assert prose.introduction == "Some $x$ words.\n\nA second paragraph."
    assert (prose.predict, prose.options, prose.reveal) == ("What happens?", ("one", "two goes on", "three"), "It was so.")
    assert prose.refutations == ("not one for $x > 1$", "", "nor three")
    assert prose.steps == (("First: with a colon", "Text of the first."), ("Second", "- a list\n- in a step"))
    task = prose.tasks["do-it"]
    assert (task.title, task.statement, task.hints, task.solution) == (
        "Do it", "The statement.", ("hint one", "hint two"), "The solution.")
    assert prose.exams == {"square": ExamWords("The square", "What is $[[a]]$ in $x^{2}$?", "$$[[a]]^2=[[answer]]$$")}
    assert prose.source == "Here."


@each("lost, name", [("> A question\n> over two lines?\n", "question"), ("What happens?\n", "predict"),
                     ("It was so.\n", "reveal"), ("## source\nHere.\n", "source"),
                     ("Some $x$ words.\n\nA second paragraph.\n", "introduction")])
def test_what_is_missing_is_named(lost: str, name: str) -> None:
    assert lost in GOOD
    with pytest.raises(ProseError, match=rf"lesson/en.md has no {name}"):
        parse_prose(GOOD.replace(lost, ""), "lesson/en.md")


def test_a_section_that_does_not_exist_is_named() -> None:
    with pytest.raises(ProseError, match="## wonder about"):
        parse_prose(GOOD + "## wonder about\nx\n")


@each("text", ["", "no title", "## predict\nx"])
def test_a_file_begins_with_its_title(text: str) -> None:
    with pytest.raises(ProseError, match="# title"):
        parse_prose(text)


def test_windows_line_ends_are_line_ends(tmp_path) -> None:
    (tmp_path / "en.md").write_bytes(GOOD.replace("\n", "\r\n").encode())
    assert read_prose(tmp_path)["en"] == parse_prose(GOOD)


def test_a_language_reads_its_own_file_and_english_where_it_has_none(tmp_path) -> None:
    folder = Path(lessons.__file__).parent / "separation"
    assert read_prose(folder)["zh"].title != read_prose(folder)["en"].title
    (tmp_path / "en.md").write_text(GOOD, encoding="utf-8")
    words = read_prose(tmp_path)
    assert words["zh"] == words["en"] == parse_prose(GOOD)


# --- drawing -------------------------------------------------------------------------------------------------------
@each("latex, pieces", [
    (r"\dot e=(A-LC)e", ["<mi>e</mi>", "<mi>A</mi>", "<mi>L</mi>"]),
    (r"\begin{bmatrix} 1 & 0 \\ 2 & -3 \end{bmatrix}", ["<mtable", "<mtr>", "<mn>3</mn>"]),
    (r"\hat{x}", ["<mover"]), (r"\frac{d}{dt}", ["<mfrac>"]), (r"u_{\max}", ["<msub>"]),
    (r"\color{#D55E00}{12}", ["#D55E00", "<mn>12</mn>"]),
])
def test_formulas_become_mathml(latex: str, pieces: list[str]) -> None:
    drawn = mathml(latex)
    assert drawn.startswith("<math") and "<code>" not in drawn and "\\" not in drawn
    for piece in pieces:
        assert piece in drawn, drawn


def test_display_and_inline_formulas_differ_only_in_their_display() -> None:
    assert 'display="block"' in mathml("x", True) and 'display="inline"' in mathml("x")
    assert render_markdown("a $x$ b") == f"a {mathml('x')} b"
    assert render_markdown("a $$x$$ b") == f"a {mathml('x', True)} b"


def test_a_formula_that_cannot_be_drawn_is_shown_as_its_source_and_not_as_markup() -> None:
    drawn = mathml(r"\frac{1}{")
    assert drawn.startswith("<code>") and r"\frac" in drawn
    dangerous = mathml(r"\left( <b>x</b> \frac{")
    assert "<b>" not in dangerous


def test_markdown_without_formulas_stays_as_it_is() -> None:
    assert render_markdown("**bold** and <kbd>k</kbd>") == "**bold** and <kbd>k</kbd>"


# --- words of the frame --------------------------------------------------------------------------------------------
FRAME = {name: value for name, value in vars(phrases).items() if isinstance(value, Text)}


@each("name", FRAME)
def test_the_words_of_the_frame_are_there_in_both_languages(name: str) -> None:
    text = FRAME[name]
    assert text("en").strip() and text("zh").strip()
    assert not re.search(r"[\u4e00-\u9fff]", text("en"))
    assert re.search(r"[\u4e00-\u9fff]", text("zh")) or not re.search("[A-Za-z]{2,}", text("en"))
    assert re.findall(r"\{.*?\}", text("en")) == re.findall(r"\{.*?\}", text("zh"))


def test_a_text_speaks_the_language_asked_for() -> None:
    assert (text("Nothing to undo.")("en"), text("Nothing to undo.")("zh")) == ("Nothing to undo.", "没有可以撤销的操作。")
    assert same("x")("zh") == "x"


@each(("plain", "set_"), [
    ("the rightmost pole is -0.0011 rad/s", "the rightmost pole is −0.0011 rad/s"), ("-2 or (-.5, -3j)", "−2 or (−.5, −3j)"),
    ("最右极点为 -3，增益（-4）", "最右极点为 −3，增益（−4）"),
    ("1e-05 of 3-4 low-order 2-D <b class=a-1>", "10⁻⁵ of 3-4 low-order 2-D <b class=a-1>"),
    ("6.3e+04 nm, 1.2e+02 %, -9.2e-06 at +7.9e−11, 6.7e4", "63000 nm, 120 %, −9.2·10⁻⁶ at +7.9·10⁻¹¹, 67000"),
    ("1e+05 and 2.50e-03, e-fold, 0x1e5, be2", "10⁵ and 0.00250, e-fold, 0x1e5, be2"),
])
def test_numbers_are_written_with_a_minus_and_powers_of_ten(plain: str, set_: str) -> None:
    assert with_minus(plain) == set_


@pytest.mark.parametrize(("latex", "accents"), [(r"\dot x", 1), (r"\hat x", 1), (r"\dot{\hat x}=A\hat x", 3), (r"\ddot z", 1),
                                                (r"\tilde x", 1), (r"\bar y", 1), (r"x^2", 0)])
def test_what_stands_above_a_letter_is_an_accent(latex: str, accents: int) -> None:
    drawn = mathml(latex)
    assert drawn.count('<mover accent="true">') == drawn.count("<mover") == accents
