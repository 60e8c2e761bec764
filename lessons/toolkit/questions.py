"""Compute what an option of a question supposes, such as an error that is driven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from observer_lab.course.guiding.questions import DrawnQuestion, question_of_bar_groups
from observer_lab.engine.systems.recursions import affine_scan, step_matrices
from observer_lab.text import Text

DRAWN = (1e-9, 1e12)  # the least and the largest value of a bar over decades


def driven(A: np.ndarray, e0: np.ndarray, t: np.ndarray, push: np.ndarray | None = None) -> np.ndarray:
    """e(t) of ė = A e + f(t) from e0 at even times: shape (n_t, n). `push` is f at the times, (n_t, n), held between them; none is zero."""
    Phi, Phi1 = step_matrices(A, float(t[1] - t[0]))
    forcing = None if push is None else push[:len(t) - 1] @ Phi1.T
    return affine_scan(Phi, forcing, np.asarray(e0, dtype=float), len(t) - 1)


def size(e: np.ndarray) -> np.ndarray:
    """The Euclidean length of a vector over time, (n_t, n) → (n_t,)."""
    return np.linalg.norm(e, axis=1)


def question_of_decades(title: Text, y_label: Text | str, known: Sequence[tuple[Text, float]], asked: Sequence[Text],
                        options: Sequence[Sequence[float]], run: Sequence[float], role: str = "plant") -> DrawnQuestion:
    """Bars over decades, all of positive values: each begins at 1."""
    drawn = question_of_bar_groups(title, y_label, [(name, float(_decades([value])[0])) for name, value in known], asked,
                                   [_decades(each) for each in options], _decades(run), role)
    return replace(drawn, figure=replace(drawn.figure, powers="y"))


def _decades(values: Sequence[float]) -> np.ndarray:
    """Exponents of ten, of what is zero or infinite those of the ends that are drawn."""
    return np.log10(np.clip(np.asarray(values, dtype=float), *DRAWN))
