"""Define what nonlinear filters share: one step, a lost sample, a record, many runs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TypeVar, overload

import numpy as np

from ...systems.arrays import as_covariance, as_numbers
from ...systems.errors import EngineError, ShapeError
from ...systems.gates.argument_checks import FUNCTION, RECORD, Sizes, array, covariance, gated_runs, passed
from ...systems.jacobian import Map, values_of
from ...systems.records import record
from ..belief import BELIEF, Belief, Beliefs, Correction, Corrections
from ..linear.kalman import gain_of
from ..track import Schedule, Track, as_record

__all__ = ["Expected", "NonlinearFilter"]

_INPUT = array()


def _beliefs(value: object, name: str, sizes: Sizes) -> Belief | Beliefs:
    return value if isinstance(value, Beliefs) else BELIEF(value, name, sizes)


B = TypeVar("B", Belief, Beliefs)


@record()
class Expected:
    """What a measurement is expected to be: mean (p,) or (p, N), covariance S with R in it, that of x with y, P after a gain."""

    mean: np.ndarray
    S: np.ndarray
    across: np.ndarray
    after: Callable[[np.ndarray], np.ndarray]


@record()
class NonlinearFilter(ABC):
    """A filter for x[k+1] = f(x[k], u[k]) + w[k], y[k] = h(x[k], u[k]) + v[k], white w, v of covariances Q, R.

    f and h take states as columns, x (n, N) with u (m, 1) or (m, N), and return (n, N) and (p, N): `A @ x + B @ u` and
    `np.stack([x[1], -np.sin(x[0])])` are right as they stand, and `each_column` wraps a function of one state; a `Flow` is
    such an f. Q is n×n, R p×p. Steps are pure. They take a `Belief` with u (m,), y (p,), or `Beliefs` of N runs with
    u (m, 1) or (m, N), y (p, N). A measurement that is NaN did not arrive. Raises ShapeError, EngineError.
    """

    f: Map
    h: Map
    Q: np.ndarray
    R: np.ndarray

    def __post_init__(self) -> None:
        passed(self, f=FUNCTION, h=FUNCTION, Q=covariance(), R=covariance())

    @property
    def n(self) -> int:
        """Number of states."""
        return len(self.Q)

    @property
    def p(self) -> int:
        """Number of measurements."""
        return len(self.R)

    # --- what an approximation says ----------------------------------------------------------------------------------
    @abstractmethod
    def ahead(self, belief: Belief | Beliefs, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Mean and covariance one step later, and points to carry on, None but for the printed algorithm."""

    @abstractmethod
    def expected(self, belief: Belief | Beliefs, u: np.ndarray) -> Expected:
        """The measurement expected."""

    def wanted(self, beliefs: Beliefs) -> np.ndarray | None:
        """Points (n, s, N) whose images under f are all that `predicted` needs; None where `predict` needs more."""
        return None

    def predicted(self, beliefs: Beliefs, images: np.ndarray) -> Beliefs:
        """The beliefs one step later from the images (n, s, N) of the points wanted."""
        raise EngineError("{name} needs more than the images of points; call predict.", name=type(self).__name__)

    # --- one step ------------------------------------------------------------------------------------------------------
    @gated_runs(belief=_beliefs, u=_INPUT)
    def predict(self, belief: B, u: object = ()) -> B:
        """The belief one step later, before its measurement."""
        self._check(belief)
        mean, P, points = self.ahead(belief, _column(belief, u))
        if isinstance(belief, Belief):
            return Belief.computed(_finite(mean, "f"), P)
        return Beliefs(mean, P, points)

    @overload
    def correct(self, belief: Belief, y: object, u: object = ()) -> Correction: ...
    @overload
    def correct(self, belief: Beliefs, y: object, u: object = ()) -> Corrections: ...
    def correct(self, belief: Belief | Beliefs, y: object, u: object = ()) -> Correction | Corrections:
        """The measurement y taken in: x̂ + M (y − ŷ), M = P_xy S⁻¹."""
        belief, seen, u = _beliefs(belief, "belief", {}), RECORD(y, "y", {}), _INPUT(u, "u", {})
        self._check(belief)
        seen = seen.reshape(-1) if isinstance(belief, Belief) else seen
        expected = self.expected(belief, _column(belief, u))
        self._check_measurement(belief, seen, expected.mean)
        nu, S = seen - expected.mean, expected.S
        M = gain_of(*_answered(S, expected.across, ~np.isnan(seen)))
        mean, P = belief.mean + _moved(M, np.where(np.isnan(seen), 0.0, nu)), expected.after(M)
        if isinstance(belief, Belief):
            return Correction(Belief.computed(mean, P), nu, S, M)
        return Corrections(Beliefs(mean, P), nu, S, M)

    def update(self, belief: Belief, y: object, u: object = ()) -> Belief:
        """The belief after the measurement y (p,); `correct` also says innovation, S and gain."""
        return self.correct(belief, y, u).belief

    # --- a record ------------------------------------------------------------------------------------------------------
    def run(self, start: object, y: object, u: object | None = None) -> Track:
        """A record y (n_t, p) with the inputs u (n_t, m) filtered; `start` is a Belief or (mean, covariance).

        It holds before the first measurement.
        """
        start = _checked(start)
        y = as_record(RECORD(y, "y", {}), "y", self.p)
        inputs = np.zeros((len(y), 0)) if u is None else as_numbers(u, "u")
        if u is not None:
            inputs = as_record(inputs, "u", inputs.shape[1] if inputs.ndim == 2 else 1, rows=len(y))
        prior, rows = start, []
        for k in range(len(y)):
            step = self.correct(prior, y[k], inputs[k])
            rows.append((prior.mean, step.belief.mean, step.innovation, prior.covariance, step.belief.covariance,
                         step.S, step.gain))
            if k + 1 < len(y):
                prior = self.predict(step.belief, inputs[k])
        predicted, means, innovations, *spreads = (np.array(part) for part in zip(*rows, strict=True))
        return Track(predicted, means, innovations, Schedule(len(y), *spreads))

    # --- checks --------------------------------------------------------------------------------------------------------
    def through(self, f: Map, points: np.ndarray, u: np.ndarray, name: str, rows: int) -> np.ndarray:
        """A map over points (n, s) or (n, s, N): (rows, s) or (rows, s, N)."""
        each = np.tile(u, (1, points.shape[1])) if u.shape[1] > 1 else u
        values = values_of(f, points.reshape(len(points), -1), each, name, rows)
        return values.reshape(rows, *points.shape[1:])

    def _check(self, belief: Belief | Beliefs) -> None:
        if len(belief.mean) != self.n:
            raise ShapeError("The belief is about {mean_size} states but Q is {n}×{n}; they must agree.",
                             mean_size=len(belief.mean), n=self.n)

    def _check_measurement(self, belief: Belief | Beliefs, y: np.ndarray, expected: np.ndarray) -> None:
        if isinstance(belief, Belief):
            if y.size != self.p:
                raise ShapeError("y must hold {p} numbers; it holds {y_size}.", p=self.p, y_size=y.size)
            _finite(expected, "h")
        elif y.shape != expected.shape:
            raise ShapeError("y must be {rows}×{columns}: a row for each output of h, a column for each run. It is {y_shape}, and R is "
                             "for {count} outputs.",
                             rows=expected.shape[0], columns=expected.shape[1], y_shape=y.shape, count=self.p)
        if np.isinf(y).any():
            raise EngineError("A measurement is infinite; give NaN where none arrived.")


def _checked(start: object) -> Belief:
    """What begins a record is a covariance; rounding and lesser algorithms may spoil it only later."""
    belief = BELIEF(start, "start", {})
    as_covariance(belief.covariance, "P", belief.mean.size)
    return belief


def _column(belief: Belief | Beliefs, u: object) -> np.ndarray:
    """An input as columns (m, 1) or (m, N)."""
    u = np.asarray(u, dtype=float)
    return u.reshape(-1, 1) if isinstance(belief, Belief) or u.ndim < 2 else u


def _finite(values: np.ndarray, name: str) -> np.ndarray:
    if not np.isfinite(values).all():
        raise EngineError("{name} gave NaN or infinity: the estimate has left the region where the model holds.",
                          name=name)
    return values


def _answered(S: np.ndarray, across: np.ndarray, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """S and P_xy of the sensors that answered, `seen` (p,) or (p, N): the others get no gain."""
    if seen.all():
        return S, across
    row = seen.T[..., None, :]
    return np.where(row & row.swapaxes(-1, -2), S, np.eye(S.shape[-1])), np.where(row, across, 0.0)


def _moved(M: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """M ν (n,), or of each run as columns (n, N) with M (N or 1, n, p), ν (p, N)."""
    if M.ndim == 2 or len(M) == 1:
        return M.reshape(M.shape[-2:]) @ nu
    return (M @ nu.T[:, :, None])[:, :, 0].T
