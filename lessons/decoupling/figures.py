"""Draw the figures of lesson 11 from an outcome."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.ranges import LOG_AXIS_FLOOR
from observer_lab.course.figures.records import Curve, LineFigure, MapFigure, PlaneFigure, Point, TableFigure, over_frequency
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine import Plant, frequency_response
from observer_lab.engine.design import polynomial_roots
from observer_lab.plants.platform import siso_loops as siso
from observer_lab.plants.platform.channels import T_y
from observer_lab.text import NO_WORDS, Text, format_number, joined, same, text, text_in

from .loops import (
    A_EDGE,
    B_EDGE,
    CHANNEL_FREQUENCIES_HZ,
    GRID_A,
    GRID_B,
    NO_MIX,
    OWN_MIX,
    PLATFORM_PLANT,
    PUBLISHED_LOOP,
    channels,
    lower_of,
)
from .margins import Margin, margins
from .report_levels import REPORT_TAB, report_figures
from .sensor_figures import SENSOR_TAB, TRANSMISSIBILITY_TAB, sensing, transmissibilities
from .sensors import knee_of, rise, sensors_of
from .study import Study

SPECTRA_TAB, CHANNEL_TAB = text("Spectra"), text("Channels")
LOOP_TAB, TIME_TAB, FORCE_TAB = text("Controllers"), text("Time"), text("Forces")
NANO = 1e9
MIN_DENSITY, MAX_DENSITY = 1e-9, 1e9  # nm/s/√Hz
BARE, CLOSED, SENSOR_LABEL = text("no control"), text("closed"), text("sensor noise")
VERTICAL_LABEL, ROTATION_LABEL = text_in("channel", "vertical"), text_in("channel", "rotation")
HORIZONTAL_LABEL = text_in("channel", "horizontal")
SUPPRESSION_CLASSES = ((text("down 10 dB or more"), "force"), (text("down 3 to 10 dB"), "second"),
        (text("down less"), "plant"), (text("up"), "muted"), (text("least"), "error"))
PRINTED_DB = MappingProxyType({"vertical": text("90 to 100"), "rotation": text("20 to 30"), "horizontal": text("40")})
CONTROLLER_SWEEP = np.geomspace(1e-3, 1e3, 160)
RE_LOW, RE_HIGH, IM_HIGH = -20.0, 5.0, 20.0


def figures(outcome: Outcome[Study]) -> FigureSet:
    """Spectra, channels, controllers, time, forces, transmissibility, sensors, the report's levels: at most three in a tab."""
    three = ((0, "vertical", VERTICAL_LABEL), (2, "horizontal", HORIZONTAL_LABEL), (1, "rotation", ROTATION_LABEL))
    return FigureSet(
        tab_figures(SPECTRA_TAB, lambda: [_spectrum(outcome, *channel) for channel in three]),
        tab_figures(CHANNEL_TAB, lambda: (_dominance(outcome),)),
        tab_figures(CHANNEL_TAB, lambda: (_map(outcome),), "always"), tab_figures(CHANNEL_TAB, lambda: (_mixing(outcome),)),
        tab_figures(LOOP_TAB, lambda: (_magnitudes(outcome), _poles(outcome), _facts(outcome))),
        tab_figures(TIME_TAB, lambda: [_velocity(outcome, *channel) for channel in three]),
        tab_figures(FORCE_TAB, lambda: (_force_spectrum(outcome), _forces(outcome))),
        tab_figures(TRANSMISSIBILITY_TAB, lambda: transmissibilities(outcome)), tab_figures(SENSOR_TAB, lambda: sensing(outcome)),
        tab_figures(REPORT_TAB, lambda: report_figures(outcome)),
    )


def _nano(density: np.ndarray) -> np.ndarray:
    return np.clip(NANO * np.sqrt(np.maximum(density, 0.0)), MIN_DENSITY, MAX_DENSITY)


def _spectrum(outcome: Outcome[Study], i: int, name: str, title: Text) -> LineFigure:
    s, gain = outcome.study.spectra, float(outcome.study.down[i])
    noise = outcome.design["noise"] ** 2 / 2 * rise(knee_of(outcome.design), s.f)
    caption = (text("The loop is unstable: what is drawn is no spectrum.")
               if outcome.metrics["rightmost"] >= 0 else
               text("Peak in 0.1–10 Hz as without control; the report prints {printed} dB.", printed=PRINTED_DB[name])
               if abs(gain) < 0.05 else
               text("Peak in 0.1–10 Hz down by {gain:.1f} dB, before sensor noise; the report prints {printed} dB.",
                    gain=gain, printed=PRINTED_DB[name]) if gain >= 0 else
               text("Peak in 0.1–10 Hz up by {gain:.1f} dB; the report prints {printed} dB down.", gain=-gain, printed=PRINTED_DB[name]))
    return over_frequency(f"spectrum-{name}", text("{title} velocity", title=title), s.f,
                          (Curve(BARE, _nano(s.bare[:, i]), "muted"), Curve(CLOSED, _nano(s.closed[:, i]), "plant"),
                           Curve(SENSOR_LABEL, _nano(noise), "disturbance", "dash", 1.6)), "[nm/s/√Hz]", caption=caption,
                          tab=SPECTRA_TAB, window=(1.0, 1e6))


# --- channels ----------------------------------------------------------------------------------------------------------
def _dominance(outcome: Outcome[Study]) -> LineFigure:
    """Row ratios of rotation and horizontal with the mixing of the design."""
    mixed, plain = outcome.study.mixed, channels(lower_of(outcome.design))
    G = plain.response @ mixed.S
    rows = np.abs(np.stack([G[:, 1, 2] / G[:, 1, 1], G[:, 2, 1] / G[:, 2, 2]], axis=1))
    width = np.gradient(np.log(CHANNEL_FREQUENCIES_HZ))
    lost = float(width[(rows > 1).any(axis=1)].sum() / width.sum())
    curves = [Curve(text("into rotation"), np.clip(rows[:, 0], 1e-4, 1e3), "plant"),
              Curve(text("into horizontal"), np.clip(rows[:, 1], 1e-4, 1e3), "estimate", "dash"),
              Curve(text("equal to the diagonal"), np.ones(len(CHANNEL_FREQUENCIES_HZ)), "reference", "dot", 1.4)]
    return over_frequency("dominance", text("off the diagonal over on it, by row"), CHANNEL_FREQUENCIES_HZ,
                          tuple(curves), text("|off-diagonal| / |diagonal|"), tab=CHANNEL_TAB, window=(1e-3, 1e2),
                          caption=text("Dominance is lost on {lost:.0f} % of the decades from 0.1 to 10 Hz; "
                                       "vertical is decoupled exactly.",
                                       lost=100 * lost))


def _map(outcome: Outcome[Study]) -> MapFigure:
    mixed = outcome.study.mixed
    ratio = 10 * np.log10(np.minimum(mixed.map, 1e30) / mixed.best.plain_J)
    values = np.select([ratio <= -10, ratio <= -3, ratio < 0], [0, 1, 2], 3)
    a, b = mixed.best.a, mixed.best.b
    inside = abs(a) <= A_EDGE and abs(b) <= B_EDGE
    if inside:
        values[int(np.argmin(np.abs(GRID_B - b))), int(np.argmin(np.abs(GRID_A - a)))] = 4
    share = 100 * float(np.mean(values <= 1))
    tail = NO_WORDS if inside else text("The optimum lies outside the map.")
    return MapFigure("index", text("J(a, b) against no mixing"), GRID_A, GRID_B, values, SUPPRESSION_CLASSES,
                     "a", "b", (float(np.clip(mixed.a, -A_EDGE, A_EDGE)), float(np.clip(mixed.b, -B_EDGE, B_EDGE))),
                     caption=joined(text("On {share:.3g} % of the map J comes down by 3 dB or more; click a point to use it.",
                                         share=share), tail), tab=CHANNEL_TAB)


def _mixing(outcome: Outcome[Study]) -> TableFigure:
    mixed, best = outcome.study.mixed, outcome.study.mixed.best

    def row(name: Text, a: float, b: float, J: float) -> tuple[Text | str, ...]:
        return (name, _short(a), _short(b), format_number(J / best.count, ".3g"), _decibel(J / best.plain_J))
    rows = (row(text("no mixing"), 0.0, 0.0, best.plain_J),
            row(text("closed form"), best.start[0], best.start[1], best.start_J),
            row(text("optimum"), best.a, best.b, best.J), row(text("in use"), mixed.a, mixed.b, mixed.J))
    d = outcome.design
    worse = best.start_J > best.plain_J
    caption = (text("{f_low:g}–{f_high:g} Hz. The closed form is worse than nothing: a resonance lies in the band.",
                    f_low=d["f_low"], f_high=d["f_high"]) if worse else
               text("{f_low:g}–{f_high:g} Hz, mean over {count} frequencies.",
                    f_low=d["f_low"], f_high=d["f_high"], count=best.count))
    return TableFigure("mixing", text("mixing of the last two inputs"),
                       (text("choice"), same("a"), same("b"), text("J per frequency"), same("dB")), rows,
                       caption=caption, tab=CHANNEL_TAB)


def _short(value: float) -> str:
    return format_number(value, ".4g")


def _decibel(ratio: float) -> str:
    return f"{10 * np.log10(max(ratio, 1e-30)):+.1f}".replace("-", "−")


# --- controllers -------------------------------------------------------------------------------------------------------
def _magnitudes(outcome: Outcome[Study]) -> LineFigure:
    built = outcome.study.controllers
    curves = []
    for name, role, dash, plant in ((text_in("channel", "vertical"), "plant", "solid", built.vertical),
                                    (text_in("channel", "horizontal"), "estimate", "dash", built.horizontal),
                                    (text_in("channel", "rotation"), "force", "dot", built.rotation)):
        size = np.zeros(len(CONTROLLER_SWEEP)) if plant is None else _size(plant)  # nothing is drawn of a loop that is open
        words = name if plant is not None else text("{name} (open)", name=name)
        curves.append(Curve(words, np.clip(size, LOG_AXIS_FLOOR, 1e8), role, dash))  # type: ignore[arg-type]
    phase = _phase(built.vertical)
    caption = (text("The vertical channel is open.") if phase is None else
               text("Between 0.1 and 10 Hz the vertical controller's phase strays from −180° by at most "
                    "{phase:.2g}°.",
                    phase=phase))
    return over_frequency("controllers", text("size of the three controllers"), CONTROLLER_SWEEP,
                          tuple(curves), "|C| [N s/m]", caption=caption, tab=LOOP_TAB, window=(1e2, 1e6))


def _size(plant: Plant) -> np.ndarray:
    return np.abs(frequency_response(plant.A, plant.B, plant.C, plant.D, 2 * np.pi * CONTROLLER_SWEEP)[:, 0, 0])


def _phase(plant: Plant | None) -> float | None:
    if plant is None:
        return None
    H = frequency_response(plant.A, plant.B, plant.C, plant.D, 2 * np.pi * CHANNEL_FREQUENCIES_HZ[::4])[:, 0, 0]
    return float(np.degrees(np.abs(np.angle(-H))).max())


def _poles(outcome: Outcome[Study]) -> PlaneFigure:
    loop, own = outcome.poles["loop"], outcome.poles["controller"]
    zeros = outcome.poles["zeros of P_h"]
    points = [Point(float(p.real), float(p.imag), role, mark)  # type: ignore[arg-type]
              for group, role, mark in ((zeros, "reference", "circle"), (own, "force", "dot"), (loop, "plant", "cross"))
              for p in group if RE_LOW <= p.real <= RE_HIGH and abs(p.imag) <= IM_HIGH]
    right = outcome.metrics["rightmost"]
    drift = outcome.metrics["drift"]
    at = format_number(right, ".3g")
    words = text("Rightmost pole of the loop: {at} rad/s.", at=at)
    if drift > 0:
        years, size = 1 / (drift * 3.156e7), format_number(drift, ".2g")
        words = text("{words} C_v adds one at +{size} rad/s: e-fold in {years:.0f} years.",
                     words=words, size=size, years=years)
    return PlaneFigure("poles", text("poles of the loop, near the origin"), (), tuple(points), "Re s",
                       "Im s", (RE_LOW, RE_HIGH), (-IM_HIGH, IM_HIGH), unstable=True, tab=LOOP_TAB,
                       caption=text("{words} Circles: zeros of P_h. Dots: poles of the controllers.", words=words))


def _facts(outcome: Outcome[Study]) -> TableFigure:
    """What (26), (31) and (32) are, and what is in use."""
    cv, ch = printed_roots()
    built, design = outcome.study.controllers, outcome.design
    rows: list[tuple[Text | str, ...]] = [
        (text("C_v printed: poles"), ", ".join(_root(p) for p in cv)),
        (text("C_v printed: gain in band"), "−31 252 N s/m"),
        (text("C_v printed: used as"), same("v = +C_v z")),
        (text("C_h printed: rightmost pole"), _root(ch[np.argmax(np.real(ch))])),
        (text("C_h printed: used as"), same("v = −C_h z")),
    ]
    for name, chosen, plant in ((text("vertical in use"), design["vertical"], built.vertical),
                                (text("horizontal in use"), design["horizontal"], built.horizontal)):
        if plant is None:
            rows.append((name, text("open")))
        elif chosen == PUBLISHED_LOOP:
            rows.append((name, text("as printed")))
        else:
            worst = float(np.max(np.real(plant.poles))) if plant.n else -np.inf
            rows.append((name, text("order {n}, {worst}",
                                    n=plant.n, worst=text("unstable by itself") if worst > 0 else text("stable"))))
    rows += [
        (text("{name} loop: delay margin, min |1 + ℓ|", name=name), _bears(margin))
        for name, margin in zip((VERTICAL_LABEL, ROTATION_LABEL, HORIZONTAL_LABEL), _margins(outcome), strict=True)
        if margin is not None
    ]
    return TableFigure("facts", text("what the controllers are"), (text("fact"), text("value")),
                       tuple(rows), tab=LOOP_TAB,
                       caption=text("Poles in rad/s, recomputed from the printed coefficients."))


def _margins(outcome: Outcome[Study]) -> tuple[Margin | None, ...]:
    if outcome.metrics["rightmost"] >= 0:
        return (None, None, None)
    s = outcome.study
    return margins(s.controllers, s.mixed.S, lower_of(outcome.design), outcome.poles["loop"], sensors_of(outcome.design))


def _bears(margin: Margin) -> str:
    delay = "∞" if not np.isfinite(margin.delay) else f"{1e3 * margin.delay:.3g} ms" if margin.delay >= 1e-6 else "< 1 µs"
    return f"{delay}, {margin.nearest:.2f}" if margin.nearest >= 0.01 else f"{delay}, < 0.01"


@lru_cache(maxsize=1)
def printed_roots() -> tuple[np.ndarray, np.ndarray]:
    """The roots of both printed denominators."""
    return polynomial_roots(siso.CV_DENOMINATOR), polynomial_roots(siso.CH_DENOMINATOR)


def _root(p: complex) -> str:
    return format_number(p.real, "+.3g") if abs(p.imag) < 1e-12 else f"{p.real:+.3g} ± {abs(p.imag):.3g}j".replace("-", "−")


# --- time --------------------------------------------------------------------------------------------------------------
def _velocity(outcome: Outcome[Study], i: int, name: str, title: Text) -> LineFigure:
    run = outcome.study.shaken
    row = 1e6 * (T_y[i] @ PLATFORM_PLANT.C)
    now, bare = run.x @ row, run.bare @ row
    size, without = float(np.std(now)), float(np.std(bare))
    return LineFigure(f"velocity-{name}", text("{title} velocity", title=title), run.t,
                      (Curve(BARE, bare, "muted"), Curve(CLOSED, np.clip(now, -1e4, 1e4), "plant")), "[µm/s]", tab=TIME_TAB,
                      caption=text("Root mean square {size:.2g} µm/s, without control {without:.2g} µm/s.",
                                   size=size, without=without))


def _force_spectrum(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study.spectra
    size = np.clip(1e3 * np.sqrt(np.maximum(s.forces, 0.0)), 1e-8, 1e4)
    inside = (s.f >= 0.1) & (s.f <= 10)
    names = (text("left vertical"), text("right vertical"), text_in("channel", "horizontal"))
    curves = tuple(Curve(n, size[:, j], role, dash)  # type: ignore[arg-type]
                   for j, (n, role, dash) in enumerate(zip(names, ("plant", "estimate", "force"), ("solid", "dash", "dot"),
                                                           strict=True)))
    return over_frequency("force-spectrum", text("forces asked of the coils"), s.f, curves, "[mN/√Hz]",
                          tab=FORCE_TAB, window=(1e-2, 10.0),
                          caption=text("Largest between 0.1 and 10 Hz: {size:.3g} mN/√Hz.",
                                       size=1e3 * float(np.sqrt(np.maximum(s.forces[inside], 0.0).max()))))


def _forces(outcome: Outcome[Study]) -> LineFigure:
    run = outcome.study.shaken
    u, largest = np.clip(1e3 * run.u, -1e7, 1e7), 1e3 * float(np.abs(run.u).max())
    names = (text("left vertical"), text("right vertical"), text_in("channel", "horizontal"))
    curves = tuple(Curve(n, u[:, j], role, dash)  # type: ignore[arg-type]
                   for j, (n, role, dash) in enumerate(zip(names, ("plant", "estimate", "force"), ("solid", "dash", "dot"),
                                                           strict=True)))
    return LineFigure("forces", text("forces on the shaking ground"), run.t, curves, "[mN]", tab=FORCE_TAB,
                      caption=text("Largest force: {largest:.3g} mN.", largest=largest) if outcome.design["mix"] == NO_MIX else
                      text("Largest force: {largest:.3g} mN, after the mixing.", largest=largest))


def pick(outcome: Outcome[Study], a: float, b: float) -> Mapping[str, str | float]:
    """A click on the map of J takes its a and b."""
    return {"mix": OWN_MIX, "a": float(np.clip(a, -A_EDGE, A_EDGE)), "b": float(np.clip(b, -B_EDGE, B_EDGE))}
