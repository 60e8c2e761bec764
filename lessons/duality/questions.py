"""Draw the questions of lesson 5: a matrix, a transposed gain, a turned sensor."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Point
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_poles
from observer_lab.engine import observer_gain
from observer_lab.engine.systems import sorted_poles
from observer_lab.text import NO_WORDS, same, symbol, text

FASTER = 2.0  # times the controller's pace: an observer whose poles cannot be taken for those of the controller
OF_K, OF_L = ((text("the run: {gain}", gain="K"), "plant"),), ((text("the run: {gain}", gain="L"), "estimate"),)
SCALED = 0.5  # a factor that an option says is still missing


def _entries(gain: np.ndarray) -> tuple[float, ...]:
    return tuple(float(value) for value in np.ravel(gain))


def recall(asked: Asked) -> DrawnQuestion:
    """The eigenvalues of each matrix that the options name, with an observer faster than the controller."""
    twins = asked.entry.study
    A, B, C, K = twins.plant.A, twins.plant.B, twins.plant.C, twins.K
    wanted = np.sort_complex(FASTER * np.asarray(asked.entry.design["poles"], dtype=complex))
    L = observer_gain(A, C, wanted).gain

    def poles(M: np.ndarray) -> Sequence[complex]:
        return sorted_poles(M).tolist()
    known = tuple(Point(s.real, s.imag, "muted", "circle", same("A") if s.imag > 0 else NO_WORDS) for s in poles(A))
    return question_of_poles(text("eigenvalues of the matrix; this observer is twice as fast as the controller"), known,
                             (poles(A - B @ K - L @ C), poles(A - L @ C), poles(A - B @ K)), wanted.tolist())


def predict(asked: Asked) -> DrawnQuestion:
    """The entries of L beside the colleague's K_d: those of K, with the other sign, equal, or scaled."""
    twins = asked.entry.study
    given = _entries(twins.K_dual)
    return question_of_bar_groups(text("K_d is known; how large are the entries of L?"), text("gain"), (),
                                  (same(symbol("L1")), same(symbol("L2"))),
                                  (_entries(twins.K), tuple(-v for v in given), given, tuple(SCALED * v for v in given)),
                                  _entries(twins.L), "estimate", (text("entries of K_d"), given))


def surprise(asked: Asked) -> DrawnQuestion:
    """The entries of both gains with the turned sensor, in the colours of their tiles. Those of both change places, none, or those of L."""
    before, after = asked.entry.study, asked.after.study
    K, L = _entries(before.K), _entries(before.L)
    return question_of_bar_groups(text("both gains with the turned sensor"), text("gain"), (),
                                  tuple(same(symbol(name)) for name in ("K1", "K2", "L1", "L2")),
                                  ((*K[::-1], *L[::-1]), (*K, *L), (*K, *L[::-1])), (*_entries(after.K), *_entries(after.L)),
                                  level=(text("now"), (*K, *L)), runs=OF_K * len(K) + OF_L * len(L))


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise})
