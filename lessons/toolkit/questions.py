"""Compute what an option of a question supposes: an error that is driven, a device on its board."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from observer_lab.course.guiding.questions import DrawnQuestion, question_of_bar_groups
from observer_lab.devices import Device, DeviceDesign
from observer_lab.engine.systems.recursions import affine_scan, step_matrices
from observer_lab.text import Text, text

DRAWN = (1e-9, 1e12)  # the least and the largest value of a bar over decades
FAULTS = ("float32", "late", "lost", "quantised")
PLACES = (text("float32"), text("late"), text("lost"), text("rounded"))
GROWS = 1.5  # times by which an option lets its cause enlarge the error
LOST_EVERY = 5  # each fifth reading does not arrive


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
    return question_of_bar_groups(title, unit, ((text("double"), whole),), PLACES, options, run, "error",
                                  (text("as in double"), [whole] * len(FAULTS)))
