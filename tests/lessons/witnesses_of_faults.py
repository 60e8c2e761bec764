"""Witnesses for faults: who is accused, alarms counted from the residuals by sums written out, the quiet member by the printed table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np
from scipy.stats import chi2
from witnesses import Shown, Witness, near, value

from app.lesson.figures import TableFigure
from app.text import Text

PARTS = ("VL", "HL", "VR", "HR", "u1", "u2", "u3")
STEP = 0.02  # s
NOBODY, UNCLEAR = "nobody", "unclear"


def _rightly(shown: Shown, words: Text) -> None:
    assert dict(words.values)["who"] in (shown["place"], shown["place2"]) and value(words, "delay") > 0


def _rows(shown: Shown) -> list[str]:
    """Of each window that lies behind both faults: the part whose member alone is quiet, nobody or unclear."""
    N, mean, rho = int(shown["window"]), shown["statistic"] == "mean", shown.outcome.study.record.residuals
    bound, found = chi2.isf(shown["rate"], 3 if mean else 3 * N), []
    for k in range(round(max(shown["at"], shown["at2"]) / STEP) + N - 1, len(rho)):
        part = rho[k - N + 1:k + 1]
        T = (part.sum(axis=0) ** 2).sum(axis=1) / N if mean else (part ** 2).sum(axis=(0, 2))
        quiet = np.flatnonzero(bound >= T)
        found.append(NOBODY if len(quiet) == 7 else PARTS[quiet[0]] if len(quiet) == 1 else UNCLEAR)
    return found


def _most_often(said: str | None) -> Witness:
    def witness(shown: Shown, words: Text) -> None:
        counted, values = Counter(_rows(shown)), dict(words.values)
        row = said or str(values["who"])
        near(value(words, "share"), 100 * counted[row] / counted.total())
        assert counted[row] == max(counted.values()), f"{row} is not what is said most of the time: {counted}"
        if said is None:
            assert (row in (shown["place"], shown["place2"])) == ("other" in values), f"{row} with {shown['place']}, {shown['place2']}"
    return witness


def _cells(shown: Shown) -> dict[frozenset[str], float]:
    """T over threshold of each member that ignores two parts, as the table prints it."""
    figure = shown.figure
    assert isinstance(figure, TableFigure)
    return {frozenset((PARTS[i], PARTS[j])): float(str(figure.rows[i][j + 1]).removeprefix("▶")) for i in range(7) for j in range(i)}


def _pair(shown: Shown, words: Text) -> None:
    named, cells = frozenset(str(dict(words.values)[k]) for k in ("first", "second")), _cells(shown)
    assert named == {shown["place"], shown["place2"]} and value(words, "delay") > 0
    assert cells[named] <= 1 <= min(v for pair, v in cells.items() if pair != named), "another member is as quiet"


def _no_pair(shown: Shown, words: Text) -> None:
    quiet = sum(v < 1 for v in _cells(shown).values())
    assert abs(quiet - dict(words.values).get("quiet", 1)) <= sum(v == 1 for v in _cells(shown).values()), f"{quiet} are quiet"


WITNESSES: Mapping[str, Witness] = {
    "{who} is accused {delay:.2f} s after it failed, rightly.": _rightly,
    "With both faults no member gives an alarm for {share:.0f} % of the time.": _most_often(NOBODY),
    "With both faults the alarms fit no row for {share:.0f} % of the time: something fails, but the bank cannot say what.":
        _most_often(UNCLEAR),
    "With both faults the alarms fit the row of {who} for {share:.0f} % of the time: {other} goes unnoticed.": _most_often(None),
    "With both faults the alarms fit the row of {who}, which is healthy, for {share:.0f} % of the time.": _most_often(None),
    "The bank of pairs names {first} and {second} {delay:.2f} s after the second fault, rightly.": _pair,
    "The bank of pairs names no pair: at the end {quiet} of its {count} members are quiet, not one.": _no_pair,
    "The bank of pairs names no pair: its one quiet member at the end was not quiet before, or too briefly.": _no_pair,
}
