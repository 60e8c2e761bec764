"""Draw the questions of lesson 13: a filter and five contests."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_bars, question_over_time
from observer_lab.course.lesson import Outcome
from observer_lab.text import NO_WORDS, text

from ..toolkit.questions import driven, size
from .controllers import CONTROLLER_ROLES, DECOUPLED, LQE, ORDER, SISO, Player, channel, channel_filter
from .race import moves
from .simulation import BAND_HZ, World
from .study import Study

BAR_ROLES = MappingProxyType({who: CONTROLLER_ROLES[ORDER.index(who)] for who in (SISO, LQE, DECOUPLED)})
QUIETER = 100.0  # times that the true noise is below the assumed one in the recall
RECALL_S = np.linspace(0.0, 2.0, 241)
BETTER_DB = 30.0  # more than before, where an option says that a controller uses the better sensors
LITTLE = 0.7  # of the other's motion, where an option says that it is less by a little
DAMPED = 0.3  # of the motion before, where an option says that friction damps
FRICTION_N = 5e-3  # of each guide, as the scene sets it
HALF, MORE = 0.5, 1.5  # of the reduction before


def recall(asked: Asked) -> DrawnQuestion:
    """An error of the vertical channel under a filter for a noisier sensor: as with the right gain, growing, or slower."""
    v = asked.after.design["v"]
    plant, _, _ = channel(0)
    assumed, right = (plant.A - channel_filter(0, intensity) @ plant.C for intensity in (v, v / QUIETER))
    e0 = plant.C[0] / np.linalg.norm(plant.C[0])
    slow, fast = (size(driven(A, e0, RECALL_S)) for A in (assumed, right))
    growing = size(driven(-assumed, e0, RECALL_S))
    return question_over_time(text("size of the error after a disturbance"), RECALL_S,
                              (Curve(text("with the right gain"), fast, "muted"),), (fast, np.minimum(growing, 2.0), slow),
                              Curve(text("with the assumed noise"), slow, "error"), "‖e‖")


def _coloured(drawn: DrawnQuestion, *who: str) -> DrawnQuestion:
    """The question with the run's bars in the colours of their controllers; that of the full LQG has the name of all."""
    run = (replace(bar, role=BAR_ROLES[each], name=bar.name if each == LQE else NO_WORDS) if isinstance(bar, Curve) else bar
           for bar, each in zip(drawn.run, who, strict=True))
    return replace(drawn, run=tuple(run))


def measures(asked: Asked) -> DrawnQuestion:
    """The vertical RMS velocity of the SISO loops beside that of the full LQG: four times, less by a little, or the same."""
    lqe, siso = (asked.entry.metrics[f"{who}_vertical_rms"] for who in (LQE, SISO))
    drawn = question_of_bar_groups(text("vertical RMS velocity, all frequencies"), "[µm/s]", (), (text("SISO loops"), text("full LQG")),
                                   ((4 * lqe, lqe), (LITTLE * lqe, lqe), (lqe, lqe)), (siso, lqe))
    return _coloured(replace(drawn, figure=replace(drawn.figure, y_range=(0.0, 1.1 * max(siso, 4 * lqe)))), SISO, LQE)


def _rotation_db(outcome: Outcome[Study]) -> list[float]:
    return [outcome.metrics[f"{who}_rotation_band_db"] for who in (SISO, LQE, DECOUPLED)]


def predict(asked: Asked) -> DrawnQuestion:
    """How far the rotation is reduced with better sensors: most by SISO, by the full LQG, by both LQGs, or as before by all."""
    before, after = (_rotation_db(outcome) for outcome in (asked.entry, asked.after))
    better = (1, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 0)
    options = [[value + BETTER_DB * share for value, share in zip(before, each, strict=True)] for each in better]
    return _coloured(question_of_bar_groups(text("rotation, reduction in 0.5–3 Hz"), "[dB]", (),
                                            (text("SISO loops"), text("full LQG"), text("decoupled LQG")), options, after,
                                            level=(text("now"), before)), SISO, LQE, DECOUPLED)


def surprise(asked: Asked) -> DrawnQuestion:
    """The reduction of the rotation on a deck with less damping: less, more, or none."""
    before, after = (outcome.metrics[f"{LQE}_rotation_band_db"] for outcome in (asked.entry, asked.after))
    return question_of_bars(text("rotation, reduction by the full LQG"), "[dB]", ((text("before"), before),), text("less damping"),
                            (HALF * before, MORE * before, 0.0), after)


@lru_cache(maxsize=4)
def _with_friction(world: World, five: tuple[Player, ...], seed: int) -> tuple[float, float]:
    siso, lqe = (moves(world, five[ORDER.index(who)], seed, FRICTION_N) for who in (SISO, LQE))
    return siso, lqe


def friction(asked: Asked) -> DrawnQuestion:
    """How many times the vertical motion grows by friction: less for both, the SISO loops most, or as before."""
    m = asked.entry.study
    smooth = [m.band_rms(*BAND_HZ)[ORDER.index(who), 0] for who in (SISO, LQE)]
    grown = _with_friction(replace(m.world, shaped=True), m.five, int(asked.entry.design["seed"]))
    siso, lqe = (now / before for now, before in zip(grown, smooth, strict=True))
    return _coloured(question_of_bar_groups(
        text("vertical motion with friction, times that without"), "", (), (text("SISO loops"), text("full LQG")),
        ((DAMPED, DAMPED), (siso, lqe), (1.0, 1.0)), (siso, lqe), level=(text("without friction"), (1.0, 1.0))), SISO, LQE)


QUESTIONS = MappingProxyType({"friction": friction, "recall": recall, "measures": measures, "predict": predict, "surprise": surprise})
