"""Figure kinds and knobs that do not exist: each place names them at once, none takes another branch."""

from __future__ import annotations

import ast
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

import pytest
from laws import holds_for_all
from syntax import nodes

from observer_lab.course.figures.figure_record import Entry, FigureRecord, Part, Sheet
from observer_lab.course.figures.records import MAP, Figure, LineFigure
from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Lesson
from observer_lab.course.pinned_designs import figures_with_pins
from observer_lab.course.prose import SECTION_KINDS, ProseError, parse_prose
from observer_lab.course.sentences import figure_parts
from observer_lab.engine import EngineError
from observer_lab.export.data.data import figure_csv, figure_json, save_csv
from observer_lab.export.figures.figure import cell_of, draw_page
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.svg import draw
from observer_lab.plants.examples import example
from observer_lab.plants.own_plant import plant_of
from observer_lab.plants.signal_names import title_of
from observer_lab.text import NO_WORDS, Text, same

APP = Path(__file__).parents[1] / "app"
KINDS = {kind.__name__ for kind in get_args(Figure)}


DRAWINGS = {"page/charts/svg.py", "export/figures/figure.py"}  # the modules that draw a figure by its kind


@dataclass(frozen=True)
class NewFigure(FigureRecord):
    """A figure of a kind that nobody draws yet: one number."""

    id: str = "new"
    title: Text = field(default_factory=lambda: same("new"))
    caption: Text = NO_WORDS
    tab: Text = MAP
    kind = "number"

    def axes(self, language: str = "en") -> tuple[str, str]:
        return "", "height [m]"

    def table(self, language: str = "en") -> Sheet:
        return ["height [m]"], [(0.5,)]

    def entries(self) -> Iterator[Entry]:
        yield "height", 0.0, 0.5, ""

    def parts(self) -> Iterator[Part]:
        yield "y", same("height [m]")


def samples() -> dict[str, Figure]:
    """A figure of each kind, as the lessons draw them at their start."""
    found: dict[str, Figure] = {}
    for lesson in LESSONS.values():
        for figure in lesson.figures(lesson.compute(lesson.start())):
            found.setdefault(type(figure).__name__, figure)
        if set(found) == KINDS:
            break
    return found


def test_a_kind_that_lacks_an_answer_cannot_be_made() -> None:
    asked = FigureRecord.__abstractmethods__
    assert asked == {"kind", "axes", "table", "entries", "parts"}
    for name in asked:
        lacking = type("Lacking", (NewFigure,), {name: getattr(FigureRecord, name)})
        with pytest.raises(TypeError, match=rf"abstract method '?{name}'?"):
            lacking()


def test_a_new_kind_is_told_in_every_file_and_sentence_by_its_record_alone(tmp_path: Path) -> None:
    new: Any = NewFigure()
    save_csv([new], tmp_path / "f.csv")
    assert (tmp_path / "f.csv").read_text(encoding="utf-8").splitlines()[1] == "new,number,height,0.0,0.5,,,height [m]"
    assert figure_csv(new, "x").decode() == "# Observer Lab, state x\nheight [m]\n0.5\n"
    assert json.loads(figure_json(new, "x"))["rows"] == [[0.5]]
    assert [where for where, _ in figure_parts([new])] == [f"figure.new.{part}" for part in ("tab", "title", "caption", "y")]
    assert figures_with_pins([new], []) == (new,)


def test_every_kind_is_drawn_on_the_page_and_in_an_export() -> None:
    """A kind that is added to `Figure` and drawn nowhere ends in assert_never here."""
    found = samples()
    assert set(found) == KINDS
    for figure in found.values():
        assert draw_page([figure], "en").axes
        assert isinstance(figure, LineFigure) or "ol-figure" in draw(figure, "en")


@pytest.mark.parametrize("use", [lambda f: cell_of(f, "en"), lambda f: draw(f, "en")])
def test_a_figure_of_an_unknown_kind_is_named_and_drawn_as_nothing_else(use: Callable[[Any], object]) -> None:
    with pytest.raises(AssertionError, match=r"unreachable.*NewFigure"):
        use(NewFigure())


def test_a_new_kind_touches_its_record_and_the_two_drawings_alone() -> None:
    """No other module of the app asks for each of the kinds."""
    asking = {path.relative_to(APP).as_posix() for path in APP.rglob("*.py") for node in nodes(path.read_text(encoding="utf-8"))
              if isinstance(node, ast.Match) and KINDS & set(ast.unparse(node).replace("(", " ").split())}
    assert asking == DRAWINGS


def test_what_differs_by_the_kind_of_a_figure_is_a_match_that_ends_in_assert_never() -> None:
    """A function that asks for two kinds by isinstance, or matches without an end, forgets the next kind in silence."""
    wrong = []
    for path in sorted(APP.rglob("*.py")):
        for node in nodes(path.read_text(encoding="utf-8")):
            if isinstance(node, ast.FunctionDef):
                asked = {name.id for call in ast.walk(node) if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "isinstance"
                         for name in ast.walk(call.args[1]) if isinstance(name, ast.Name) and name.id in KINDS}
                matched = [m for m in ast.walk(node) if isinstance(m, ast.Match) and KINDS & set(ast.unparse(m).replace("(", " ").split())]
                open_ended = [m for m in matched if not ast.unparse(m.cases[-1]).lstrip().startswith("case _:\n    assert_never(")]
                wrong += [f"{path.relative_to(APP)}:{node.lineno} {node.name}"] * (len(asked) > 1 or bool(open_ended))
    assert wrong == []


def test_a_section_of_an_unknown_kind_is_named_beside_those_that_exist() -> None:
    with pytest.raises(ProseError, match=f"has a section '## song of joy'; use {', '.join(SECTION_KINDS[:-1])} or {SECTION_KINDS[-1]}"):
        parse_prose("# title\n> question?\nintroduction\n## song of joy\nla")


def variants(lesson: Lesson) -> list[Lesson]:
    """The lesson and what it becomes on a linear and on a bilinear example plant, where it takes them."""
    found = [lesson]
    for name in ("motor", "exchanger") if lesson.adapt is not None else ():
        try:
            found.append(lesson.fit(example(name)))
        except (EngineError, KnobError):
            continue
    return found


def test_a_missing_knob_is_named_with_its_lesson_and_the_plant_that_it_was_adapted_to() -> None:
    def named(lesson: Lesson) -> None:
        design, knobs = lesson.start(), ", ".join(knob.name for knob in lesson.knobs)
        whose = f", adapted to {title_of(plant_of(lesson.plant))('en')}," if lesson.plant else ""
        for use in (lambda: design["no_such"], lambda: design.with_values(no_such=1), lambda: lesson.apply(design, {"no_such": 1}),
                    lambda: lesson.knob("no_such")):
            with pytest.raises(KnobError) as caught:
                use()
            assert str(caught.value) == f"Lesson {lesson.id}{whose} has no knob no_such; it has {knobs}."
    own = [variant for lesson in LESSONS.values() for variant in variants(lesson)]
    assert any(variant.plant for variant in own)
    holds_for_all(own, named, lambda lesson: f"{lesson.id} {lesson.plant[:60]}")
