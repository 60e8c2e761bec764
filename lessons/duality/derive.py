"""Compute the numbers in the derivation of lesson 5: both Riccati equations, both gains."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome
from observer_lab.engine import lqr

from .dual_quantities import Setting, Twins, weights_of


def derived(here: Setting, outcome: Outcome[Twins]) -> Mapping[str, Value]:
    """The cost, entry 11 of each term of both equations, P by two routes, L with its twin; for one sensor the gain of the filter."""
    plant, twins = here.plant(outcome.design), outcome.study
    Q, R, W, V = weights_of(here, outcome.design)
    A, B, C, P = plant.A, plant.B, plant.C, twins.P
    optimal = lqr(A, B, Q, R)
    S, K, x = optimal.solution, optimal.gain, np.asarray(here.model.x0, dtype=float)[:, None]
    u = -K @ x
    cost, rate = (x.T @ Q @ x + u.T @ R @ u).item(), (2 * x.T @ S @ (A @ x + B @ u)).item()
    s_lin, s_quad = 2 * (A.T @ S)[0, 0], (S @ B @ np.linalg.solve(R, B.T @ S))[0, 0]
    p_lin, p_quad = 2 * (A @ P)[0, 0], (P @ C.T @ np.linalg.solve(V, C @ P))[0, 0]
    share, start = outcome.design["terminal"], float(twins.horizon.S[0][0, 0])
    end = {"s_inf": float(S[0, 0]), "s_end": float(share * S[0, 0]), "d_end": float((1 - share) * S[0, 0]), "s_start": start,
           "d_start": float(S[0, 0]) - start}
    gain: dict[str, Value] = {"v": float(V[0, 0]), "Ct": C.T, "L_w": P @ C.T / V[0, 0]} if plant.p == 1 else {}
    return gain | end | {
        "cost_now": cost, "cost_rate": rate, "zero_j": 0.0, "K_opt": K, "x_start": x, "Kx": (K @ x).item() if len(K) == 1 else K @ x,
        "s_lin": float(s_lin), "s_quad": float(s_quad), "q": float(Q[0, 0]), "zero_s": 0.0,
        "p_lin": float(p_lin), "p_quad": float(p_quad), "w": float(W[0, 0]), "zero_p": 0.0,
        "S_dual": twins.S_dual, "P": P, "K_d": outcome.gains["K_dual"], "L": outcome.gains["L"]}
