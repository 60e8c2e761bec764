"""Compute J and N of the examples in closed form over whole axes of poles."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Design
from observer_lab.plants.two_carts import CARTS, STIFFNESS

from .knobs import EXAMPLE_FOUR, EXAMPLE_THREE
from .study import EXAMPLE_1, norm_of, turn


def criterion_1(s: np.ndarray, design: Design) -> np.ndarray:
    """The three parts of J of example 1 over s (3, n): (α₁ + α₂)|s|, β|s² + 4s + 3|, γ|50 + 30s|; equal in all norms."""
    return np.array([(1 + design["second"]) * design["alpha"] * np.abs(s), design["beta"] * np.abs(s * s + 4 * s + 3),
                     design["gamma"] * np.abs(50 + 30 * s)])


def criterion_2(s1: np.ndarray, s2: np.ndarray, design: Design) -> np.ndarray:
    """The three parts of J of example 2 over s1, s2 (3, …): both real, or conjugate (Re and Im are then the rows).

    Every matrix in J has one column that is not zero: J = (α₁ + α₂)‖W 1‖ + β‖W l′‖ + γ|1 + s1 + s2 − s1 s2|.
    """
    pair = np.iscomplexobj(s1)
    l1, l2 = (-s * (s + 1) * (s + 2) for s in (s1, s2))
    ones = np.array([1.0, 0.0 if pair else 1.0])
    rows = np.array([np.real(l1), -np.imag(l2) if pair else l2])
    order = {1: 1, 2: 2, "inf": np.inf}[norm_of(design)]
    W = turn(design)
    known = np.full(np.shape(s1), (1 + design["second"]) * design["alpha"] * np.linalg.norm(W @ ones, order))
    seen = design["beta"] * np.linalg.norm(np.tensordot(W, rows, 1), order, axis=0)
    return np.array([known, seen, design["gamma"] * np.abs(np.real(1 + s1 + s2 - s1 * s2))])


def criterion_3(s1: np.ndarray, s2: np.ndarray, design: Design) -> np.ndarray:
    """The three parts of J of example 1 with two states over s1, s2 (3, …): both real, or conjugate.

    J = (α₁ + α₂)‖(s1, s2)‖ + β‖(l1, l2)‖ + γ|M′| with l = −(s² + 4s + 3); of a pair Re and Im stand in place of the two.
    """
    pair = np.iscomplexobj(s1)
    l1, l2 = (-(s * s + 4 * s + 3) for s in (s1, s2))
    order = {1: 1, 2: 2, "inf": np.inf}[norm_of(design)]
    poles, seen = (np.array([np.real(a), np.imag(a) if pair else b]) for a, b in ((s1, s2), (l1, l2)))
    return np.array([(1 + design["second"]) * design["alpha"] * np.linalg.norm(poles, order, axis=0),
                     design["beta"] * np.linalg.norm(seen, order, axis=0),
                     np.full(np.shape(s1), design["gamma"] * abs(design["free"]))])


def direct_4(s1: np.ndarray, s2: np.ndarray) -> np.ndarray:
    """M₂ of the carts, from the tachometer straight into û: k₂ − k₄ − (k₃(s1 + s2) − k₄ s1 s2)/k; zero on a circle for a pair."""
    k2, k3, k4 = CARTS.K[0, 1:]
    return k2 - k4 - np.real(k3 * (s1 + s2) - k4 * s1 * s2) / STIFFNESS


def criterion_4(s1: np.ndarray, s2: np.ndarray, design: Design) -> np.ndarray:
    """The three parts of J of the carts over s1, s2 (3, …): both real, or conjugate; J = (α₁ + α₂)‖(s1², s2²)‖/k + γ|M₂|.

    T A₁ and T A₂ are −(s²/k)(1, 0, −1, 0) and one column further; L takes nothing of the tachometer, so L C₁ = 0.
    """
    pair = np.iscomplexobj(s1)
    first, second = s1 * s1 / STIFFNESS, s2 * s2 / STIFFNESS
    rows = np.array([np.real(first), np.imag(first) if pair else second])
    norm = norm_of(design)
    size = (np.abs(rows).sum(axis=0) if norm == 1 else np.sqrt(2) * np.linalg.norm(rows, axis=0) if norm == 2 else
            2 * np.abs(rows).max(axis=0))
    return np.array([(1 + design["second"]) * design["alpha"] * size, 0 * size, design["gamma"] * np.abs(direct_4(s1, s2))])


def of_two(s1: np.ndarray, s2: np.ndarray, design: Design) -> np.ndarray:
    """The three parts of J over two poles, of the example with two of them that the design shows."""
    return {EXAMPLE_THREE: criterion_3, EXAMPLE_FOUR: criterion_4}.get(design["example"], criterion_2)(s1, s2, design)


def steering(s1: np.ndarray, s2: np.ndarray) -> np.ndarray:
    """Largest entry of |N| of example 2 for W = I and real poles: N = ±[1 − s2, s1 − 1]/(s2 − s1)."""
    apart = np.maximum(np.abs(s2 - s1), 1e-12)
    return np.maximum(np.abs(1.0 - s2), np.abs(1.0 - s1)) / apart


def steering_3(s1: np.ndarray, s2: np.ndarray, direct: float) -> np.ndarray:
    """Largest entry of |N| of example 1 with two real poles: N = (K − M′C) T⁻¹."""
    apart, (k1, k2) = np.maximum(np.abs(s2 - s1), 1e-12), EXAMPLE_1.K[0]
    return np.maximum(np.abs(k1 * s2 - k2 + direct), np.abs(k2 - direct - k1 * s1)) / apart
