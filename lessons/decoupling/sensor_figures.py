"""Draw the transmissibility, the sensors' own noise and the tilt that they read as motion."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.ranges import LOG_AXIS_FLOOR
from observer_lab.course.figures.records import Curve, LineFigure, over_frequency
from observer_lab.course.lesson import Outcome
from observer_lab.text import NO_WORDS, Text, joined, text, text_in

from .loops import bare_loop
from .sensors import GRAVITY, HALF_DISTANCE_M, Sensors, knee_of, own_gain, rise, sensors_of
from .study import Study, transmissibility

TRANSMISSIBILITY_TAB, SENSOR_TAB = text("Transmissibility"), text("Sensors")
NANO = 1e9
LOW_HZ, HIGH_HZ = 0.1, 10.0  # where captions compare
BARE, CLOSED = text("no control"), text("closed")
UNSTABLE = text("The loop is unstable: what is drawn is no spectrum.")
CHANNELS = (("vertical", text_in("channel", "vertical")), ("horizontal", text_in("channel", "horizontal")))


def transmissibilities(outcome: Outcome[Study]) -> tuple[LineFigure, ...]:
    """|deck/ground| vertically and horizontally, without control and with it."""
    return tuple(_transmissibility(outcome, i) for i in range(len(CHANNELS)))


def _transmissibility(outcome: Outcome[Study], i: int) -> LineFigure:
    name, title = CHANNELS[i]
    f = outcome.study.spectra.f
    bare = transmissibility(bare_loop(), f)[:, i]
    curves = [Curve(BARE, bare, "muted")]
    said = text("The loop is unstable: it has no transmissibility.")
    if outcome.metrics["rightmost"] < 0:
        closed = outcome.study.transmissibility[:, i]
        curves.append(Curve(CLOSED, np.maximum(closed, LOG_AXIS_FLOOR), "plant"))
        said = _said(f, closed, float(bare.max()))
    curves.append(Curve(text("as the ground"), np.ones(len(f)), "reference", "dot", 1.4))
    return over_frequency(f"transmissibility-{name}", text("{title} transmissibility, deck over ground", title=title), f, tuple(curves),
                          "|T|", caption=said, tab=TRANSMISSIBILITY_TAB, window=(1e-7, 1e3))


def _said(f: np.ndarray, closed: np.ndarray, bare: float) -> Text:
    """Where it is largest, and from where on the deck moves less than the ground."""
    at, above = int(np.argmax(closed)), np.flatnonzero(closed > 1)
    most = text("Largest {most:.3g}, at {at:.2g} Hz; without control {bare:.3g}.", most=float(closed[at]), at=float(f[at]), bare=bare)
    if not above.size:
        return joined(most, text("At every frequency drawn the deck moves less than the ground."))
    if above[-1] + 1 == len(f):
        return most
    return joined(most, text("Above {start:.2g} Hz the deck moves less than the ground.", start=float(f[above[-1] + 1])))


def sensing(outcome: Outcome[Study]) -> tuple[LineFigure, ...]:
    """What a sensor adds by itself, and what tilt adds to the horizontal ones."""
    return _noise(outcome), _tilt(outcome)


def noise_as_velocity(sensors: Sensors, sigma: float, knee: float, f: np.ndarray) -> np.ndarray:
    """σ √(1 + knee/f)/|H|: the velocity that a sensor would need to read what it adds by itself."""
    return sigma * np.sqrt(rise(knee, f)) / own_gain(sensors, f)


def _noise(outcome: Outcome[Study]) -> LineFigure:
    s, d = outcome.study.spectra, outcome.design
    sensors, knee, sigma = sensors_of(d), knee_of(d), d["noise"]
    moved = np.sqrt(np.maximum(s.closed[:, 0] - s.sensors[:, 0], 0.0))
    stable = outcome.metrics["rightmost"] < 0
    curves = [Curve(text("noise of one sensor, as velocity"), _nano(noise_as_velocity(sensors, sigma, knee, s.f)), "disturbance"),
              Curve(text("without corner and rise"), _nano(np.full(len(s.f), sigma)), "muted", "dash", 1.6)]
    if stable:
        curves.append(Curve(text("vertical velocity of the deck, from the ground"), _nano(moved), "plant"))
    low, high = (float(NANO * v) for v in noise_as_velocity(sensors, sigma, knee, np.array([LOW_HZ, HIGH_HZ])))
    said = text("At {low_f:g} Hz a sensor's noise equals a velocity of {low:.3g} nm/s/√Hz, at {high_f:g} Hz {high:.3g}.",
                low_f=LOW_HZ, low=low, high_f=HIGH_HZ, high=high)
    return over_frequency("sensor-noise", text("noise of a sensor beside the motion of the deck"), s.f, tuple(curves), "[nm/s/√Hz]",
                          caption=said, tab=SENSOR_TAB, window=(1e-2, 1e6))


def _tilt(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study.spectra
    motion, read = np.sqrt(s.closed[:, 2]), tilt_as_velocity(s.f, np.sqrt(s.closed[:, 1]))
    reacts = sensors_of(outcome.design).tilt
    curves = (Curve(text("horizontal velocity"), _nano(motion), "plant"),
              Curve(text("tilt read as velocity, g θ/ω"), _nano(read), "error", "solid" if reacts else "dash"))
    ratio = float(np.interp(LOW_HZ, s.f, read) / max(np.interp(LOW_HZ, s.f, motion), 1e-30))
    said = UNSTABLE if outcome.metrics["rightmost"] >= 0 else joined(
        text("At {low_f:g} Hz tilt reads as {ratio:.2g} times the true horizontal velocity.", low_f=LOW_HZ, ratio=ratio),
        NO_WORDS if reacts else text("These sensors do not react to tilt; the dashed curve is what others would read."))
    return over_frequency("tilt", text("tilt in a horizontal sensor"), s.f, curves, "[nm/s/√Hz]", caption=said, tab=SENSOR_TAB,
                          window=(1e-2, 1e6))


def tilt_as_velocity(f: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """g θ/ω with θ from the rotation channel, s_m θ̇: a sensor cannot tell the acceleration g θ from a true one."""
    return GRAVITY * rotation / (HALF_DISTANCE_M * (2 * np.pi * f) ** 2)


def _nano(amplitude: np.ndarray) -> np.ndarray:
    return np.clip(NANO * amplitude, LOG_AXIS_FLOOR, 1e12)
