"""Correct one number by one reading: the Kalman filter of one state at one sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any  # the study is computed with this module, so its type is `Any` here

import numpy as np

from observer_lab.course.figures.records import Curve, PlaneFigure, Point
from observer_lab.course.lesson import Design, Outcome
from observer_lab.text import text

NUMBER_TAB = text("One number")
PREDICTED, READ = 1.0, 4.0  # the estimate before the reading, and the reading
RANGE = (-6.0, 11.0)  # of the axis of the number
TALLEST = 0.6  # of the axis of the densities


@dataclass(frozen=True)
class OneReading:
    """x̂⁻ = 1 with the variance P⁻ takes in the reading y = 4 of the variance R: S = P⁻ + R, M = P⁻/S."""

    P_prior: float
    R: float

    @property
    def S(self) -> float:
        """Variance of the innovation y − x̂⁻."""
        return self.P_prior + self.R

    @property
    def M(self) -> float:
        """The gain."""
        return self.P_prior / self.S

    @property
    def mean(self) -> float:
        """x̂⁺ = x̂⁻ + M (y − x̂⁻)."""
        return PREDICTED + self.M * (READ - PREDICTED)

    @property
    def P(self) -> float:
        """Variance after the reading, (1 − M) P⁻: as 1/P = 1/P⁻ + 1/R says, below both."""
        return (1 - self.M) * self.P_prior

    @property
    def metrics(self) -> dict[str, float]:
        """What a card names."""
        return {"one_gain": self.M, "one_mean": self.mean, "one_variance": self.P}


def one_reading(design: Design) -> OneReading:
    """At the knobs of a design."""
    return OneReading(design["one_p"], design["one_r"])


def _density(x: np.ndarray, mean: float, variance: float) -> np.ndarray:
    return np.exp(-0.5 * (x - mean) ** 2 / variance) / np.sqrt(2 * np.pi * variance)


def number_figure(outcome: Outcome[Any]) -> PlaneFigure:
    """The densities of the estimate before, of the reading, and of the estimate after it."""
    one, x = one_reading(outcome.design), np.linspace(*RANGE, 341)
    curves = tuple(Curve(name, _density(x, mean, variance), role, dash, 2.0, x) for name, mean, variance, role, dash in (
        (text("estimate before"), PREDICTED, one.P_prior, "disturbance", "dash"),
        (text("reading"), READ, one.R, "second", "dot"),
        (text("estimate after"), one.mean, one.P, "estimate", "solid")))
    said = text("Gain M = P⁻/S = {M:.2g} with S = P⁻ + R = {S:.3g}. The estimate moves from 1 to {mean:.3g}, and its variance falls "
                "from {before:.3g} to {after:.3g}.", M=one.M, S=one.S, mean=one.mean, before=one.P_prior, after=one.P)
    return PlaneFigure("number", text("one number before and after one reading"), curves, (Point(one.mean, 0.0, "estimate"),),
                       text("the number"), text("density"), RANGE, (0.0, TALLEST), caption=said, tab=NUMBER_TAB)
