"""Check source 003, 5.3 and 6.1: the controllers of figures 13–25, also sampled at 1 kHz."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..engine import Plant, balanced_truncation, sampled_loop, sampled_lqg
from ..engine.sampled import loop_density, mechanics_response, sampled_controller
from ..plants.platform import model
from ..plants.platform import siso_loops as siso
from ..plants.platform.channels import T_y
from ..plants.platform.lqg_weights import Weights, coils, ground, lqg
from .record import Published

SOURCE = "003 platform report"
DT = 1e-3  # s
V = 1e-10  # (m/s)² s, believed and true: where the report's 20–40 dB come out
BAND_HZ = np.unique(np.concatenate([np.geomspace(0.5, 3.0, 400),
                                 *(f + np.linspace(-0.05, 0.05, 201) for f in (0.995, 1.193, 1.494))]))
FREQUENCIES_HZ = np.unique(np.concatenate([np.geomspace(0.1, 499, 2000), BAND_HZ]))


def controllers(v: float) -> tuple[Plant, ...]:
    """None, our SISO pair, full LQG, the same designed for the samples, decoupled LQG."""
    plant, weights = balanced_truncation(model.plant(), 8).plant, Weights(v0=v)
    nothing = Plant(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((3, 0)), np.zeros((3, 4)))
    sampled = sampled_lqg(coils(plant), weights.Q(plant), weights.R, weights.W, weights.V, DT, G=ground(plant))
    return nothing, siso.designed(), lqg(plant, weights).controller, sampled.controller, siso.decoupled_lqg(weights)


@lru_cache(maxsize=4)
def densities(v: float, whole: bool) -> np.ndarray:
    """Vertical, rotation, horizontal velocity in (m/s)²/Hz under white ground and sensors of intensity v, (5, n_f,
    3)."""
    plant = model.plant()
    loops = [sampled_loop(plant, sampled_controller(c, DT), range(3), W=1e-12 * np.eye(2), V=v * np.eye(4),
                          outputs=T_y[:3] @ plant.C) for c in controllers(v)]
    mechanics = mechanics_response(loops[0], FREQUENCIES_HZ if whole else BAND_HZ)
    return np.array([loop_density(loop, mechanics)[:, :3] for loop in loops])


def by_area(channel: int) -> np.ndarray:
    """Suppression in dB over 0.5–3 Hz of SISO pair, full LQG, decoupled LQG."""
    area = np.trapezoid(densities(V, False)[:, :, channel], BAND_HZ, axis=1)
    return 10 * np.log10(area[0] / area[[1, 2, 4]])


def rms(channel: int) -> np.ndarray:
    """RMS velocity from 0.1 Hz up in µm/s: full LQG, decoupled LQG, SISO pair."""
    return 1e6 * np.sqrt(np.trapezoid(densities(V, True)[:, :, channel], FREQUENCIES_HZ, axis=1))[[2, 4, 1]]


def peaks(v: float) -> np.ndarray:
    """How far the full LQG brings the highest peak of vertical, rotation, horizontal down, in dB."""
    S = densities(v, False)
    return 10 * np.log10(S[0].max(axis=0) / S[2].max(axis=0))


def filters_apart() -> float:
    """Largest distance in dB of steady LQE and settled recursive filter, 0.1–10 Hz, all three channels."""
    S, work = densities(V, True), FREQUENCIES_HZ <= 10
    return float(np.abs(10 * np.log10(S[3][work] / S[2][work])).max())


def fastest(controller: Plant, dt: float) -> float:
    """Largest |z| of the loop with a controller run every dt s by Tustin's rule."""
    return sampled_loop(model.plant(), sampled_controller(controller, dt), range(3)).radius


RECORDS = (
    Published(SOURCE, "figure 23, horizontal, dB over 0.5–3 Hz: SISO, LQG, decoupled", "nearly equal",
              lambda: by_area(2), right="15.8, 16.5, 16.5"),
    Published(SOURCE, "figure 24, rotation, µm/s RMS: LQG, decoupled, SISO", "in this order", lambda: rms(1),
              right="2.54, 3.47, 4.34", relative=0.01),
    Published(SOURCE, "figure 24, rotation, dB over 0.5–3 Hz: SISO, LQG, decoupled", "LQG best, decoupled between",
              lambda: by_area(1), right="9.4, 13.0, 10.4"),
    Published(SOURCE, "figure 25, vertical, µm/s RMS: LQG, decoupled, SISO", "LQG, then SISO, then decoupled",
              lambda: rms(0), "beyond", "24.9, 24.9, 100", relative=0.01,
              note="not reproduced: by symmetry the vertical channel is alone, so decoupled and full LQG are one there"),
    Published(SOURCE, "sections 5.3.2, 6.1, LQE and recursive filter apart, dB in 0.1–10 Hz", "almost identical",
              filters_apart, right="0.0", tolerance=0.2,
              note="continuous design by Tustin at 1 kHz beside the design for the samples"),
    Published(SOURCE, "section 6.1, full LQG, peaks in dB, sensors as believed at V = 1e-10", "20–40 dB",
              lambda: peaks(1e-10), "beyond", "38.2, 16.0, 34.2", tolerance=0.07,
              note="half of what is left is sensor noise; pitch stays below 20 dB"),
    Published(SOURCE, "section 6.1, the same at V = 1e-11", "20–40 dB", lambda: peaks(1e-11), "beyond",
              "48.2, 25.7, 44.1", tolerance=0.07),
    Published(SOURCE, "published SISO pair at 1 kHz, 10 kHz: largest |z|", "", lambda: (
        fastest(siso.published(), 1e-3), fastest(siso.published(), 1e-4)), "beyond", "34.2, 1.0", tolerance=0.01,
        note="gain 31 250 needs ten times the sampling rate"),
)
