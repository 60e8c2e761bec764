"""Compute what lesson 12 has on the platform alone: the motion on the stage and two regulators."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from observer_lab.course.lesson import Check, Design, Formula
from observer_lab.plants.platform.model import Parameters
from observer_lab.text import Text, text

from ..toolkit.latex import number
from .balanced_platform import MASSES_AGAINST_MODE, MASSES_TOGETHER_MODE, STATE_COUNT, Motion, Platform, closed_forms, system
from .body import rank_shares, share, slower
from .reduced_regulator import Compared, compare
from .study import RELATIVE, Study


@dataclass(frozen=True, eq=False)
class PlatformStudy(Study):
    """The platform with the motion of a pair on the stage, and LQG on ten states and on `order`."""

    system: Platform
    motion: Motion
    v0: float
    pressed: str
    tolerance: float = 1e-9
    measure: str = RELATIVE
    ranked: bool = False
    rest: bool = False

    @property
    def columns(self) -> np.ndarray:
        """Heights of the singular values before the deck, and of the tolerance; none if they are not wanted."""
        return rank_shares(self.ranks, self.tolerance, self.measure) if self.ranked else np.zeros(0)

    @property
    def errors(self) -> tuple[float, ...]:
        """The error of the smaller model at the lowest frequency and at that of the weakest motion; none where nothing is cut."""
        if self.order == STATE_COUNT or self.ranked or self.rest:
            return ()
        f, error = self.system.frequencies, self.cut.error
        return float(error[0]), float(error[np.argmin(np.abs(f - self.system.motions[-1].frequency))])

    @cached_property
    def compared(self) -> Compared:
        """LQG on both."""
        return compare(self.system, self.order, self.v0, self.pressed)


def studied(design: Design) -> PlatformStudy:
    """The platform of a design."""
    s = system(Parameters(**{name: design[name] for name in ("s", "h", "a", "mu", "kp")}), design["ground"])
    return PlatformStudy(s, design["clock"], int(design["order"]), s.motions[int(design["pair"]) - 1], design["v0"], design["pressed"],
                         design["tolerance"], design["measure"], bool(design["columns"]), bool(design["rest"]))


def numbers(study: PlatformStudy) -> dict[str, float | None]:
    """How much of the motion the model holds, and what the states that are left out cost."""
    c = study.compared
    return {"held": share(study.system, study.motion, study.order), "frequency": study.motion.frequency, "growth": c.growth, "gap": c.gap,
            "extra": c.extra}


def checks(study: PlatformStudy, m: Mapping[str, float]) -> tuple[Check, ...]:
    """The lights of a design."""
    c = study.compared
    return (
        Check("rank", text("both matrices have rank 10 at this tolerance"),
              m["rank_controllability"] == m["rank_observability"] == STATE_COUNT, min(m["rank_controllability"], m["rank_observability"]),
              informative=True),
        study.bound_check,
        Check("stable", text("LQG on the cut model holds the platform"), c.small.stable,
              c.small.rightmost),
        Check("same", text("both loops agree within 1 %"), c.gap is not None and c.gap < 0.01,
              1.0 if c.gap is None else c.gap),
        Check("growth", text("ten states ask for at most 5 % more gain"), c.growth < 0.05, c.growth),
    )


def formulas(study: PlatformStudy) -> tuple[Formula, ...]:
    """Three Hankel values from the geometry."""
    s, forms = study.system, dict(closed_forms(study.system.parameters, study.system.unit))
    return (
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


def live(study: PlatformStudy) -> Text:
    """What is on the stage, and what the model leaves out."""
    order, motion, held = study.order, study.motion, share(study.system, study.motion, study.order)
    ghost = (text("the ghost moves with it") if held > 0.9 else
             text("the ghost stands still") if held < 0.1 else
             text("the ghost moves in part"))
    factor = slower(motion)
    if study.rest:
        return text("On the stage the deck rests.")
    shown = text("On the stage: {name}, {frequency:.3g} Hz, drawn {factor:.2g} times slower; ",
                 name=motion.name, frequency=motion.frequency, factor=factor)
    if order == STATE_COUNT:
        return text("{shown}all ten states are kept.", shown=shown)
    return text("{shown}{ghost}: {order} of 10 states are kept, error {error:.3g}.",
                shown=shown, ghost=ghost, order=order, error=study.cut.peak)
