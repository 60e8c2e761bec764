"""Lesson 9: ellipsoids above the deck, prediction beside current estimate, and Q and R from a data sheet."""

from __future__ import annotations

import control
import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are, solve_discrete_lyapunov
from scipy.spatial.transform import Rotation

from observer_lab.lessons.kalman.body import SETTLED
from observer_lab.lessons.kalman.data_sheet import sheet_of
from observer_lab.lessons.kalman.filters import tuned, watcher
from observer_lab.lessons.kalman.knobs import MODEL
from observer_lab.lessons.kalman.lesson import LESSON


def outcome(**changes):
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


# --- the ellipsoids above the deck -----------------------------------------------------------------------------------
def drawn_ellipsoids(o) -> dict[str, np.ndarray]:
    """Of each ellipsoid the matrix whose 1σ it is, in the units of the stage: R diag(half²) Rᵀ from what the stage is told."""
    poses = o.stage.body.pose(o.stage.x[0].tolist(), o.stage.body.gain)
    turned = {name: (Rotation.from_quat(np.roll(poses[name].wxyz, -1)).as_matrix(), np.square(poses[name].scale))
              for name in ("last", "prediction", "estimate")}
    return {name: R @ np.diag(half) @ R.T for name, (R, half) in turned.items()}


def shape_of(pose) -> np.ndarray:
    """R diag(half²) Rᵀ of one ellipsoid."""
    R = Rotation.from_quat(np.roll(pose.wxyz, -1)).as_matrix()
    return R @ np.diag(np.square(pose.scale)) @ R.T


@pytest.mark.parametrize("k", [1, 5, 20, 60])
def test_the_ellipsoids_above_the_deck_are_the_covariances_of_the_velocities(k):
    """One linear scale holds for all of them, so that growth and shrinkage can be compared by eye."""
    kf, velocities = tuned(), np.ix_([3, 5, 4], [3, 5, 4])  # right, away, up
    last = prior = posterior = watcher("white", 1.0, 1.0, 1.0).start.covariance
    for sample in range(k + 1):
        last, prior = posterior, posterior if sample == 0 else kf.A @ posterior @ kf.A.T + kf.Q
        S = kf.C @ prior @ kf.C.T + kf.R
        posterior = prior - prior @ kf.C.T @ np.linalg.inv(S) @ kf.C @ prior
    size = np.sqrt(np.diag(solve_discrete_are(kf.A.T, kf.C.T, kf.Q, kf.R)[velocities]))
    before, after = (drawn_ellipsoids(outcome(q=1.0, r=1.0, k=k, phase=phase)) for phase in ("predict", "update"))
    factor = np.trace(before["prediction"]) / np.trace(prior[velocities] / np.outer(size, size))
    for drawn, true in ((before["last"], last), (before["prediction"], prior), (after["prediction"], prior),
                        (after["estimate"], posterior)):
        assert np.allclose(drawn, factor * true[velocities] / np.outer(size, size), rtol=1e-6, atol=1e-6 * factor)


def test_the_ellipsoid_has_one_scale_for_all_settings_so_that_a_larger_r_makes_it_larger():
    right, wide, narrow = (drawn_ellipsoids(outcome(q=q, r=r, k=60, phase="update"))["prediction"]
                           for q, r in ((1.0, 1.0), (1.0, 2.0), (0.05, 1.0)))
    assert np.linalg.det(wide) > 1.2 * np.linalg.det(right) > 1.2**2 * np.linalg.det(narrow)
    assert np.diag(right) == pytest.approx(SETTLED**2, rel=1e-2)


def test_the_ellipsoid_grows_in_predict_and_shrinks_in_correct():
    before, after = (drawn_ellipsoids(outcome(q=1.0, r=1.0, k=5, phase=phase)) for phase in ("predict", "update"))
    assert np.linalg.det(before["last"]) < 0.5 * np.linalg.det(before["prediction"])
    assert np.linalg.det(after["estimate"]) < 0.5 * np.linalg.det(after["prediction"])
    assert np.linalg.det(before["estimate"]) < 1e-12 and np.linalg.det(after["last"]) < 1e-12


@pytest.mark.parametrize("q, r", [(0.05, 1.73), (1.0, 1.0), (100.0, 1.73)])
def test_the_errors_above_the_deck_are_those_of_the_run_beside_the_stated_covariance(q, r):
    """Stated: P⁺ = P⁻ − P⁻Cᵀ(CP⁻Cᵀ + R)⁻¹CP⁻ of the settled filter. Actual: the mean of e eᵀ from 2 s on. One scale, a half axis is 2σ."""
    o, kf, velocities = outcome(q=q, r=r, above="errors"), tuned(), np.ix_([3, 5, 4], [3, 5, 4])
    prior = solve_discrete_are(kf.A.T, kf.C.T, q * kf.Q, r * kf.R)
    P = prior - prior @ kf.C.T @ np.linalg.inv(kf.C @ prior @ kf.C.T + r * kf.R) @ kf.C @ prior
    size = np.sqrt(np.diag(solve_discrete_are(kf.A.T, kf.C.T, kf.Q, kf.R)[velocities]))
    e = (o.study.truth.x - o.study.means)[50:, [3, 5, 4]]
    moments = sum(np.outer(each, each) for each in e) / len(e)
    poses = o.stage.body.pose(o.stage.x[-1].tolist(), o.stage.body.gain)
    stated, actual = (shape_of(poses[name]) for name in ("estimate", "actual"))
    factor = np.trace(stated) / np.trace(P[velocities] / np.outer(size, size))
    assert np.allclose(stated, factor * P[velocities] / np.outer(size, size), rtol=1e-5, atol=1e-6)
    assert np.allclose(actual, factor * moments / np.outer(size, size), rtol=1e-5, atol=1e-6)
    dots = [np.array(pose.position) - np.array([0.0, 0.0, 2.95]) for name, pose in poses.items() if name.startswith("error ")]
    assert np.allclose(dots[0], np.sqrt(factor) / 2 * e[0] / size, atol=1e-9) and np.allclose(poses["actual"].position, (0, 0, 2.95))
    rms = np.sqrt(np.mean([each @ np.linalg.inv(P[velocities]) @ each for each in e]) / 3)
    assert o.metrics["rms_times"] == pytest.approx(rms, rel=1e-6)
    (words, *_), = o.stage.body.marks(o.stage.x[-1].tolist(), o.stage.xhat[-1].tolist(), 1.0).words
    assert words == f"RMS = {rms:.2g} σ"


def test_no_error_is_shown_before_the_filter_has_settled():
    o = outcome(above="errors")
    poses = o.stage.body.pose(o.stage.x[40].tolist(), 1.0)
    assert all(pose.position[2] < 0 for name, pose in poses.items() if name.startswith("error "))
    assert max(poses["actual"].scale) < 0.01


@pytest.mark.parametrize("q, r, p0", [(1.0, 1.0, 1.0), (16.0, 1.0, 1.0), (16.0, 16.0, 100.0)])
def test_the_bar_of_the_gain_is_as_high_as_the_gain_is_large(q, r, p0):
    """M = P⁻Cᵀ(CP⁻Cᵀ + R)⁻¹ of the recursion, over the settled one for the right Q and R."""
    kf, o = tuned(), outcome(q=q, r=r, p0=p0, above="gain")
    settled = solve_discrete_are(kf.A.T, kf.C.T, kf.Q, kf.R)
    one = np.linalg.norm(settled @ kf.C.T @ np.linalg.inv(kf.C @ settled @ kf.C.T + kf.R))
    P = watcher("white", q, r, p0).start.covariance
    for k in range(100):
        P = P if k == 0 else kf.A @ P @ kf.A.T + q * kf.Q
        M = P @ kf.C.T @ np.linalg.inv(kf.C @ P @ kf.C.T + r * kf.R)
        P = P - M @ kf.C @ P
        if k in (0, 5, 99):
            poses = o.stage.body.pose(o.stage.x[k].tolist(), 1.0)
            assert poses["gain"].scale[2] / poses["right gain"].scale[2] == pytest.approx(np.linalg.norm(M) / one, rel=1e-6)
    (words, *_), = o.stage.body.marks(o.stage.x[99].tolist(), o.stage.xhat[99].tolist(), 1.0).words
    assert words == f"× {np.linalg.norm(M) / one:.3g}"


# --- prediction and current estimate, data sheet ---------------------------------------------------------------------
def cells(o, id: str) -> list[tuple[str, ...]]:
    figure = next(f for f in LESSON.figures(o) if f.id == id)
    return [tuple(cell if isinstance(cell, str) else cell("en") for cell in row) for row in figure.rows]


@pytest.mark.parametrize("q, r", [(1.0, 1.0), (20.0, 0.47), (0.05, 1.73)])
def test_the_table_compares_the_settled_prediction_and_current_estimate(q, r):
    kf = tuned()
    P = solve_discrete_are(kf.A.T, kf.C.T, q * kf.Q, r * kf.R)
    L, _, _ = control.dlqe(kf.A, np.eye(6), kf.C, q * kf.Q, r * kf.R)
    after = P - np.linalg.solve(kf.A, L) @ kf.C @ P
    shown = [[float(cell) for cell in row[1:3]] for row in cells(outcome(q=q, r=r), "estimators")]
    assert np.allclose(shown, 1e3 * np.sqrt(np.column_stack([np.diag(P), np.diag(after)])), rtol=6e-3)


@pytest.mark.parametrize("density, step, push, period", [(0.28, 0.1, 0.025, 0.04), (0.2, 1.0, 0.3, 0.004), (5.0, 3.0, 0.01, 0.2)])
def test_the_data_sheet_gives_r_and_q(density, step, push, period):
    A, B = MODEL.plant.A, MODEL.plant.B
    G = (B[:, :1] + B[:, 1:2]) / 2
    blocks = expm(np.block([[-A, G @ G.T * push**2 / 2], [np.zeros((6, 6)), A.T]]) * period)  # Van Loan
    Q, R = blocks[6:, 6:].T @ blocks[:6, 6:], density**2 / (2 * period) + step**2 / 12
    P = solve_discrete_are(expm(A * period).T, MODEL.plant.C.T, (Q + Q.T) / 2, 1e-6 * R * np.eye(4))
    value = {name: float(number) for name, number, _ in cells(outcome(density=density, step=step, push=push, period=period), "sheet")
             if "·" not in number}
    assert value["R of one reading"] == pytest.approx(R, rel=6e-3)
    assert value["r, for sensors of this sheet: R / true R"] == pytest.approx(R, rel=6e-3)  # the true one is 1 mm²/s²
    found = sheet_of(density, step, push, period)
    assert np.allclose(found.Q, Q, atol=1e-9 * np.abs(Q).max())
    assert value["σ of v_z before a reading"] == pytest.approx(1e3 * np.sqrt(P[4, 4]), rel=6e-3)


def test_the_gain_for_correlated_noises_is_the_best_one():
    """L = (A P Cᵀ + N) S⁻¹, N the covariance of w and v of a sample: any other gain leaves a larger settled covariance."""
    rng = np.random.default_rng(3)
    A, C = np.array([[0.9, 0.4], [-0.2, 1.1]]), np.array([[1.0, 0.5]])
    root = rng.standard_normal((3, 3))
    Q, N, R = (root @ root.T)[:2, :2], (root @ root.T)[:2, 2:], (root @ root.T)[2:, 2:]
    P = solve_discrete_are(A.T, C.T, Q, R, s=N)
    L = (A @ P @ C.T + N) @ np.linalg.inv(C @ P @ C.T + R)

    def settled(gain):
        mixed = np.hstack([np.eye(2), -gain])
        return solve_discrete_lyapunov(A - gain @ C, mixed @ root @ root.T @ mixed.T)
    assert np.allclose(settled(L), P)
    for _ in range(20):
        other = settled(L + 0.05 * rng.standard_normal((2, 1)))
        assert np.linalg.eigvalsh(other - P).min() > -1e-12 and np.trace(other - P) > 0
    assert np.trace(settled(A @ P @ C.T @ np.linalg.inv(C @ P @ C.T + R)) - P) > 1e-3  # the gain that forgets N


def test_without_detectability_the_covariance_grows_and_with_stabilizability_the_start_is_forgotten():
    A, Q = np.diag([1.1, 0.5]), np.eye(2)
    for C, seen in ((np.array([[0.0, 1.0]]), False), (np.array([[1.0, 0.0]]), True)):
        ends = []
        for P in (np.zeros((2, 2)), 1e3 * np.eye(2)):
            for _ in range(200):
                P = A @ (P - P @ C.T @ C @ P / (C @ P @ C.T + 1)) @ A.T + Q
            ends.append(P)
        assert np.allclose(*ends, rtol=1e-6) == seen and (np.trace(ends[0]) < 1e3) == seen


def test_the_shelf_of_the_gains_stands_behind_the_deck_in_every_run():
    """The deck and all on it, turned and shifted as far as the run goes, end before the shelf begins."""
    o = outcome(above="gain")
    sizes = {part.name: part.shape.size for part in o.stage.body.parts if hasattr(part.shape, "size")}
    begins = min(1.2 - sizes[name][1] / 2 for name in ("gain foot", "gain base", "gain post left"))
    for k in range(0, len(o.stage.t), 10):
        poses = o.stage.body.pose(o.stage.x[k].tolist(), 20.0)
        assert poses["gain foot"].position[1] == pytest.approx(1.2)
        assert all(poses[name].position[1] + sizes[name][1] / 2 < begins for name in ("deck", "payload"))
