"""Compute and draw how much of the ground's motion reaches the deck under each controller."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from observer_lab.course.figures.ranges import LOG_AXIS_FLOOR
from observer_lab.course.figures.records import Curve, LineFigure, over_frequency
from observer_lab.course.lesson import Outcome
from observer_lab.text import Text, listed, text, text_in

from .controllers import CONTROLLER_NAMES, ORDER, SHORT_NAMES
from .curve_styles import CURVE_STYLES, width
from .simulation import analyse
from .study import Study

TRANSMISSIBILITY_TAB = text("Transmissibility")
AXES = (("vertical", text_in("channel", "vertical")), ("horizontal", text_in("channel", "horizontal")))
LAST_HZ = 100.0  # above it the samples fold the ground's noise back
NO_NOISE = 1e-30  # (m/s)² s
GROUND = 2.0  # µm²/Hz, one-sided, of white ground of 10⁻¹² m² s


def transmissibility(m: Study, i: int) -> np.ndarray | None:
    """|deck/ground| of player i, vertical and horizontal, over the study's frequencies up to LAST_HZ (n_f, 2); None if unstable.

    By symmetry vertical ground moves the vertical channel alone, and horizontal ground the horizontal one: the density of the
    velocity under white ground, without noise of the sensors, is (2πf)²|T|² times the ground's.
    """
    hardware = replace(m.world.hardware, limit=np.inf, step=0.0, walk=0.0)
    quiet = replace(m.world, hardware=hardware, sensor=NO_NOISE, shaped=False)
    made = analyse(quiet, m.five[i], m.more)
    if not made.stable:
        return None
    seen = m.f <= LAST_HZ
    return np.sqrt(made.density[seen][:, [0, 2]] / GROUND) / (2 * np.pi * m.f[seen, None])


def transmissibilities(outcome: Outcome[Study]) -> tuple[LineFigure, ...]:
    """Vertical and horizontal, of every player."""
    m = outcome.study
    found = [transmissibility(m, i) for i in range(len(ORDER))]
    return tuple(_drawn(outcome, name, title, [None if T is None else T[:, k] for T in found]) for k, (name, title) in enumerate(AXES))


def _drawn(outcome: Outcome[Study], name: str, title: Text, found: list[np.ndarray | None]) -> LineFigure:
    f = outcome.study.f[outcome.study.f <= LAST_HZ]
    curves = [Curve(CONTROLLER_NAMES[i], np.full(len(f), LOG_AXIS_FLOOR) if T is None else np.maximum(T, LOG_AXIS_FLOOR), role, dash,
                    width(outcome, i)) for i, (T, (role, dash)) in enumerate(zip(found, CURVE_STYLES, strict=True))]
    curves.append(Curve(text("as the ground"), np.ones(len(f)), "second", "dot", 1.2))
    most = listed(text("{name} {value}", name=SHORT_NAMES[i], value=text("unstable") if T is None else f"{T.max():.3g}")
                  for i, T in enumerate(found))
    return over_frequency(f"transmissibility_{name}", text("{title} transmissibility, deck over ground", title=title), f, tuple(curves),
                          "|T|", text("Largest: {most}.", most=most), TRANSMISSIBILITY_TAB, (1e-4, 1e2))
