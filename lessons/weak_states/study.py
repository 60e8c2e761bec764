"""Compute a design of lesson 12: ranks, truncation, mode shown, two regulators."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Check, Design, Formula, Outcome
from observer_lab.engine import Plant
from observer_lab.engine.structure import controllability_matrix, observability_matrix
from observer_lab.plants.platform.model import Parameters, in_time_units
from observer_lab.text import Text, text

from ..toolkit.latex import number
from .balanced_platform import MASSES_AGAINST_MODE, MASSES_TOGETHER_MODE, STATE_COUNT, Cut, Motion, System, closed_forms, cut, system
from .body import share, slower, swing
from .reduced_regulator import Compared, compare

RELATIVE, ABSOLUTE = "relative", "absolute"
MEASURES = ((RELATIVE, text("of the largest")), (ABSOLUTE, text("as they are")))
REPORT = (1e-12, 1e-6)  # tolerances that the report names


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
    """Singular values with time in units of `clock` seconds; metres, radians and newtons stay."""
    return ranks_of(in_time_units(s.plant, clock), clock)


def ranks_of(counted: Plant, clock: float) -> Ranks:
    """The singular values of a plant whose time is counted in units of `clock` seconds already."""
    return Ranks(clock, *(np.linalg.svd(M, compute_uv=False) for M in (controllability_matrix(counted), observability_matrix(counted))))


def _count(values: np.ndarray, tolerance: float, measure: str) -> int:
    return int(np.count_nonzero(values > tolerance * (values[0] if measure == RELATIVE else 1.0)))


@dataclass(frozen=True, eq=False)
class Study:
    """All that a design leads to: ranks with time in units of `clock`, a cut to `order` states, LQG on ten and on so many. Each is
    found when it is looked at."""

    system: System
    clock: float
    order: int
    v0: float
    pressed: str

    @cached_property
    def ranks(self) -> Ranks:
        """Singular values of the matrices of controllability and observability."""
        return ranks(self.system, self.clock)

    @cached_property
    def cut(self) -> Cut:
        """The truncation and its error."""
        return cut(self.system, self.order)

    @cached_property
    def compared(self) -> Compared:
        """LQG on both."""
        return compare(self.system, self.order, self.v0, self.pressed)


def compute(design: Design) -> Outcome[Study]:
    """Ranks, Hankel values, the truncation with its error, the motion on the stage, LQG on ten states and on fewer."""
    s = system(Parameters(**{name: design[name] for name in ("s", "h", "a", "mu", "kp")}), design["ground"])
    order = int(design["order"])
    study = Study(s, design["clock"], order, design["v0"], design["pressed"])
    motion = s.motions[int(design["pair"]) - 1]
    metrics = LazyMap(lambda: _metrics(design, study, motion))
    return Outcome(design, LazyMap(lambda: {"K": study.compared.small.design.K, "L": study.compared.small.design.L}),
                   LazyMap(lambda: {"plant": s.plant.poles, "model": study.cut.model.poles}), metrics,
                   LazySequence(lambda: _checks(study, metrics)), stage=swing(s, motion, order),
                   formulas=LazySequence(lambda: _formulas(study)), words=LazyValue(lambda: _live(study, motion, metrics)), study=study)


def _metrics(design: Design, study: Study, motion: Motion) -> dict[str, float]:
    s, c = study.system, study.compared
    reached, seen = study.ranks.at(design["tolerance"], design["measure"])
    found = {
        "rank_controllability": float(reached), "rank_observability": float(seen), "error": study.cut.peak,
        "error_at": study.cut.where, "bound": study.cut.bound, "sharp": study.cut.sharp, "held": share(s, motion, study.cut.order),
        "frequency": motion.frequency, "growth": c.growth, "gap": c.gap, "extra": c.extra,
        **{f"sigma{k + 1}": float(v) for k, v in enumerate(s.hankel)},
    }
    return {name: float(value) for name, value in found.items() if value is not None}


def _checks(study: Study, m: Mapping[str, float]) -> tuple[Check, ...]:
    c = study.compared
    return (
        Check("rank", text("both matrices have rank 10 at this tolerance"),
              m["rank_controllability"] == m["rank_observability"] == STATE_COUNT, min(m["rank_controllability"], m["rank_observability"]),
              informative=True),
        Check("bound", text("the error keeps below 2Σσ"), m["error"] <= m["bound"] * (1 + 1e-6) + 1e-8, m["error"]),
        Check("stable", text("LQG on the cut model holds the platform"), c.small.stable,
              c.small.rightmost),
        Check("same", text("both loops agree within 1 %"), c.gap is not None and c.gap < 0.01,
              1.0 if c.gap is None else c.gap),
        Check("growth", text("ten states ask for at most 5 % more gain"), c.growth < 0.05, c.growth),
    )


def _formulas(study: Study) -> tuple[Formula, ...]:
    s, forms = study.system, dict(closed_forms(study.system.parameters, study.system.unit))
    bound = (rf"\|G-G_{{{study.cut.order}}}\|_\infty = {number(study.cut.peak)} \le 2\sum_{{i>{study.cut.order}}}\sigma_i = "
             rf"{number(study.cut.bound)}") if study.cut.order < STATE_COUNT else r"G_{10} = G"
    return (
        Formula("hankel", r"\sigma_i = \sqrt{\lambda_i(W_c W_o)}"),
        Formula("bound", bound),
        Formula(
            "together",
            rf"\sigma \approx \frac{{\sqrt2\, N_z\mu^2}}{{m^2 c_p}} = {number(forms[MASSES_TOGETHER_MODE])}, \quad "
            rf"\sigma_{{{2 * s.pair(MASSES_TOGETHER_MODE) + 1}}} = {number(float(s.hankel[2 * s.pair(MASSES_TOGETHER_MODE)]))}",
        ),
        Formula(
            "against",
            rf"\sigma \approx \frac{{\sqrt2\, N_\theta \mu^2 s^2\sqrt{{s^2+h^2}}}}{{J^2 c_p}} = {number(forms[MASSES_AGAINST_MODE])}, "
            rf"\quad \sigma_{{{2 * s.pair(MASSES_AGAINST_MODE) + 1}}} = {number(float(s.hankel[2 * s.pair(MASSES_AGAINST_MODE)]))}",
        ),
        Formula(
            "pushes",
            r"N_z = \sqrt{2 + (2k_z g)^2}, \quad N_\theta = \sqrt{2b^2 + h^2 + (k_x h g)^2}",
            text("what one unit of every input lifts and turns; g: the ground's unit"),
        ),
    )


def _live(study: Study, motion: Motion, m: Mapping[str, float]) -> Text:
    order = study.cut.order
    ghost = (text("the ghost moves with it") if m["held"] > 0.9 else
             text("the ghost stands still") if m["held"] < 0.1 else
             text("the ghost moves in part"))
    factor = slower(motion)
    shown = text("On the stage: {name}, {frequency:.3g} Hz, drawn {factor:.2g} times slower; ",
                 name=motion.name, frequency=motion.frequency, factor=factor)
    if order == STATE_COUNT:
        return text("{shown}all ten states are kept.", shown=shown)
    return text("{shown}{ghost}: {order} of 10 states are kept, error {error:.3g}.",
                shown=shown, ghost=ghost, order=order, error=m["error"])
