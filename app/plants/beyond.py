"""What the file of a plant may say beyond A, B, C and D: the bilinear term u F x, and the numbers g = K x wanted of it."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np

from ..engine import EngineError, Plant, ShapeError, to_json
from ..engine.systems import read_matrix

__all__ = ["NOTHING", "Beyond", "beyond_in", "beyond_of", "written"]

MOST_WANTED = 16  # rows of K


@dataclass(frozen=True, eq=False)
class Beyond:
    """ẋ = A x + B u + u F x with F n×n, and g = K x with K r×n; None where the file leaves it out. Without F no K is read."""

    F: np.ndarray | None = None
    K: np.ndarray | None = None


NOTHING = Beyond()


def beyond_in(name: str, data: bytes, plant: Plant) -> Beyond:
    """F and K of the file that the plant came from. Raises EngineError, in one sentence, where they do not fit the plant."""
    F = read_matrix(name, data, "F")
    if F is None:
        return NOTHING
    if plant.dt:
        raise EngineError("A bilinear plant is taken in continuous time: give dx/dt = A x + B u + u F x and leave out dt, or leave out F.")
    if F.shape != plant.A.shape:
        raise ShapeError("F must be {n}×{n}, as A is; it is {rows}×{columns}.", n=plant.n, rows=F.shape[0], columns=F.shape[1])
    K = read_matrix(name, data, "K")
    if K is None:
        return Beyond(F)
    if K.shape[1] != plant.n or not 1 <= len(K) <= MOST_WANTED:
        raise ShapeError("K must have 1 to {most} rows of {n} numbers, one for each state; it is {rows}×{columns}.",
                         most=MOST_WANTED, n=plant.n, rows=K.shape[0], columns=K.shape[1])
    return Beyond(F, K)


def beyond_of(text: str, plant: Plant) -> Beyond:
    """F and K of a plant in its JSON text. Raises EngineError, as `beyond_in` does."""
    return beyond_in("plant.json", text.encode(errors="replace"), plant) if '"F"' in text else NOTHING


def written(plant: Plant, beyond: Beyond) -> str:
    """The plant as JSON that reads back exactly, with F and K where there are any."""
    more = {key: value.tolist() for key, value in (("F", beyond.F), ("K", beyond.K)) if value is not None}
    return json.dumps(json.loads(to_json(plant)) | more, ensure_ascii=False) if more else to_json(plant)
