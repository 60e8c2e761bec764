"""Draw the questions of lesson 4: what a force does to the error, and which poles stay."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve, Point
from observer_lab.course.guiding.questions import (
    CROSSES_OF_RUN,
    YOUR_DIAMONDS,
    Asked,
    DrawnQuestion,
    question_of_bar_groups,
    question_of_poles,
    question_over_time,
)
from observer_lab.text import NO_WORDS, text

from ..toolkit.questions import driven, size
from .study import with_loop_poles

SHIFT = 1.35  # of poles that an option says move, where it does not say where to


def _rings(poles: Sequence[complex], role: str) -> tuple[Point, ...]:
    named = max(range(len(poles)), key=lambda k: -complex(poles[k]).imag)
    return tuple(Point(complex(s).real, complex(s).imag, role, "ring", text("rings: before") if k == named else NO_WORDS)
                 for k, s in enumerate(poles))


def recall(asked: Asked) -> DrawnQuestion:
    """The error under a larger force: driven by Bu, or as before."""
    run = asked.entry.run
    plant, L, t = run.scenario.plant, asked.entry.gains["L"], run.t
    A, e0 = plant.A - L @ plant.C, np.linalg.solve(plant.A - L @ plant.C, plant.B[:, 0])
    push = np.outer(np.sin(2 * np.pi * t / t[-1] * 4), plant.B[:, 0])
    alone = size(driven(A, e0, t))
    return question_over_time(text("size of the error after a disturbance"), t, (), (size(driven(A, e0, t, push)), alone),
                              Curve(text("with the larger force"), alone, "error"), "‖e‖")


def predict(asked: Asked) -> DrawnQuestion:
    """The observer's poles while the controller's move: they move too, stay, or stay only while they are faster."""
    before, after = asked.entry.poles["observer"], asked.after.poles["observer"]
    slow = [s * SHIFT if s.real > min(p.real for p in asked.after.poles["controller"]) else s for s in before]
    return question_of_poles(text("poles of the observer"), _rings(before, "muted"), (SHIFT * np.asarray(before), before, slow), after,
                             names=(YOUR_DIAMONDS, CROSSES_OF_RUN))


def surprise(asked: Asked) -> DrawnQuestion:
    """How far a wrong model moves the loop's poles: the controller's stay, the observer's stay, all stay, or none does."""
    boards = with_loop_poles(asked.after.boards, asked.after.study.boards.poles)
    far = [max((abs(pole - ring) for pole, ring in zip(board.poles, board.loop, strict=False)), default=0.0) for board in boards]
    usual = sum(far) / 2
    return question_of_bar_groups(text("how far the loop's poles are from those on the boards"), text("farthest distance [1/s]"), (),
                                  (text("controller"), text("observer")), ((0, usual), (usual, 0), (0, 0), (usual, usual)), far)


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise})
