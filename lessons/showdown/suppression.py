"""Draw how each controller suppresses the ground's motion: as bars, and over frequency."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from observer_lab.course.figures.ranges import LOG_AXIS_FLOOR, round_up_nicely
from observer_lab.course.figures.records import Curve, Dash, LineFigure, PlaneFigure, Point, over_frequency
from observer_lab.course.lesson import Outcome
from observer_lab.text import NO_WORDS, Text, joined, listed, text, text_in

from .controllers import CONTROLLER_NAMES, CONTROLLER_ROLES, ORDER, SHORT_NAMES
from .race import leaders
from .score_tables import HEADS, SCORE_TAB
from .simulation import analyse
from .study import Study, as_predicted

WANTED_SUPPRESSION_DB = 20.0  # dB in every channel
TIED = 0.05  # dB: less is no lead
BAR_WIDTH_PX, BAR_STEP = 17.0, 0.2  # px; from one bar of a channel to the next, in channels
DASHES: tuple[Dash, ...] = ("solid", "solid", "solid", "dash", "dash")
CURVE_STYLES: tuple[tuple[str, Dash], ...] = tuple(zip(CONTROLLER_ROLES, DASHES, strict=True))
TRANSMISSIBILITY_TAB = text("Transmissibility")
AXES = (("vertical", text_in("channel", "vertical")), ("horizontal", text_in("channel", "horizontal")))
LAST_HZ = 100.0  # above it the samples fold the ground's noise back
NO_NOISE = 1e-30  # (m/s)² s
GROUND = 2.0  # µm²/Hz, one-sided, of white ground of 10⁻¹² m² s


def suppression(outcome: Outcome[Study]) -> PlaneFigure:
    """A group of bars a channel, a bar a controller; a dot for the highest peak, a cross at zero for a loop that is not stable."""
    m, bars, marks = outcome.study, [], []
    stable = np.array([s.stable for s in m.spectra])
    for i in range(1, 5):
        role, name = CURVE_STYLES[i][0], CONTROLLER_NAMES[i]
        for j in range(3):
            at = j + BAR_STEP * (i - 2.5)
            if not stable[i]:
                marks.append(Point(at, 0.0, role, "cross"))
                continue
            bars.append(Curve(name, np.array([0.0, m.band_db[i, j]]), role, "solid", BAR_WIDTH_PX, np.full(2, at)))
            marks.append(Point(at, float(m.peak_db[i, j]), role, "dot"))
        if not stable[i]:
            bars.append(Curve(text("{name}: unstable", name=name), np.zeros(2), role, "solid", 0.0, np.full(2, BAR_STEP * (i - 2.5))))
    asked = Curve(text("asked: {wanted:g} dB", wanted=WANTED_SUPPRESSION_DB), np.full(2, WANTED_SUPPRESSION_DB), "force", "dash", 2.4,
                  np.array([-0.6, 2.6]))
    heights = [float(y) for curve in bars for y in curve.y] + [mark.y for mark in marks]
    low, high = min(0.0, *heights), max(1.25 * WANTED_SUPPRESSION_DB, *heights)
    gains = np.where(stable[:, None], m.band_db, -np.inf)
    said = joined(as_predicted(outcome.design, best_words(gains[1:]) if stable[1:].any() else
                               text("Unstable with these settings: {names}.", names=listed(SHORT_NAMES[1:]))),
                  NO_WORDS if m.trials is None or m.trials.raced is None else leaders(m.trials.raced.rms))
    title = text("suppression, 0.5–3 Hz: of the area, dots: of the highest peak")
    span = -round_up_nicely(-1.05 * low) if low < 0 else 0.0, round_up_nicely(1.05 * high)
    return PlaneFigure("suppression", title, (*bars, asked), tuple(marks), "", "dB", (-0.6, 2.6), span, caption=said, tab=SCORE_TAB,
                       names=tuple((float(j), head) for j, head in enumerate(HEADS)))


def best_words(gains: np.ndarray) -> Text:
    """Which controllers reduce the area most in each channel (4, 3) in dB: those that tie, or none where none reduces it."""
    def named(j: int) -> Text:
        most = float(np.nanmax(gains[:, j]))
        if most <= TIED:
            return SHORT_NAMES[0]
        return listed(SHORT_NAMES[1 + int(i)] for i in np.flatnonzero(gains[:, j] >= most - TIED))
    return text("Best by area: {short} vertically, {short2} in rotation, {short3} horizontally.", short=named(0), short2=named(1),
                short3=named(2))


def width(outcome: Outcome[Study], i: int) -> float:
    """Of the curve of player i: wider for the one on the stage."""
    return 2.6 if ORDER[i] == outcome.design["play"] else 1.6


def transmissibility(m: Study, i: int) -> np.ndarray | None:
    """|deck/ground| of player i, vertical and horizontal, over the study's frequencies up to LAST_HZ (n_f, 2); None if unstable.

    By symmetry vertical ground moves the vertical channel alone, and horizontal ground the horizontal one: the density of the
    velocity under white ground, without noise of the sensors, is (2πf)²|T|² times the ground's.
    """
    hardware = replace(m.world.hardware, limit=np.inf, step=0.0, walk=0.0)
    quiet = replace(m.world, hardware=hardware, sensor=NO_NOISE, shaped=False)
    made = analyse(quiet, m.five[i], m.more)
    if not made.stable:
        return None
    seen = m.f <= LAST_HZ
    return np.sqrt(made.density[seen][:, [0, 2]] / GROUND) / (2 * np.pi * m.f[seen, None])


def transmissibilities(outcome: Outcome[Study]) -> tuple[LineFigure, ...]:
    """Vertical and horizontal, of every player."""
    m = outcome.study
    found = [transmissibility(m, i) for i in range(len(ORDER))]
    return tuple(_drawn(outcome, name, title, [None if T is None else T[:, k] for T in found]) for k, (name, title) in enumerate(AXES))


def _drawn(outcome: Outcome[Study], name: str, title: Text, found: list[np.ndarray | None]) -> LineFigure:
    f = outcome.study.f[outcome.study.f <= LAST_HZ]
    curves = [Curve(CONTROLLER_NAMES[i], np.full(len(f), LOG_AXIS_FLOOR) if T is None else np.maximum(T, LOG_AXIS_FLOOR), role, dash,
                    width(outcome, i)) for i, (T, (role, dash)) in enumerate(zip(found, CURVE_STYLES, strict=True))]
    curves.append(Curve(text("as the ground"), np.ones(len(f)), "disturbance", "dot", 1.6))
    most = listed(text("{name} {value}", name=SHORT_NAMES[i], value=text("unstable") if T is None else f"{T.max():.3g}")
                  for i, T in enumerate(found))
    return over_frequency(f"transmissibility_{name}", text("{title} transmissibility, deck over ground", title=title), f, tuple(curves),
                          "|T|", text("Largest: {most}.", most=most), TRANSMISSIBILITY_TAB, (1e-4, 1e2))
