"""Define what nonlinear filters share: one step, a lost sample, a record, many runs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import field, replace
from functools import cached_property
from typing import NamedTuple, Self, TypeVar, overload

import numpy as np

from ...systems.arrays import all_finite, as_covariance, as_numbers
from ...systems.errors import EngineError, ShapeError
from ...systems.flow import Flow, FlowInTime
from ...systems.gates.argument_checks import FINITE, FUNCTION, HORIZON, RECORD, Sizes, array, covariance, gated_runs, optional, passed
from ...systems.gates.map_roles import InTime, NeedsTime, adapted
from ...systems.jacobian import Map, values_of
from ...systems.records import record
from ..belief import BELIEF, Belief, Beliefs, Correction, Corrections
from ..linear.kalman import gain_of
from ..moments import moments_of
from ..track import Track, as_record
from .differences import Combine, minus, plus
from .record_runs import filtered, noises_of

__all__ = ["Expected", "NonlinearFilter"]

_INPUT = array()


def _beliefs(value: object, name: str, sizes: Sizes) -> Belief | Beliefs:
    return value if isinstance(value, Beliefs) else BELIEF(value, name, sizes)


B = TypeVar("B", Belief, Beliefs)


class Expected(NamedTuple):
    """What a measurement is expected to be: mean (p,) or (p, N), covariance S with R in it, that of x with y, P after a gain, and the
    slope H where there is one."""

    mean: np.ndarray
    S: np.ndarray
    across: np.ndarray
    after: Callable[[np.ndarray], np.ndarray]
    H: np.ndarray | None = None


@record()
class NonlinearFilter(ABC):
    """A filter for x[k+1] = f(x[k], u[k]) + w[k], y[k] = h(x[k], u[k]) + v[k], white w, v of covariances Q, R.

    f and h take states as columns, x (n, N) with u (m, 1) or (m, N), and return (n, N) and (p, N): `A @ x + B @ u` and
    `np.stack([x[1], -np.sin(x[0])])` are right as they stand, and `each_column` wraps a function of one state; a `Flow` is
    such an f. A map takes x, or x and u, or t and dt too: `f(x)`, `f(x, u)`, `f(x, u, t)`, `f(x, u, dt)`, by the names of its
    parameters. Q is n×n, R p×p; a number is that number times I. `y_minus(y, ŷ)`, `x_minus(x, x̂)` and `x_plus(x̂, step)` stand for
    − and + where those will not do; `angles` makes such differences. Steps are pure. They take a `Belief` with u (m,), y (p,), or
    `Beliefs` of N runs with u (m, 1) or (m, N), y (p, N). A measurement that is NaN did not arrive. Raises ShapeError, EngineError.
    """

    f: Map
    h: Map
    Q: np.ndarray
    R: np.ndarray
    y_minus: Combine | None = field(default=None, kw_only=True)
    x_minus: Combine | None = field(default=None, kw_only=True)
    x_plus: Combine | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        numbers = tuple(name for name in "QR" if _is_number(getattr(self, name)))
        passed(self, f=FUNCTION, h=FUNCTION, Q=covariance(), R=covariance(), y_minus=optional(FUNCTION), x_minus=optional(FUNCTION),
               x_plus=optional(FUNCTION))
        for name in "fh":
            object.__setattr__(self, name, adapted(getattr(self, name)))
        object.__setattr__(self, "_numbers", numbers)

    def fitting(self, n: int, p: int | None) -> Self:
        """The filter for n states and p measurements: itself unless Q or R is a number."""
        sizes = {name: size for name, size in (("Q", n), ("R", p)) if name in self._numbers and size is not None}  # type: ignore[attr-defined]
        if all(len(getattr(self, name)) == size for name, size in sizes.items()):
            return self
        key = n, p
        if key not in self._fitted:
            self._fitted[key] = replace(self, **{name: getattr(self, name)[0, 0] * np.eye(size) for name, size in sizes.items()})
        return self._fitted[key]

    @cached_property
    def _fitted(self) -> dict[tuple[int, int | None], Self]:
        return {}

    @cached_property
    def in_time(self) -> Self:
        """The filter whose maps read t and dt from two more rows of u."""
        return replace(self, **self.maps_in_time())

    def maps_in_time(self) -> dict[str, object]:
        """f and h that read t and dt from two more rows of u."""
        f = FlowInTime(self.f) if isinstance(self.f, Flow) else self._in_time(self.f)
        return {"f": f, "h": self._in_time(self.h)}

    @staticmethod
    def _in_time(f: object) -> InTime:
        return InTime(f.f, f.roles) if isinstance(f, NeedsTime) else InTime(f)  # type: ignore[arg-type]

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
    def lead(self, belief: Belief, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Mean one step later, covariance without Q, and that of x[k] with x[k+1]."""

    @abstractmethod
    def expected(self, belief: Belief | Beliefs, u: np.ndarray, *, R: np.ndarray | None = None) -> Expected:
        """The measurement expected; R is the filter's own if left out."""

    def taken_in(self, belief: Belief | Beliefs, y: np.ndarray, u: np.ndarray, *,
                 R: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
        """ν, S, M, mean and covariance after the measurement y."""
        expected = self.expected(belief, u, R=R)
        if isinstance(belief, Beliefs):
            self._check_measurement(belief, y)
        nu = minus(self.y_minus, y, expected.mean)
        missing = None if nu.ndim == 1 and all_finite(nu) else np.isnan(y)
        if missing is not None and missing.any():
            M = gain_of(*answered(expected.S, expected.across, ~missing))
            moved = moved_by(M, np.where(missing, 0.0, nu))
        else:
            M = gain_of(expected.S, expected.across)
            moved = moved_by(M, nu)
        mean = plus(self.x_plus, belief.mean, moved)
        return nu, expected.S, M, mean, expected.after(M)

    def wanted(self, beliefs: Beliefs) -> np.ndarray | None:
        """Points (n, s, N) whose images under f are all that `predicted` needs; None where `predict` needs more."""
        return None

    def predicted(self, beliefs: Beliefs, images: np.ndarray) -> Beliefs:
        """The beliefs one step later from the images (n, s, N) of the points wanted."""
        raise EngineError("{name} needs more than the images of points; call predict.", name=type(self).__name__)

    # --- one step ------------------------------------------------------------------------------------------------------
    @gated_runs(belief=_beliefs, u=_INPUT, t=optional(FINITE), dt=optional(HORIZON))
    def predict(self, belief: B, u: object = (), *, t: float | None = None, dt: float | None = None) -> B:
        """The belief one step later, before its measurement; t and dt in s for an f that takes them, or a `Flow` over another step."""
        self = self.fitting(len(belief.mean), None)
        self._check(belief)
        column = _column(belief, u)
        if t is not None or dt is not None:
            column, self = self._clocked(column, t, dt), self.in_time
        mean, P, points = self.ahead(belief, column)
        if isinstance(belief, Belief):
            return Belief.computed(_finite(mean, "f"), P)
        return Beliefs(mean, P, points)

    @overload
    def correct(self, belief: Belief, y: object, u: object = (), *, t: float | None = None) -> Correction: ...
    @overload
    def correct(self, belief: Beliefs, y: object, u: object = (), *, t: float | None = None) -> Corrections: ...
    def correct(self, belief: Belief | Beliefs, y: object, u: object = (), *, t: float | None = None) -> Correction | Corrections:
        """The measurement y taken in: x̂ + M (y − ŷ), M = P_xy S⁻¹; t in s for an h that takes it."""
        belief, seen, u = _beliefs(belief, "belief", {}), RECORD(y, "y", {}), _INPUT(u, "u", {})
        seen = seen.reshape(-1) if isinstance(belief, Belief) else seen
        self = self.fitting(len(belief.mean), len(seen))
        self._check(belief)
        column = _column(belief, u)
        if t is not None:
            column, self = self._clocked(column, FINITE(t, "t", {}), None), self.in_time
        if isinstance(belief, Belief):
            self._check_measurement(belief, seen)
        nu, S, M, mean, P = self.taken_in(belief, seen, column)
        if isinstance(belief, Belief):
            _finite(nu[~np.isnan(seen)], "h")
        if isinstance(belief, Belief):
            return Correction(Belief.computed(mean, P), nu, S, M)
        return Corrections(Beliefs(mean, P), nu, S, M)

    def update(self, belief: Belief, y: object, u: object = ()) -> Belief:
        """The belief after the measurement y (p,); `correct` also says innovation, S and gain."""
        return self.correct(belief, y, u).belief

    def _clocked(self, u: np.ndarray, t: float | None, dt: float | None) -> np.ndarray:
        """u with t and dt below it; a `Flow` makes its own step where dt is left out."""
        step = self.f.step if dt is None and isinstance(self.f, Flow) else np.nan if dt is None else dt
        return np.vstack([u, np.full((1, u.shape[1]), np.nan if t is None else t), np.full((1, u.shape[1]), step)])

    # --- a record ------------------------------------------------------------------------------------------------------
    @gated_runs(t=optional(array()), Q=optional(array()), R=optional(array()), gate=optional(array()))
    def run(self, start: object, y: object, u: object | None = None, *, t: object | None = None, Q: object | None = None,
            R: object | None = None, gate: object | None = None) -> Track:
        """A record y (n_t, p) with the inputs u (n_t, m) filtered; `start` is a Belief or (mean, covariance).

        It holds before the first measurement. t (n_t,) are the times of the samples in s, in steps of any length where f is a `Flow`
        (Q is then in proportion to the step) or takes dt; without t an f that takes t is given the number of the sample. Q and R are
        n×n and p×p, or one such matrix a sample. A `gate`, as 0.999 or one a sample, is the share of good readings that it lets
        through: readings that surprise more are not used. Raises ShapeError, EngineError.
        """
        start, y = _checked(start), RECORD(y, "y", {})
        self = self.fitting(len(start.mean), y.shape[1] if y.ndim == 2 else 1)
        y = as_record(y, "y", self.p)
        self._check(start)
        if np.isinf(y).any():
            raise EngineError("A measurement is infinite; give NaN where none arrived.")
        inputs = np.zeros((len(y), 0)) if u is None else as_numbers(u, "u")
        if u is not None:
            inputs = as_record(inputs, "u", inputs.shape[1] if inputs.ndim == 2 else 1, rows=len(y))
        moments = moments_of(len(y), self.R, t, R, gate)
        return filtered(self, start, y, inputs, moments, noises_of(self, Q, moments, len(y)))

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

    def _check_measurement(self, belief: Belief | Beliefs, y: np.ndarray) -> None:
        if isinstance(belief, Belief):
            if y.size != self.p:
                raise ShapeError("y must hold {p} numbers; it holds {y_size}.", p=self.p, y_size=y.size)
        elif y.shape != (self.p, belief.mean.shape[1]):
            raise ShapeError("y must be {rows}×{columns}: a row for each output of h, a column for each run. It is {y_shape}, and R is "
                             "for {count} outputs.",
                             rows=self.p, columns=belief.mean.shape[1], y_shape=y.shape, count=self.p)
        if np.isinf(y).any():
            raise EngineError("A measurement is infinite; give NaN where none arrived.")


def _is_number(value: object) -> bool:
    """Whether a noise is said by one number, for as many states or sensors as there are."""
    return isinstance(value, int | float | np.number) or (isinstance(value, np.ndarray) and not value.ndim)


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


def answered(S: np.ndarray, across: np.ndarray, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """S and P_xy of the sensors that answered, `seen` (p,) or (p, N): the others get no gain."""
    if seen.all():
        return S, across
    row = seen.T[..., None, :]
    return np.where(row & row.swapaxes(-1, -2), S, np.eye(S.shape[-1])), np.where(row, across, 0.0)


def moved_by(M: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """M ν (n,), or of each run as columns (n, N) with M (N or 1, n, p), ν (p, N)."""
    if M.ndim == 2:
        return M.dot(nu)
    if len(M) == 1:
        return M.reshape(M.shape[-2:]) @ nu
    return (M @ nu.T[:, :, None])[:, :, 0].T
