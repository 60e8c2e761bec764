"""Draw the questions of lesson 4: what a force does to the error, and which poles stay."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve, Point
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_poles, question_over_time
from observer_lab.text import text

from ..toolkit.questions import driven, size

SHIFT = 1.35  # of poles that an option says move, where it does not say where to


def _crosses(poles: Sequence[complex], role: str) -> tuple[Point, ...]:
    return tuple(Point(complex(s).real, complex(s).imag, role, "circle") for s in poles)


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
    return question_of_poles(text("poles of the observer"), _crosses(before, "muted"), (SHIFT * np.asarray(before), before, slow), after)


def surprise(asked: Asked) -> DrawnQuestion:
    """How far a wrong model moves the loop's poles: the controller's stay, the observer's stay, all stay, or none does."""
    K, L, loop = (np.asarray(asked.after.poles[name]) for name in ("controller", "observer", "loop"))
    far = [float(np.mean([np.min(np.abs(loop - s)) for s in each])) for each in (K, L)]
    usual = sum(far) / 2
    return question_of_bar_groups(text("how far the loop's poles are from those on the boards"), text("distance [1/s]"), (),
                                  (text("controller"), text("observer")), ((0, usual), (usual, 0), (0, 0), (usual, usual)), far)


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise})
