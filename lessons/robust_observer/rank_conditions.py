"""Test conditions (11)–(13) of the paper for each order: can K be reached, what stays free."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from observer_lab.course.figures.records import Curve, PlaneFigure, Point, TableFigure
from observer_lab.course.lesson import Design, Outcome
from observer_lab.engine import EngineError, Plant
from observer_lab.engine.observers import Existence, existence
from observer_lab.text import Text, same, text, text_in

from ..toolkit.latex import pole_words
from .loop import S, Setting

ORDERS_TAB = text("Orders")
BAR_PX, NOTHING_MISSED = 34.0, 1e-9  # px across a bar; the share of K that rounding misses
Ladder = tuple[tuple[tuple[complex, ...], Existence], ...]  # the poles of each order and what they allow


@lru_cache(maxsize=32)
def _rung(plant: Plant, row: bytes, poles: tuple[complex, ...]) -> Existence | None:
    try:
        return existence(plant, np.frombuffer(row)[None], poles)
    except (EngineError, np.linalg.LinAlgError):
        return None


def ladder(here: Setting, design: Design) -> Ladder:
    """Orders from 0 (no observer: u = −My) on, each with its poles."""
    plant, row, rate = here.inner(design)
    found = ((tuple(poles), _rung(plant, row.tobytes(), tuple(np.array(poles, dtype=complex) / rate))) for poles in here.orders(design))
    return tuple((poles, rung) for poles, rung in found if rung is not None)


def _means(rung: Existence) -> Text:
    if not rung.exists:
        return text("K lies outside the rows of T and C: no N, M")
    if not rung.free:
        return text("N and M exist and are fixed")
    return text("N and M exist; {free} free in each row of K", free=rung.free)


def ranks(here: Setting[S], outcome: Outcome[S], tab: Text, said: Callable[[Design, Existence], Text]) -> TableFigure:
    """The table of the conditions, with what is said of the page's own order; that one is marked."""
    rungs, order = ladder(here, outcome.design), len(outcome.poles["observer"])
    rows = tuple((f"▸ {r.order}" if r.order == order else str(r.order), pole_words(poles) or "–", str(r.rank), str(r.with_K),
                  "0" if r.missed < NOTHING_MISSED else f"{100 * r.missed:.3g} %", f"{r.rows} − {r.rank} = {r.free}", _means(r))
                 for poles, r in rungs)
    chosen = next(r for _, r in rungs if r.order == order)
    return TableFigure("ranks", text("conditions (11)–(13), order by order"),
                       (text("order"), text("poles"), text_in("robust-observer", "rank r*"), text("with K"), text("K missed by"),
                        text("columns of M′"), text("what it says")), rows, caption=said(outcome.design, chosen), tab=tab)


def missed(here: Setting[S], outcome: Outcome[S]) -> PlaneFigure:
    """The share of K that each order misses; a circle stands where an observer exists."""
    rungs, order = ladder(here, outcome.design), len(outcome.poles["observer"])
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

