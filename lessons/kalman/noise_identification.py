"""Estimate Q and R from one record by the likelihood of its innovations."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from observer_lab.course.figures.records import Curve, PlaneFigure, Point
from observer_lab.course.lesson import Outcome
from observer_lab.engine import KalmanFilter
from observer_lab.text import text

from .deck_study import DeckStudy
from .filters import UNTESTED_SAMPLES, Truth, tuned
from .knobs import WHITE

RATIOS = np.logspace(-3.0, 3.0, 61)  # of Q over R, each in units of the truth
CHI2_95_PERCENT = 3.841  # 95 % point of χ² with one degree of freedom
TALL = 3.0  # of the figure
FIT_TAB = text("Fit")


@dataclass(frozen=True, eq=False)
class Fit:
    """What a record says of Q and R, in units of the true ones.

    excess (n,): −2 log L per sample over RATIOS, R chosen best at each, above its least. q and r are there, and `low` and `high`
    the ratios q/r that it leaves open at 95 %. `least` is the level itself.
    """

    excess: np.ndarray
    q: float
    r: float
    low: float
    high: float
    least: float


@lru_cache(maxsize=1)
def _bank() -> tuple[np.ndarray, np.ndarray]:
    """Settled gains (n, 6, 4) and covariances S (n, 4, 4) of filters that believe in RATIOS times the true Q and in the true R."""
    kf = tuned()
    steady = [KalmanFilter(kf.A, kf.B, kf.C, ratio * kf.Q, kf.R, dt=kf.dt).steady for ratio in RATIOS]
    return (np.array([s.filter_gain for s in steady]),
            np.array([kf.C @ s.solution @ kf.C.T + kf.R for s in steady]))


@lru_cache(maxsize=8)
def fitted(record: Truth) -> Fit:
    """The most likely Q and R of a record (n_t, 4), of the known forms q Q and r R.

    The gain of a settled filter depends on q/r alone and S = r S₁, so −2 log L / n = log det S₁ + p log r + tr(S₁⁻¹ N)/r, N the mean
    of ννᵀ. The best r at each ratio is tr(S₁⁻¹ N)/p: one curve is left.
    Source: Schweppe, IEEE Transactions on Information Theory 11 (1965) 61–70; Mehra, IEEE Transactions on Automatic Control 15 (1970).
    """
    kf, (gains, S) = tuned(), _bank()
    x, p = np.zeros((len(RATIOS), kf.n)), kf.C.shape[0]
    squares, driven = np.zeros_like(S), record.u @ kf.B.T
    for k, y in enumerate(record.y):
        nu = y - x @ kf.C.T
        if k >= UNTESTED_SAMPLES:
            squares += nu[:, :, None] * nu[:, None, :]
        x = (x + (gains @ nu[:, :, None])[:, :, 0]) @ kf.A.T + driven[k]
    count = len(record.y) - UNTESTED_SAMPLES
    r = np.trace(np.linalg.solve(S, squares), axis1=1, axis2=2) / (p * count)
    level = np.linalg.slogdet(S)[1] + p * np.log(r) + p
    best, least = int(np.argmin(level)), float(level.min())
    open_ = RATIOS[count * (level - least) <= CHI2_95_PERCENT]
    return Fit(level - least, float(RATIOS[best] * r[best]), float(r[best]), float(open_[0]), float(open_[-1]), least)


def fit_figure(outcome: Outcome[DeckStudy]) -> PlaneFigure:
    """The likelihood over the ratio, what this record leaves open, and where the present filter stands."""
    s, d, found = outcome.study, outcome.design, fitted(outcome.study.truth)
    white = d["noise"] == WHITE
    x = np.log10(RATIOS)
    nu, S = s.track.innovations[UNTESTED_SAMPLES:], s.track.S[UNTESTED_SAMPLES:]
    now = float(np.mean(np.linalg.slogdet(S)[1] + np.einsum("ki,ki->k", nu, np.linalg.solve(S, nu[:, :, None])[:, :, 0]))) - found.least
    points = [Point(0.0, 0.0, "plant", "circle", text("true")),
              Point(float(np.log10(found.q / found.r)), 0.0, "estimate", "dot", text("best"))]
    if white:
        points.append(Point(float(np.log10(d["q"] / d["r"])), min(now, TALL), "error", "cross", text("now")))
    said = (text("This record fits best with q = {q:.2g} and r = {r:.2g}; q/r from {low:.2g} to {high:.2g} is left open (95 %). Your "
                 "filter is less likely by {now:.3g} in −2 log L a sample.",
                 q=found.q, r=found.r, low=found.low, high=found.high, now=max(now, 0.0))
            if white else
            text("The converter's noise has a memory, and this fit takes it for white: it makes q = {q:.2g} and r = {r:.2g} of it.",
                 q=found.q, r=found.r))
    return PlaneFigure("fit", text("which Q and R explain this record"),
                       (Curve(text("R chosen best"), np.minimum(found.excess, 2 * TALL), "estimate", x=x),), tuple(points),
                       "q/r", text("−2 log L a sample, above its least"), (-3.0, 3.0), (-0.1 * TALL, TALL), caption=said,
                       tab=FIT_TAB, powers="x")
