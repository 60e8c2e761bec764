"""Define controllers as a computer runs them: steady, or with a gain that still changes."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..filters.belief import BELIEF, Belief
from ..filters.linear.linear_filter import LinearFilter
from ..systems.arrays import as_checked
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import SECONDS, choice, count, instance, matrix, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record
from ..systems.sampling import discretise, tustin

__all__ = ["SampledController", "recursive_controller", "sampled_controller"]

Method = Literal["tustin", "hold"]


@record()
class SampledController:
    """c⁺ = A c + B y + E s, u = C c + D y every dt seconds; s is what the clipped coils were told.

    Arrays are (k, …, …): entry i holds at sample i, the last one from then on. k = 1 for a steady controller. E is zero
    for a controller that assumes its commands are carried out.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    E: np.ndarray
    dt: float

    @property
    def n(self) -> int:
        """Number of states."""
        return self.A.shape[1]

    @property
    def settled(self) -> int:
        """The sample from which the controller is constant."""
        return len(self.A) - 1

    @property
    def last(self) -> Plant:
        """The constant controller that it becomes, from y to u, its commands taken for carried out."""
        A, B, C, D, E = (matrix[-1] for matrix in (self.A, self.B, self.C, self.D, self.E))
        return Plant(A + E @ C, B + E @ D, C, D, self.dt)


@takes(controller=PLANT, dt=SECONDS, method=choice("tustin", "hold"))
def sampled_controller(controller: Plant, dt: float, *, method: Method = "tustin") -> SampledController:
    """A controller (y to u, sign included) run every dt seconds; one that is sampled already is taken as it is.

    "tustin": s = 2(z − 1)/(dt(z + 1)), which answers in its own sample and keeps the response at low frequencies whatever
    its fast poles; "hold": its input held over a sample, which costs a strictly proper controller about half a sample
    more. Raises EngineError where the period is another.
    """
    if controller.dt:
        if abs(controller.dt - dt) > 1e-9 * dt:
            raise EngineError("The controller runs every {dt:g} s but the loop every {dt2:g} s; give both the "
                              "same period.",
                              dt=controller.dt, dt2=dt)
        return _steady(controller.A, controller.B, controller.C, np.asarray(controller.D), dt)
    done = (tustin if method == "tustin" else discretise)(controller, dt)
    return _steady(done.A, done.B, done.C, np.asarray(done.D), dt)


def _steady(A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray, dt: float) -> SampledController:
    return SampledController(A[None], B[None], C[None], D[None], np.zeros((1, len(A), len(C))), dt)


@takes(estimator=instance(LinearFilter), K=matrix(), start=BELIEF, steps=count(1, 100_000),
       told=choice("commanded", "applied"))
def recursive_controller(estimator: LinearFilter, K: object, start: Belief, steps: int,
                         *, told: Literal["commanded", "applied"] = "commanded") -> SampledController:
    """The recursive Kalman filter with feedback u = −K x̂[k|k]; its gain M[k] follows from the belief `start`.

    c = x̂[k|k−1]: u = −K(I − M C)c − K M y, c⁺ = A(I − M C)c + A M y + B u. With told = "applied" the filter predicts
    with the clipped command instead of u. Report on the platform, equations (53)–(58) with (74). `steps`: how many
    samples the gain is computed for at most; it is held after that. Raises ShapeError, EngineError.
    """
    K = as_checked(K)
    if K.shape != (estimator.B.shape[1], estimator.n):
        raise ShapeError("K must be {columns}×{n}; it is {rows}×{columns2}.",
                         columns=estimator.B.shape[1], n=estimator.n, rows=K.shape[0], columns2=K.shape[1])
    if not estimator.dt:
        raise EngineError("The filter must say its period: make it with from_plant, or give dt.")
    if np.any(estimator.D):
        raise EngineError("A filter of a plant with direct feedthrough (D ≠ 0) cannot be closed through u = −K x̂[k|k].")
    A, C, M = estimator.A, estimator.C, estimator.schedule(start, steps).gains
    corrected = np.eye(estimator.n) - M @ C
    Cc, Dc = -K @ corrected, -K @ M
    Ac, Bc, E = A @ corrected, A @ M, np.zeros((len(M), estimator.n, len(K)))
    if told == "applied":
        E = E + estimator.B
    else:
        Ac, Bc = Ac + estimator.B @ Cc, Bc + estimator.B @ Dc
    return SampledController(Ac, Bc, Cc, Dc, E, estimator.dt)
