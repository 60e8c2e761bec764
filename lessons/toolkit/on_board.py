"""Run the device of a design with what a board adds: float32, late, lost and rounded readings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from observer_lab.course.guiding.questions import DrawnQuestion, question_of_bar_groups
from observer_lab.devices import Device, DeviceDesign
from observer_lab.text import Text, text

__all__ = ["FAULTS", "board_designs", "board_estimates", "board_question"]

FAULTS = ("float32", "late", "lost", "quantised")
PLACES = (text("float32"), text("late"), text("lost"), text("rounded"))
GROWS = 1.5  # times by which an option lets its cause enlarge the error
LOST_EVERY = 5  # each fifth reading does not arrive


def board_designs(design: DeviceDesign, step: float, late: int) -> Mapping[str, tuple[DeviceDesign, bool]]:
    """The device's design with the readings that it gets, and whether it computes in float32, by the name of the fault.

    `late`: periods by which each reading comes late. `step`: of the quantised readings.
    """
    y = np.asarray(design.y, dtype=float)
    lost = y.copy()
    lost[LOST_EVERY - 1::LOST_EVERY] = np.nan
    delayed = np.vstack([np.repeat(y[:1], late, axis=0), y[:-late]])
    return {"double": (design, False), "float32": (design, True), "late": (replace(design, y=delayed), False),
            "lost": (replace(design, y=lost), False), "quantised": (replace(design, y=step * np.round(y / step)), False)}


def board_estimates(design: DeviceDesign, step: float, late: int) -> Mapping[str, np.ndarray]:
    """The estimates (n_t, n) of the device by the name of the fault; "double" is without one."""
    return {name: Device(each.routine, single=single).run(each.y, each.u, each.r, (each.shown,))[each.shown]
            for name, (each, single) in board_designs(design, step, late).items()}


def board_question(title: Text, unit: str, design: DeviceDesign, x: np.ndarray, state: int, *, step: float, late: int,
                   grows: float = GROWS, scale: float = 1.0) -> DrawnQuestion:
    """The error of one state on a board, by what goes wrong there; each option lets one cause enlarge it `grows` times.

    x (n_t, n) is the truth at the readings. The error is the root mean square after the first third of the run,
    times `scale` where its unit is not that of the state.
    """
    found = board_estimates(design, step, late)
    first, last = len(design.y) // 3, len(design.y)
    size = {name: scale * float(np.sqrt(np.mean((x[first:last, state] - xhat[first:last, state]) ** 2))) for name, xhat in found.items()}
    whole = size["double"]
    options = [[grows * whole if name == guilty else whole for name in FAULTS] for guilty in FAULTS]
    run = [size[name] for name in FAULTS]
    return question_of_bar_groups(title, unit, ((text("double"), whole),), PLACES, options, run, "error")
