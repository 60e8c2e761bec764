"""Run two starts side by side: do the readings of the sensors tell them apart?"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve, LineFigure
from observer_lab.course.lesson import Design
from observer_lab.text import Text, format_number, text

from .cases import Case, Sensed, shown, unit

STARTS_TAB = text("Two starts")
SAME_READING = 1e-9  # of the difference of the starts: readings nearer than this differ by rounding alone
DECK_STATES = MappingProxyType({"x": 0, "z": 1, "theta": 2})  # of the deck: which state the second start changes


@dataclass(frozen=True, eq=False)
class TwoStarts:
    """Two free runs: their start, the difference v (n,) of the second, their states and readings (n_t, n) and (n_t, p).

    `gap`: the largest difference of the readings, |C e^{At} v|, in typical readings. `state`: the state that v changes most.
    """

    start: np.ndarray
    v: np.ndarray
    states: tuple[np.ndarray, np.ndarray]
    readings: tuple[np.ndarray, np.ndarray]

    @property
    def gap(self) -> float:
        """How far the readings come apart."""
        return float(np.abs(self.readings[1] - self.readings[0]).max(initial=0.0))

    @property
    def state(self) -> int:
        """The state in which the two starts differ most."""
        return int(np.argmax(np.abs(self.v)))


def two_starts(s: Sensed, start: np.ndarray, design: Design) -> TwoStarts:
    """x₁(0) = start and x₂(0) = start + Δ d: d is the chosen motion of the deck, else the direction that the readings show least.

    That direction is the eigenvector of the least eigenvalue of W(T), in the kernel of O where the plant is not observable.
    """
    chosen = dict(design.values).get("second") if dict(design.values).get("plant") == "deck" else None
    direction = s.axes[-1][:, 0] if chosen is None else np.eye(len(start))[DECK_STATES[chosen]]
    v = design["apart"] * direction
    states = tuple(s.powers @ x for x in (start, start + v))
    return TwoStarts(start, v, states, tuple(x @ s.plant.C.T for x in states))  # type: ignore[arg-type]


def starts_figures(case: Case, s: Sensed, found: TwoStarts, noise: float) -> tuple[LineFigure, LineFigure]:
    """The readings of both starts, and the state in which they differ most."""
    first, second = found.readings
    sensor = int(np.argmax(np.abs(second - first).max(axis=0)))
    quiet, alike = not np.any(s.plant.C), not np.any(found.v)
    said = text("No sensor is on: there is no reading.") if quiet else text("Both starts are the same.") if alike else (
        _told(s, found, noise))
    i = found.state
    values = [shown(case, x[:, [i]], (i,))[:, 0] for x in found.states]
    names = text("first start"), text("second start")
    readings = LineFigure(
        "two-readings", text("reading of both starts"), s.t,
        (Curve(names[0], first[:, sensor], "plant", "solid", 3.0), Curve(names[1], second[:, sensor], "second", "dash")),
        text("y, in typical readings"), tab=STARTS_TAB, caption=said)
    states = LineFigure(
        "two-states", text("the state in which they differ"), s.t,
        (Curve(names[0], values[0], "plant"), Curve(names[1], values[1], "second", "dash")), unit(case, i), tab=STARTS_TAB,
        caption=text("At the start they are {apart} {unit} apart.", apart=format_number(abs(values[1][0] - values[0][0]), ".3g"),
                     unit=case.units[i]) if case.units[i] else
        text("At the start they are {apart} apart.", apart=format_number(abs(values[1][0] - values[0][0]), ".3g")))
    return readings, states


def _told(s: Sensed, found: TwoStarts, noise: float) -> Text:
    """Whether the readings tell two different starts apart: not at all, only without noise, or clearly."""
    if not s.seen.observable and found.gap <= SAME_READING * float(np.abs(found.v).max()):
        return text("The readings of both starts agree at every time: no record distinguishes the two.")
    if found.gap < noise:
        return text("The readings differ by at most {gap:.2g} of a typical reading, less than their noise.", gap=found.gap)
    return text("The readings differ by up to {gap:.2g} of a typical reading, so they distinguish the two starts.", gap=found.gap)
