"""Draw the figures of both banks: seven tests of one sample, and what pairs of faults show."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, Figure, PlaneFigure, Point, TableFigure
from observer_lab.course.lesson import Outcome
from observer_lab.text import NO_WORDS, Text, joined, listed, same, text

from .fault_pairs import ALWAYS_ISOLABLE, NEVER_ISOLABLE, PAIRS, Pair, isolable, judge_pairs, rank_of, rivals
from .observer_bank import DT, FAULT_PLACES, MEMBER_NAMES, PLACE_NAMES
from .results import Study
from .sensitivity import deaf, least_beside
from .summary import of_pairs, when_talked_about

VERDICT_TAB = text("Verdict")
BAR_WIDTH, HIGHEST = 26.0, 3.0  # px; of the threshold: a bar beyond it ends there with an arrow
PAIR_TAB = text("Two faults")
ALWAYS, NOT_AT_ALL, CURRENT_MARK = "●", "○", "▶"
LARGEST_SHOWN_FAULT = 1000.0  # mm/s or N: what it takes more of is not seen
USUAL = (1, 3)  # HL and HR
Cell = Callable[[int, int], str]


def bank(s: Study, at: int) -> PlaneFigure:
    """A bar for each observer: its test value over the threshold at a sample."""
    values = s.verdict.values[at]
    bars = tuple(Curve(text("alarm") if value > 1 else text("no alarm"), np.array([0.0, min(value, HIGHEST)]),
                       "error" if value > 1 else "plant", "solid", BAR_WIDTH, np.full(2, float(k))) for k, value in enumerate(values))
    line = Curve(text("threshold"), np.ones(3), "reference", "dash", 1.8,
                 np.linspace(-0.6, len(values) - 0.4, 3))
    quiet = [k for k, value in enumerate(values) if value <= 1]
    fits = text("Only the observer that ignores {place} stays below the threshold.", place=PLACE_NAMES[quiet[0]]) if len(quiet) == 1 else (
        text("No observer is above the threshold.") if len(quiet) == len(values) else
        text("Observers above the threshold: {count} of {all}.", count=len(values) - len(quiet), all=len(values)))
    return PlaneFigure("bank", text("test value of each observer at {at:.2f} s", at=DT * at), (*bars, line),
                       tuple(Point(float(k), HIGHEST, "error", "up") for k, value in enumerate(values) if value > HIGHEST),
                       text("the part that the observer ignores"), "T / χ²", (-0.6, len(values) - 0.4), (0.0, 1.05 * HIGHEST),
                       tab=VERDICT_TAB, names=tuple((float(k), same(name[1:])) for k, name in enumerate(MEMBER_NAMES)),
                       caption=fits)


def pair_figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything about two faults at once."""
    return _apart(outcome.study), _bank(outcome)


def _square(cell: Cell, here: Pair | None) -> tuple[tuple[Text | str, ...], ...]:
    """Part against part; the pair that fails now is marked."""
    rows: list[tuple[Text | str, ...]] = []
    for i, name in enumerate(FAULT_PLACES):
        cells = [cell(i, j) for j in range(len(FAULT_PLACES))]
        rows.append((name, *(CURRENT_MARK + c if here in ((i, j), (j, i)) else c for j, c in enumerate(cells))))
    return tuple(rows)


def _columns() -> tuple[Text, ...]:
    return text("fault"), *(same(n) for n in FAULT_PLACES)


def _apart(s: Study) -> TableFigure:
    def cell(i: int, j: int) -> str:
        if i == j:
            return "—"
        pair = (min(i, j), max(i, j))
        kind = isolable(pair)
        return ALWAYS if kind == ALWAYS_ISOLABLE else NOT_AT_ALL if kind == NEVER_ISOLABLE else str(len(rivals()[pair]))
    tied = frozenset(k for pair in PAIRS if isolable(pair) != ALWAYS_ISOLABLE for k in pair)
    told = text("● distinguished from all other pairs, whatever both faults do: with each of them rank [H_P H_Q] = |P ∪ Q|. A number: so "
                "many "
                "other pairs can make the same readings. {names} are {count} directions in a space of {rank}.",
                names=listed(same(FAULT_PLACES[k]) for k in sorted(tied)), count=len(tied), rank=rank_of(tied))
    return TableFigure("pairs", text("which pairs of faults can be isolated"), _columns(), _square(cell, s.pair), told, PAIR_TAB)


def _bank(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study
    v = judge_pairs(s.test, s.record, int(outcome.design["seed"]))
    at = when_talked_about(s, v)

    def cell(i: int, j: int) -> str:
        value = float(s.verdict.values[at, i] if i == j else v.values[at, PAIRS.index((min(i, j), max(i, j)))])
        return f"{value:.2f}" if value < 9.995 else f"{value:.0f}"
    return TableFigure("pair-bank", text("ignoring two parts: T / threshold at {dt:.2f} s", dt=DT * at), _columns(),
                       _square(cell, s.pair), of_pairs(s, v), PAIR_TAB)


# --- how small -------------------------------------------------------------------------------------------------------------
def short(value: float) -> str:
    """The size of a fault in a cell."""
    return "—" if not np.isfinite(value) else f"{value:.2f}" if value < 10 else f"{value:.0f}" if value < LARGEST_SHOWN_FAULT else "∞"


def pair_reach(s: Study, tab: Text) -> TableFigure:
    """The least size of each fault beside each other one, and alone."""
    values = least_beside(s.test, s.case.tone) * np.array([1e3] * 4 + [1.0] * 3)[:, None]

    def cell(i: int, j: int) -> str:
        return short(values[i, j]) + ("*" if i != j and isolable((min(i, j), max(i, j))) != ALWAYS_ISOLABLE else "")
    rows = tuple((same(f"{row[0]} [{'mm/s' if i < 4 else 'N'}]"), *row[1:]) for i, row in enumerate(_square(cell, s.pair)))
    told = text("Bias, or missing amplitude at {tone:.2g} Hz, of the row's fault while the column's fault is arbitrary. On the "
                "diagonal: that fault alone, by the seven. ∞: {most:.0f} or more. *: other pairs can make the same readings.",
                tone=s.case.tone, most=LARGEST_SHOWN_FAULT)
    return TableFigure("least-pairs", text("least fault that the members which ignore other parts all detect with 99 %"),
                       (text("fault"), *(same(n) for n in FAULT_PLACES)), rows, joined(told, _company(s, values)), tab)


def _company(s: Study, values: np.ndarray) -> Text:
    """What the company of the other costs that of the two faults, of the present pair or of HL and HR, which suffers more from it."""
    first, second = s.pair or USUAL
    i, j = (first, second) if values[first, second] / values[first, first] >= values[second, first] / values[second, second] else (
        second, first)
    unseen = text("A lasting lie of {fault} goes unseen beside {other}: the member that ignores {other} and {third} takes it for what "
                  "those two can do.", fault=FAULT_PLACES[i], other=FAULT_PLACES[j], third=FAULT_PLACES[deaf(s.case.tone, i, j)])
    least, times, unit = float(values[i, j]), float(values[i, j] / values[i, i]), "mm/s" if i < 4 else "N"
    seen = text("{fault} is seen beside {other} from {least:.3g} {unit} on, {times:.3g} times what it takes alone.", fault=FAULT_PLACES[i],
                other=FAULT_PLACES[j], least=least, unit=unit, times=times)
    if times <= 1:
        seen = text("{fault} is seen beside {other} from {least:.3g} {unit} on, no more than it takes alone ({alone:.3g} {unit}): "
                    "two residuals have less noise than three.", fault=FAULT_PLACES[i], other=FAULT_PLACES[j], least=least, unit=unit,
                    alone=float(values[i, i]))
    return claim(seen, least, below=LARGEST_SHOWN_FAULT, otherwise=(
        claim(unseen, least, above=LARGEST_SHOWN_FAULT) if i < 4 else NO_WORDS))
