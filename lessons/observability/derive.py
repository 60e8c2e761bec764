"""Compute the numbers in the derivation of lesson 3: output derivatives, weakest mode."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import expm

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .study import Study

SERIES_TERMS = 20
OUTPUT_ROUNDING = 1e-12  # of the size of C


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Sizes of rows, the n-th derivative of the first output in two ways, and the weakest mode."""
    found = outcome.study
    plant, start = found.sensed.plant, found.start
    A, C, n = plant.A, plant.C, plant.n
    lower = [C[0] @ start]
    row = C[0]
    for _ in range(n):
        row = row @ A
        lower.append(row @ start)
    coefficients = np.real(np.poly(A))[1:]  # of λⁿ⁻¹, …, 1
    values, vectors = np.linalg.eig(A)
    weakest = int(np.argmin(np.abs(values - found.weakest.pole)))
    v = vectors[:, weakest]
    near, far = float(np.linalg.norm(C @ v)), float(np.linalg.norm(C @ np.linalg.matrix_power(A, n) @ v))
    if near <= OUTPUT_ROUNDING * float(np.linalg.norm(C, 2)):  # what is hidden: two roundings would not obey the equation
        near = far = 0.0
    time = 1 / float(np.linalg.norm(A, 2))
    terms, term = start.astype(float), start.astype(float)
    for k in range(1, SERIES_TERMS):
        term = time / k * (A @ term)
        terms = terms + term
    return {
        "exact": float(C[0] @ expm(time * A) @ start), "series": float(C[0] @ terms),
        "p": float(plant.p), "n": float(n), "rows": float(plant.p * n), "normA": float(np.linalg.norm(A, 2)),
        "norm0": float(np.linalg.norm(C, 2)), "norm1": float(np.linalg.norm(C @ A, 2)),
        "bound": float(np.linalg.norm(C, 2) * np.linalg.norm(A, 2)),
        "direct": float(lower[-1]), "combined": float(-coefficients @ np.array(lower[-2::-1])),
        "size": float(abs(values[weakest])), "near": near,
        "far": far, "distance": found.weakest.distance,
        "least": float(np.linalg.svd(np.vstack([A - values[weakest] * np.eye(n), C]), compute_uv=False)[-1])}
