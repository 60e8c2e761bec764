"""Compute the numbers in the derivation of lesson 12: one mode, error bound, geometry."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .balanced_platform import MASSES_TOGETHER_MODE, closed_forms
from .platform_study import PlatformStudy
from .study import sharp_bound


def derived(outcome: Outcome[PlatformStudy]) -> Mapping[str, Value]:
    """Of the motion on the stage: ‖wᴴB‖, ‖Cv‖, |Re λ| and its strength; the bounds of the order; the closed form."""
    s = outcome.study.system
    motion, p = s.motions[int(outcome.design["pair"]) - 1], s.parameters
    values, left = np.linalg.eig(s.plant.A.conj().T)
    w = left[:, np.argmin(np.abs(values.conj() - motion.pole))]
    w = w / np.conj(w.conj() @ motion.shape)
    reached, heard = float(np.linalg.norm(w.conj() @ s.plant.B)), float(np.linalg.norm(s.plant.C @ motion.shape))
    damping = abs(motion.pole.real)
    order, values = outcome.study.cut.order, s.hankel
    even = order + order % 2  # equal values are cut together
    sharp = sharp_bound(values, even) or 2 * float(values[even:].sum())
    return {
        "once": sharp / 2, "sharp": sharp, "first": float(s.hankel[0]), "last": float(s.hankel[-1]), "reached": reached, "heard": heard,
        "damping": damping, "Wc": reached**2 / (2 * damping), "strength": motion.strength, "tail": float(values[order:].sum()),
        "bound": outcome.study.cut.bound, "N_z": float(np.hypot(np.sqrt(2), 2 * p.kz * s.unit)), "mu": p.mu, "m": p.m, "c_p": p.cp,
        "together": dict(closed_forms(p, s.unit))[MASSES_TOGETHER_MODE]}
