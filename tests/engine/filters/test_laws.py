"""One table: every filter keeps every law of the Kalman filter on a linear plant, lost samples and a direct path included."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from observer_lab.engine import (
    Belief,
    EngineError,
    ExtendedKalmanFilter,
    KalmanFilter,
    ShapeError,
    SquareRootFilter,
    UnscentedKalmanFilter,
)
from observer_lab.engine.filters import Beliefs, LinearFilter, LinearisedFilter, NonlinearFilter, joseph, short_form


@dataclass(frozen=True, eq=False)
class Problem:
    """x⁺ = A x + B u + w, y = C x + D u + v with full covariances, a start, and a record with lost samples."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    D: np.ndarray
    start: Belief
    y: np.ndarray
    u: np.ndarray


def problem(seed: int, n: int = 3, p: int = 2, m: int = 2, steps: int = 12) -> Problem:
    rng = np.random.default_rng(seed)

    def covariance(k: int) -> np.ndarray:
        half = rng.standard_normal((k, k))
        return half @ half.T + 0.1 * np.eye(k)

    A = rng.standard_normal((n, n))
    A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
    y = rng.standard_normal((steps, p))
    y[3], y[5, 0], y[8, -1] = np.nan, np.nan, np.nan  # lost packets, whole and in part
    return Problem(A, rng.standard_normal((n, m)), rng.standard_normal((p, n)), covariance(n), covariance(p),
                   rng.standard_normal((p, m)), Belief(rng.standard_normal(n), covariance(n) + np.eye(n)), y,
                   rng.standard_normal((steps, m)))


Filter = LinearFilter | NonlinearFilter
Make = Callable[[Problem], Filter]


def linear(kind: type[LinearFilter]) -> Make:
    return lambda q: kind(q.A, q.B, q.C, q.Q, q.R, q.D)


def mapped(kind: Callable[..., NonlinearFilter], **options: float) -> Make:
    return lambda q: kind(lambda x, u: q.A @ x + q.B @ u, lambda x, u: q.C @ x + q.D @ u, q.Q, q.R, **options)


def linearised(q: Problem) -> Filter:
    return mapped(lambda *maps: LinearisedFilter(*maps, np.ones(len(q.A)), np.ones(q.B.shape[1])))(q)


FILTERS = {
    "Kalman": linear(KalmanFilter),
    "square root": linear(SquareRootFilter),
    "linearised once": linearised,
    "extended": mapped(ExtendedKalmanFilter),
    "unscented": mapped(UnscentedKalmanFilter),
    "unscented, alpha 0.1": mapped(UnscentedKalmanFilter, alpha=0.1),
    "unscented, alpha 0.3": mapped(UnscentedKalmanFilter, alpha=0.3),
    "unscented, n + kappa = 2": lambda q: mapped(UnscentedKalmanFilter, alpha=0.5, beta=0.0, kappa=2.0 - len(q.A))(q),
}


def batch_estimate(q: Problem) -> tuple[np.ndarray, np.ndarray]:
    """x[N] given y[0..N] by one weighted least-squares problem in all states at once: mean and covariance."""
    n, steps = len(q.A), len(q.y)
    rows, values = [], []

    def row(blocks: list[tuple[int, np.ndarray]], value: np.ndarray, covariance: np.ndarray) -> None:
        W = np.linalg.inv(np.linalg.cholesky(covariance))
        wide = np.zeros((len(value), n * steps))
        for k, block in blocks:
            wide[:, k * n:(k + 1) * n] = block
        rows.append(W @ wide)
        values.append(W @ value)

    row([(0, np.eye(n))], q.start.mean, q.start.covariance)
    for k in range(steps):
        seen = np.isfinite(q.y[k])
        if seen.any():
            row([(k, q.C[seen])], (q.y[k] - q.D @ q.u[k])[seen], q.R[np.ix_(seen, seen)])
        if k + 1 < steps:
            row([(k + 1, np.eye(n)), (k, -q.A)], q.B @ q.u[k], q.Q)
    H, z = np.vstack(rows), np.concatenate(values)
    covariance = np.linalg.inv(H.T @ H)
    return (covariance @ H.T @ z)[-n:], covariance[-n:, -n:]


def near(found: np.ndarray, wanted: np.ndarray, rtol: float = 1e-9, atol: float = 1e-10, what: str = "") -> None:
    np.testing.assert_allclose(found, wanted, rtol=rtol, atol=atol, err_msg=what)


# --- the laws --------------------------------------------------------------------------------------------------------
def it_is_batch_least_squares(make: Make, q: Problem) -> None:
    track, (mean, covariance) = make(q).run(q.start, q.y, q.u), batch_estimate(q)
    near(track.means[-1], mean)
    near(track.covariances[-1], covariance, rtol=1e-8)


def on_a_linear_plant_it_is_the_kalman_filter(make: Make, q: Problem) -> None:
    ours, theirs = (of(q).run(q.start, q.y, q.u) for of in (make, FILTERS["Kalman"]))
    for name in ("predicted", "means", "innovations", "covariances", "prior_covariances", "S", "gains"):
        near(getattr(ours, name), getattr(theirs, name), what=name)


def steps_by_hand_are_the_run(make: Make, q: Problem) -> None:
    filter_, belief = make(q), q.start
    track = filter_.run(belief, q.y, q.u)
    for k in range(len(q.y)):
        step = filter_.correct(belief, q.y[k], q.u[k])
        for name, one in {"predicted": belief.mean, "prior_covariances": belief.covariance, "innovations": step.innovation,
                          "gains": step.gain, "S": step.S, "means": filter_.update(belief, q.y[k], q.u[k]).mean}.items():
            near(getattr(track, name)[k], one, rtol=1e-7, atol=1e-12, what=name)
        belief = filter_.predict(step.belief, q.u[k])
    near(track.last.mean, step.belief.mean, rtol=1e-7, atol=1e-12)
    near(track.variances[-1], np.diag(step.belief.covariance), rtol=1e-7, atol=1e-12)


def its_update_is_the_information_form(make: Make, q: Problem) -> None:
    """P⁺⁻¹ = P⁻¹ + CᵀR⁻¹C and P⁺⁻¹x̂⁺ = P⁻¹x̂ + CᵀR⁻¹(y − D u)."""
    P, y, u = q.start.covariance, q.y[0], q.u[0]
    information = np.linalg.inv(P) + q.C.T @ np.linalg.solve(q.R, q.C)
    right = np.linalg.solve(P, q.start.mean) + q.C.T @ np.linalg.solve(q.R, y - q.D @ u)
    after = make(q).update(q.start, y, u)
    near(after.covariance, np.linalg.inv(information), rtol=1e-7, atol=1e-9)
    near(after.mean, np.linalg.solve(information, right), rtol=1e-7, atol=1e-8)


def josephs_form_is_the_short_form(make: Make, q: Problem) -> None:
    """At its own gain, and nowhere below it."""
    step, P = make(q).correct(q.start, q.y[0], q.u[0]), q.start.covariance
    near(step.belief.covariance, joseph(P, q.C, q.R, step.gain), rtol=1e-8)
    near(step.belief.covariance, short_form(P, q.C, step.gain), rtol=1e-8)
    assert np.trace(joseph(P, q.C, q.R, 1.01 * step.gain)) > np.trace(step.belief.covariance)


def nan_is_a_lost_sample(make: Make, q: Problem) -> None:
    """Nothing heard: nothing learnt. One sensor silent: the filter of the others."""
    silent = make(q).update(q.start, np.full(len(q.C), np.nan), q.u[0])
    near(silent.mean, q.start.mean, rtol=1e-13)
    near(silent.covariance, q.start.covariance, rtol=1e-12, atol=1e-13)
    y = q.y[0].copy()
    y[0] = np.nan
    rest = replace(q, C=q.C[1:], D=q.D[1:], R=q.R[1:, 1:])
    part = make(q).update(q.start, y, q.u[0])
    other = make(rest).update(q.start, y[1:], q.u[0]) if len(rest.C) else q.start
    near(part.mean, other.mean)
    near(part.covariance, other.covariance)


def units_change_nothing(make: Make, q: Problem) -> None:
    """States, inputs and sensors in units of their own, up to a thousand times larger or smaller."""
    rng = np.random.default_rng(len(q.y))
    X, U, Y = (10 ** rng.uniform(-3, 3, k) for k in (len(q.A), q.B.shape[1], len(q.C)))
    other = Problem(q.A * X[:, None] / X, q.B * X[:, None] / U, q.C * Y[:, None] / X, q.Q * np.outer(X, X),
                    q.R * np.outer(Y, Y), q.D * Y[:, None] / U,
                    Belief(q.start.mean * X, q.start.covariance * np.outer(X, X)), q.y * Y, q.u * U)
    one, two = make(q).run(q.start, q.y, q.u), make(other).run(other.start, other.y, other.u)
    near(two.means / X, one.means, rtol=1e-7, atol=1e-8)
    near(two.covariances / np.outer(X, X), one.covariances, rtol=1e-7, atol=1e-8)
    near(two.innovations / Y, one.innovations, rtol=1e-7, atol=1e-8)


def a_batch_of_one_is_the_single_run(make: Make, q: Problem) -> None:
    """Many runs at once go through `Beliefs`, or, in a linear filter, share one schedule of gains."""
    filter_ = make(q)
    track = filter_.run(q.start, q.y, q.u)
    if isinstance(filter_, LinearFilter):
        shared = filter_.schedule(q.start, len(q.y), seen=np.isfinite(q.y))
        np.testing.assert_array_equal(filter_.run(q.start, q.y, q.u, schedule=shared).means, track.means)
        return
    beliefs = Beliefs.alike(q.start.mean, q.start.covariance, 1)
    for k in range(len(q.y)):
        step = filter_.correct(beliefs, q.y[k][:, None], q.u[k][:, None])
        near(step.beliefs.mean[:, 0], track.means[k])
        near(step.beliefs.covariance[0], track.covariances[k])
        near(step.innovation[:, 0], track.innovations[k])
        beliefs = filter_.predict(step.beliefs, q.u[k][:, None])


def what_is_no_measurement_is_refused(make: Make, q: Problem) -> None:
    """An infinite reading does not pass for a lost one, and shapes that do not fit are told."""
    filter_ = make(q)
    with pytest.raises(EngineError, match="infinit"):
        filter_.update(q.start, np.full(len(q.C), -np.inf), q.u[0])
    with pytest.raises(EngineError, match="infinit"):
        filter_.run(q.start, np.full(q.y.shape, np.inf), q.u)
    with pytest.raises(ShapeError, match="y must hold"):
        filter_.update(q.start, np.zeros(len(q.C) + 1), q.u[0])
    with pytest.raises(ShapeError, match="y must be"):
        filter_.run(q.start, np.zeros((5, len(q.C) + 1)))
    with pytest.raises(ShapeError, match="u must be"):
        filter_.run(q.start, q.y, q.u[1:])
    with pytest.raises(ShapeError, match="The belief is about"):
        filter_.predict(Belief(np.zeros(len(q.A) + 1), np.eye(len(q.A) + 1)), q.u[0])


LAWS = (it_is_batch_least_squares, on_a_linear_plant_it_is_the_kalman_filter, steps_by_hand_are_the_run,
        its_update_is_the_information_form, josephs_form_is_the_short_form, nan_is_a_lost_sample, units_change_nothing,
        a_batch_of_one_is_the_single_run, what_is_no_measurement_is_refused)
SIZES = ((3, 2), (4, 2), (1, 1), (5, 3), (2, 3), (3, 1))  # states and sensors


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
@pytest.mark.parametrize("name", FILTERS)
def test_every_filter_keeps_every_law(name: str, law: Callable[[Make, Problem], None]) -> None:
    for seed, (n, p) in enumerate(SIZES):
        law(FILTERS[name], problem(seed, n, p))
