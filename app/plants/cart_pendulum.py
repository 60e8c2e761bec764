"""Model the cart-pendulum: an inverted pole on a cart.

State (p, θ, v, ω): position of the cart in m, angle from upright in rad with leaning to the right positive, and
their velocities. Which sensor sees what: the position alone shows everything, the angle alone never shows where the
cart stands.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import copysign, cos, sin
from types import MappingProxyType
from typing import Literal

import numpy as np

from ..colours import COLOURS
from ..engine import EngineError, NonlinearPlant, Plant
from ..text import text
from .bodies.body import (
    ASKED,
    DARK_GREY,
    GHOST_NAME,
    METAL,
    PLANT_COLOUR,
    STEEL,
    Arrow,
    Ball,
    Body,
    Box,
    Cylinder,
    Part,
    PartName,
    Pose,
    Quaternion,
    Rod,
    Vector,
    about_y,
    bound_displacement,
    force_arrow,
    pose_between,
)
from .grip import Grip
from .model import Model, Signal, Window

Sensor = Literal["position", "angle", "both"]
SENSOR_CHOICES: Mapping[str, tuple[tuple[int, str, str], ...]] = MappingProxyType({
    "position": ((0, "position", "m"),),
    "angle": ((1, "angle", "rad"),),
    "both": ((0, "position", "m"), (1, "angle", "rad")),
})
STAGE_SCALE = 1.6  # stage units per metre
RAIL_TOP, WHEEL = 0.36, 0.16  # top of the rail, radius of a wheel
CART = (1.0, 0.66, 0.36)
PIVOT = RAIL_TOP + 2 * WHEEL + CART[2] - 0.02
WORDS_OFF = 0.08  # how far apart from these arrows' height their words are
ASKED_ABOVE = 0.11  # of the arrow of the force that is asked for, over that of the force that acts
MAX_DRAWN_POSITION = 0.9  # farthest drawn position of the cart
FLAT = 1.5  # rad, farthest drawn angle of the pole


@dataclass(frozen=True)
class Parameters:
    """cart, ball kg; length m of the weightless pole; friction N s/m of the cart; pivot N m s; g m/s²."""

    cart: float = 1.0
    ball: float = 0.2
    length: float = 1.0
    friction: float = 0.1
    pivot: float = 0.0
    g: float = 9.81


def nonlinear(x: np.ndarray, u: np.ndarray | float, parameters: Parameters = Parameters()) -> np.ndarray:
    """ẋ of the full equations, for states x (…, 4) and forces u (…) in N; complex states pass through.

    (M + m) p̈ + m l cosθ θ̈ = u − c ṗ + m l sinθ θ̇²,  m l cosθ p̈ + m l² θ̈ = m g l sinθ − d θ̇.
    """
    states = np.moveaxis(np.asarray(x), -1, 0)
    return np.moveaxis(rates(states, np.asarray(u), parameters), 0, -1)


def rates(x: np.ndarray, u: np.ndarray, parameters: Parameters = Parameters()) -> np.ndarray:
    """The same with the states first: x (4, …), u (…) in N."""
    k = parameters
    angle, v, omega = x[1], x[2], x[3]
    sine, cosine = np.sin(angle), np.cos(angle)
    fall = k.g * sine - k.pivot / (k.ball * k.length) * omega
    push = u - k.friction * v + k.ball * k.length * sine * omega * omega
    out = np.empty((4, *push.shape), dtype=push.dtype)
    out[0], out[1] = v, omega
    out[2] = acceleration = (push - k.ball * cosine * fall) / (k.cart + k.ball * sine * sine)
    out[3] = (fall - cosine * acceleration) / k.length
    return out


def rate_slopes(x: np.ndarray, u: np.ndarray, parameters: Parameters = Parameters()) -> np.ndarray:
    """∂ẋ/∂x (N, 4, 4) at the columns of x (4, N), u (N,) or (1,) in N."""
    k = parameters
    angle, v, omega = x[1], x[2], x[3]
    sine, cosine = np.sin(angle), np.cos(angle)
    drag, swing = k.pivot / (k.ball * k.length), k.ball * k.length * omega
    fall, push = k.g * sine - drag * omega, u - k.friction * v + swing * sine * omega
    inertia = k.cart + k.ball * sine * sine
    acceleration = (push - k.ball * cosine * fall) / inertia
    steeper = cosine * (swing * omega - k.ball * k.g * cosine - 2 * k.ball * sine * acceleration) + k.ball * sine * fall
    J = np.zeros((x.shape[1], 4, 4))
    J[:, 0, 2] = J[:, 1, 3] = 1.0
    J[:, 2, 1] = by_angle = steeper / inertia
    J[:, 2, 2] = by_v = -k.friction / inertia
    J[:, 2, 3] = by_omega = (2 * swing * sine + k.ball * drag * cosine) / inertia
    J[:, 3, 1] = (k.g * cosine + sine * acceleration - cosine * by_angle) / k.length
    J[:, 3, 2] = -cosine * by_v / k.length
    J[:, 3, 3] = (-drag - cosine * by_omega) / k.length
    return J


def nonlinear_plant(parameters: Parameters = Parameters(), sensor: Sensor = "position") -> NonlinearPlant:
    """The full equations as a record; y is the position, the angle, or both."""
    rows = [index for index, _, _ in _chosen(sensor)]
    C = np.eye(4)[rows]

    def output_slope(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.broadcast_to(C, (x.shape[1], *C.shape))

    return NonlinearPlant(4, 1, len(rows), lambda x, u: rates(x, u[0], parameters),
                          lambda x, u: rate_slopes(x, u[0], parameters), lambda x, u: x[rows], output_slope,
                          "cart-pendulum, full equations")


def _chosen(sensor: str) -> tuple[tuple[int, str, str], ...]:
    if sensor not in SENSOR_CHOICES:
        raise EngineError("There is no sensor {sensor} on the cart; choose one of {sensors}.",
                          sensor=f'{sensor!r}', sensors=", ".join(SENSOR_CHOICES))
    return SENSOR_CHOICES[sensor]


def plant(parameters: Parameters = Parameters(), sensor: Sensor = "position") -> Plant:
    """The equations linearised about upright; y is the position, the angle, or both. Raises EngineError otherwise."""
    chosen = _chosen(sensor)
    k = parameters
    M, m, length = k.cart, k.ball, k.length
    turn = k.pivot / length  # the pivot's friction as a force on the pole's end
    A = [[0, 0, 1, 0], [0, 0, 0, 1],
         [0, -m * k.g / M, -k.friction / M, turn / M],
         [0, (M + m) * k.g / (M * length), k.friction / (M * length), -(M + m) * turn / (m * M * length)]]
    B = [[0], [0], [1 / M], [-1 / (M * length)]]
    return Plant(np.array(A), np.array(B), np.eye(4)[[index for index, _, _ in chosen]],
                 state_names=("p", "theta", "v", "omega"), input_names=("force",),
                 output_names=tuple(name for _, name, _ in chosen),
                 units=(("p", "m"), ("theta", "rad"), ("v", "m/s"), ("omega", "rad/s"), ("force", "N"),
                        *((name, unit) for _, name, unit in chosen)),
                 name="cart-pendulum")


POINTING_AWAY: Quaternion = (cos(0.7853981633974483), -sin(0.7853981633974483), 0.0, 0.0)  # a wheel's axle points away
WHEELS = tuple((sx * 0.32, sy * 0.28) for sy in (-1, 1) for sx in (-1, 1))
BODY_PARTS = (
    Part("base", Box((4.3, 1.1, 0.1)), DARK_GREY),
    *(Part(f"rail {side}", Box((4.0, 0.1, 0.08)), METAL) for side in ("front", "back")),
    *(Part(f"pier {i}", Box((0.14, 0.7, RAIL_TOP - 0.18)), STEEL) for i in range(3)),
    *(Part(f"stop {side}", Box((0.1, 0.7, 0.3)), STEEL) for side in ("left", "right")),
    Part("rest mark", Box((0.05, 0.14, 0.012)), METAL),
    Part("cart", Box(CART), PLANT_COLOUR, twin=True),
    *(Part(f"wheel {i}", Cylinder(WHEEL, 0.08), DARK_GREY) for i in range(4)),
    *(Part(f"hub {i}", Box((0.05, 0.16, 0.1)), METAL) for i in range(4)),
    Part("pivot", Cylinder(0.11, 0.6), STEEL),
    Part("pole", Rod(0.05), PLANT_COLOUR, twin=True),
    Part("ball", Ball(0.2), PLANT_COLOUR, twin=True),
)
FIXED_POSES = MappingProxyType({
    "base": Pose((0.0, 0.0, 0.05)),
    "rail front": Pose((0.0, -0.26, RAIL_TOP - 0.04)),
    "rail back": Pose((0.0, 0.26, RAIL_TOP - 0.04)),
    **{f"pier {i}": Pose((1.8 * (i - 1), 0.0, 0.1 + (RAIL_TOP - 0.18) / 2)) for i in range(3)},
    "stop left": Pose((-1.97, 0.0, RAIL_TOP + 0.13)),
    "stop right": Pose((1.97, 0.0, RAIL_TOP + 0.13)),
    "rest mark": Pose((0.0, -0.44, 0.106)),
})


def body(parameters: Parameters = Parameters()) -> Body:
    """Rails, cart, wheels that roll, and the pole with its ball; drawn to scale, the pole at most lying flat.

    A second entry of u is the force that is asked for, where the motor gives less.
    """
    reach = min(parameters.length * STAGE_SCALE, 1.9)
    full = 8.0

    def placed(x: Sequence[float], gain: float) -> tuple[float, float, Vector]:
        at, lean = bound_displacement(float(x[0]) * STAGE_SCALE * gain, MAX_DRAWN_POSITION), bound_displacement(float(x[1]) * gain, FLAT)
        return at, lean, (at + reach * sin(lean), 0.0, PIVOT + reach * cos(lean))

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        at, _, ball = placed(x, gain)
        poses = dict(FIXED_POSES)
        poses["cart"] = Pose((at, 0.0, RAIL_TOP + 2 * WHEEL + CART[2] / 2 - 0.06))
        poses["pivot"] = Pose((at, 0.0, PIVOT), POINTING_AWAY)
        poses["pole"] = pose_between((at, 0.0, PIVOT), ball)
        poses["ball"] = Pose(ball)
        rolled = about_y(at / WHEEL)
        for i, (dx, y) in enumerate(WHEELS):
            poses[f"wheel {i}"] = Pose((at + dx, y, RAIL_TOP + WHEEL), POINTING_AWAY)
            poses[f"hub {i}"] = Pose((at + dx, y, RAIL_TOP + WHEEL), rolled)
        return poses

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        at, height = placed(x, gain)[0], RAIL_TOP + 2 * WHEEL + CART[2] / 2 - 0.06

        def drawn(force: float, up: float, role: str = "force") -> Arrow:  # from the side of the cart to which it points
            return force_arrow((at + copysign(CART[0] / 2, force), -0.4, height + up), (1.0, 0.0, 0.0), force, full, role)

        if len(u) == 1:
            return (drawn(float(u[0]), 0.0),)
        return (replace(drawn(float(u[0]), 0.0), called=(text("applied"), -WORDS_OFF)),
                replace(drawn(float(u[1]), ASKED_ABOVE, ASKED), called=(text("commanded"), WORDS_OFF)))

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        at, _, ball = placed(x, gain)
        return (ball, (at, -CART[1] / 2, PIVOT - 0.04))

    return Body(BODY_PARTS, pose, arrows, anchors, 1.0, text("A pole balanced on a cart; the green arrow is the force "
                                                        "on the cart"), names=(
        PartName(text("cart: its position is measured"), "cart", (-1.0, -0.5, 0.0)),
        PartName(text("balanced pole"), "ball", (0.7, -0.2, 0.1)),
        PartName(GHOST_NAME, "ball", (-0.7, -0.2, 0.1), True),
    ))


FOG_PUFFS: Mapping[str, tuple[Vector, Vector]] = MappingProxyType({  # middles and half sizes, behind the estimate, which stays in sight
    "fog 0": ((-1.15, 0.5, 1.9), (0.8, 0.28, 0.7)),
    "fog 1": ((-0.4, 0.6, 2.15), (0.85, 0.3, 0.78)),
    "fog 2": ((0.5, 0.5, 2.1), (0.9, 0.28, 0.8)),
    "fog 3": ((1.25, 0.55, 1.85), (0.75, 0.28, 0.66)),
    "fog 4": ((0.05, 0.45, 1.75), (1.3, 0.2, 0.5)),
})
FOG_OPACITY = 0.3


def in_fog(clear: Body) -> Body:
    """The body with its pole hidden by fog: only the cart and what the estimate says can be seen, and no line shows the error."""
    hidden = tuple(replace(part, unseen=True) if part.name in ("pole", "ball") else part for part in clear.parts)
    puffs = {name: Pose(middle, scale=half) for name, (middle, half) in FOG_PUFFS.items()}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        return {**clear.pose(x, gain), **puffs}

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return clear.anchors(x, gain)[1:]

    cart, _, ghost = clear.names
    return replace(clear, parts=(*hidden, *(Part(name, Ball(1.0), COLOURS["fog"], opacity=FOG_OPACITY) for name in puffs)),
                   pose=pose, anchors=anchors, names=(cart, PartName(text("fog hides the pole"), "fog 3", (0.5, -0.2, 0.75)), ghost))


def grips(parameters: Parameters = Parameters()) -> tuple[Grip, ...]:
    """The ball and the cart, each pulled across.

    A force F on the ball gives, in the linear equations about upright, p̈ = 0 and θ̈ = F / (m l); one on the cart is an input.
    """
    def at_ball(x: Sequence[float], gain: float) -> Vector:
        return shown.anchors(x, gain)[0]

    def at_cart(x: Sequence[float], gain: float) -> Vector:
        across, y, z = shown.anchors(x, gain)[1]
        return across, y, z - CART[2] / 2

    shown, k = body(parameters), parameters
    return (
        Grip("pull", text("force of a hand on the ball"), ("ball", "pole"), at_ball, (1.0, 0.0, 0.0),
             (0.0, 0.0, 0.0, 1 / (k.ball * k.length)), 0.4),
        Grip("pull_2", text("force of a hand on the cart"), ("cart",), at_cart, (1.0, 0.0, 0.0),
             (0.0, 0.0, 1 / k.cart, -1 / (k.cart * k.length)), 2.0),
    )


MODEL = Model(
    id="cart-pendulum",
    label=text("Pole on a cart"),
    plant=plant(),
    body=body(),
    x0=(0.0, 0.12, 0.0, 0.0),
    guess=(0.0, 0.0, 0.0, 0.0),
    horizon=5.0,
    dt=0.01,
    controller_poles=(-2 - 1j, -2 + 1j, -3 - 1.5j, -3 + 1.5j),
    observer_poles=(-8 - 3j, -8 + 3j, -10 - 4j, -10 + 4j),
    controller_window=Window(-8.0, 5.0, 5.0),
    observer_window=Window(-16.0, 6.0, 8.0),
    kick=(0.0, 0.0, 0.0, 0.25),
    watched=(
        Signal(text("angle of the pole"), (0.0, 1.0, 0.0, 0.0), "°", 57.29577951308232),
        Signal(text("position of the cart"), (1.0, 0.0, 0.0, 0.0), "m"),
        Signal(text("angular velocity of the pole"), (0.0, 0.0, 0.0, 1.0), "°/s", 57.29577951308232),
    ),
    u_max=15.0,
    grips=grips(),
    source="Tutorial on output feedback: the pole balanced in the fog",
)
