"""Draw the figures of lesson 13: channels, sensors, inputs, time test, run on the stage."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from observer_lab.course.figures.ranges import LOG_AXIS_FLOOR
from observer_lab.course.figures.records import Curve, LineFigure, over_frequency
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine.sampled import ResponseMeasures
from observer_lab.text import Text, format_number, joined, listed, same, text, text_in

from .controllers import CONTROLLER_NAMES, ORDER, SHORT_NAMES, gain_gap
from .deck_bars import run_rms, velocity_of
from .rankings import EFFORT_TAB, RACE_TAB, equal, race_figures
from .report_levels import REPORT_TAB, report_tables
from .score_tables import SCORE_TAB, TRIAL_TAB, friction, sizes, times, tried
from .simulation import loop_of
from .study import Study, as_predicted, rival_of
from .suppression import CURVE_STYLES, TRANSMISSIBILITY_TAB, suppression, transmissibilities, width

CHANNEL_TAB, SENSOR_TAB, INPUT_TAB = text("Channels"), text("Sensors"), text("Inputs")
TIME_TAB, RUN_TAB = text("Test"), text("Stage")
CHANNEL_LABELS = (("vertical", text_in("channel", "vertical"), "µm/s"), ("rotation", text("rotation, (VL − VR)/2"), "µm/s"),
            ("horizontal", text_in("channel", "horizontal"), "µm/s"))


def figures(outcome: Outcome[Study]) -> FigureSet:
    """Everything on the right of the stage."""
    return FigureSet(
        tab_figures(CHANNEL_TAB, lambda: [_channel(outcome, j) for j in range(3)]),
        tab_figures(TRANSMISSIBILITY_TAB, lambda: transmissibilities(outcome)),
        tab_figures(SENSOR_TAB, lambda: [_sensor(outcome, j) for j in range(3)]),
        tab_figures(INPUT_TAB, lambda: (_input(outcome, 0), _input(outcome, 2), _gain(outcome))),
        tab_figures(TIME_TAB, lambda: [_test(outcome, j) for j in range(3)]),
        tab_figures(RUN_TAB, lambda: (_stage_velocity(outcome), _stage_force(outcome), friction(outcome, RUN_TAB))),
        tab_figures(SCORE_TAB, lambda: (suppression(outcome), sizes(outcome))), tab_figures(SCORE_TAB, lambda: (times(outcome),), "late"),
        tab_figures(RACE_TAB, lambda: race_figures(outcome)),
        tab_figures(TRIAL_TAB, lambda: tried(outcome)),
        tab_figures(EFFORT_TAB, lambda: equal(outcome)), tab_figures(REPORT_TAB, lambda: report_tables(outcome)))


def _curves(outcome: Outcome[Study], column: int, scale: float = 1.0, skip_open: bool = False) -> list[Curve]:
    """A density of every player; an unstable one lies below the axis."""
    m = outcome.study
    return [Curve(CONTROLLER_NAMES[i], np.maximum(scale * m.spectra[i].density[:, column], LOG_AXIS_FLOOR), role, dash, width(outcome, i))
            for i, (role, dash) in enumerate(CURVE_STYLES) if not (skip_open and i == 0)]


def _measured(outcome: Outcome[Study], column: int, scale: float = 1.0) -> list[Curve]:
    """The Monte-Carlo of the controller on the stage with its band of two standard errors, on the figure's frequencies."""
    m, i = outcome.study, ORDER.index(outcome.design["play"])
    tried = None if m.trials is None else m.trials.noise[i]
    if tried is None:
        return []
    low, high = tried.band()
    keep = tried.frequency > 1.5 * tried.frequency[1]
    f = np.log(tried.frequency[keep])

    def on_grid(values: np.ndarray) -> np.ndarray:
        return np.exp(np.interp(np.log(m.f), f, np.log(np.maximum(scale * values[keep, column], LOG_AXIS_FLOOR))))

    return [Curve(text("Monte-Carlo"), on_grid(tried.density), "estimate", "dot", 1.6),
            Curve(text("band"), on_grid(low), "estimate", "dot", 0.8),
            Curve(text("upper edge"), on_grid(high), "estimate", "dot", 0.8)]


def _noise(m: Study, share: float) -> Curve:
    level = 2 * m.world.sensor * share * 1e12
    return Curve(text("sensor noise"), np.full(len(m.f), max(level, LOG_AXIS_FLOOR)), "disturbance", "dot", 1.6)


def _window(curves: list[Curve]) -> tuple[float, float]:
    top = max(float(c.y.max()) for c in curves)
    return (top * 1e-7, top)


def _each(m: Study, values: list[str]) -> Text:
    """The value of every controller; an unstable one has none."""
    return _beside(same(v) if s.stable else text("unstable") for v, s in zip(values[1:], m.spectra[1:], strict=True))


def _beside(values: Iterable[Text]) -> Text:
    """Each controller with what is said of it."""
    return listed(text("{name} {value}", name=name, value=value) for name, value in zip(SHORT_NAMES[1:], values, strict=True))


def _channel(outcome: Outcome[Study], j: int) -> LineFigure:
    m = outcome.study
    key, name, _ = CHANNEL_LABELS[j]
    curves = [*_curves(outcome, j), _noise(m, 0.5), *_measured(outcome, j, 1e12)]
    said = _each(m, [format_number(db, ".1f") for db in m.band_db[:, j]])
    return over_frequency(f"channel_{key}", text("velocity: {name}", name=name), m.f, tuple(curves), "[(µm/s)²/Hz]",
                          as_predicted(outcome.design, text("Suppression over 0.5–3 Hz in dB: {said}.", said=said)), CHANNEL_TAB,
                          _window(curves))


def _sensor(outcome: Outcome[Study], j: int) -> LineFigure:
    m = outcome.study
    column, key, name = ((2, "left_h", text("left horizontal, HL")), (3, "left_v", text("left vertical, VL")),
                         (4, "right_v", text("right vertical, VR")))[j]
    curves = [*_curves(outcome, column), _noise(m, 1.0)]
    i = ORDER.index(outcome.design["play"])
    if not m.spectra[i].stable:
        said = text("The controller on the stage does not hold this loop.")
    else:
        before, now = (float(m.spectra[k].density[:, column].max()) for k in (0, i))
        gain = 10 * np.log10(before / now)
        said = (text("On the stage is the platform without control.") if i == 0 else as_predicted(
            outcome.design, text("{name}: the highest point is {gain:.1f} dB lower than without control.", name=CONTROLLER_NAMES[i],
                               gain=gain)
            if gain >= 0 else
            text("{name}: the highest point is {gain:.1f} dB higher than without control.", name=CONTROLLER_NAMES[i], gain=-gain)))
    return over_frequency(f"sensor_{key}", text("true velocity at {name}", name=name), m.f, tuple(curves),
                          "[(µm/s)²/Hz]", said, SENSOR_TAB, _window(curves))


def _input(outcome: Outcome[Study], j: int) -> LineFigure:
    m = outcome.study
    name = (text("left vertical coil u1"), same(""), text("horizontal coil u3"))[j]
    curves = [*_curves(outcome, 5 + j, 1e6, True), *_measured(outcome, 5 + j, 1e6)]
    said = _each(m, [format_number(1e3 * v, ".3g") for v in m.forces[:, j]])
    return over_frequency(f"input_{j}", text("command: {name}", name=name), m.f, tuple(curves), "[mN²/Hz]",
                          as_predicted(outcome.design, text("RMS in mN: {said}.", said=said)), INPUT_TAB, _window(curves))


def _gain(outcome: Outcome[Study]) -> LineFigure:
    t, away = gain_gap(outcome.design["v"])
    m = outcome.study
    apart = m.filters_apart
    said = [text("It has {left:.2g} % to go after 20 s.", left=100 * away[-1])]
    if apart is not None:
        said.append(text("Settled, its loop differs from the steady LQE's by at most {apart:.2f} dB.", apart=apart))
    if m.trials is not None and m.trials.learning is not None:
        first, last = (" / ".join(format_number(100 * v, ".2g") for v in m.trials.learning[k]) for k in (0, -1))
        count = len(m.trials.learning)
        said.append(text("On one seed (vertical/rotation/horizontal) the runs are {first} % apart in second 1, {last} % in second "
                         "{count}.", first=first, last=last, count=count))
    return LineFigure(
        "gain",
        text("recursive gain on its way to the Riccati gain"),
        t,
        (Curve(text("distance"), np.maximum(away, LOG_AXIS_FLOOR), "estimate"),),
        "‖M − M∞‖ / ‖M∞‖",
        log_y=True,
        caption=joined(*said),
        tab=INPUT_TAB,
        window=(1e-4, 10.0),
    )


def _test(outcome: Outcome[Study], j: int) -> LineFigure:
    m = outcome.study
    key, name, unit = CHANNEL_LABELS[j]
    bare = m.responses[0]
    assert bare is not None  # the deck alone is stable
    t = bare.t
    seen = t <= 6.0
    curves = [Curve(CONTROLLER_NAMES[i], np.zeros(int(seen.sum())) if r is None else np.interp(t[seen], r.t, r.velocity[:, j]), role, dash,
                    width(outcome, i))
              for i, ((role, dash), r) in enumerate(zip(CURVE_STYLES, m.responses, strict=True))]
    high = float(np.abs(bare.velocity[:, j]).max())
    parts = [_recovery(measured, j) for measured in m.measures[1:]]
    return LineFigure(f"test_{key}", text("velocity after the test: {name}", name=name), t[seen],
                      tuple(curves), f"v [{unit}]",
                      caption=text("Recovered, to 5 % of the peak without control: {each}.", each=_beside(parts)),
                      tab=TIME_TAB, window=(-high, high))


def _recovery(measured: tuple[ResponseMeasures, ...] | None, j: int) -> Text:
    if measured is None:
        return text("unstable")
    after = measured[j].recovery
    return text("not in 12 s") if after is None else same(f"{after:.2g} s")


UNSTABLE_CAPTION = text("This loop is unstable: its run is held where it leaves every bound.")


def _held(outcome: Outcome[Study]) -> bool:
    m = outcome.study
    return loop_of(m.world, m.five[ORDER.index(outcome.design["play"])]).stable


def _stage_velocity(outcome: Outcome[Study]) -> LineFigure:
    m = outcome.study
    t, x, _ = m.run
    v, rival, ghost = (velocity_of(states) for states in (x, m.rival[0], m.ghost))
    sizes = [run_rms(t, each) for each in (x, m.rival[0], m.ghost)]
    upper = outcome.design["play"]
    who = [ORDER.index(each) for each in (upper, rival_of(upper))]
    (above, below), roles = (CONTROLLER_NAMES[i] for i in who), [CURVE_STYLES[i][0] for i in who]
    return LineFigure("stage_velocity", text("vertical velocity of the run on the stage"), t,
                      (Curve(below, rival, roles[1], "solid", 0.8), Curve(text("without control"), ghost, "muted", "dash", 2.4),
                       Curve(above, v, roles[0], width=2.4)), "v [µm/s]",
                      caption=UNSTABLE_CAPTION if not _held(outcome) else
                      text("RMS after 1 s: {sizes:.3g} µm/s, {sizes3:.3g} µm/s without control. The loop of the lower deck is unstable.",
                           sizes=sizes[0], sizes3=sizes[2]) if not m.stable[who[1]] else
                      text("RMS after 1 s: {sizes:.3g} µm/s, {sizes2:.3g} µm/s on the lower deck, {sizes3:.3g} µm/s without control.",
                           sizes=sizes[0], sizes2=sizes[1], sizes3=sizes[2]),
                      tab=RUN_TAB, window=(-500.0, 500.0))


def _stage_force(outcome: Outcome[Study]) -> LineFigure:
    t, _, u = outcome.study.run
    peak = 1e3 * float(np.abs(u).max())
    return LineFigure("stage_force", text("coil commands of this run"), t,
                      (Curve(text("left vertical u1"), 1e3 * u[:, 0], "force", "solid", 1.6),
                       Curve(text("horizontal u3"), 1e3 * u[:, 2], "disturbance", "solid", 1.0)), "u [mN]",
                      caption=UNSTABLE_CAPTION if not _held(outcome) else text("Largest command {peak:.3g} mN.", peak=peak),
                      tab=RUN_TAB,
                      window=(-20.0, 20.0))
