"""Test conditions (11)–(13) of the paper for each order: can K be reached, what stays free."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, PlaneFigure, Point, TableFigure
from observer_lab.course.lesson import Design, Outcome
from observer_lab.engine import EngineError
from observer_lab.engine.observers import Existence, existence
from observer_lab.text import Text, same, text, text_in

from ..toolkit.latex import pole_words
from .knobs import EXAMPLE_THREE
from .own_loop import Story as OwnStory
from .own_loop import wanted_of
from .own_plant import Here
from .study import EXAMPLE_CASES, Story

LADDER_POLES = (-4.0, -2.5, -6.0, -7.5)  # poles of the orders that the board does not show
ORDERS_TAB = text("Orders")
BAR_PX, NOTHING_MISSED = 34.0, 1e-9  # px across a bar; the share of K that rounding misses
Ladder = tuple[tuple[tuple[complex, ...], Existence], ...]  # the poles of each order and what they allow


@lru_cache(maxsize=16)
def _beside(example: str, order: int) -> Existence:
    """An order of an example that the board does not show."""
    here = EXAMPLE_CASES[example].example
    return existence(here.plant, here.K, LADDER_POLES[:order])


def ladder(design: Design) -> Ladder:
    """Orders 0 (no observer: u = −My) to n, the design's own order with its own poles."""
    case = EXAMPLE_CASES[design["example"]]
    poles = design[case.poles]
    return tuple(
        (tuple(poles), existence(case.example.plant, case.example.K, poles))
        if order == len(poles)
        else (tuple(map(complex, LADDER_POLES[:order])), _beside(design["example"], order))
        for order in range(case.example.plant.n + 1)
    )


@lru_cache(maxsize=16)
def _rung(here: Here, wanted: bytes, poles: tuple[complex, ...]) -> Existence | None:
    row = np.frombuffer(wanted)[None]
    try:
        return existence(here.scaled.inner, row * here.scaled.unit, np.array(poles) / here.scaled.rate)
    except (EngineError, np.linalg.LinAlgError):
        return None


def own_ladder(here: Here, design: Design) -> Ladder:
    """Order 0, the orders that the page offers, each with its poles, and one more than the highest."""
    row = wanted_of(here, design)[1].tobytes()
    offered = [tuple(design[f"poles_{order}"]) for order, _ in here.starts]
    more = (*offered[-1], complex(2 * min(p.real for p in offered[-1])))
    found = ((poles, _rung(here, row, poles)) for poles in ((), *offered, more))
    return tuple((poles, rung) for poles, rung in found if rung is not None)


def _means(rung: Existence) -> Text:
    if not rung.exists:
        return text("K lies outside the rows of T and C: no N, M")
    if not rung.free:
        return text("N and M exist and are fixed")
    return text("N and M exist; {free} free in each row of K", free=rung.free)


def table(rungs: Ladder, order: int, caption: Text, tab: Text) -> TableFigure:
    """The table of the conditions; the page's own order is marked."""
    rows = tuple((f"▸ {r.order}" if r.order == order else str(r.order), pole_words(poles) or "–", str(r.rank), str(r.with_K),
                  "0" if r.missed < NOTHING_MISSED else f"{100 * r.missed:.3g} %", f"{r.rows} − {r.rank} = {r.free}", _means(r))
                 for poles, r in rungs)
    return TableFigure("ranks", text("conditions (11)–(13), order by order"),
                       (text("order"), text("poles"), text_in("robust-observer", "rank r*"), text("with K"), text("K missed by"),
                        text("columns of M′"), text("what it says")), rows, caption=caption, tab=tab)


def paper_ranks(outcome: Outcome[Story], tab: Text) -> TableFigure:
    """The conditions for the example on the page."""
    design, rungs = outcome.design, ladder(outcome.design)
    here = next(r for _, r in rungs if r.order == len(outcome.poles["observer"]))
    said = (text("T itself is T₀ and Q = I in (12): N = (K − M′C)T⁻¹ for every M′, and M = M′. Three rows of rank 2 leave one column.")
            if design["example"] == EXAMPLE_THREE else
            claim(text("The {rows} rows of [T; C] have rank {rank}, and with K no more: N and M exist and are fixed.",
                       rows=here.rows, rank=here.rank), float(here.missed), below=1e-9))
    return table(rungs, here.order, said, tab)


def own_ranks(here: Here, outcome: Outcome[OwnStory], order: int, tab: Text) -> TableFigure:
    """The conditions for a person's own plant."""
    rungs = own_ladder(here, outcome.design)
    return table(rungs, order, text("Order 0 is the readings alone, My. As soon as the rank with K is no higher, an observer exists; rows "
                                    "of [T; C] beyond their rank leave M′ free. Each order has the poles of its own knob; an order without "
                                    "one has a pole more."), tab)


def missed_figure(rungs: Ladder, order: int) -> PlaneFigure:
    """The share of K that each order misses; a circle stands where an observer exists."""
    shares = [0.0 if r.exists else 100 * float(r.missed) for _, r in rungs]
    bars = tuple(Curve(text("missed"), np.array([0.0, share]), "error", "solid", BAR_PX, np.full(2, float(k)))
                 for k, share in enumerate(shares) if share)
    points = tuple(Point(float(k), 4.0, "right", "circle", text("exists")) for k, (_, r) in enumerate(rungs) if r.exists)
    names = tuple((float(k), same(f"▸ {r.order}" if r.order == order else str(r.order))) for k, (_, r) in enumerate(rungs))
    least = next((r.order for _, r in rungs if r.exists), None)
    said = (text("The least order with an observer is {least}.", least=least) if least is not None else
            text("None of these orders gives all of K."))
    return PlaneFigure("missed", text("share of K that each order misses"), bars, points, text("order"), text("K missed [%]"),
                       (-0.6, len(rungs) - 0.4), (0.0, 100.0), tab=ORDERS_TAB, names=names, caption=said)


def paper_missed(outcome: Outcome[Story]) -> PlaneFigure:
    """For the example on the page."""
    return missed_figure(ladder(outcome.design), len(outcome.poles["observer"]))
