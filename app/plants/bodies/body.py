"""Define a plant's body on the stage: parts, poses, force arrows, error anchors.

Stage units, not metres: x to the right, y away from the viewer, z up, the floor at z = 0, a plant about three
units wide. Pure data and arithmetic; the view turns parts into meshes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from ...colours import COLOURS
from ...text import NO_WORDS, Text, text

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]  # (w, x, y, z)
UNTURNED: Quaternion = (1.0, 0.0, 0.0, 0.0)

PLANT_COLOUR = COLOURS["plant"]  # the moving body
METAL, STEEL, COIL, DARK_GREY, BENCH = (COLOURS[role] for role in ("metal", "steel", "coil", "dark", "bench"))


@dataclass(frozen=True)
class Box:
    """A box with its middle at the part's position."""

    size: Vector


@dataclass(frozen=True)
class Cylinder:
    """An upright cylinder with its middle at the part's position."""

    radius: float
    height: float


@dataclass(frozen=True)
class Ball:
    """A sphere."""

    radius: float


@dataclass(frozen=True)
class Spring:
    """A helical spring from the position along its own z axis, one unit long: the pose's scale stretches it."""

    radius: float
    turns: float = 6.0
    wire: float = 0.03


@dataclass(frozen=True)
class Rod:
    """A round bar from the position along its own z axis, one unit long: the pose's scale stretches it."""

    radius: float


Shape = Box | Cylinder | Ball | Spring | Rod


@dataclass(frozen=True)
class Part:
    """One solid part. `twin` parts are drawn a second time, translucent, where the estimate says they are.

    `opacity` below 1 lets what is behind or inside shine through: a region rather than a thing. What is `unseen` is drawn only where
    the estimate says that it is. Its ghost has lines along its edges if it is `edged`.
    """

    name: str
    shape: Shape
    colour: str = COLOURS["grey"]
    twin: bool = False
    opacity: float | None = None
    unseen: bool = False
    edged: bool = True


@dataclass(frozen=True)
class Pose:
    """Where a part is: position, rotation, scale along its own axes, and a colour if it shows a value."""

    position: Vector
    wxyz: Quaternion = UNTURNED
    scale: Vector = (1.0, 1.0, 1.0)
    colour: tuple[int, int, int] | None = None


ASKED = "asked"  # the role of a force that the controller asks for


@dataclass(frozen=True)
class Arrow:
    """A force or velocity drawn from `tail` to `head`; one that is only asked for is drawn thinner.

    It may be `called` by words past its head, which stand so far above it.
    """

    tail: Vector
    head: Vector
    role: str = "force"
    called: tuple[Text, float] | None = None


@dataclass(frozen=True)
class PartName:
    """What a part of the body, or of its `ghost`, is called: words that stand `away` from it, at the end of a line to it.

    The line ends `at` a point of the part, in the part's own frame.
    """

    words: Text
    part: str
    away: Vector
    ghost: bool = False
    at: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class ErrorMarks:
    """An error that is drawn to scale: bars between a plant and its ghost, and words with its size, each with its place and its anchor.

    Plain strings are the same in every language.
    """

    bars: tuple[tuple[Vector, Vector], ...]
    words: tuple[tuple[Text | str, Vector, str], ...]


MOST_NAMES = 4  # of a body's parts
GHOST_NAME, UNCONTROLLED = text("ghost: the estimate"), text("ghost: without control")


@dataclass(frozen=True)
class Body:
    """A plant that can be posed.

    `pose(x, gain)` places every part for the state x (SI units); `gain` is how many times motion is exaggerated.
    `arrows(x, u, gain)` draws the inputs; `anchors(x, gain)` are the points that thin lines join from the plant to
    its ghost, so that the error can be seen. `gain` is the default exaggeration, shown beside the plant; so is `forces`,
    how many times longer than usual the arrows of the inputs are. `labels` are words that stand on the stage and where;
    `names`, at most MOST_NAMES, say what a newcomer sees, until he has done something. `marks(x, xhat, gain)` draws the error to scale.
    `ghost` is the role of the ghost's colour: another one than that of estimates where the ghost is none.
    """

    parts: tuple[Part, ...]
    pose: Callable[[Sequence[float], float], Mapping[str, Pose]]
    arrows: Callable[[Sequence[float], Sequence[float], float], tuple[Arrow, ...]]
    anchors: Callable[[Sequence[float], float], tuple[Vector, ...]]
    gain: float = 1.0
    caption: Text = NO_WORDS
    labels: tuple[tuple[Text | str, Vector], ...] = ()
    forces: float = 1.0
    names: tuple[PartName, ...] = ()
    marks: Callable[[Sequence[float], Sequence[float], float], ErrorMarks] | None = None
    ghost: str = "estimate"


def with_longer_arrows(body: Body, times: float, inputs: int) -> Body:
    """The body with the arrows of its first `inputs` inputs this many times longer, which is then said beside it."""
    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return body.arrows(x, [times * v for v in u[:inputs]] + list(u[inputs:]), gain)

    return replace(body, arrows=arrows, forces=times)


def called(body: Body, ghost: Text) -> tuple[PartName, ...]:
    """The names of a body whose ghost is not the estimate but something else."""
    return tuple(replace(name, words=ghost) if name.ghost else name for name in body.names)


def turned(vector: Vector, by: Quaternion) -> Vector:
    """The vector (x, y, z) turned by a unit quaternion (w, x, y, z)."""
    w, a, b, c = by
    x, y, z = vector
    across, up, ahead = 2 * (b * z - c * y), 2 * (c * x - a * z), 2 * (a * y - b * x)
    return x + w * across + b * ahead - c * up, y + w * up + c * across - a * ahead, z + w * ahead + a * up - b * across


def about_y(angle: float) -> Quaternion:
    """Rotation in the picture's plane: about the axis that points away from the viewer, right side down positive."""
    return (math.cos(angle / 2), 0.0, math.sin(angle / 2), 0.0)


LYING = about_y(math.pi / 2)  # turns an upright cylinder along x


def pose_between(start: Vector, end: Vector, thickness: float = 1.0) -> Pose:
    """The pose of a unit-long spring or rod that reaches from `start` to `end`."""
    d = (end[0] - start[0], end[1] - start[1], end[2] - start[2])
    length = math.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)
    if length < 1e-6:
        return Pose(start, UNTURNED, (thickness, thickness, 1e-6))
    x, y, z = d[0] / length, d[1] / length, d[2] / length
    aside = x * x + y * y
    if aside < 1e-24:
        turn: Quaternion = UNTURNED if z > 0 else (0.0, 1.0, 0.0, 0.0)
    else:  # the shortest turn from (0, 0, 1) to (x, y, z); 1 + z without cancellation when it points down
        w = 1 + z if z > 0 else aside / (1 - z)
        norm = math.sqrt(w * w + aside)
        turn = (w / norm, -y / norm, x / norm, 0.0)
    return Pose(start, turn, (thickness, thickness, length))


def bound_displacement(value: float, limit: float) -> float:
    """A displacement that never leaves the stage: nearly linear near zero, at most ±limit."""
    return limit * math.tanh(value / limit) if limit > 0 else 0.0


def force_arrow(tail: Vector, along: Vector, value: float, full: float, role: str = "force") -> Arrow:
    """An arrow from `tail` along the unit vector `along`, 0.65 long at `full`, never longer than 0.9."""
    length = bound_displacement(value / full * 0.7 if full > 0 else 0.0, 0.9)
    head = (tail[0] + along[0] * length, tail[1] + along[1] * length, tail[2] + along[2] * length)
    return Arrow(tail, head, role)
