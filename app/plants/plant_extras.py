"""Read what a plant file may hold beyond A, B, C, D: bilinear terms uⱼ Fⱼ x and g = K x."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..engine import EngineError, Plant, ShapeError, to_json
from ..engine.systems import as_matrix

__all__ = ["NO_EXTRAS", "PlantExtras", "extras_of", "plant_json"]

MOST_WANTED = 16  # rows of K


@dataclass(frozen=True, eq=False)
class PlantExtras:
    """ẋ = A x + B u + Σ uⱼ Fⱼ x with F = [F₁ … F_m] n×(m n), and g = K x with K r×n; None where the file leaves it out.

    Without F no K is read.
    """

    F: np.ndarray | None = None
    K: np.ndarray | None = None


NO_EXTRAS = PlantExtras()


def extras_of(more: Mapping[str, np.ndarray], plant: Plant) -> PlantExtras:
    """F and K of the file that the plant came from. Raises EngineError, in one sentence, where they do not fit the plant."""
    F = _multiplying(more, plant)
    if F is None:
        return NO_EXTRAS
    K = more.get("K")
    if K is None:
        return PlantExtras(F)
    if K.shape[1] != plant.n or not 1 <= len(K) <= MOST_WANTED:
        raise ShapeError("K must have 1 to {most} rows of {n} numbers, one for each state; it is {rows}×{columns}.",
                         most=MOST_WANTED, n=plant.n, rows=K.shape[0], columns=K.shape[1])
    return PlantExtras(F, as_matrix(K, "K"))


def _multiplying(more: Mapping[str, np.ndarray], plant: Plant) -> np.ndarray | None:
    """[F₁ … F_m] of the file: F where there is one input, F1, F2, … where there are several, zero where one of them is left out."""
    keys = [f"F{j + 1}" for j in range(plant.m)]
    found = {key: M for key, M in more.items() if key != "K"}
    if not found:
        return None
    if plant.dt:
        raise EngineError("A bilinear plant must be in continuous time: give dx/dt = A x + B u + u F x without dt, or leave out F.")
    if "F" in found and plant.m > 1:
        raise EngineError("F multiplies one input, and this plant has {count}: give F1 to F{count}, one for each, or keep one column of B.",
                          count=plant.m)
    for key, F in found.items():
        if key not in ("F", *keys):
            raise EngineError("{name} has no input to multiply; this plant has {count} inputs.", name=key, count=plant.m)
        if F.shape != plant.A.shape:
            raise ShapeError("{name} must be {n}×{n}, as A is; it is {rows}×{columns}.", name=key, n=plant.n, rows=F.shape[0],
                             columns=F.shape[1])
    return np.hstack([as_matrix(found.get("F", found.get(key, np.zeros_like(plant.A))), key) for key in keys])


def plant_json(plant: Plant, beyond: PlantExtras) -> str:
    """The plant as JSON that reads back exactly, with F and K where there are any."""
    parts = () if beyond.F is None else np.hsplit(beyond.F, plant.m)
    more = {"F" if plant.m == 1 else f"F{j + 1}": F.tolist() for j, F in enumerate(parts)}
    more |= {} if beyond.K is None else {"K": beyond.K.tolist()}
    return json.dumps(json.loads(to_json(plant)) | more, ensure_ascii=False) if more else to_json(plant)
