"""Define what stands in the 3-D scene: pole boards, and the stage with its body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...plants.bodies.body import Body
from ...plants.grip import Grip
from ...text import Text, text
from ..knobs import KnobError

RUN_LOST = text("The run is lost within its first step; choose gentler gains.")


@dataclass(frozen=True, eq=False)
class Board:
    """A pole board: the poles that `knob` holds, which of them can be dragged, and what part of the plane is shown.

    `reached` are the poles that the gain really gives; `fixed` poles are bolted: no gain moves them. A board with
    `knob` None only mirrors. `side` is where it stands, left or right of the plant.
    """

    id: str
    title: Text
    poles: tuple[complex, ...]
    knob: str | None = None
    fixed: tuple[complex, ...] = ()
    zeros: tuple[complex, ...] = ()
    role: str = "plant"
    side: str = "left"
    re_low: float = -10.0
    re_high: float = 2.0
    im_high: float = 8.0
    also: tuple[tuple[str, Any], ...] = ()  # knobs that dragging sets too
    disc: bool = False  # discrete time: stable is inside the unit circle
    pinned: tuple[tuple[int, tuple[complex, ...]], ...] = ()  # poles of pinned designs, by the place of the pin
    placed: tuple[tuple[complex, int], ...] = ()  # poles that a class has placed, with how often each; one of a pair stands for both
    landscape: np.ndarray | None = None  # matrix whose |det(sI − M)|⁻¹ is drawn in front, if any
    began: tuple[complex, ...] = ()  # where the poles stood when the open scene began, in their order, once some pole has moved
    loop: tuple[complex, ...] = ()  # poles of the loop that really runs, each in the place of its pole, where it has others

    def hold(self, s: complex) -> complex:
        """The point of the window that is nearest to s: a pole beyond the board's edge stands on the edge."""
        return complex(min(max(s.real, self.re_low), self.re_high), min(max(s.imag, -self.im_high), self.im_high))

    @property
    def held(self) -> tuple[complex, ...]:
        """The poles where they stand on the board and can be dragged from."""
        return tuple(map(self.hold, self.poles))


PICTURE_DEPTH, PICTURE_WIDTH, PICTURE_HEIGHT, PICTURE_FOOT = 1.5, 4.4, 2.0, 0.1  # of its place below the boards, in stage units


@dataclass(frozen=True, eq=False)
class StagePicture:
    """A picture of pixels (rows, columns, 3), upright behind the plant and as large as its room: `wide`, `foot`, `high`, `deep`."""

    image: np.ndarray
    wide: float = PICTURE_WIDTH
    foot: float = PICTURE_FOOT
    high: float = PICTURE_HEIGHT
    deep: float = PICTURE_DEPTH

    @property
    def size(self) -> tuple[float, float]:
        """How wide and how high it stands, in stage units."""
        rows, columns, _ = self.image.shape
        scale = min(self.wide / columns, self.high / rows)
        return scale * columns, scale * rows

    @property
    def place(self) -> tuple[float, float, float]:
        """Where its middle is, in stage units."""
        return 0.0, self.deep, self.foot + self.size[1] / 2


@dataclass(frozen=True, eq=False)
class Stage:
    """What the 3-D stage plays: a body along the true trajectory and, as a ghost, along its estimate.

    A record of x or xhat is what `body.pose` takes: the plant's state, and after it whatever else a body shows that no
    equation moves (where sensors stand, which are on, an ellipsoid of states).
    `spread` is a radius per time (stage units) of the uncertainty at each anchor, if there is noise; `note` says in lines of
    words on the stage what would surprise there.
    `held` says where a hand can pull the body, each with the record of its force. Raises KnobError where
    there is no more than the start to be played.
    """

    body: Body
    t: np.ndarray
    x: np.ndarray
    xhat: np.ndarray | None = None
    u: np.ndarray | None = None
    spread: np.ndarray | None = None
    note: tuple[Text, ...] = ()
    held: tuple[tuple[Grip, tuple[tuple[float, float], ...]], ...] = ()
    picture: StagePicture | None = None  # that a lesson brings, the same in all its runs
    plain: Stage | None = None  # the same without what a simulated run alone knows: where a plant runs now, this is shown
    readings: int = 0  # so many columns at the end of x and xhat are the last readings of the first output, the latest first

    def __post_init__(self) -> None:
        if len(self.t) < 2:
            raise KnobError(RUN_LOST)


def last_readings(y: np.ndarray, count: int) -> np.ndarray:
    """At each sample the last `count` readings (n_t, count) of y (n_t,), the latest first; before the first one that one."""
    return y[np.maximum(np.arange(len(y))[:, None] - np.arange(count), 0)]
