"""Hold the errors of many seeds of one design beside the covariance that was predicted for them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..engine import chi2_band, nees
from ..engine.filters import SquaredError
from ..text import Text, same, text
from .figures.records import Curve, PlaneFigure, Point, TableFigure

SEED_COUNT = 300  # seeds that are run where there is no class
LEVEL = 0.95  # probability of the ellipses and bands
RADIUS = float(np.sqrt(-2 * np.log(1 - LEVEL)))  # of that ellipse in standard deviations: χ² with two degrees of freedom
CIRCLE = np.stack([f(np.linspace(0, 2 * np.pi, 73)) for f in (np.cos, np.sin)])
MARGIN = 1.3  # times the predicted ellipse that the figure shows at least
TAB = text("Many seeds")
CONSISTENT = text("The errors are as large as P says.")
OVER_CONFIDENT = text("The errors are larger than P says: P is over-confident.")
UNDER_CONFIDENT = text("The errors are smaller than P says: P is under-confident.")


@dataclass(frozen=True, eq=False)
class SeedErrors:
    """Errors of N seeds of one design at time `t` in s.

    errors (N, n), NaN in a run that was given up. covariance: the P that was predicted, (n, n), or (N, n, n) where each run has
    its own. rows (2, n): the two signals that are drawn, in the units that `names` states. times (k,), paths (N, k): the course of
    the error of the first one; sigmas (k,) or (N, k): its predicted standard deviation.
    """

    t: float
    errors: np.ndarray
    covariance: np.ndarray
    rows: np.ndarray
    names: tuple[Text, Text]
    times: np.ndarray
    paths: np.ndarray
    sigmas: np.ndarray

    @cached_property
    def kept(self) -> np.ndarray:
        """Which runs were not given up (N,)."""
        return np.isfinite(self.errors).all(axis=1)

    @property
    def count(self) -> int:
        """How many."""
        return int(self.kept.sum())

    @cached_property
    def shown(self) -> np.ndarray:
        """The errors of the two signals (count, 2), in an order that does not tell which run is whose."""
        found = self.errors[self.kept] @ self.rows.T
        return found[np.lexsort(found.T)]

    @cached_property
    def predicted(self) -> np.ndarray:
        """Their covariance (2, 2) as predicted, on average over the runs."""
        P = self.covariance if self.covariance.ndim == 2 else self.covariance[self.kept].mean(axis=0)
        return self.rows @ P @ self.rows.T

    @cached_property
    def sample(self) -> np.ndarray:
        """Their covariance (2, 2) in the runs, about the mean of zero that an unbiased estimate has."""
        return self.shown.T @ self.shown / max(self.count, 1)

    @cached_property
    def judged(self) -> SquaredError:
        """The average NEES of all states over the runs, with its band.

        ε̄ = (1/N) Σ eᵢᵀ Pᵢ⁻¹ eᵢ. For a consistent filter N ε̄ has the distribution χ²(N n), because the runs are independent; see
        Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section 5.4.2.
        Raises EngineError where P is not positive definite, or no run is left.
        """
        e = self.errors[self.kept][:, None]
        P = self.covariance if self.covariance.ndim == 2 else self.covariance[self.kept][:, None]
        return nees(e, np.zeros_like(e), P, level=LEVEL, independent=1.0)

    @cached_property
    def inside(self) -> np.ndarray:
        """Which runs lie in the predicted ellipse (N,); one that was given up does not."""
        found = np.where(self.kept[:, None], self.errors, 0.0) @ self.rows.T
        squares = np.einsum("ki,ij,kj->k", found, np.linalg.inv(self.predicted), found)
        return self.kept & (squares <= RADIUS**2)


SeedTrial = Callable[[Any, np.ndarray], Iterator[tuple[float, SeedErrors | None]]]
"""What a lesson gives: (outcome, seeds) → (fraction, errors of the seeds so far). The design is computed once; the noise alone differs."""


def ellipse(P: np.ndarray) -> np.ndarray:
    """The ellipse (2, k) that holds a Gaussian error of covariance P with probability LEVEL."""
    values, vectors = np.linalg.eigh(P)
    return RADIUS * (vectors * np.sqrt(np.maximum(values, 0.0))) @ CIRCLE


def cloud_figure(found: SeedErrors) -> PlaneFigure:
    """All errors as points, with the ellipse of P and that of the sample covariance."""
    rings = ellipse(found.predicted), ellipse(found.sample)
    half = MARGIN * np.maximum(*(np.abs(ring).max(axis=1) for ring in rings))
    share = 100 * float(found.inside.sum()) / max(found.count, 1)
    return PlaneFigure(
        "many-seeds", text("errors of {count} seeds at {t:.3g} s", count=found.count, t=found.t),
        (Curve(text("95 % ellipse of P"), rings[0][1], "reference", "dash", 2.0, rings[0][0]),
         Curve(text("95 % ellipse of the runs"), rings[1][1], "error", "solid", 2.0, rings[1][0])),
        tuple(Point(float(x), float(y), "estimate", "dot") for x, y in found.shown), *found.names,
        (-float(half[0]), float(half[0])), (-float(half[1]), float(half[1])), tab=TAB,
        caption=text("{share:.0f} % of the runs lie in the ellipse of P; 95 % are expected.", share=share))


def covariance_table(found: SeedErrors) -> TableFigure:
    """The standard deviations and the average NEES of the runs, beside what P predicts and their χ² bands."""
    low, high = (float(np.sqrt(edge)) for edge in chi2_band(1, count=found.count, level=LEVEL))
    deviations = [(name, float(np.sqrt(found.predicted[i, i])), float(np.sqrt(found.sample[i, i]))) for i, name in enumerate(found.names)]
    whole = found.judged
    rows = [(text("σ: {name}", name=name), f"{sigma:.3g}", f"{tried:.3g}", f"{low * sigma:.3g} … {high * sigma:.3g}")
            for name, sigma, tried in deviations]
    rows.append((text("average NEES"), str(whole.dof), f"{whole.values[0]:.3g}", f"{whole.band[0]:.3g} … {whole.band[1]:.3g}"))
    return TableFigure("many-seeds-table", text("predicted by P and found in the runs"),
                       (same(""), text("predicted"), text("in the runs"), text("95 % band")), tuple(rows), tab=TAB,
                       caption=verdict_words(found))


def verdict_words(found: SeedErrors) -> Text:
    """Whether P is consistent with the runs."""
    (low, high), mean = found.judged.band, float(found.judged.values[0])
    return OVER_CONFIDENT if mean > high else UNDER_CONFIDENT if mean < low else CONSISTENT
