"""Witnesses for faults: who is accused, alarms counted from the residuals by sums written out, the quiet member by the printed table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from scipy.stats import chi2, ncx2
from witnesses import Shown, Witness, near, value

from observer_lab.course.figures.records import TableFigure
from observer_lab.lessons.fault_diagnosis.fault_pairs import PAIRS, pair_bank
from observer_lab.lessons.fault_diagnosis.observer_bank import guard
from observer_lab.text import Text

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
    assert abs(quiet - int(str(dict(words.values).get("quiet", 1)))) <= sum(v == 1 for v in _cells(shown).values()), f"{quiet} are quiet"


SETTLED = 30_000  # samples
FORCES = 5_000


@lru_cache(maxsize=8)
def _left(pairs: bool, fault: int, tone: float) -> np.ndarray:
    """What a lasting 1 m/s, or a sine of 1 N that a coil owes, leaves in each member in the long run: residuals (n_t, members, q)."""
    bank, count = pair_bank() if pairs else guard().bank, SETTLED if fault < 4 else FORCES
    y, u = np.zeros((count, 4)), np.zeros((count, 3))
    if fault < 4:
        y[:, fault] = 1.0
    else:
        u[:, fault - 4] = np.sin(2 * np.pi * tone * STEP * np.arange(count))
    return bank.run(y, u, bank.start(np.zeros(6)))[0][-FORCES // 2:]


def _power(shown: Shown, fault: int, size: float, ignored: frozenset[int]) -> float:
    """With what probability the member that ignores these parts sees a fault of this size, its λ averaged over the phase."""
    pairs, mean, N = len(ignored) == 2, shown["statistic"] == "mean", int(shown["window"])
    found = _left(pairs, fault, shown["tone"])
    rho = size * found[:, PAIRS.index((min(ignored), max(ignored))) if pairs else next(iter(ignored))]
    total = np.vstack([np.zeros(rho.shape[1]), np.cumsum(rho, axis=0)])
    sums = total[N:] - total[:-N]
    lam = float(np.mean(np.sum(sums**2, axis=1)) / N) if mean else float(np.mean(np.sum(rho**2, axis=1)) * N)
    dof = rho.shape[1] * (1 if mean else N)
    return float(ncx2.sf(chi2.isf(shown["rate"], dof), dof, lam))


def _beside(shown: Shown, words: Text) -> None:
    fault, other = (PARTS.index(str(dict(words.values)[name])) for name in ("fault", "other"))
    unit = 1e-3 if fault < 4 else 1.0
    size, values = unit * value(words, "least"), dict(words.values)
    alone = unit * value(words, "alone") if "alone" in values else size / value(words, "times")
    assert (alone >= size * (1 - 1e-9)) == ("alone" in values), "company makes it easier, or harder"
    pairs = min(_power(shown, fault, size, frozenset((other, k))) for k in range(7) if k not in (fault, other))
    seven = min(_power(shown, fault, alone, frozenset((k,))) for k in range(7) if k != fault)
    assert abs(pairs - 0.99) < 0.005 and abs(seven - 0.99) < 0.005, f"seen with {pairs:.4f}, alone with {seven:.4f}"


def _unseen(shown: Shown, words: Text) -> None:
    fault, other, third = (PARTS.index(str(dict(words.values)[name])) for name in ("fault", "other", "third"))
    power = _power(shown, fault, 1.0, frozenset((other, third)))
    assert power < 0.99, f"a lie of 1 m/s is seen with {power:.4f}"
    assert _power(shown, fault, 1.0, frozenset((other,))) > 0.99, "it is no better alone"


WITNESSES: Mapping[str, Witness] = {
    "{who} is correctly identified {delay:.2f} s after it failed.": _rightly,
    "{fault} is seen beside {other} from {least:.3g} {unit} on, {times:.3g} times what it takes alone.": _beside,
    "{fault} is seen beside {other} from {least:.3g} {unit} on, no more than it takes alone ({alone:.3g} {unit}): two residuals have less "
    "noise than three.": _beside,
    "A lasting lie of {fault} goes unseen beside {other}: the member that ignores {other} and {third} takes it for what those two can do.":
        _unseen,
    "With both faults no member gives an alarm for {share:.3g} % of the time.": _most_often(NOBODY),
    "With both faults the alarms fit no row for {share:.3g} % of the time: something fails, but the bank cannot say what.":
        _most_often(UNCLEAR),
    "With both faults the alarms fit the row of {who} for {share:.3g} % of the time: {other} goes unnoticed.": _most_often(None),
    "With both faults the alarms fit the row of {who}, which is healthy, for {share:.3g} % of the time.": _most_often(None),
    "The bank of pairs names {first} and {second} {delay:.2f} s after the second fault, rightly.": _pair,
    "The bank of pairs names no pair: at the end {quiet} of its {count} members are below their threshold, not one.": _no_pair,
    "The bank of pairs names no pair: its one member below the threshold was above it before, or below it too briefly.": _no_pair,
}
