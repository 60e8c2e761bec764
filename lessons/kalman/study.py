"""Compute a design of lesson 9: one filtered record and its tests, on the deck or on an own plant."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np

from observer_lab.course.figures.records import Figure
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue, TabFigures
from observer_lab.course.lesson import Check, Design, Formula, Outcome, Stage
from observer_lab.engine import innovation_test, nees, nis
from observer_lab.engine.filters import InnovationTest, SquaredError, Track
from observer_lab.plants import Signal
from observer_lab.text import Text, text

from .filters import Truth, Watcher


@dataclass(frozen=True, eq=False)
class Trials:
    """Means over `count` runs of NIS and NEES at each sample (n_t,)."""

    count: int
    nis: np.ndarray
    nees: np.ndarray


@dataclass(frozen=True, eq=False)
class Study:
    """One record through one filter, and all that judges it, found when it is looked at. `nis` and `nees` are of the whole record."""

    truth: Truth
    watcher: Watcher
    track: Track
    trials: Trials | None = field(default=None, kw_only=True)

    @cached_property
    def test(self) -> InnovationTest:
        """Of the innovations once the filter has settled."""
        first = self.watcher.first
        return innovation_test(self.track.innovations[first:], self.track.S[first:])

    @cached_property
    def settled(self) -> SquaredError:
        """NEES once the filter has settled."""
        return self._nees(slice(self.watcher.first, None), self.watcher.independent.value)

    @cached_property
    def nis(self) -> np.ndarray:
        """νᵀ S⁻¹ ν at every sample."""
        return nis(self.track.innovations, self.track.S).values

    @cached_property
    def nees(self) -> np.ndarray:
        """eᵀ P⁻¹ e at every sample."""
        return np.concatenate([self._nees(slice(self.watcher.first)).values, self.settled.values])

    @cached_property
    def distance(self) -> np.ndarray:
        """Of the gain of each sample from that of the Riccati equation (n_t,), relative."""
        goal = self.watcher.steady.filter_gain
        return np.abs(self.track.gains - goal).max(axis=(1, 2)) / max(float(np.abs(goal).max()), 1e-300)

    @property
    def means(self) -> np.ndarray:
        """The estimates of the plant's own states (n_t, n), which come first in the filter."""
        return self.track.means[:, :self.truth.x.shape[1]]

    @property
    def covariances(self) -> np.ndarray:
        """P of them (n_t, n, n)."""
        n = self.truth.x.shape[1]
        return self.track.covariances[:, :n, :n]

    def _nees(self, part: slice, independent: float | None = None) -> SquaredError:
        P = self.covariances[part]
        spread = np.maximum(np.diagonal(P, axis1=1, axis2=2), 1e-300)
        solid = P + self.watcher.floor * spread[:, :, None] * np.eye(P.shape[1])
        return nees(self.truth.x[part], self.means[part], solid, independent=independent)


S = TypeVar("S", bound=Study)


@dataclass(frozen=True, eq=False)
class Look:
    """How the figures show a plant.

    `states`: the rows of a step's table, numbers times `scale` in `digits`; `signals`: the two states over time; `sensors`: the outputs;
    `innovation`: the name of the first one and its unit; `entries`: row, column and name of the gains that are drawn over the first
    `early` samples under `gain`; `squares`: what NIS and NEES are called; `windows`: the least range of a figure by its id; `verdict`:
    what the tests of a record mean, where all of them pass or not.
    """

    states: Sequence[Text | str]
    scale: float
    digits: str
    signals: tuple[Signal, Signal]
    sensors: Sequence[Text]
    innovation: tuple[Text, str]
    gain: Text
    entries: Callable[[np.ndarray], Sequence[tuple[int, int, str]]]
    early: int
    squares: tuple[Text, Text]
    windows: Mapping[str, tuple[float, float]]
    gauge_digits: str
    verdict: Callable[[Design, bool], Text]


@dataclass(frozen=True, eq=False)
class Setting(Generic[S]):
    """The plant of the lesson: the study of a design with the noise of a seed, and what is shown of it.

    `numbers`: further metrics; `planes` and `more`: figures beside the table of a step, and further tabs.
    """

    studied: Callable[[Design, int], S]
    stage: Callable[[Design, S], Stage]
    numbers: Callable[[Design, S], Mapping[str, float]]
    formulas: Callable[[Design, S], tuple[Formula, ...]]
    live: Callable[[S], Text]
    look: Look
    planes: Callable[[Outcome[S]], tuple[Figure, ...]] = lambda _: ()
    more: Callable[[Outcome[S]], tuple[TabFigures, ...]] = lambda _: ()


def compute(here: Setting[S], design: Design) -> Outcome[S]:
    """The filter with its beliefs, the record filtered, and judged when that is looked at."""
    study = here.studied(design, int(design["seed"]))
    steady = study.watcher.steady
    metrics = LazyMap(lambda: {**_metrics(study), **here.numbers(design, study)})
    poles = np.where(np.abs(steady.poles) > 1e-12, steady.poles, 1e-12).astype(complex)
    return Outcome(design, {"M": study.track.schedule.gains[-1], "M_riccati": steady.filter_gain},
                   {"filter": np.log(poles) / study.watcher.filter.dt}, metrics,
                   LazySequence(lambda: checks(study.test, study.settled, metrics["gain_gap"])), None, (), here.stage(design, study),
                   LazySequence(lambda: here.formulas(design, study)), LazyValue(lambda: here.live(study)), study)


def _metrics(s: Study) -> dict[str, float]:
    return {"nis_mean": s.test.nis.mean, "nees_mean": s.settled.mean, "white_p": s.test.whiteness.p_value,
            "gain_gap": float(s.distance[-1]), "riccati_residual": s.watcher.steady.residual}


def holds(test: InnovationTest, settled: SquaredError) -> dict[str, bool]:
    """Which tests a record passes."""
    failed = failures_of(test)
    return {"centred": "biased" not in failed, "white": "coloured" not in failed, "nis": test.nis.verdict == "consistent",
            "nees": settled.verdict == "consistent"}


def failures_of(test: InnovationTest) -> tuple[str, ...]:
    """The tests that fail, without that of the bias where another fails: it takes innovations for white, of covariance S."""
    return test.failures if bias_is_judged(test) else tuple(name for name in test.failures if name != "biased")


def bias_is_judged(test: InnovationTest) -> bool:
    """Whether the innovations are white and of the size that the filter says, as the test of the mean assumes."""
    return not set(test.failures) - {"biased"}


def checks(test: InnovationTest, settled: SquaredError, gain_gap: float) -> tuple[Check, ...]:
    """The lights of a record: its tests, and whether the gain has come to rest."""
    held = holds(test, settled)
    return (
        Check("centred", text("innovations have no bias"), held["centred"], test.bias_p_value),
        Check("white", text("innovations are white"), held["white"], test.whiteness.p_value, informative=True),
        Check("nis", text("NIS lies in its band"), held["nis"], test.nis.mean),
        Check("nees", text("NEES lies in its band"), held["nees"], settled.mean, informative=True),
        Check("riccati", text("the gain has reached the Riccati solution"), gain_gap < 1e-3, gain_gap),
    )
