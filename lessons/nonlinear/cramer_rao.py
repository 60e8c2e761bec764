"""Compute the Cramér–Rao bound for these runs and the distance of each filter from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Design
from observer_lab.engine import NonlinearPlant
from observer_lab.engine.filters import Experiment, Sample, posterior_bound, slopes_along
from observer_lab.engine.systems import Flow
from observer_lab.text import Text, joined, listed, text

from .cases import PLATFORM, UKF, Case, judged

PRIOR = 20  # runs that the deviation of a filter at the bound counts for
CHANCE_SIGMAS = 2.0  # standard errors that the runs of chance are given
NEAR_BOUND_PERCENT = 25.0  # % of an error that may be left to better filters if this one is to be called nearly as good as can be


@dataclass(frozen=True, eq=False)
class Bound:
    """The posterior Cramér–Rao bound, and the filters above it.

    rms (K,): the least rms error of the signal judged. times, unsure: by filter, its rms error over the second half of the
    record in multiples of the bound, and the standard error of that (`_multiple`); NaN where no run is left.
    """

    rms: np.ndarray
    times: Mapping[str, float]
    unsure: Mapping[str, float]

    def room(self, name: str) -> float:
        """By how many per cent a better filter could err less, at most, as far as the runs tell; at least 1."""
        return max(100 * (1 - 1 / max(self.times[name] + CHANCE_SIGMAS * self.unsure[name], 1e-9)), 1.0)

    def gap(self, name: str) -> float:
        """By how many per cent the bound lies below the error, at least, as far as the runs tell; perhaps not at all if not above 0."""
        return 100 * (1 - 1 / max(self.times[name] - CHANCE_SIGMAS * self.unsure[name], 1e-9))


class Slopes:
    """Collects the slopes of flow and sensors along the true runs, block by block."""

    def __init__(self, case: Case, experiment: Experiment, plant: NonlinearPlant) -> None:
        self.case, self.experiment, self.plant = case, experiment, plant
        self.F: list[np.ndarray] = []
        self.H: list[np.ndarray] = []

    def add(self, samples: Sequence[Sample]) -> None:
        """All samples of a block at once."""
        x = np.concatenate([s.x for s in samples], axis=1)
        runs = x.shape[1] // len(samples)
        u = np.concatenate([np.broadcast_to(s.u, (len(s.u), runs)) for s in samples], axis=1)
        flow = self.experiment.flow
        assert isinstance(flow, Flow)
        for slopes, kept in zip(slopes_along(self.plant, flow.step, x, u, parts=flow.parts), (self.F, self.H), strict=True):
            kept.append(slopes.reshape(len(samples), runs, *slopes.shape[1:]))

    def bound(self, squares: Mapping[str, np.ndarray], fell: np.ndarray) -> Bound:
        """The bound over the runs that did not fall (N,), beside squared errors (K, N) by filter, NaN where a run does not count."""
        kept = ~fell if not fell.all() else fell
        F, H = np.concatenate(self.F)[:-1, kept], np.concatenate(self.H)[:, kept]
        row = np.array(self.case.watched[judged(self.case)].weights)
        P = self._covariances(F, H)
        least = np.einsum("i,kij,j->k", row, P, row)
        late = slice(len(least) // 2, None)
        alone = spread_at_the_bound(F.mean(axis=1), H.mean(axis=1), P, self.experiment.R, row, late)
        found = {name: _multiple(of[late] / np.maximum(least[late, None], 1e-300), alone) for name, of in squares.items()}
        return Bound(np.sqrt(np.maximum(least, 0.0)), {n: v[0] for n, v in found.items()}, {n: v[1] for n, v in found.items()})

    def _covariances(self, F: np.ndarray, H: np.ndarray) -> np.ndarray:
        """The higher of the two bounds that can be had in time; they differ little on the platform, sevenfold at the pole."""
        e, unknown = self.experiment, "states" if self.case.id == PLATFORM else "noise"
        return posterior_bound(F, H, e.Q, e.R, e.start.covariance[0], unknown=unknown)


def spread_at_the_bound(F: np.ndarray, H: np.ndarray, P: np.ndarray, R: np.ndarray, row: np.ndarray, late: slice) -> float:
    """Standard deviation of one run's mean of e²/σ² over the samples `late`, for Gaussian errors of a filter that reaches the bound.

    e[k+1] = (I − K H) F e[k] + …, K = P Hᵀ R⁻¹, so cov(e[k], e[l]) = Φ(k, l) P[l] for k ≥ l, and for Gaussian errors
    cov(e[k]², e[l]²) = 2 cov(e[k], e[l])². F (K − 1, n, n), H (K, p, n), P (K, n, n), row (n,).
    """
    begin, count = late.start, len(P)
    square = np.zeros((count - begin, count - begin))
    for first in range(begin, count):
        carried = P[first] @ row
        for k in range(first, count):
            if k > first:
                carried = F[k - 1] @ carried
                carried = carried - P[k] @ H[k].T @ np.linalg.solve(R, H[k] @ carried)
            square[k - begin, first - begin] = square[first - begin, k - begin] = float(row @ carried) ** 2
    size = np.sqrt(np.maximum(np.diag(square), 1e-300))
    return float(np.sqrt(2 * np.mean(square / np.outer(size, size))))


def _multiple(squares: np.ndarray, alone: float) -> tuple[float, float]:
    """Root of the mean over samples and runs (k, N), and its standard error.

    A run's mean has the relative deviation c. Few runs say little of c, and least where they happen to be small: so c² is the runs'
    own, of N − 1 degrees of freedom, together with that of a filter at the bound (`alone`), which counts like `PRIOR` of them.
    """
    good = np.isfinite(squares)
    count = good.sum(axis=0)
    each = np.where(good, squares, 0.0).sum(axis=0)[count > 0] / count[count > 0]
    if len(each) < 2:
        return np.nan, np.nan
    mean, own = float(each.mean()), len(each) - 1
    times = float(np.sqrt(mean))
    c2 = (own * float(each.var(ddof=1)) / max(mean, 1e-300) ** 2 + PRIOR * alone**2) / (own + PRIOR)
    return times, float(np.sqrt(c2 / len(each)) / 2) * max(times, times**0.5)


def is_kalman(design: Design) -> bool:
    """Whether the chosen filter is the Kalman filter of a linear plant with Gaussian noise: then no filter errs less."""
    linear = design["case"] == PLATFORM and design["hardening"] == 0 and design["weakening"] == 0
    return linear and (design["filter"] != UKF or design["redraw"])


def words(who: str, bound: Bound, runs: int, out: int, kicked: bool, kalman: bool) -> Text:
    """How far above the bound the filters stand, and what that leaves to others; `out`: runs that do not count to the end."""
    each = listed(text("{name} {times:.3g} ± {unsure:.1g}", name=name.upper(), times=times, unsure=bound.unsure[name])
                  for name, times in bound.times.items() if np.isfinite(times))
    return joined(text("In the second half, in multiples of the bound: {each}.", each=each),
                  _room(who, bound, runs, out, kicked, kalman))


def _room(who: str, bound: Bound, runs: int, out: int, kicked: bool, kalman: bool) -> Text:
    if kicked:
        return text("The bound assumes that the kick is known, and no filter has it.")
    if kalman:
        return text("The plant is linear, so the {who} is the Kalman filter: no filter has a smaller mean square error.", who=who.upper())
    if out or not np.isfinite(bound.times[who]):
        return text("Some runs were left out, so the bound is a yardstick and no limit.")
    left, gap = bound.room(who), bound.gap(who)
    unknown = text("It takes more than {runs} runs to decide whether a better filter than the {who} can exist.", runs=runs, who=who.upper())
    better = claim(text("A better filter than the {who} may exist: the bound lies at least {gap:.0f} % below its error.", who=who.upper(),
                        gap=gap), gap, above=1.0, otherwise=unknown)
    return claim(text("As far as {runs} runs tell, no filter could have an error {left:.2g} % smaller than that of the "
                      "{who}.", runs=runs, left=left,
                      who=who.upper()), left, below=NEAR_BOUND_PERCENT,
                 otherwise=better)
