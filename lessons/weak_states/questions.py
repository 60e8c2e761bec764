"""Draw the questions of lesson 12: rank, motion and error."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
from scipy.linalg import block_diag

from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_bars
from observer_lab.engine import Plant
from observer_lab.engine.structure import observability_matrix
from observer_lab.text import text

from .balanced_platform import MASSES_AGAINST_MODE, MASSES_TOGETHER_MODE, PITCH_MODE, Motion, Platform, relative
from .body import MAX_DRAWN_MOTION

CHAINS = (3, 3, 2, 1)  # states of four chains, each with a sensor at its end; one more state acts on no sensor


def _rank(A: np.ndarray, C: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(observability_matrix(Plant(A, np.zeros((len(A), 1)), C))))


def recall(asked: Asked) -> DrawnQuestion:
    """What is missing in ten states of rank nine: a direction without effect, a useless sensor, or gain."""
    A = block_diag(*(np.eye(n, k=1) for n in (*CHAINS, 1)))
    C = np.zeros((len(CHAINS), len(A)))
    C[range(len(CHAINS)), np.cumsum((0, *CHAINS[:-1]))] = 1.0
    found = _rank(A, C)
    spare = sum(_rank(A, np.delete(C, k, axis=0)) == found for k in range(len(C)))
    gained = _rank(A, 10 * C) - found
    return question_of_bar_groups(text("ten states, rank 9"), text("how many"), (),
                                  (text("unseen directions"), text("spare sensors"), text("gained directions")),
                                  ((1, 0, 0), (0, 1, 0), (0, 0, 1)), (len(A) - found, spare, gained))


def _moves(s: Platform, motion: Motion) -> np.ndarray:
    """How deck (pitch) and test masses move at one moment, each as a share of the largest way that is drawn."""
    parts = relative(s.parameters, motion.shape) / MAX_DRAWN_MOTION
    parts = np.real(parts / parts[np.argmax(np.abs(parts))])[2:]
    return parts * (1 if parts[-1] >= 0 else -1)


def predict(asked: Asked) -> DrawnQuestion:
    """What moves in the weakest pair: the deck's pitch, the masses against each other, together, or nothing."""
    s = asked.entry.study.system
    by_kind = {motion.kind: _moves(s, motion) for motion in s.motions}
    shown = _moves(s, s.motions[int(asked.after.design["pair"]) - 1])
    return question_of_bar_groups(text("what moves in the weakest pair"), text("share of the largest way"), (),
                                  (text("deck tilt"), text("left test mass"), text("right test mass")),
                                  (by_kind[PITCH_MODE], by_kind[MASSES_AGAINST_MODE], by_kind[MASSES_TOGETHER_MODE], np.zeros(3)), shown)


def surprise(asked: Asked) -> DrawnQuestion:
    """The largest error with nine states: as with eight, a half, or nearly none."""
    before, after = (1e4 * each.metrics["error"] for each in (asked.entry, asked.after))
    return question_of_bars(text("largest error of the reduced model"), text("largest error [10⁻⁴]"), ((text("8 states"), before),),
                            text("9 states"), (before, 0.5 * before, 0.0), after, "error")


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise})
