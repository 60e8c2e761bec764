"""Figure kinds and knobs that do not exist: each place names them at once, none takes another branch."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

import pytest
from laws import holds_for_all
from syntax import nodes

from observer_lab.course.figures.records import MAP, Figure, columns
from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Lesson
from observer_lab.course.pinned_designs import figures_with_pins
from observer_lab.course.prose import SECTION_KINDS, ProseError, parse_prose
from observer_lab.course.sentences import figure_parts
from observer_lab.engine import EngineError
from observer_lab.export.data.data import csv_rows, save_csv
from observer_lab.export.data.tables import table
from observer_lab.export.figures.figure import cell_of
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.svg import draw
from observer_lab.plants.examples import example
from observer_lab.plants.own_plant import plant_of
from observer_lab.plants.signal_names import title_of
from observer_lab.text import NO_WORDS, Text, same

APP = Path(__file__).parents[1] / "app"
KINDS = {kind.__name__ for kind in get_args(Figure)}


@dataclass(frozen=True)
class NewFigure:
    """A figure of a kind that nobody draws yet."""

    id: str = "new"
    title: Text = field(default_factory=lambda: same("new"))
    caption: Text = NO_WORDS
    tab: Text = MAP


@pytest.mark.parametrize("use", [
    columns, lambda f: [*figure_parts([f])], lambda f: [*csv_rows([f])], table, lambda f: cell_of(f, "en"), lambda f: draw(f, "en"),
    lambda f: figures_with_pins([f], [])])
def test_a_figure_of_an_unknown_kind_is_named_and_drawn_as_nothing_else(use: Callable[[Any], object]) -> None:
    with pytest.raises(AssertionError, match=r"unreachable.*NewFigure"):
        use(NewFigure())


def test_a_file_of_an_unknown_kind_of_figure_is_not_written_as_another(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match=r"unreachable.*NewFigure"):
        save_csv([NewFigure()], tmp_path / "f.csv")  # type: ignore[list-item]


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
