"""Compute the numbers in the derivation of lesson 10: split of the cost, Doyle's polynomial."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome
from observer_lab.plants import doyle

from .loops import setting_of
from .study import Study


def cost_split(outcome: Outcome[Study]) -> dict[str, Value]:
    """The cost's two parts beside that of the whole loop, where m = 1; on a person's own plant too."""
    case, design, cost = outcome.study.case, outcome.design, outcome.study.cost
    setting = setting_of(case, design)
    known: dict[str, Value] = {"known": cost.known, "total": cost.total}
    if setting.gain == 1.0:
        f, plant, L, K = setting.factors, case.plant, outcome.gains["L"], outcome.gains["K"]
        noise = outcome.study.disturbance * case.G @ case.W @ case.G.T + f.sensor * L @ case.V @ L.T
        P = solve_continuous_lyapunov(plant.A - L @ plant.C, -noise)
        known["unknown"] = float(np.sum((K.T @ (f.alpha_r * case.R) @ K) * P))
    return known


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """The split of the cost, and the last coefficients of Doyle's loop."""
    known, design = cost_split(outcome), outcome.design
    setting = setting_of(outcome.study.case, design)
    q, sigma, m = design["q"], design["sigma"], setting.gain
    top, d = doyle.gains(q, sigma)
    p, K, L = doyle.plant(), top * np.ones((1, 2)), d * np.ones((2, 1))
    whole = np.block([[p.A, -m * p.B @ K], [L @ p.C, p.A - p.B @ K - L @ p.C]])
    polynomial = np.real(np.poly(whole))
    return known | {"q": q, "sigma": sigma, "f": top, "d": d, "m": m, "c1": float(polynomial[-2]), "c0": float(np.linalg.det(whole)),
                    "excess": doyle.largest_gain(q, sigma) - 1}
