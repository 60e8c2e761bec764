"""Measure runs for the bars of the stage, and give the design that they began with."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Design

from .knobs import KNOBS

FROM_S = 1.0  # of a run: the RMS velocity is measured from here on
MOST_UM_S = 2e3  # beyond which the velocity of an unstable loop is not drawn
VERTICAL = 6  # the state that is the vertical velocity of a deck
SET_BACK = ("v", "sensor", "limited", "driver", "delay", "adc", "drift", "friction", "stiffness", "damping", "placement")


def velocity_of(states: np.ndarray) -> np.ndarray:
    """The vertical velocity of a deck in µm/s (n_t,), bounded."""
    return np.clip(1e6 * states[:, VERTICAL], -MOST_UM_S, MOST_UM_S)


def run_rms(t: np.ndarray, states: np.ndarray) -> float:
    """The RMS vertical velocity of a deck in µm/s after the first second of a run."""
    return float(np.std(velocity_of(states)[t > FROM_S]))


def first_design(design: Design) -> Design:
    """The design with noise and hardware as at the start; run, ground, controllers and bars stay."""
    return design.with_values(**{knob.name: knob.default for knob in KNOBS if knob.name in SET_BACK})
