"""Compare the report's levels (33)–(38) of figures 3–5 with our densities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, LineFigure, over_frequency
from observer_lab.course.lesson import Outcome
from observer_lab.text import Text, joined, text, text_in

from .loops import Spectra
from .study import Study

REPORT_TAB = text("Report")
UNIT = 1e-12  # (m/s)²/Hz of the drawn axis, (µm/s)²/Hz
AGREES = 3.0  # dB
MIN_DENSITY, MAX_DENSITY = 1e-8, 1e7  # of the drawn axis


@dataclass(frozen=True)
class Level:
    """What the report prints of a channel: equations and figure, the band it speaks of in Hz, peaks in (m/s)²/Hz.

    bare: without control. closed: with control, the least and the most it says.
    """

    channel: int
    title: Text
    figure: int
    equations: tuple[int, int]
    band: tuple[float, float]
    bare: float
    closed: tuple[float, float]


LEVELS: Mapping[str, Level] = MappingProxyType({
    "vertical": Level(0, text_in("channel", "vertical"), 4, (35, 36), (1.0, 2.0), 1e-8, (1e-18, 1e-17)),
    "horizontal": Level(2, text_in("channel", "horizontal"), 3, (33, 34), (0.8, 1.25), 1e-11, (1e-15, 1e-15)),
    "rotation": Level(1, text_in("channel", "rotation"), 5, (37, 38), (1.0, 10.0), 1e-11, (1e-14, 1e-13)),
})


def apart(s: Spectra, level: Level) -> tuple[float, ...]:
    """Our peaks without and with control in (m/s)²/Hz, and how many dB they lie above what is printed; 0 within its range."""
    inside = (s.f >= level.band[0]) & (s.f <= level.band[1])
    bare, closed = (max(float(S[inside, level.channel].max()), 1e-30) for S in (s.bare, s.closed))
    nearest = min(max(closed, level.closed[0]), level.closed[1])
    return bare, closed, *(10 * float(np.log10(ratio)) for ratio in (bare / level.bare, closed / nearest))


def report_figures(outcome: Outcome[Study]) -> tuple[LineFigure, ...]:
    """One figure a channel, as figures 4, 3 and 5 of the report."""
    return tuple(_beside(outcome, name, level) for name, level in LEVELS.items())


def _beside(outcome: Outcome[Study], name: str, level: Level) -> LineFigure:
    s = outcome.study.spectra
    first, second = level.equations
    flat = np.ones(len(s.f))

    def drawn(density: np.ndarray) -> np.ndarray:
        return np.clip(density / UNIT, MIN_DENSITY, MAX_DENSITY)
    printed = [Curve(text("no control, ({equation})", equation=first), drawn(level.bare * flat), "muted", "dot", 1.6)]
    printed += [Curve(text("closed, ({equation})", equation=second), drawn(edge * flat), "plant", "dot", 1.6)
                for edge in sorted(set(level.closed))]
    curves = (Curve(text("no control"), drawn(s.bare[:, level.channel]), "muted"),
              Curve(text("closed"), drawn(s.closed[:, level.channel]), "plant"), *printed)
    return over_frequency(f"report-{name}", text("{title} velocity beside figure {figure} of the report", title=level.title,
                                                 figure=level.figure), s.f, curves, "[10⁻¹² (m/s)²/Hz]", caption=_said(outcome, level),
                          tab=REPORT_TAB, window=(1e-7, 1e5))


def _said(outcome: Outcome[Study], level: Level) -> Text:
    """How far our peaks are from the printed ones."""
    if outcome.metrics["rightmost"] >= 0:
        return text("The loop is unstable: what is drawn is no spectrum.")
    bare, closed, *decibels = apart(outcome.study.spectra, level)
    open_db, closed_db = (round(value) + 0 for value in decibels)
    first, second = level.equations
    return joined(
        text("Peaks at {low:g}–{high:g} Hz in (m/s)²/Hz: {bare:.1e} without control, {open_db:+.0f} dB beside ({first}); {closed:.1e} with "
             "control, {closed_db:+.0f} dB beside ({second}).", low=level.band[0], high=level.band[1], bare=bare, open_db=open_db,
             first=first, closed=closed, closed_db=closed_db, second=second),
        claim(text("Both agree with the report to 3 dB."), max(map(abs, decibels)), below=AGREES))
