"""Define the platform's channels: combinations of four sensors and of three coils.

Outputs (VL, HL, VR, HR) become z = T_y y: vertical (VL + VR)/2, rotation (VL − VR)/2, horizontal (HL − HR)/2 and the
residual (HL + HR)/2, which is zero on a rigid deck. Inputs are u = T_u v with v = (common, differential vertical force,
horizontal force). Platform report (003), equations (3)–(8) and (10)–(14).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...engine import Plant
from ...text import Text, text


def _fixed(rows: list[list[float]]) -> np.ndarray:
    matrix = np.array(rows, dtype=float)
    matrix.setflags(write=False)
    return matrix


T_y = _fixed([[0.5, 0, 0.5, 0], [0.5, 0, -0.5, 0], [0, 0.5, 0, -0.5], [0, 0.5, 0, 0.5]])
T_u = _fixed([[1, 1, 0], [1, -1, 0], [0, 0, 1]])


@dataclass(frozen=True)
class Channel:
    """One virtual channel: id, name, its row in T_y, its column in T_u (None: no coil acts on it)."""

    id: str
    name: Text
    output: int
    input: int | None


VERTICAL_CHANNEL = Channel("vertical", text("vertical"), 0, 0)
ROTATION = Channel("rotation", text("rotation"), 1, 1)
HORIZONTAL = Channel("horizontal", text("horizontal"), 2, 2)
RESIDUAL = Channel("residual", text("residual"), 3, None)
CHANNELS = (VERTICAL_CHANNEL, ROTATION, HORIZONTAL, RESIDUAL)


def in_channels(plant: Plant) -> Plant:
    """The plant from v to z: B T_u, T_y C, T_y D T_u (equations (16) and (17)).

    `plant` has the four sensors as outputs and the coils as its first three inputs; other inputs are left out.
    """
    D = np.asarray(plant.D)
    return Plant(plant.A, plant.B[:, :3] @ T_u, T_y @ plant.C, T_y @ D[:, :3] @ T_u, plant.dt, plant.state_names,
                 ("v_sum", "v_diff", "v_3"), tuple(c.id for c in CHANNELS), name=f"{plant.name} in channels".strip())


def controller_from_channels(controller: Plant) -> Plant:
    """The controller y → u made of one from z to v: T_u Kc(s) T_y.

    `controller` has three or four inputs (vertical, rotation, horizontal[, residual]) and three outputs, sign included.
    """
    T = T_y[:controller.m]
    return Plant(controller.A, controller.B @ T, T_u @ controller.C, T_u @ np.asarray(controller.D) @ T, controller.dt,
                 controller.state_names, ("VL", "HL", "VR", "HR"), ("u1", "u2", "u3"), name=controller.name)
