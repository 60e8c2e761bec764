"""Compute the numbers in the derivation of lesson 13: vertical gain, crossover, phase."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome
from observer_lab.plants.platform.channels import VERTICAL_CHANNEL
from observer_lab.plants.platform.siso_loops import VERTICAL_SHAPE, rigid_polynomials

from .controllers import DT, ORDER
from .simulation import BAND_HZ, band_rms
from .study import Study


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Band velocities in µm/s and their ratio in dB where the loop on the stage is stable; crossover and lost phase."""
    study, late = outcome.study, 1e-3 * outcome.design["delay"] + DT / 2
    g, b = abs(VERTICAL_SHAPE.gain), float(abs(rigid_polynomials(VERTICAL_CHANNEL)[0][0]))
    crossover = g * b / (2 * np.pi)
    known: dict[str, Value] = {
        "g": g, "b": b, "two_pi": 2 * np.pi, "crossover": crossover, "late": late, "phase": 360 * crossover * late}
    i = ORDER.index(outcome.design["play"])
    if study.spectra[i].stable:
        opened, closed = (float(band_rms(study.f, study.spectra[k].density, *BAND_HZ)[0]) for k in (0, i))
        known |= {"rms_open": opened, "rms": closed, "area": closed**2, "gain": float(study.band_db[i, 0])}
    return known
