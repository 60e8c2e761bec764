"""Define a named plant for lessons: matrices, body, and default numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..engine import Plant
from ..engine.design import StartingGain
from ..text import Text
from .bodies.body import Body
from .grip import Grip
from .plant_extras import NO_EXTRAS, PlantExtras


@dataclass(frozen=True)
class Signal:
    """What a plot shows of a state: `weights` @ x × `scale`, in `unit` (SI inside, mm or degrees on the axis)."""

    name: Text
    weights: tuple[float, ...]
    unit: str
    scale: float = 1.0

    def of(self, x: np.ndarray) -> np.ndarray:
        """The signal over a trajectory x (n_t, n)."""
        return np.asarray(x) @ np.asarray(self.weights) * self.scale


@dataclass(frozen=True)
class Window:
    """The part of the s-plane that a pole board shows."""

    re_low: float
    re_high: float
    im_high: float


@dataclass(frozen=True)
class Model:
    """A plant with its body on the stage and the numbers from which lessons start.

    x0, guess: true and believed initial state; horizon, dt in s; poles in rad/s; `kick`: the jump of the state that
    the kick button gives; `watched`: the signals a person follows, the most telling first; `u_max`: a natural input
    limit per input; `input_unit` and `input_scale`: how inputs are shown; `controls`: which inputs a controller may
    drive, all of them if empty, the others being disturbances; `grips`: where a hand can pull.

    A plant that a person brought has gains to start from, `controller` and `observer`; its `controller_poles` and
    `observer_poles` are those that stand on a board, and the others stay where these gains put them. `beyond` is what its
    file says of a bilinear term.
    """

    id: str
    label: Text
    plant: Plant
    body: Body
    x0: tuple[float, ...]
    guess: tuple[float, ...]
    horizon: float
    dt: float
    controller_poles: tuple[complex, ...]
    observer_poles: tuple[complex, ...]
    controller_window: Window
    observer_window: Window
    kick: tuple[float, ...]
    watched: tuple[Signal, ...]
    u_max: float
    input_unit: str = "N"
    input_scale: float = 1.0
    source: str = ""
    controls: tuple[int, ...] = ()
    controller: StartingGain | None = None
    observer: StartingGain | None = None
    beyond: PlantExtras = NO_EXTRAS
    grips: tuple[Grip, ...] = ()

    @property
    def controlled(self) -> Plant:
        """The plant with only the inputs that a controller drives."""
        if not self.controls:
            return self.plant
        p, chosen = self.plant, list(self.controls)
        assert p.D is not None
        return Plant(p.A, p.B[:, chosen], p.C, p.D[:, chosen], p.dt, p.state_names,
                     tuple(p.input_names[i] for i in chosen), p.output_names, p.units, p.name)

    @property
    def disturbed(self) -> np.ndarray | None:
        """G (n×q): the columns of B that are disturbances, or None if every input is a control."""
        others = [i for i in range(self.plant.m) if i not in self.controls]
        return self.plant.B[:, others] if self.controls and others else None
