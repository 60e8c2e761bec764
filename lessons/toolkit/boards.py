"""Build the two pole boards of a lesson with K and L, and the stage along a run."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from observer_lab.course.lesson import Board, Design, Stage
from observer_lab.engine.design import StartingGain
from observer_lab.engine.simulation import Run
from observer_lab.plants.model import Model, Window
from observer_lab.text import text

from .knobs import BY_POLES, by_hand, held

WEIGHTS_FOLDER = text("Weights")


def bolts(start: StartingGain | None, window: Window) -> tuple[complex, ...]:
    """The poles that no gain moves, as far as the board reaches."""
    if start is None:
        return ()
    return tuple(complex(p) for p in start.bolted
                 if window.re_low <= p.real <= window.re_high and abs(p.imag) <= window.im_high)


def pole_boards(model: Model, design: Design, controller: np.ndarray, observer: np.ndarray,
                error_matrix: np.ndarray | None = None) -> tuple[Board, Board]:
    """The two boards of a lesson with K and L: controller on the left, observer on the right.

    Poles chosen by hand stand exactly where the hand put them; poles that weights choose can be dragged too, which
    turns the method to poles. `error_matrix` A − LC gives the landscape of |det(sI − A + LC)|⁻¹.
    """
    chosen = by_hand(design)
    take = (("method", BY_POLES),) if "method" in dict(design.values) else ()
    c, o = model.controller_window, model.observer_window

    def grip(knob: str, poles: np.ndarray) -> str | None:  # a board that shows other poles than the knob holds only mirrors
        return knob if chosen or len(design[knob]) == len(poles) else None
    return (
        Board("controller", text("controller poles  eig(A − BK)"),
              design["controller_poles"] if chosen else listed(controller), grip("controller_poles", controller),
              bolts(model.controller, c) if chosen else (), role="plant", side="left", re_low=c.re_low, re_high=c.re_high,
              im_high=c.im_high, also=take, disc=bool(model.plant.dt)),
        Board("observer", text("observer poles  eig(A − LC)"),
              design["observer_poles"] if chosen else listed(observer), grip("observer_poles", observer),
              bolts(model.observer, o) if chosen else (), role="estimate", side="right", re_low=o.re_low,
              re_high=o.re_high, im_high=o.im_high, also=take, disc=bool(model.plant.dt), landscape=error_matrix),
    )


def listed(poles: Iterable[complex]) -> tuple[complex, ...]:
    """Poles of an array as a board takes them."""
    return tuple(complex(p) for p in poles)


def stage(model: Model, run: Run, design: Design) -> Stage:
    """The plant and its ghost along the run of a design."""
    xhat = run.xhat if run.xhat.shape == run.x.shape else None
    return Stage(model.body, run.t, run.x, xhat, run.u_applied, held=held(design, model))
