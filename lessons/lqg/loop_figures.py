"""Draw the loop of lesson 10: as a block diagram, and Nyquist's curves of its recovery."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from observer_lab.course.figures.diagram import DiagramFigure
from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, Dash, PlaneFigure, Point, finite
from observer_lab.course.lesson import Outcome
from observer_lab.text import Text, format_number, same, text

from ..toolkit.diagram import LoopSignals, loop
from .cases import DOYLE
from .knobs import RECURSIVE
from .loops import computer, schedule
from .robustness import real
from .study import Study

RECOVERY_TAB = text("Recovery")
RING_RECOVERIES = (1.0, 2.0, 3.0, 4.0, 6.0)  # decades, of the thin curves between plain LQG and LQR
RING_NAME = f"ρ = {RING_RECOVERIES[0]:g} … {RING_RECOVERIES[-1]:g}"
CIRCLE_ANGLES_RAD = np.linspace(0, 2 * np.pi, 73)
UNIT_CIRCLE = Curve(text("unit circle around −1"), np.sin(CIRCLE_ANGLES_RAD), "muted", "dot", 1.4, np.cos(CIRCLE_ANGLES_RAD) - 1)
CLOSEST_TAB = text("Near −1")
TIMES = 2.5  # how many times the distance the window reaches to either side
MOST_HALF = 1.0  # half the window's height is no more, where the curve is far away


def loop_of(outcome: Outcome[Study]) -> DiagramFigure:
    """Plant and filter: the steady gain L, or the gain M at which the recursive filter arrives in the run."""
    s = outcome.study
    run, plant = s.trace, s.case.plant
    direct = run.u @ np.asarray(plant.D).T
    signals = LoopSignals(run.t, run.u, run.x @ plant.C.T + s.setting.gain * direct, run.xhat @ plant.C.T + direct, run.xhat)
    if outcome.design["filter"] != RECURSIVE:
        return loop(plant, signals, outcome.gains["L"], outcome.gains["K"])
    f, steps = s.setting.factors, round(s.case.horizon / s.case.dt) + 1
    design = computer(s.case, replace(f, sensor=1.0), s.setting.recovery, s.case.dt)
    gains = schedule(s.case, f.beta_q, f.beta_r, s.setting.recovery, steps).gains
    return loop(plant, signals, gains[-1], design.K, gain="M", sampled=True)


def both_halves(ell: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nyquist's curve from ω = −∞ over 0 to ∞, so that it begins and ends at 0: its real and its imaginary part."""
    x, y = finite(np.real(ell), 1e6), finite(np.imag(ell), 1e6)
    return np.concatenate([x[::-1], x]), np.concatenate([-y[::-1], y])


def rings_figure(outcome: Outcome[Study]) -> PlaneFigure:
    """From the curve of plain LQG, close to −1, to that of LQR; on Doyle's plant with steps of ρ in between."""
    s, rho = outcome.study, outcome.design["recovery"]
    rings = [] if s.case.id != DOYLE else [np.hstack([
        both_halves(real(s.case, s.setting.factors, step, s.cut).curve) for step in RING_RECOVERIES])]

    def curve(name: Text, ell: np.ndarray, role: str, dash: Dash = "solid", width: float = 2.0) -> Curve:
        x, y = both_halves(ell)
        return Curve(name, y, role, dash, width, x)

    curves = [UNIT_CIRCLE,
              *(Curve(same(RING_NAME), y, "second", "solid", 1.2, x) for x, y in rings),
              curve(same("LQR"), s.ideal.curve, "plant", "dash"),
              curve(text("plain LQG"), s.plain.curve, "error"),
              curve(text("this LQG"), s.real.curve, "estimate", width=2.6)]
    plain, near, ideal = (format_number(r.margins.nearest, ".2g") for r in (s.plain, s.real, s.ideal))
    said = (text("The curve passes −1 at a distance of {near}, that of LQR at {ideal}.", near=near, ideal=ideal) if rho == 0 else
            text("Distance from −1: {plain} without recovery, {near} with ρ = {rho:g}, {ideal} for LQR.",
                 plain=plain, near=near, rho=rho, ideal=ideal))
    return PlaneFigure("rings", text("Nyquist with more and more recovery"), tuple(curves), (Point(-1.0, 0.0, "reference", "cross"),),
                       "Re ℓ", "Im ℓ", (-2.6, 1.0), (-1.8, 1.8), equal=True, tab=RECOVERY_TAB, caption=said)


def closest_figure(outcome: Outcome[Study]) -> PlaneFigure:
    """The curves of LQG and LQR in a window about −1 that the distance fills."""
    s = outcome.study
    near = s.real.margins.nearest
    half = max(min(round_up_nicely(TIMES * near), MOST_HALF), 1.05 * near)
    gap = s.real.curve[int(np.argmin(np.abs(1 + s.real.curve)))] + 1
    gap = gap / max(abs(gap), 1e-300) * near
    ideal, real = both_halves(s.ideal.curve), both_halves(s.real.curve)
    return PlaneFigure(
        "closest", text("Nyquist near −1: distance {near}", near=format_number(near, ".3g")),
        (Curve(same("LQR"), ideal[1], "plant", "dash", 2.0, ideal[0]), Curve(same("LQG"), real[1], "estimate", "solid", 2.4, real[0]),
         Curve(text("distance"), np.array([0.0, gap.imag]), "error", "solid", 5.0, np.array([-1.0, gap.real - 1]))),
        (Point(-1.0, 0.0, "reference", "cross", same("−1")),), "Re ℓ", "Im ℓ", (-1 - half, -1 + half), (-half, half), equal=True,
        tab=CLOSEST_TAB, caption=text("The curve passes −1 at a distance of {near}, that of LQR at {ideal}.",
                                      near=format_number(near, ".2g"), ideal=format_number(s.ideal.margins.nearest, ".2g")))
