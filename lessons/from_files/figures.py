"""Draw the figures of a lesson file by their kind: state, output, error, input, innovation, poles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.figures.records import Curve, Figure, LineFigure, PlaneFigure, Point
from observer_lab.course.lesson import Outcome
from observer_lab.course.reading.toml_table import Table
from observer_lab.plants.model import Model
from observer_lab.text import Text, same, text

from ..toolkit.figures import TIME_TAB, error_figure, input_figure
from .plant_source import PlantSource
from .study import Study

KINDS = ("state", "output", "error", "input", "innovation", "poles")
FIGURE_KEYS = ("kind", "of", "title", "id")
POLES_TAB = text("Poles")
Draw = Callable[[Outcome[Study]], Figure]


def read_figures(top: Table, source: PlantSource) -> tuple[Draw, ...]:
    """`[[figures]]`, in their order; the error where the file names none. Raises LessonFileError."""
    draws = [_figure(table.only(*FIGURE_KEYS), source) for table in top.tables("figures")]
    return tuple(draws) or (partial(_error, "error"),)


def figure_ids(top: Table) -> tuple[str, ...]:
    """The ids of the figures; that of a figure without one is its kind, with the signal it is of."""
    return tuple(_id(table) for table in top.tables("figures")) or ("error",)


def draw_all(draws: Sequence[Draw], outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Every figure of an outcome."""
    return tuple(draw(outcome) for draw in draws)


def _id(table: Table) -> str:
    of = table.words("of", "")
    return table.words("id", f"{table.words('kind')}-{of}".rstrip("-"))


def _figure(table: Table, source: PlantSource) -> Draw:
    plant, kind, id = source.model.plant, table.one_of("kind", KINDS), _id(table)
    names = {"state": plant.state_names, "output": plant.output_names, "innovation": plant.output_names}.get(kind, ())
    index = names.index(table.one_of("of", names, names[0])) if names else 0
    unit = plant.unit(names[index]) if names else ""
    name = same(names[index]) if names else same("")
    drawn: Draw
    match kind:
        case "state":
            drawn = partial(_pair, id, name, unit, index, "state")
        case "output":
            drawn = partial(_pair, id, name, unit, index, "output")
        case "innovation":
            drawn = partial(_innovation, id, unit, index)
        case "input":
            drawn = partial(_input, id, source.model)
        case "poles":
            drawn = partial(_poles, id)
        case _:
            drawn = partial(_error, id)
    title = table.label("title", "")
    return (lambda outcome: replace(drawn(outcome), title=title)) if title.id else drawn


def _pair(id: str, name: Text, unit: str, index: int, kind: str, outcome: Outcome[Study]) -> Figure:
    run = outcome.study.run
    true, guess = (run.x, run.xhat) if kind == "state" else (run.y, run.yhat)
    measured = text("true") if kind == "state" else text("measured")
    return LineFigure(id, name, run.t, (Curve(measured, true[:, index]), Curve(text("estimate"), guess[:, index], "estimate", "dash")),
                      f"[{unit}]" if unit else "", tab=TIME_TAB)


def _innovation(id: str, unit: str, index: int, outcome: Outcome[Study]) -> Figure:
    run = outcome.study.run
    return LineFigure(id, text("innovation"), run.t, (Curve(same("y − ŷ"), run.y[:, index] - run.yhat[:, index], "error"),),
                      f"[{unit}]" if unit else "", tab=TIME_TAB)


def _error(id: str, outcome: Outcome[Study]) -> Figure:
    return replace(error_figure(outcome.study.run), id=id, tab=TIME_TAB)


def _input(id: str, model: Model, outcome: Outcome[Study]) -> Figure:
    return replace(input_figure(outcome.study.run, model), id=id, tab=TIME_TAB)


def _poles(id: str, outcome: Outcome[Study]) -> Figure:
    roles = {"observer": "estimate", "controller": "plant"}
    points = tuple(Point(float(p.real), float(p.imag), roles[name]) for name, poles in outcome.poles.items() for p in poles)
    size = max(1e-9, *(max(abs(p.x), abs(p.y)) for p in points))
    right = max(0.3 * size, *(1.1 * p.x for p in points))
    return PlaneFigure(id, text("poles"), points=points, x_label="Re", y_label="Im", x_range=(-1.2 * size, right),
                       y_range=(-1.2 * size, 1.2 * size), unstable=True, tab=POLES_TAB, caption=_rightmost(outcome))


def _rightmost(outcome: Outcome[Study]) -> Text:
    return text("The rightmost observer pole is at {pole:.3g} per second.", pole=float(np.max(outcome.poles["observer"].real)))
