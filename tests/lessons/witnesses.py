"""Who can say whether a shown sentence is true: computations that do not use what the lesson used.

A witness gets what is shown and the message, and fails with what is the case. Here is what they share: the sentence where it
stands, its numbers, and what the matrices of its run say. Each `witnesses_of_….py` has those of one subject by message;
`claim_trials.py` puts all together.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import expm

from observer_lab.course.figures.records import Figure
from observer_lab.course.lesson import Lesson, Outcome
from observer_lab.engine.simulation import Run
from observer_lab.text import Text

LONGER = 3.0  # times the horizon: a claim about what is to come is tried there


@dataclass(frozen=True)
class Shown:
    """A sentence where it stands: in which figure, None for the live sentence, of which outcome."""

    lesson: Lesson
    outcome: Outcome
    figure: Figure | None

    @property
    def run(self) -> Run:
        run = self.outcome.run
        assert run is not None
        return run

    def __getitem__(self, knob: str) -> Any:
        return self.outcome.design[knob]


Witness = Callable[[Shown, Text], None]
RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
NUMBER = re.compile(r"([+-]?)(?:10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)|(\d+(?:\.\d+)?)(?:·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?)")


def value(words: Text, name: str) -> float:
    """A number that stands in a message."""
    found = dict(words.values)[name]
    return read(str(found)) if not isinstance(found, (int, float)) else float(found)


def read(said: str) -> float:
    """The number at the front of words: −0.25, 10⁴, +7.9·10⁻¹¹."""
    found = NUMBER.match(said.replace("−", "-"))
    assert found, f"no number in {said}"
    sign, power, plain, high = found.groups()
    size = float(plain or 1) * 10.0 ** int((power or high or "0").translate(RAISED))
    return -size if sign == "-" else size


def near(said: float, true: float, relative: float = 1e-6) -> None:
    assert abs(said - true) <= relative * max(abs(true), abs(said)) + 1e-12, f"says {said:.6g}, is {true:.6g}"


# --- the run and what its matrices say ----------------------------------------------------------------------------------
def matrices(run: Run) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A, B, C of the plant, and A − LC, B of what the observer believes."""
    s = run.scenario
    model = s.plant if s.model is None else s.model
    L = np.zeros((s.plant.n, s.plant.p)) if s.L is None else s.L
    return s.plant.A, s.plant.B, s.plant.C, model.A - L @ model.C, model.B


def rightmost(M: np.ndarray) -> float:
    return float(np.max(np.real(np.linalg.eigvals(M))))


def by_itself(run: Run, so_far: bool = False) -> float:
    """How far the run's error leaves e^{(A − LC)t} e(0), over its own peak, or over its largest size so far; kicks start it anew."""
    A, _, _, F, _ = matrices(run)
    jumps = {round(t / run.scenario.dt): jump for t, jump in run.scenario.impulses}
    step = expm((F if A.shape == F.shape else A) * (run.t[1] - run.t[0]))
    e, off = run.e[0], np.zeros(len(run.t))
    for k in range(1, len(run.t)):
        e = step @ e
        if k in jumps or k - 1 in jumps:
            e = run.e[k]
        off[k] = float(np.max(np.abs(e - run.e[k])))
    size = np.maximum.accumulate(np.abs(run.e).max(axis=1))
    return float(np.max(off / np.maximum(size if so_far else size[-1], 1e-12)))


def whole(run: Run) -> np.ndarray:
    """The matrix of (x, x̂)."""
    A, B, C, F, Bm = matrices(run)
    K, L = run.scenario.K, run.scenario.L
    return np.block([[A, -B @ K], [L @ C, F - Bm @ K]])
