"""Design a reduced-order observer: it estimates only what the outputs do not measure."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import null_space

from ..design.placement import observer_gain
from ..systems.arrays import frozen
from ..systems.balance import balance
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import POLES, gated, matrix, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record

__all__ = ["ReducedObserver", "reduced_observer"]


@record()
class ReducedObserver:
    """ẇ = F w + G (y − D u) + H u and x̂ = M w + N (y − D u), of order n − p; w⁺ = … for a sampled plant.

    F (n−p×n−p), G (n−p×p), H (n−p×m), M (n×n−p), N (n×p). e = x − x̂ = M ε − N v with ε̇ = F ε − G v: the noise v of the outputs
    reaches x̂ at once, through N. `S` (n−p×n): w estimates S x.
    """

    F: np.ndarray
    G: np.ndarray
    H: np.ndarray
    M: np.ndarray
    N: np.ndarray
    S: np.ndarray
    plant: Plant

    @property
    def model(self) -> Plant:
        """What a `Scenario` of the plant takes as `model`, with L = G, to run this observer: its estimate is w."""
        p = self.plant
        return Plant(self.F, self.H, np.zeros((p.p, len(self.F))), p.D, p.dt, input_names=p.input_names, output_names=p.output_names)

    @gated(w=matrix("t r"), y=matrix("t p"), u=matrix("t m"))
    def estimates(self, w: Any, y: Any, u: Any) -> np.ndarray:
        """x̂ (n_t, n) along w (n_t, n−p), readings y (n_t, p) and inputs u (n_t, m)."""
        for name, given, n in (("w", w, len(self.F)), ("y", y, self.plant.p), ("u", u, self.plant.m)):
            if given.shape[1] != n:
                raise ShapeError("{name} must have {n} columns, one for each signal; it has {columns}.", name=name, n=n,
                                 columns=given.shape[1])
        return w @ self.M.T + (y - u @ np.asarray(self.plant.D).T) @ self.N.T


@takes(plant=PLANT, poles=POLES)
def reduced_observer(plant: Plant, poles: Any) -> ReducedObserver:
    """The observer of order n − p whose error has these n − p poles, for a plant whose p outputs are independent.

    In balanced states and outputs, with the rows of V orthonormal and V Cᵀ = 0, x = C⁺ (y − D u) + Vᵀ z. The outputs' derivative
    shows C A Vᵀ z, so L_r places the poles of F = (V A − L_r C A) Vᵀ; w = ẑ − L_r (y − D u) avoids the derivative. Source: Luenberger,
    An Introduction to Observers (IEEE Trans. Automatic Control 16, 1971), section IV. Raises EngineError where the outputs are
    dependent or measure every state, PoleError as `observer_gain` does.

    >>> np.linalg.eigvals(reduced_observer(Plant([[0, 1], [0, 0]], [[0], [1]], [[1, 0]]), [-3]).F)
    array([-3.])
    """
    own = balance(plant.A, plant.B, plant.C)
    x, y = own.states, own.outputs
    A, B, C = own.A(plant.A), plant.B / x[:, None], own.C(plant.C)
    V = null_space(C).T if C.size else np.eye(plant.n)
    if len(V) != plant.n - plant.p:
        raise EngineError("The outputs depend on each other; leave out those that the others give.")
    if not len(V):
        raise EngineError("The outputs measure every state, so nothing is left to estimate.")
    seen = np.linalg.pinv(C)
    L = observer_gain(V @ A @ V.T, C @ A @ V.T, poles).gain
    step = V @ A - L @ C @ A
    F = step @ V.T
    return ReducedObserver(frozen(F), frozen((F @ L + step @ seen) / y), frozen(V @ B - L @ C @ B), frozen(x[:, None] * V.T),
                           frozen(x[:, None] * (seen + V.T @ L) / y), frozen((V - L @ C) / x), plant)
