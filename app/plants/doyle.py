"""Model Doyle's plant of 1978, whose optimal loop has vanishing margins.

ẋ₁ = x₁ + x₂ + w, ẋ₂ = x₂ + u + w, y = x₁ + v; the weights are Q = q [1; 1][1 1], R = 1, the noise W = σ on both states
alike, V = 1. Then K = f [1 1] with f = 2 + √(4 + q), L = d [1; 1] with d = 2 + √(4 + σ), and with the plant's input gain
multiplied by m the loop is stable up to m = 1 + 1/(d f) exactly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import sqrt

import numpy as np

from ..engine import Plant
from ..text import text
from .bodies.body import Body, Pose
from .bodies.gauge_body import gauge_body, gauge_labels, gauge_places
from .model import Model, Signal, Window

SOURCE = "J. C. Doyle, Guaranteed margins for LQG regulators, IEEE Transactions on Automatic Control 23 (1978)"
BOTH_STATES = np.array([[1.0], [1.0]])  # where the noise enters, and (transposed) what is weighted
BOTH_STATES.setflags(write=False)


def plant() -> Plant:
    """Both states unstable at +1; u drives the second, the first is measured."""
    A, B, C = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
    return Plant(A, B, C, state_names=("x1", "x2"), name="doyle-1978")


def gains(q: float, sigma: float) -> tuple[float, float]:
    """(f, d) = (2 + √(4 + q), 2 + √(4 + σ))."""
    return 2 + sqrt(4 + q), 2 + sqrt(4 + sigma)


def largest_gain(q: float, sigma: float) -> float:
    """The factor of the input gain at which the optimal loop turns unstable: 1 + 1/(d f)."""
    f, d = gains(q, sigma)
    return 1 + 1 / (d * f)


def body() -> Body:
    """Two gauges for the states, the first one measured, and a large one for x₁ + x₂, which the cost weighs."""
    shape, places = gauge_body(2, (0,)), gauge_places(2, (0,))
    anchors = shape.anchors

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        found = dict(shape.pose((x[0], x[1], PER_SUM * (x[0] + x[1])), gain))
        for name in found:  # the plates stand behind the thick levels
            if name.startswith(("back", "zero", "large back", "large zero", "lamp")):
                across, away, up = found[name].position
                found[name] = replace(found[name], position=(across, away + PLATES_BACK, up))
        return found

    lamps = tuple((word, (x + aside, 0.0, 2.78)) for word, x, aside in ((text("measured"), places[0], -0.2),
                                                                      (text("not measured"), places[1], 0.3)))
    return replace(
        shape, pose=pose,
        anchors=lambda x, gain: anchors((x[0], x[1], PER_SUM * (x[0] + x[1])), gain), gain=4.0,
        marks=None, labels=(*gauge_labels(places, ("x₁", "x₂"), "x₁ + x₂"), *lamps),
        caption=text("Small gauges: the states x₁ and x₂; x₁ is measured and lit; large gauge: x₁ + x₂ and its ghost"))


PLATES_BACK = 0.19  # stage units that the plates stand farther behind than on other gauges
PER_SUM = 5.0  # the large gauge's unit is made for g of another plant
MODEL = Model(
    id="doyle",
    label=text("Doyle's plant of 1978"),
    plant=plant(),
    body=body(),
    x0=(0.3, -0.2),
    guess=(0.0, 0.0),
    horizon=6.0,
    dt=0.012,
    controller_poles=(-2.0, -1.5),
    observer_poles=(-4.0, -3.0),
    controller_window=Window(-16.0, 4.0, 12.0),  # as the platform's: one lesson shows both on the same boards
    observer_window=Window(-20.0, 4.0, 12.0),
    kick=(0.0, 0.3),
    watched=(Signal(text("measured state x₁"), (1.0, 0.0), ""),
             Signal(text("hidden state x₂"), (0.0, 1.0), "")),
    u_max=10.0,
    input_unit="",
    source=SOURCE,
)
