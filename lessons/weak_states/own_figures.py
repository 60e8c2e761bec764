"""Draw the figures of lesson 12 for the user's own plant: Hankel values, error, outputs after a blow."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import Curve, LineFigure, PlaneFigure, over_frequency
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import joined, text

from .figures import HANKEL_TAB, MOTION_TAB, bars, show
from .own_system import OwnStudy, OwnSystem

FLOOR_SHARE = 1e-17  # of the largest value: the least that is drawn
ROUNDING = 1e-9  # of the largest gain: rounding of a frequency response
OUTPUTS = 3  # that are drawn
WIDE = 1e100  # a gain beyond it is a pole on the axis


def dust(s: OwnSystem) -> float:
    """What rounding may make of an error."""
    return ROUNDING * float(np.abs(s.response[np.isfinite(s.response)]).max(initial=0.0))


def staircase(study: OwnStudy) -> PlaneFigure:
    """The Hankel values of the stable part, kept and cut."""
    s, stable = study.system, study.order - study.system.whole.kept
    floor = float(np.log10(max(s.hankel[0], 1e-300) * FLOOR_SHARE))
    values = np.log10(np.maximum(s.hankel, 10**floor))
    index, curves = np.arange(1.0, len(values) + 1), []
    for name, role, part in ((text("kept"), "plant", slice(0, stable)), (text("cut"), "muted", slice(stable, None))):
        if len(values[part]):
            x, y = bars(index[part], values[part], floor, 0.33)
            curves.append(Curve(name, y, role, x=x, width=2.6))
    said = text("Largest {first}, smallest {last}.", first=show(s.hankel[0]), last=show(s.hankel[-1]))
    if s.whole.kept:
        said = joined(said, text("Unstable states, which have no Hankel value and always stay: {kept}.", kept=s.whole.kept))
    return PlaneFigure("staircase", text("Hankel singular values"), tuple(curves), (), "i", "σ", (0.3, len(values) + 0.7),
                       (floor, float(values[0]) + 1.0), tab=HANKEL_TAB, powers="y", caption=said)


def error(study: OwnStudy) -> LineFigure:
    """σ_max of the plant and of what the model leaves out, with the bound."""
    c, s = study.cut, study.system
    gains = np.linalg.norm(np.where(np.isfinite(s.response), s.response, 0.0), 2, axis=(1, 2))
    gains = np.where(np.isfinite(s.response).all(axis=(1, 2)), np.minimum(gains, WIDE), np.nan)
    least = max(float(np.nanmax(gains, initial=0.0)), 1e-300) * FLOOR_SHARE
    sure = [v for v in (c.bound, c.peak) if v > least]
    said = (text("Nothing is cut: no error.") if c.order == s.most else
            text("Largest error {peak} at {where} Hz. The bound 2Σσ over all values cut is {bound}.",
                 peak=show(c.peak, 4), where=show(c.where, 3), bound=show(c.bound, 4)))
    curves = [Curve(text("whole plant"), np.maximum(gains, least), "muted", width=1.4),
              Curve(text("error"), np.maximum(c.error, least), "error")]
    if sure:
        curves.append(Curve(text("bound 2Σσ"), np.full(len(s.frequencies), max(c.bound, least)), "reference", "dash", 1.6))
    largest = float(np.nanmax(gains, initial=least))
    window = (max(least, min([*sure, largest]) / 100), 10 * max([*sure, largest]))
    return over_frequency("error", text("what the model leaves out: σ_max(G − G_r)"), s.frequencies, tuple(curves), "σ_max", tab=HANKEL_TAB,
                          window=window, caption=said)


def outputs(study: OwnStudy) -> LineFigure:
    """The first outputs of plant and model after a blow on the first input."""
    P, (t, x, believed) = study.system.plant, study.blow
    curves = []
    for i, name in enumerate(P.output_names[:OUTPUTS]):
        said = signal_name(P, name)
        curves += [Curve(text("{name}, plant", name=said), x @ P.C[i], "plant"),
                   Curve(text("{name}, model", name=said), believed @ P.C[i], "estimate", "dash")]
    return LineFigure("outputs", text("outputs after a blow on the first input"), t, tuple(curves), tab=MOTION_TAB,
                      caption=text("Dashed: the model, which starts from its part of the same blow."))
