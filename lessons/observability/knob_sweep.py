"""Sweep one knob: distance of the weakest mode from unobservability, and rank of O."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from observer_lab.course.lesson import Design

from .cases import PLANT_CASES, dynamics, rows

LOWEST = -17.0  # decades: exact zeros are drawn here
USED = ("plant", "left_on", "left", "right_on", "right", "across_on", "angle", "gap", "count")  # what a plant depends on


@dataclass(frozen=True, eq=False)
class Sweep:
    """`along`: the knob's values (log₁₀ of them if `log`), `at` the present one; `distance` = weakest
    σ_min [A − λI; C] over the poles and `ratio` = σ_min/σ_max(O), both in decades."""

    label: str
    log: bool
    at: float
    along: np.ndarray
    distance: np.ndarray
    ratio: np.ndarray


def decades(values: np.ndarray) -> np.ndarray:
    """log₁₀|values|, not below the lowest that is drawn."""
    return np.log10(np.maximum(np.abs(values), 10.0**LOWEST))


def sweep(design: Design) -> Sweep:
    """The knob that matters most for the plant, over its whole range."""
    name, label, grid, log = _axis(design)
    kept = tuple((k, grid[0] if k == name else design[k]) for k in USED)
    distance, ratio = _along(Design(design.lesson, kept), name, grid)
    along, at = (np.log10(grid), float(np.log10(design[name]))) if log else (np.array(grid), float(design[name]))
    return Sweep(label, log, at, along, distance, ratio)


def _axis(design: Design) -> tuple[str, str, tuple[float, ...], bool]:
    """The knob that is swept: its name, axis label, grid, and whether the axis counts decades."""
    plant = design["plant"]
    if plant == "notes":
        return "angle", "φ [°]", tuple(np.linspace(-90, 90, 73).tolist()), False
    if plant == "pair":
        return "gap", "ε", tuple(np.logspace(-8, 0, 33).tolist()), True
    if plant == "many":
        return "count", "n", tuple(float(n) for n in range(2, 21)), False
    name = "left" if design["left_on"] or not design["right_on"] else "right"
    return name, "p [m]", tuple(np.linspace(-0.2, 0.2, 41).tolist()), False


@lru_cache(maxsize=64)
def _along(design: Design, name: str, grid: tuple[float, ...]) -> np.ndarray:
    case, out = PLANT_CASES[design["plant"]], []
    for value in grid:
        moved = design.with_values(**{name: value})
        A, C = dynamics(case, moved), rows(case, moved)
        out.append((least_distance(A, C), least_ratio(A, C)))
    return decades(np.array(out).T)


def least_distance(A: np.ndarray, C: np.ndarray) -> float:
    n = len(A)
    values = np.asarray(np.linalg.eigvals(A), dtype=complex)
    poles = values[np.imag(values) >= 0]
    stack = np.empty((len(poles), n + len(C), n), dtype=complex)
    stack[:, :n], stack[:, n:] = A - poles[:, None, None] * np.eye(n), C
    return float(np.linalg.svd(stack, compute_uv=False)[:, -1].min())


def least_ratio(A: np.ndarray, C: np.ndarray) -> float:
    blocks = [C]
    for _ in range(len(A) - 1):
        blocks.append(blocks[-1] @ A)
    values = np.linalg.svd(np.vstack(blocks), compute_uv=False)
    return float(values[-1] / values[0]) if values[0] > 0 else 0.0
