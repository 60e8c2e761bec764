"""Keep the colours, dashes and widths of the players' curves."""

from __future__ import annotations

from observer_lab.course.figures.records import Dash
from observer_lab.course.lesson import Outcome

from .controllers import ORDER
from .study import Study

CURVE_STYLES: tuple[tuple[str, Dash], ...] = (
    ("muted", "solid"), ("disturbance", "solid"), ("plant", "solid"), ("reference", "dash"), ("error", "dash"),
)


def width(outcome: Outcome[Study], i: int) -> float:
    """Of the curve of player i: wider for the one on the stage."""
    return 2.6 if ORDER[i] == outcome.design["play"] else 1.6
