"""Compute a design of lesson 12: ranks, Hankel values and a truncation with its error."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Generic, TypeVar

import numpy as np

from observer_lab.course.figures.records import Curve, Figure
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue, TabFigures
from observer_lab.course.lesson import Check, Design, Formula, Outcome, Stage
from observer_lab.engine import Plant, balanced_truncation, frequency_response
from observer_lab.engine.structure import Truncation, controllability_matrix, observability_matrix
from observer_lab.text import NO_WORDS, Text, text

from ..toolkit.latex import number

ROUNDING = 1e-9  # of the largest gain: rounding of a frequency response
EQUAL = 1e-3  # of a Hankel value: two that differ by less count as equal
RELATIVE, ABSOLUTE = "relative", "absolute"
MEASURES = ((RELATIVE, text("of the largest")), (ABSOLUTE, text("as they are")))


Reduced = tuple[Plant, np.ndarray, np.ndarray, float]  # model of r states, x ≈ T z (n×r), z = left x (r×n), bound of its error


@dataclass(frozen=True, eq=False)
class System:
    """A plant and its balanced states: `balanced` keeps all that take part between u and y, the unstable ones last; f in Hz."""

    plant: Plant
    balanced: Truncation
    frequencies: np.ndarray

    @property
    def hankel(self) -> np.ndarray:
        """The Hankel values of its stable part, largest first."""
        return self.balanced.hankel

    @property
    def kept(self) -> int:
        """How many unstable states there are, which no model may leave out."""
        return self.balanced.kept

    @property
    def most(self) -> int:
        """How many states take part between u and y."""
        return self.balanced.plant.n

    @cached_property
    def response(self) -> np.ndarray:
        """G(j2πf), a matrix for each f."""
        return self.heard(self.plant)

    def heard(self, plant: Plant) -> np.ndarray:
        """The response of a plant with these inputs and outputs; a pole on the axis is passed beside it."""
        with np.errstate(all="ignore"):
            return frequency_response(plant.A, plant.B, plant.C, np.asarray(plant.D), 2 * np.pi * self.frequencies)

    def counted(self, clock: float) -> Plant:
        """The plant with its time in units of `clock` seconds; the states stay in the units given."""
        P = self.plant
        return Plant(clock * P.A, clock * P.B, P.C, P.D)

    def reduced(self, order: int) -> Reduced:
        """The balanced truncation to `order` states."""
        small = self.balanced if order == self.most else balanced_truncation(self.plant, order)
        return small.plant, small.T, small.left, small.error_bound


def norms(response: np.ndarray) -> np.ndarray:
    """σ_max of a matrix for each frequency, 0 where a pole lies on the axis."""
    return np.linalg.norm(np.where(np.isfinite(response), response, 0.0), 2, axis=(1, 2))


@dataclass(frozen=True, eq=False)
class Cut:
    """A model of `order` states and what it loses: σ_max(G − G_r) over frequency, its peak and where, and two bounds on it.

    x ≈ T z, z = left x. bound: 2 Σ σ over all that is cut. sharp: the same with equal values counted once; None where the cut runs
    between equal ones.
    """

    order: int
    model: Plant
    T: np.ndarray
    left: np.ndarray
    bound: float
    error: np.ndarray
    peak: float
    where: float
    sharp: float | None


@lru_cache(maxsize=64)
def cut(s: System, order: int) -> Cut:
    """The truncation to `order` states, and its error over frequency."""
    small = s.reduced(order)
    error = norms(s.response - s.heard(small[0]))
    at = int(error.argmax())
    return Cut(order, *small, error, float(error[at]), float(s.frequencies[at]), sharp_bound(s.hankel, order - s.kept))


def sharp_bound(values: np.ndarray, order: int) -> float | None:
    """2 Σ over the distinct values that are cut, each once however often it occurs; None if kept and cut values are equal.

    Values that differ by less than EQUAL of themselves count as equal. Source: Glover (1984), theorem 9.6; Enns (1984).
    """
    steps = np.flatnonzero(values[:-1] - values[1:] > EQUAL * values[:-1]) + 1  # where another value begins
    if order == len(values):
        return 0.0
    if order and order not in steps:
        return None
    return float(2 * values[[order, *(k for k in steps if k > order)]].sum())


@dataclass(frozen=True, eq=False)
class Ranks:
    """Singular values (n,) of both matrices, time counted in units of `clock` seconds."""

    clock: float
    reached: np.ndarray
    seen: np.ndarray

    def at(self, tolerance: float, measure: str) -> tuple[int, int]:
        """Rank of both matrices: singular values above the tolerance, or above the tolerance times the largest."""
        return _count(self.reached, tolerance, measure), _count(self.seen, tolerance, measure)


@lru_cache(maxsize=64)
def ranks(s: System, clock: float) -> Ranks:
    """Singular values with time in units of `clock` seconds."""
    counted = s.counted(clock)
    return Ranks(clock, *(np.linalg.svd(M, compute_uv=False) for M in (controllability_matrix(counted), observability_matrix(counted))))


def _count(values: np.ndarray, tolerance: float, measure: str) -> int:
    return int(np.count_nonzero(values > tolerance * (values[0] if measure == RELATIVE else 1.0)))


@dataclass(frozen=True, eq=False)
class Study:
    """Ranks with time in units of `clock`, and a cut to `order` states. Each is found when it is looked at."""

    system: System
    clock: float
    order: int

    @cached_property
    def ranks(self) -> Ranks:
        """Singular values of the matrices of controllability and observability."""
        return ranks(self.system, self.clock)

    @cached_property
    def cut(self) -> Cut:
        """The truncation and its error."""
        return cut(self.system, self.order)

    @property
    def bound_check(self) -> Check:
        """Whether the error keeps below its bound, but for what rounding may make of it."""
        c, response = self.cut, self.system.response
        dust = ROUNDING * float(np.abs(response[np.isfinite(response)]).max(initial=0.0))
        return Check("bound", text("the error keeps below 2Σσ"), c.peak <= c.bound * (1 + 1e-6) + dust, c.peak)


S = TypeVar("S", bound=Study)


@dataclass(frozen=True, eq=False)
class Setting(Generic[S]):
    """The plant of the lesson, and what is told of it beside ranks and truncation.

    `numbers`: further metrics; `told`: ranges that others name, beside the ranks; `staircase`, `beside`: the Hankel values, and figures
    beside them; `sharper`: what is said of the sharper bound; `floor`, `window`: least error and range of its axis, where they are fixed.
    """

    studied: Callable[[Design], S]
    stage: Callable[[S], Stage]
    gains: Callable[[S], Mapping[str, np.ndarray]]
    numbers: Callable[[S], Mapping[str, float | None]]
    checks: Callable[[S, Mapping[str, float]], tuple[Check, ...]]
    formulas: Callable[[S], tuple[Formula, ...]]
    live: Callable[[S], Text]
    staircase: Callable[[S], Figure]
    more: Callable[[Outcome[S]], tuple[TabFigures, ...]]
    beside: Callable[[S], tuple[Figure, ...]] = lambda _: ()
    told: tuple[Curve, ...] = ()
    sharper: Callable[[Cut], Text] = lambda _: NO_WORDS
    floor: float | None = None
    window: tuple[float, float] | None = None


def compute(here: Setting[S], design: Design) -> Outcome[S]:
    """Ranks, Hankel values, the truncation with its error, and what the plant shows on the stage."""
    study = here.studied(design)
    metrics = LazyMap(lambda: _metrics(design, study, here.numbers(study)))
    return Outcome(design, LazyMap(lambda: here.gains(study)),
                   LazyMap(lambda: {"plant": study.system.plant.poles, "model": study.cut.model.poles}), metrics,
                   LazySequence(lambda: here.checks(study, metrics)), stage=here.stage(study),
                   formulas=LazySequence(lambda: (*_formulas(study), *here.formulas(study))), words=LazyValue(lambda: here.live(study)),
                   study=study)


def _metrics(design: Design, study: Study, more: Mapping[str, float | None]) -> dict[str, float]:
    reached, seen = study.ranks.at(design["tolerance"], design["measure"])
    found = {
        "rank_controllability": reached, "rank_observability": seen, "error": study.cut.peak, "error_at": study.cut.where,
        "bound": study.cut.bound, "sharp": study.cut.sharp, **more,
        **{f"sigma{k + 1}": float(v) for k, v in enumerate(study.system.hankel)},
    }
    return {name: float(value) for name, value in found.items() if value is not None}


def _formulas(study: Study) -> tuple[Formula, ...]:
    s, c = study.system, study.cut
    bound = (rf"\|G-G_{{{c.order}}}\|_\infty = {number(c.peak)} \le 2\sum_{{i>{c.order - s.kept}}}\sigma_i = {number(c.bound)}"
             if c.order < s.most else rf"G_{{{s.most}}} = G")
    return (Formula("hankel", r"\sigma_i = \sqrt{\lambda_i(W_c W_o)}"), Formula("bound", bound))
