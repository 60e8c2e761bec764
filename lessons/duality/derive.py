"""Compute the numbers in the derivation of lesson 5: both Riccati equations, both gains."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome
from observer_lab.engine import lqr

from .dual_quantities import Setting, Twins, weights_of


def derived(here: Setting, outcome: Outcome[Twins]) -> Mapping[str, Value]:
    """Entry 11 of every term of both equations, P by two routes, the present L with its twin; for one sensor the filter's gain."""
    plant, twins = here.plant(outcome.design), outcome.study
    Q, R, W, V = weights_of(here, outcome.design)
    A, B, C, P = plant.A, plant.B, plant.C, twins.P
    S = lqr(A, B, Q, R).solution
    s_lin, s_quad = 2 * (A.T @ S)[0, 0], (S @ B @ np.linalg.solve(R, B.T @ S))[0, 0]
    p_lin, p_quad = 2 * (A @ P)[0, 0], (P @ C.T @ np.linalg.solve(V, C @ P))[0, 0]
    gain: dict[str, Value] = {"v": float(V[0, 0]), "Ct": C.T, "L_w": P @ C.T / V[0, 0]} if plant.p == 1 else {}
    return gain | {
        "s_lin": float(s_lin), "s_quad": float(s_quad), "q": float(Q[0, 0]), "zero_s": 0.0,
        "p_lin": float(p_lin), "p_quad": float(p_quad), "w": float(W[0, 0]), "zero_p": 0.0,
        "S_dual": twins.S_dual, "P": P, "K_d": outcome.gains["K_dual"], "L": outcome.gains["L"]}
