"""Figures about two faults: which pairs can be told apart at all, and what a bank of pairs says of this run."""

from __future__ import annotations

from collections.abc import Callable

from app.lesson.figures import Figure, TableFigure
from app.lesson.lesson import Outcome
from app.text import Text, listed, same, text

from .bank import DT, PLACES
from .pairs import NEVER, PAIRS, SURE, Pair, isolable, judge_pairs, rank_of, rivals
from .record import Study
from .words import of_pairs, when_talked_about

PAIR_TAB = text("Two faults")
ALWAYS, NOT_AT_ALL, HERE = "●", "○", "▶"
Cell = Callable[[int, int], str]


def pair_figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything about two faults at once."""
    return _apart(outcome.study), _bank(outcome)


def _square(cell: Cell, here: Pair | None) -> tuple[tuple[Text | str, ...], ...]:
    """Part against part; the pair that fails now is marked."""
    rows: list[tuple[Text | str, ...]] = []
    for i, name in enumerate(PLACES):
        cells = [cell(i, j) for j in range(len(PLACES))]
        rows.append((name, *(HERE + c if here in ((i, j), (j, i)) else c for j, c in enumerate(cells))))
    return tuple(rows)


def _columns() -> tuple[Text, ...]:
    return text("fault"), *(same(n) for n in PLACES)


def _apart(s: Study) -> TableFigure:
    def cell(i: int, j: int) -> str:
        if i == j:
            return "—"
        pair = (min(i, j), max(i, j))
        kind = isolable(pair)
        return ALWAYS if kind == SURE else NOT_AT_ALL if kind == NEVER else str(len(rivals()[pair]))
    tied = frozenset(k for pair in PAIRS if isolable(pair) != SURE for k in pair)
    told = text("● told from all other pairs, whatever both faults do: with each of them rank [H_P H_Q] = |P ∪ Q|. A number: so many "
                "other pairs can make the same readings. {names} are {count} directions in a space of {rank}.",
                names=listed(same(PLACES[k]) for k in sorted(tied)), count=len(tied), rank=rank_of(tied))
    return TableFigure("pairs", text("which pairs of faults can be told apart"), _columns(), _square(cell, s.pair), told, PAIR_TAB)


def _bank(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study
    v = judge_pairs(s.test, s.record, int(outcome.design["seed"]))
    at = when_talked_about(s, v)

    def cell(i: int, j: int) -> str:
        value = float(s.verdict.values[at, i] if i == j else v.values[at, PAIRS.index((min(i, j), max(i, j)))])
        return f"{value:.2f}" if value < 9.995 else f"{value:.0f}"
    return TableFigure("pair-bank", text("ignoring two parts: T / threshold at {dt:.2f} s", dt=DT * at), _columns(),
                       _square(cell, s.pair), of_pairs(s, v), PAIR_TAB)
