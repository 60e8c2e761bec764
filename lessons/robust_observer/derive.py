"""Compute the numbers in the derivation of lesson 15: both conditions, t = g H(s), J."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .loop import S

REAL = 1e-9


def derived(outcome: Outcome[S]) -> Mapping[str, Value]:
    """Both conditions, the parts of J, and the row that belongs to the first real pole, if there is one."""
    o = outcome.study.observer
    A, C, order = o.plant.A, o.plant.C, {1: 1, 2: 2, "inf": np.inf}[o.norm]
    wrong = o.wrong

    def sizes(weights: np.ndarray, left: np.ndarray, directions: np.ndarray) -> float:
        return float(sum(w * np.linalg.norm(left @ d, order) for w, d in zip(weights, directions, strict=True)))
    known: dict[str, Value] = {
        "TA": o.T @ A, "FT": o.F @ o.T, "LC": o.L @ C, "NT": o.N @ o.T, "MC": o.M @ C, "K": o.K,
        "J_A": sizes(wrong.alpha, o.T, wrong.A), "J_L": sizes(wrong.beta, o.L, wrong.C), "J_M": sizes(wrong.gamma, o.M, wrong.C),
        "J": o.J}
    values, vectors = np.linalg.eig(o.F.T)
    real = np.flatnonzero(np.abs(np.imag(values)) < REAL)
    if len(real) and len(C) == 1:
        s, row = float(np.real(values[real[0]])), np.real(vectors[:, real[0]])[None]
        t, lower = row @ o.T, row @ o.L
        H = _adjugate_row(A, C, s)
        top = int(np.argmax(np.abs(H)))
        known |= {"s": s, "t": t, "tA": t @ A, "l": float(lower[0, 0]), "lC": lower @ C, "H": H, "g": float(t[0, top] / H[0, top]),
                  "det": float(np.linalg.det(s * np.eye(len(A)) - A))}
    return known


def _adjugate_row(A: np.ndarray, C: np.ndarray, s: float) -> np.ndarray:
    """C adj(sI − A) (1×n) by the recursion of Faddeev and LeVerrier, also where s is a pole of A."""
    n, B, total = len(A), np.eye(len(A)), np.zeros_like(A)
    for k in range(n):
        total = total + B * s ** (n - 1 - k)
        AB = A @ B
        B = AB - np.trace(AB) / (k + 1) * np.eye(n)
    return C @ total
