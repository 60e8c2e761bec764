"""Where each lesson stands in the course, and three ways through it."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType

from app.lesson.course import Place, Way
from app.text import text

FIRST = Way("first", text("A first course in observers"),
            text("From the virtual sensor to noise: design an observer, steer by it, and see where that ends."))
ESTIMATION = Way("estimation", text("Estimation"),
                 text("How a filter knows what to trust: from noise over Kalman to lost packets and sensors that lie."))
PLATFORM = Way("platform", text("The platform"),
               text("One machine, start to finish: a table that is to stand still while the ground shakes, by LQG and what rivals it."))
MINUTES = 90


def _place(id: str, needs: str, *ways: Way) -> tuple[str, Place]:
    return id, Place(MINUTES, tuple(needs.split()), ways, Path(__file__).parent / id.replace("-", "_") / "card.webp")


PLACES = MappingProxyType(dict((
    _place("virtual-sensor", "", FIRST, ESTIMATION),
    _place("error-dynamics", "virtual-sensor", FIRST),
    _place("observability", "error-dynamics", FIRST, ESTIMATION),
    _place("separation", "error-dynamics", FIRST, PLATFORM),
    _place("duality", "observability separation", FIRST),
    _place("hidden-modes", "observability separation", FIRST),
    _place("saturation", "separation", FIRST),
    _place("noise", "error-dynamics", FIRST, ESTIMATION),
    _place("kalman", "noise", ESTIMATION, PLATFORM),
    _place("lqg", "separation kalman", PLATFORM),
    _place("decoupling", "lqg", PLATFORM),
    _place("weak-states", "observability lqg", PLATFORM),
    _place("showdown", "lqg decoupling", PLATFORM),
    _place("nonlinear", "kalman", ESTIMATION),
    _place("robust-observer", "separation duality"),
    _place("bilinear-observer", "observability hidden-modes"),
    _place("fault-diagnosis", "kalman", ESTIMATION),
    _place("network", "separation kalman", ESTIMATION),
    _place("sandbox", "separation"),
    _place("arm", "separation saturation"),
)))
