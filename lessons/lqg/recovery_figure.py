"""Draw Nyquist's curves from plain LQG to LQR, one for each amount of recovery."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import Curve, Dash, PlaneFigure, Point, finite
from observer_lab.course.lesson import Outcome
from observer_lab.text import Text, format_number, same, text

from .cases import DOYLE
from .robustness import real
from .study import Study

RECOVERY_TAB = text("Recovery")
RING_RECOVERIES = (1.0, 2.0, 3.0, 4.0, 6.0)  # decades, of the thin curves between plain LQG and LQR
RING_NAME = f"ρ = {RING_RECOVERIES[0]:g} … {RING_RECOVERIES[-1]:g}"
CIRCLE_ANGLES_RAD = np.linspace(0, 2 * np.pi, 73)
UNIT_CIRCLE = Curve(text("unit circle around −1"), np.sin(CIRCLE_ANGLES_RAD), "muted", "dot", 1.4, np.cos(CIRCLE_ANGLES_RAD) - 1)


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
