"""Balance the user's own plant for lesson 12, and show one blow on plant and model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import expm

from observer_lab.course.figures.records import Curve, LineFigure, PlaneFigure
from observer_lab.course.knobs import KnobError
from observer_lab.course.lazy import tab_figures
from observer_lab.course.lesson import Stage
from observer_lab.engine import EngineError, balanced_truncation
from observer_lab.engine.design import typical_rate
from observer_lab.engine.structure import split_stable
from observer_lab.plants import Model
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import Text, joined, text

from .figures import FLOOR_SHARE, HANKEL_TAB, MOTION_TAB, bars, show
from .study import Setting, Study, System

GOOD_SHARE = 0.01  # of σ₁: the order at the start is the least whose bound 2Σσ is below it
MAX_GROWTH_EXPONENT = 5.0  # how many times e a run may grow
SAMPLES, OUTPUTS = 240, 3  # of a run; that are drawn


@dataclass(frozen=True, eq=False)
class OwnSystem(System):
    """A person's own plant, balanced."""

    model: Model

    @property
    def least(self) -> int:
        """The unstable states; one state at the least."""
        return max(self.kept, 1)

    @property
    def good(self) -> int:
        """The least order whose bound is below a hundredth of the largest Hankel value."""
        tail = 2 * np.append(np.cumsum(self.hankel[::-1])[::-1], 0.0)
        fine = int(np.argmax(tail <= GOOD_SHARE * self.hankel[0]))
        return min(max(self.kept + fine, self.least), self.most)


@dataclass(frozen=True, eq=False)
class OwnStudy(Study):
    """A cut of a person's own plant, and one blow on both."""

    system: OwnSystem

    @cached_property
    def blow(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """t (k,), states of the plant (k×n) after a blow on its first input, and those of the model, T z (k×n).

        Both run free: x(0) = kick, z(0) = left x(0).
        """
        s, c = self.system, self.cut
        fastest, start = float(np.real(s.plant.poles).max()), np.asarray(s.model.kick)
        t = np.linspace(0.0, min(s.model.horizon, MAX_GROWTH_EXPONENT / fastest) if fastest > 0 else s.model.horizon, SAMPLES + 1)
        return t, _free(s.plant.A, start, t[1]), _free(c.model.A, c.left @ start, t[1]) @ c.T.T


def _free(A: np.ndarray, start: np.ndarray, dt: float) -> np.ndarray:
    step, states = expm(A * dt), [start]
    for _ in range(SAMPLES):
        states.append(step @ states[-1])
    return np.array(states)


def system_of(model: Model) -> OwnSystem:
    """The plant, balanced. Raises KnobError where there is nothing to cut, EngineError where Gramians are lost in rounding."""
    plant, poles = model.plant, model.plant.poles
    speeds = np.abs(poles)[np.abs(poles) > 1e-7 * max(np.abs(poles).max(), 1e-300)]
    speeds = speeds if speeds.size else np.array([typical_rate(plant)])
    about = np.outer(speeds, np.linspace(0.9, 1.1, 9)).ravel()  # two decades to both sides of all modes that move, denser about each
    f = np.unique(np.concatenate([np.geomspace(speeds.min() / 100, 100 * speeds.max(), 120), about])) / (2 * np.pi)
    for order in range(plant.n, plant.n - split_stable(plant).stable.n, -1):
        try:
            return OwnSystem(plant, balanced_truncation(plant, order), f, model)
        except EngineError:
            continue
    raise KnobError(text("This lesson leaves states out by their Hankel values. This plant has no stable state between input and output."))


def own_setting(s: OwnSystem) -> Setting[OwnStudy]:
    """A person's own plant: a blow on plant and model takes the place of the platform's motions."""
    return Setting(
        lambda design: OwnStudy(s, design["clock"], int(design["order"])), lambda study: Stage(s.model.body, *study.blow), lambda _: {},
        lambda _: {"unstable": float(s.kept)}, lambda study, _: (study.bound_check,), lambda _: (), _live, _staircase,
        lambda outcome: (tab_figures(MOTION_TAB, lambda: (_outputs(outcome.study),)),))


def _live(study: OwnStudy) -> Text:
    s, c = study.system, study.cut
    if c.order == s.plant.n:
        return text("States kept: all {n}.", n=s.plant.n)
    if c.order == s.most:
        return text("States kept: {order} of {n}, all that take part between input and output.", order=c.order, n=s.plant.n)
    return text("States kept: {order} of {n}. The largest error is {error:.3g}, its bound 2Σσ {bound:.3g}.",
                order=c.order, n=s.plant.n, error=c.peak, bound=c.bound)


def _staircase(study: OwnStudy) -> PlaneFigure:
    """The Hankel values of the stable part, kept and cut."""
    s, stable = study.system, study.order - study.system.kept
    floor = float(np.log10(max(s.hankel[0], 1e-300) * FLOOR_SHARE))
    values = np.log10(np.maximum(s.hankel, 10**floor))
    index, curves = np.arange(1.0, len(values) + 1), []
    for name, role, part in ((text("kept"), "plant", slice(0, stable)), (text("cut"), "muted", slice(stable, None))):
        if len(values[part]):
            x, y = bars(index[part], values[part], floor, 0.33)
            curves.append(Curve(name, y, role, x=x, width=2.6))
    said = text("Largest {first}, smallest {last}.", first=show(s.hankel[0]), last=show(s.hankel[-1]))
    if s.kept:
        said = joined(said, text("Unstable states, which have no Hankel value and always stay: {kept}.", kept=s.kept))
    return PlaneFigure("staircase", text("Hankel singular values"), tuple(curves), (), "i", "σ", (0.3, len(values) + 0.7),
                       (floor, float(values[0]) + 1.0), tab=HANKEL_TAB, powers="y", caption=said)


def _outputs(study: OwnStudy) -> LineFigure:
    """The first outputs of plant and model after a blow on the first input."""
    P, (t, x, believed) = study.system.plant, study.blow
    curves = []
    for i, name in enumerate(P.output_names[:OUTPUTS]):
        said = signal_name(P, name)
        curves += [Curve(text("{name}, plant", name=said), x @ P.C[i], "plant"),
                   Curve(text("{name}, model", name=said), believed @ P.C[i], "estimate", "dash")]
    return LineFigure("outputs", text("outputs after a blow on the first input"), t, tuple(curves), tab=MOTION_TAB,
                      caption=text("Dashed: the model, which starts from its part of the same blow."))
