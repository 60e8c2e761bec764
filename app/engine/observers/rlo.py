"""Find the functional observer of lowest order and least sensitivity: algorithm RLO."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from ..structure.coprime import CoprimeFactors, coprime_factors
from ..systems.errors import EngineError, PoleError
from ..systems.gates.argument_checks import (
    FUNCTION,
    SEED,
    choice,
    count,
    either,
    instance,
    items,
    matrix,
    number,
    optional,
    passed,
    real,
    takes,
)
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record
from .directions import seen_rows
from .family import Family
from .functional import FunctionalObserver, assemble, check_functional, check_stable
from .perturbation import Norm, Perturbations, check_norm, every_entry
from .search import kinked_line, kinked_minimum, spaced

__all__ = ["Attempt", "Region", "RobustObserver", "rlo", "rlo_steps"]

Measure = Callable[[FunctionalObserver], float]


@record(eq=True)
class Region:
    """re_low ≤ Re s ≤ re_high, im_low ≤ |Im s| ≤ im_high; with im_high = 0 real poles only."""

    re_low: float
    re_high: float
    im_low: float = 0.0
    im_high: float = 0.0

    def __post_init__(self) -> None:
        bound = number(infinite=True)
        passed(self, re_low=bound, re_high=bound, im_low=bound, im_high=bound)


@record(eq=True)
class Attempt:
    """One order with so many complex pairs: did an observer exist, how far K was missed (relative), the least J."""

    order: int
    pairs: int
    feasible: bool
    gap: float
    J: float


@record()
class RobustObserver:
    """What RLO found: the observer, the measure it minimised, and what was tried on the way, in order."""

    observer: FunctionalObserver
    value: float
    attempts: tuple[Attempt, ...]
    evaluations: int


@takes(plant=PLANT, K=matrix(), wrong=instance(Perturbations), norm=choice(1, 2, "inf"),
       region=optional(either(Region, items(instance(Region), 1000))), max_order=optional(count(1, 1000)), measure=FUNCTION,
       seed=SEED, worst_condition=number(1))
def rlo(plant: Plant, K: object, *, wrong: Perturbations | None = None, norm: Any = 2,
        region: Region | Sequence[Region] | None = None, max_order: int | None = None, measure: Measure | None = None,
        seed: int = 0, worst_condition: float = 1e4) -> RobustObserver:
    """The functional observer of K x (r×n) of lowest order with its poles in `region` and the least J.

    min J(sᵢ, gᵢ, M′) = Σ αᵢ‖T Aᵢ‖ + βᵢ‖L Cᵢ‖ + γᵢ‖M Cᵢ‖ subject to T A − F T = L C, K = N T + M C, sᵢ in the region;
    the order grows from 1 until the conditions can be met. gᵢ has unit 2-norm and W = I: without a fixed scale of T
    the infimum of J is of no use. Where the condition number of [T; C] (see FunctionalObserver) is beyond
    `worst_condition`, N grows without bound (which J does not see); such observers are left out.
    A pair's second row of T vanishes with Im s, so J likes pairs near the real axis: give such a region an im_low.
    `region`: one for all poles, or one for each pole or pair, the last repeated; default: real poles from 0.001 to 10
    times the spectral radius (0.05 … 0.6 for dt > 0). `max_order`: default n − rank C. `measure`: minimise this instead of
    J. Raises EngineError where no order will do or the request makes no sense.
    Source: Duan, Li, Zhou (1993), algorithm RLO, remarks 2 and 3 (there u = +K x).

    >>> plant = Plant([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
    >>> rlo(plant, [[1, 1]], max_order=1).observer.order
    1
    """
    *_, (_, result) = rlo_steps(plant, K, wrong=wrong, norm=norm, region=region, max_order=max_order, measure=measure,
                                seed=seed, worst_condition=worst_condition)
    assert result is not None
    return result


@takes(plant=PLANT, K=matrix(), wrong=instance(Perturbations), norm=choice(1, 2, "inf"),
       region=optional(either(Region, items(instance(Region), 1000))), max_order=optional(count(1, 1000)), measure=FUNCTION,
       seed=SEED, worst_condition=number(1))
def rlo_steps(plant: Plant, K: object, *, wrong: Perturbations | None = None, norm: Any = 2,
              region: Region | Sequence[Region] | None = None, max_order: int | None = None,
              measure: Measure | None = None, seed: int = 0,
              worst_condition: float = 1e4) -> Iterator[tuple[float, RobustObserver | None]]:
    """`rlo` in steps: yields (fraction done, best so far or None), (1.0, result) last; stop iterating to cancel."""
    wanted = check_functional(plant, K)
    regions = _regions(plant, region)
    highest = max(1, plant.n - len(seen_rows(plant.A, plant.C)[0])) if max_order is None else int(max_order)
    if not 1 <= highest <= plant.n:
        raise EngineError("max_order must lie between 1 and {n}; it is {highest}.", n=plant.n, highest=highest)
    task = _Task(plant, wanted, coprime_factors(plant), every_entry(plant) if wrong is None else wrong,
                 check_norm(norm), regions, measure, seed, worst_condition)
    attempts: list[Attempt] = []
    evaluations, best = 0, None
    for order in range(1, highest + 1):
        shapes = [pairs for pairs in range(order // 2 + 1) if task.allows(order, pairs)]
        for k, pairs in enumerate(shapes):
            family = Family(plant, wanted, task.factors, task.wrong, task.norm, order, pairs, worst_condition)
            found = value = None
            for part, at, value in task.minimise(family):
                found = at if at is None else task.observer(family, at)
                if found is not None and value is not None and (best is None or value < best.value):
                    best = RobustObserver(found, float(value), tuple(attempts), evaluations)
                yield (order - 1 + (k + part) / len(shapes)) / highest * 0.999, best
            evaluations += family.evaluations
            missed = family.least_gap if found is None else found.output_residual
            attempts.append(Attempt(order, pairs, found is not None, missed,
                                    np.inf if found is None or value is None else float(value)))
        if best is not None:
            yield 1.0, RobustObserver(best.observer, best.value, tuple(attempts), evaluations)
            return
    missed = min((a.gap for a in attempts), default=np.inf)
    if missed < 1e-9:
        raise EngineError("Observers of K x exist up to order {highest} in this region, but each tried has a condition number of [T; "
                          "C] beyond {worst_condition:g}. Allow more or widen the region.",
                          highest=highest, worst_condition=worst_condition)
    raise EngineError("No observer of K x up to order {highest} has its poles in this region. K is missed by at least {missed:.2g}; "
                      "allow a higher order or a wider region.",
                      highest=highest, missed=missed)


@record()
class _Task:
    plant: Plant
    K: np.ndarray
    factors: CoprimeFactors
    wrong: Perturbations
    norm: Norm
    regions: tuple[Region, ...]
    measure: Measure | None
    seed: int
    worst_condition: float

    def of(self, head: int) -> Region:
        return self.regions[min(head, len(self.regions) - 1)]

    def allows(self, order: int, pairs: int) -> bool:
        """The pairs come first; their regions must leave the real axis, the others must touch it."""
        heads = order - pairs
        return (all(self.of(i).im_high > 0 for i in range(pairs))
                and all(self.of(i).im_low <= 0 for i in range(pairs, heads)))

    def box(self, family: Family) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of the pole part: (Re, Im) for each pair, then one number for each real pole."""
        low, high = [], []
        for i in range(family.heads):
            r = self.of(i)
            low.append(r.re_low)
            high.append(r.re_high)
            if i < family.pairs:
                low.append(max(r.im_low, 1e-6 * max(r.im_high, abs(r.re_low))))
                high.append(r.im_high)
        return np.array(low), np.array(high)

    def observer(self, family: Family, theta: np.ndarray) -> FunctionalObserver:
        low, high = self.box(family)
        poles, g, N, M = family.design(self.inside(family, theta, low, high))
        return assemble(self.plant, self.K, self.factors, poles, g, None, None, self.wrong, self.norm, (N, M))

    def inside(self, family: Family, theta: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """The point with its poles clipped into the box and, in a thin family, bent until K fits."""
        point = theta.copy()
        point[:low.size] = np.clip(theta[:low.size], low, high)
        return family.bend(point, low, high) if family.thin else point

    def minimise(self, family: Family) -> Iterator[tuple[float, np.ndarray | None, float]]:
        low, high = self.box(family)
        rng = np.random.default_rng(self.seed)
        grids = [spaced(a, b, 997) for a, b in zip(low, high, strict=True)]

        def sample(rng: np.random.Generator) -> np.ndarray:
            return np.concatenate([[grid[rng.integers(grid.size)] for grid in grids], rng.standard_normal(family.rest)])

        family.look(sample, rng)

        def value(theta: np.ndarray) -> float:
            point = self.inside(family, theta, low, high)
            J = family.J(point)
            return J if self.measure is None or not np.isfinite(J) else real(self.measure(self.observer(family, point)), "measure")

        if family.size == 1 and not family.thin:
            at, best = kinked_line(value, low[0], high[0])
            yield 1.0, at if np.isfinite(best) else None, best
            return
        effort = (10, 1, 5 * family.size, 2) if family.thin else (60 * family.size, 3, 150 * family.size, 5)
        yield from kinked_minimum(value, sample, self.seed, *effort)


def _regions(plant: Plant, region: Region | Sequence[Region] | None) -> tuple[Region, ...]:
    if region is None:
        speed = float(np.max(np.abs(plant.poles))) or 1.0
        return (Region(0.05, 0.6) if plant.dt else Region(-10 * speed, -1e-3 * speed),)
    regions = (region,) if isinstance(region, Region) else tuple(region)
    if not regions:
        raise EngineError("A region for the poles is needed.")
    for r in regions:
        if not np.all(np.isfinite([r.re_low, r.re_high, r.im_low, r.im_high])):
            raise EngineError("The bounds of a pole region must be finite numbers.")
        if r.re_low > r.re_high or r.im_low > r.im_high or r.im_low < 0:
            raise EngineError("A pole region needs re_low ≤ re_high and 0 ≤ im_low ≤ im_high.")
        corners = np.array([complex(re, im) for re in (r.re_low, r.re_high) for im in (r.im_low, r.im_high)])
        try:
            check_stable(plant, corners)
        except PoleError as problem:
            raise EngineError("The pole region must lie wholly inside the stable region.") from problem
    return regions
