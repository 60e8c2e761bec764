"""Compute the numbers in the derivation of lesson 14: one hardening spring in three ways."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .cases import LENGTH, PLATFORM, case_of
from .runs import Study

HEIGHT_INDEX, MILLI = 1, 1e3
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.hermite_e.hermegauss(8)


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Lengths in mm, forces over k in mm, for a deck one standard deviation of its height off; `exact` by quadrature."""
    design = outcome.design
    gamma, ell = design["hardening"], MILLI * LENGTH
    sigma = MILLI * design["size"] * float(case_of(PLATFORM).spread[HEIGHT_INDEX])
    m, c2 = sigma, design["alpha"] ** 2 * (1 + design["kappa"])

    def force(e: np.ndarray | float) -> np.ndarray | float:
        return e * (1 + gamma * (e / ell) ** 2)
    known: dict[str, Value] = {
        "m": m, "l": ell, "x": m / ell, "gamma": gamma, "sigma": sigma, "tangent": float(force(m)), "second": 6 * gamma * m / ell**2,
        "exact": float(GAUSS_WEIGHTS @ force(m + sigma * GAUSS_NODES) / GAUSS_WEIGHTS.sum()),
        "bend": 3 * gamma * m * sigma / ell**2 / (1 + 3 * gamma * (m / ell) ** 2)}
    if c2 > 0:
        reach = np.sqrt(c2) * sigma
        known |= {"c2": c2, "above": float(force(m + reach)), "below": float(force(m - reach))}
    return known
