"""The numbers that stand now in the derivation of lesson 13: the vertical channel's gain, the crossover of our pair, its phase."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.lesson.derivation import Value
from app.lesson.lesson import Outcome
from app.plants.platform_channels import VERTICAL
from app.plants.platform_siso import VERTICAL_SHAPE, rigid_polynomials

from .players import DT, ORDER
from .study import Study
from .world import BAND, band_rms


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Band velocities in µm/s and their ratio in dB where the loop on the stage is stable; crossover and lost phase."""
    study, late = outcome.study, 1e-3 * outcome.design["delay"] + DT / 2
    g, b = abs(VERTICAL_SHAPE.gain), float(abs(rigid_polynomials(VERTICAL)[0][0]))
    crossover = g * b / (2 * np.pi)
    known: dict[str, Value] = {
        "g": g, "b": b, "two_pi": 2 * np.pi, "crossover": crossover, "late": late, "phase": 360 * crossover * late}
    i = ORDER.index(outcome.design["play"])
    if study.spectra[i].stable:
        opened, closed = (float(band_rms(study.f, study.spectra[k].density, *BAND)[0]) for k in (0, i))
        known |= {"rms_open": opened, "rms": closed, "area": closed**2, "gain": float(study.band_db[i, 0])}
    return known
