"""Filter a whole record: covariances first, which no measurement changes, then the means."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..kernels import as_kernel_array, compiled_kernel
from ..kernels.recursion import mean_steps
from ..plotting import plot_estimates
from ..systems.arrays import as_numbers
from ..systems.errors import ShapeError
from ..systems.gates.argument_checks import MOST_NUMBERS, NAME, RECORD, array, count, instance, matrix, optional, takes, vector
from ..systems.records import record
from ..systems.recursions import affine_scan
from .belief import Belief

if TYPE_CHECKING:
    from ..plotting import Axes

__all__ = ["Schedule", "Track", "as_record", "means_along"]


@record()
class Schedule:
    """Covariances and gains of `steps` time steps; the s stored entries cover them all, the last one repeating.

    prior P[k|k−1], posterior P[k|k]: (s, n, n); S: (s, p, p) covariance of the innovation; gains: (s, n, p) filter
    gain M. s < steps once the filter has settled.
    """

    steps: int
    prior: np.ndarray
    posterior: np.ndarray
    S: np.ndarray
    gains: np.ndarray

    @property
    def settled(self) -> int | None:
        """The step from which the gain is constant, or None."""
        return len(self.gains) - 1 if len(self.gains) < self.steps else None

    @property
    def index(self) -> np.ndarray:
        """Which stored entry belongs to each step (steps,)."""
        return np.minimum(np.arange(self.steps), len(self.gains) - 1)


@record()
class Track:
    """A record filtered: row k holds what is known at sample k.

    predicted x̂[k|k−1] (n_t, n), means x̂[k|k] (n_t, n), innovations ν = y − ŷ (n_t, p; NaN where no measurement
    came). The covariances are in `schedule` and unfolded on demand. across: cov(x[k], x[k+1]) given the samples to k, (n_t − 1, n, n),
    where the model alone does not say it. rejected (n_t,): which samples a gate refused.
    """

    predicted: np.ndarray
    means: np.ndarray
    innovations: np.ndarray
    schedule: Schedule
    across: np.ndarray | None = None
    rejected: np.ndarray | None = None

    @property
    def settled(self) -> int | None:
        """The sample from which the gain is constant, or None."""
        return self.schedule.settled

    @property
    def covariances(self) -> np.ndarray:
        """P[k|k], (n_t, n, n)."""
        return self.schedule.posterior[self.schedule.index]

    @property
    def prior_covariances(self) -> np.ndarray:
        """P[k|k−1], (n_t, n, n).

        >>> from observer_lab.engine import Belief, KalmanFilter
        >>> KalmanFilter([[1]], [[0]], [[1]], 1.0, 1.0).run(Belief([0], [[1]]), [1.0, 1.0]).prior_covariances.ravel()
        array([1. , 1.5])
        """
        return self.schedule.prior[self.schedule.index]

    @property
    def variances(self) -> np.ndarray:
        """The diagonals of P[k|k], (n_t, n)."""
        return np.diagonal(self.schedule.posterior, axis1=1, axis2=2)[self.schedule.index]

    @property
    def S(self) -> np.ndarray:
        """Covariance of each innovation, (n_t, p, p)."""
        return self.schedule.S[self.schedule.index]

    @property
    def gains(self) -> np.ndarray:
        """Filter gain M of each sample, (n_t, n, p)."""
        return self.schedule.gains[self.schedule.index]

    def plot(self, *, dt: float = 0.0) -> list[Axes]:
        """The means with two standard deviations to either side, a panel each state, over samples, or seconds if dt is given."""
        return plot_estimates(self.means, self.variances, dt=dt)

    @property
    def last(self) -> Belief:
        """The belief after the last sample."""
        return Belief.computed(self.means[-1], self.schedule.posterior[-1])


@takes(value=optional(RECORD), name=NAME, columns=count(), rows=optional(count(0, MOST_NUMBERS)))
def as_record(value: object, name: str, columns: int, *, rows: int | None = None) -> np.ndarray:
    """A time-first array (n_t, columns); a vector is one column, None is zeros of `rows` rows. NaN stays.

    Raises ShapeError where the shape is another, EngineError where an entry is infinite.
    """
    if value is None:
        return np.zeros((rows or 0, columns))
    array = np.array(as_numbers(value, name, missing=True), dtype=float)
    if array.ndim == 1 and columns == 1:
        array = array[:, None]
    if array.ndim != 2 or array.shape[1] != columns or len(array) == 0 or len(array) != (rows or len(array)):
        raise ShapeError("{name} must be {value}×{columns}, one row a sample; its shape is {array_shape}.",
                         name=name, value=rows or "n_t", columns=columns, array_shape=array.shape)
    return array


@takes(A=matrix("n n"), C=matrix("p n"), schedule=instance(Schedule), start=vector("n"), known=array("k p", missing=True),
       push=optional(array("k n")))
def means_along(A: np.ndarray, C: np.ndarray, schedule: Schedule, start: np.ndarray, known: np.ndarray,
                push: np.ndarray | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Predicted means, means and innovations for measurements `known` = y − D u (n_t, p) and `push` = B u (n_t, n) or None.

    x̂[k+1|k] = A (I − M C) x̂[k|k−1] + A M (y − D u) + B u: one step after another while M changes, in parallel blocks
    once it is constant.
    """
    steps, n = len(known), len(start)
    tail = steps if schedule.settled is None else schedule.settled  # a record with gaps never settles
    predicted, means, innovations, x = np.empty((steps, n)), np.empty((steps, n)), np.empty(known.shape), np.array(start)
    head = predicted[:tail], means[:tail], innovations[:tail]
    if tail and (quick := compiled_kernel(mean_steps)) is not None:
        forced = np.zeros((0, n)) if push is None else as_kernel_array(push[:tail])
        quick(
            as_kernel_array(A), as_kernel_array(C), as_kernel_array(schedule.gains[:tail]), x, as_kernel_array(known[:tail]), forced, *head
        )
    else:
        x = _means_while_changing(A, C, schedule.gains[:tail], x, known[:tail], push, *head)
    if tail < steps:
        M = schedule.gains[-1]
        AM = A @ M
        forcing = known[tail:] @ AM.T
        if push is not None:
            forcing += push[tail:]
        predicted[tail:] = affine_scan(A - AM @ C, forcing, x, steps - tail)[:-1]
        np.subtract(known[tail:], predicted[tail:] @ C.T, out=innovations[tail:])
        np.add(predicted[tail:], innovations[tail:] @ M.T, out=means[tail:])
    return predicted, means, innovations


def _means_while_changing(A: np.ndarray, C: np.ndarray, gains: np.ndarray, x: np.ndarray, known: np.ndarray, push: np.ndarray | None,
                          predicted: np.ndarray, means: np.ndarray, innovations: np.ndarray) -> np.ndarray:
    """As `kernels.recursion.mean_steps`; the next x̂."""
    AM = A @ gains
    Phi = A - AM @ C
    forcing = (AM @ np.nan_to_num(known)[:, :, None])[..., 0]
    if push is not None:
        forcing += push[:len(forcing)]
    for k, step in enumerate(Phi):
        predicted[k] = x
        x = step @ x
        x += forcing[k]
    np.subtract(known, predicted @ C.T, out=innovations)
    np.add(predicted, (gains @ np.nan_to_num(innovations)[:, :, None])[..., 0], out=means)
    return x
