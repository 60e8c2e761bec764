"""Design LQG control and compute the average cost of its loop."""

from __future__ import annotations

import numpy as np

from ..design.optimal import Optimal, dlqe, dlqr, lqe, lqr
from ..systems.arrays import as_checked, as_covariance
from ..systems.gates.argument_checks import covariance, matrix, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record
from .compensator import compensator

__all__ = ["Lqg", "lqg"]


@record()
class Lqg:
    """An LQG design. K (m×n), L (n×p), controller from y to u with its sign, u = −K x̂.

    regulator, estimator: the two Riccati solutions S and P with their certificates. The least average of
    xᵀQx + uᵀRu, if the noise is as it was believed, is tr(S G W Gᵀ) + tr(P KᵀRK), R + BᵀSB in place of R for a sampled plant:
    `known_state`, what a regulator that knows x would pay, and `estimation`, what not knowing it adds.
    """

    K: np.ndarray
    L: np.ndarray
    controller: Plant
    regulator: Optimal
    estimator: Optimal
    known_state: float
    estimation: float

    @property
    def cost(self) -> float:
        """Both together."""
        return self.known_state + self.estimation


@takes(plant=PLANT, Q=covariance("n"), R=covariance("m"), W=covariance(), V=covariance("p"), G=matrix("n q"))
def lqg(plant: Plant, Q: object, R: object, W: object, V: object, *, G: object | None = None) -> Lqg:
    """u = −K x̂ minimising the average of xᵀQx + uᵀRu for ẋ = A x + B u + G w, y = C x + D u + v, or x⁺ of a sampled plant.

    Q n×n ≥ 0, R m×m > 0; W q×q ≥ 0, V p×p > 0 intensities of white w, v (a number is that number times I); G n×q, by
    default B. K depends on Q, R alone, L on W, V alone: separation. Of a sampled plant W and V are covariances, the cost is of a
    sample, and the controller answers one sample late, u[k] = −K x̂[k|k−1]; `sampled_lqg` makes one that uses y[k] too. Platform
    report (003), equations (71)–(74), (79), (86)–(89). Raises ShapeError, EngineError for bad weights, RiccatiError where no
    stabilising gain exists.

    >>> np.round(lqg(Plant([[0]], [[1]], [[1]]), [[1]], [[1]], [[1]], [[1]]).regulator.gain, 6)
    array([[1.]])
    """
    G = plant.B if G is None else as_checked(G)
    R, W = as_checked(R), as_covariance(W, "W", G.shape[1])
    regulator = (dlqr if plant.dt else lqr)(plant.A, plant.B, Q, R)
    estimator = (dlqe if plant.dt else lqe)(plant.A, G, plant.C, W, as_checked(V))
    K, L, S = regulator.gain, estimator.gain, regulator.solution
    price = R + plant.B.T @ S @ plant.B if plant.dt else R  # of an error in u
    return Lqg(K, L, compensator(plant, K, L), regulator, estimator, float(np.trace(S @ G @ W @ G.T)),
               float(np.trace(estimator.solution @ K.T @ price @ K)))
