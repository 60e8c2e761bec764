"""Make state estimators in MATLAB's habit: estim of a plant and a gain, kalman of its noise."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import numpy as np

from ..design.optimal import DiscreteFilter, Optimal, dlqe, lqe
from ..systems.arrays import as_checked, as_covariance
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import choice, count, covariance, items, matrix, optional, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant

__all__ = ["estim", "kalman"]


@takes(plant=PLANT, L=matrix("n q"), sensors=optional(items(count())), known=optional(items(count())))
def estim(plant: Plant, L: object, sensors: Iterable[int] | None = None, known: Iterable[int] | None = None) -> Plant:
    """The estimator x̂̇ = A x̂ + B u + L (y − C x̂ − D u) from (u, y) to (ŷ, x̂); a sampled plant has x̂⁺ in place of x̂̇.

    `sensors` are the outputs that L (n×q) takes in, all if left out, and `known` the inputs that the estimator is given, none if left
    out; both count from 0. Raises ShapeError, EngineError where they do not fit the plant.

    >>> estim(Plant([[-1]], [[1]], [[1]]), [[2]], known=[0]).B
    array([[1., 2.]])
    """
    L, seen, given = as_checked(L), _picked(sensors, plant.p, "sensors", range(plant.p)), _picked(known, plant.m, "known", ())
    if L.shape[1] != len(seen):
        raise ShapeError("{name} must be {must}; it is {it_is}.", name="L", must=f"{plant.n}×{len(seen)}", it_is=f"{len(L)}×{L.shape[1]}")
    return _built(plant, L, np.zeros((plant.n, len(seen))), seen, given)


@takes(plant=PLANT, Qn=covariance(), Rn=covariance("p"), Nn=optional(matrix()), type=choice("current", "delayed"))
def kalman(plant: Plant, Qn: object, Rn: object, Nn: object = None,
           type: Literal["current", "delayed"] = "current") -> tuple[Plant, np.ndarray, np.ndarray]:
    """(kest, L, P): the steady Kalman filter of ẋ = A x + B u + G w, y = C x + D u + H w + v as a system, its gain and P.

    The last q inputs of the plant are w, for Qn q×q; the first are u. Qn, Rn (p×p) and Nn = E w vᵀ (q×p) are intensities, of a sampled
    plant covariances. kest goes from (u, y) to (ŷ, x̂). Of a sampled plant P and L belong to the prediction x̂[k|k−1], and kest
    gives x̂[k|k], or x̂[k|k−1] if "delayed". Raises as `lqe` does.

    >>> np.round(kalman(Plant([[-1]], [[1, 1]], [[1]]), [[3]], [[1]])[1], 6)
    array([[1.]])
    """
    q = as_checked(Qn).shape[0]
    if q > plant.m:
        raise ShapeError("Qn is {q}×{q} but the plant has {m} inputs; its last inputs are the noise.", q=q, m=plant.m)
    known, D = plant.m - q, np.asarray(plant.D)
    G, H, W = plant.B[:, known:], D[:, known:], as_covariance(Qn, "Qn", q)
    N = np.zeros((q, plant.p)) if Nn is None else as_checked(Nn)
    if N.shape != (q, plant.p):
        raise ShapeError("{name} must be {must}; it is {it_is}.", name="Nn", must=f"{q}×{plant.p}", it_is=f"{len(N)}×{N.shape[1]}")
    V = as_covariance(Rn, "Rn", plant.p) + H @ W @ H.T + H @ N + N.T @ H.T  # of the noise H w + v in a reading
    found: Optimal = (dlqe if plant.dt else lqe)(plant.A, G, plant.C, W, V, N + W @ H.T)
    M = found.filter_gain if isinstance(found, DiscreteFilter) and type == "current" else np.zeros((plant.n, plant.p))
    return _built(plant, found.gain, M, range(plant.p), range(known)), found.gain, found.solution


def _picked(given: object, most: int, name: str, otherwise: Iterable[int]) -> list[int]:
    """Places of signals, each once."""
    picked = list(otherwise) if given is None else [int(place) for place in np.asarray(given)]
    if len(set(picked)) != len(picked) or any(not 0 <= place < most for place in picked):
        raise EngineError("{name} must be different whole numbers from 0 to {most}.", name=name, most=most - 1)
    return picked


def _built(plant: Plant, L: np.ndarray, M: np.ndarray, seen: Iterable[int], given: Iterable[int]) -> Plant:
    """x̂⁺ or x̂̇ with the gain L; the outputs are of x̂ + M (y − C x̂ − D u)."""
    seen, given = list(seen), list(given)
    C, D, B = plant.C[seen], np.asarray(plant.D)[np.ix_(seen, given)], plant.B[:, given]
    outward = np.vstack([C, np.eye(plant.n)])
    direct = np.vstack([D, np.zeros((plant.n, len(given)))])
    return Plant(plant.A - L @ C, np.hstack([B - L @ D, L]), outward @ (np.eye(plant.n) - M @ C),
                 np.hstack([direct - outward @ M @ D, outward @ M]), plant.dt, tuple(f"{name}_hat" for name in plant.state_names),
                 tuple(plant.input_names[i] for i in given) + tuple(plant.output_names[i] for i in seen),
                 tuple(f"{plant.output_names[i]}_hat" for i in seen) + tuple(f"{name}_hat" for name in plant.state_names),
                 name=f"estimator of {plant.name}".strip())
