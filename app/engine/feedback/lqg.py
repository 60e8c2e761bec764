"""Design LQG control, compute the average cost of its loop, and recover its margins (LTR)."""

from __future__ import annotations

import numpy as np

from ..design.optimal import Optimal, dlqe, dlqr, lqe, lqr
from ..systems.arrays import as_checked, as_covariance, symmetric
from ..systems.errors import EngineError
from ..systems.gates.argument_checks import covariance, matrix, number, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record
from ..systems.zeros import transmission_zeros
from .compensator import compensator
from .margins import LoopMargins, loop_margins, state_feedback_margins
from .sensitivity import Sensitivity, sensitivity

__all__ = ["Lqg", "Recovered", "lqg", "recover", "recover_at_output"]


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


@record()
class Recovered:
    """One step of recovery, with the knob q.

    gain_K (m×n), gain_L (n×p), compensator from y to u, margins of the loop, target: margins of the loop to recover.
    gap: max over ω of ‖S − S_target‖, the sensitivities at the recovered place; it goes to 0 as q grows if the plant
    has no zeros in the right half plane and as many outputs as inputs at least (at the output: at most).
    """

    q: float
    gain_K: np.ndarray
    gain_L: np.ndarray
    compensator: Plant
    margins: LoopMargins
    target: LoopMargins
    gap: float
    minimum_phase: bool | None


@takes(plant=PLANT, K=matrix(), W=covariance(), V=covariance("p"), q=number(0, 1_000_000_000_000.0), G=matrix("n q"))
def recover(plant: Plant, K: object, W: object, V: object, q: float, *, G: object | None = None) -> Recovered:
    """Recovery at the plant's input: the filter is told of noise G W Gᵀ + q² B Bᵀ, so L Kc P → K (sI − A)⁻¹ B.

    K (m×n) is a state feedback, usually of `lqr`; W, V intensities (a number is that number times I), G n×q_w, default
    B. q = 0 is plain LQG. Doyle and Stein (1979). Raises ShapeError, EngineError, RiccatiError.

    >>> recover(Plant([[-1]], [[1]], [[1]]), [[1]], [[1]], [[1]], 100.0).minimum_phase
    True
    """
    K = as_checked(K)
    _check(plant)
    G = plant.B if G is None else as_checked(G)
    noise = G @ as_covariance(W, "W", G.shape[1]) @ G.T + q**2 * plant.B @ plant.B.T
    L = lqe(plant.A, np.eye(plant.n), plant.C, symmetric(noise), as_checked(V)).gain
    aim = sensitivity(_whole(plant), -K)
    return _recovered(plant, K, L, q, aim, state_feedback_margins(plant, K), slice(0, plant.m))


@takes(plant=PLANT, L=matrix(), Q=covariance("n"), R=covariance("m"), q=number(0, 1_000_000_000_000.0))
def recover_at_output(plant: Plant, L: object, Q: object, R: object, q: float) -> Recovered:
    """Recovery at the plant's output, the dual: the regulator is told of Q + q² Cᵀ C, so P Kc → −C (sI − A)⁻¹ L.

    L (n×p) is a filter gain, usually of `lqe`; Q (n×n), R (m×m) weights. Raises ShapeError, EngineError, RiccatiError.

    >>> recover_at_output(Plant([[-1]], [[1]], [[1]]), [[1]], [[1]], [[1]], 100.0).gap < 0.05
    True
    """
    L = as_checked(L)
    _check(plant)
    weight = as_checked(Q) + q**2 * plant.C.T @ plant.C
    K = lqr(plant.A, plant.B, symmetric(weight), as_checked(R)).gain
    fed = Plant(plant.A, L, plant.C)
    target = loop_margins(fed, -np.eye(plant.p))
    aim = sensitivity(fed, -np.eye(plant.p))
    return _recovered(plant, K, L, q, aim, target, slice(plant.m, plant.m + plant.p))


def _check(plant: Plant) -> None:
    if plant.dt:
        raise EngineError("Recovery is for continuous plants; a sampled loop has the delay of a step that remains.")


def _whole(plant: Plant) -> Plant:
    return Plant(plant.A, plant.B, np.eye(plant.n))


def _recovered(plant: Plant, K: np.ndarray, L: np.ndarray, q: float, aim: Sensitivity, target: LoopMargins,
               place: slice) -> Recovered:
    built = compensator(plant, K, L)
    loop = sensitivity(plant, built)
    here = slice(0, plant.m) if place.start == 0 else slice(plant.p, 2 * plant.p)  # of the target: its own inputs first
    omega = loop.omega
    difference = loop.values[:, place, place] - aim.at(omega)[:, here, here]
    zeros = transmission_zeros(plant)
    return Recovered(float(q), K, L, built, loop_margins(plant, built), target,
                     float(np.linalg.svd(difference, compute_uv=False).max()),
                     None if zeros is None else bool(np.all(np.real(zeros) < 0)))
