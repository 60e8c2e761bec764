"""Witnesses for what is left under noise, by the equations of Lyapunov and Riccati: variances, costs, margins, means that stay bounded."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov
from witnesses import Shown, Witness, near, value

from observer_lab.course.figures.records import LineFigure
from observer_lab.lessons.noise.knobs import SPRING_PLANT as BLOCK
from observer_lab.text import Text


def variance(poles: np.ndarray, W: float, V: float) -> np.ndarray:
    """Variances of the error of the observer with these poles on the block, by coefficients and scipy's Lyapunov equation."""
    A, B, C = BLOCK.A, BLOCK.B, BLOCK.C
    O, last = np.vstack([C, C @ A]), np.array([[0.0], [1.0]])
    a1, a0 = -float(np.real(np.sum(poles))), float(np.real(np.prod(poles)))
    L = (A @ A + a1 * A + a0 * np.eye(2)) @ np.linalg.solve(O, last)
    return np.diag(solve_continuous_lyapunov(A - L @ C, -(W * B @ B.T + V * L @ L.T)))


def _least(W: float, V: float) -> np.ndarray:
    return np.diag(solve_continuous_are(BLOCK.A.T, BLOCK.C.T, W * BLOCK.B @ BLOCK.B.T, np.array([[V]])))


def _as_small(shown: Shown, _: Text) -> None:
    i, W, V = int(shown["watch"] == "velocity"), shown["w"], shown["v"]
    now = variance(shown.outcome.poles["observer"], W, V)[i]
    assert now < 1.011 * _least(W, V)[i], f"{np.sqrt(now / _least(W, V)[i]):.4g} times the least"


def _times(shown: Shown, words: Text) -> None:
    i, W, V = int(shown["watch"] == "velocity"), shown["w"], shown["v"]
    near(value(words, "ratio"), float(np.sqrt(variance(shown.outcome.poles["observer"], W, V)[i] / _least(W, V)[i])), 1e-4)


def _other_speed(*better: float) -> Witness:
    def witness(shown: Shown, _: Text) -> None:
        i, W, V = int(shown["watch"] == "velocity"), shown["w"], shown["v"]
        poles = shown.outcome.poles["observer"]
        now = variance(poles, W, V)[i]
        for factor in better:
            assert variance(factor * poles, W, V)[i] < now, f"{factor} times the speed is not better"
        if not better:
            best = min(variance(f * poles, W, V)[i] for f in (0.7, 0.85, 1.18, 1.4))
            assert best > now * (1 - 1.01e-2), f"another speed has {np.sqrt(best / now):.4g} times the error"
    return witness


def _none_smaller(shown: Shown, _: Text) -> None:
    W, V = shown["w"], shown["v"]
    assert np.all(variance(shown.outcome.poles["observer"], W, V) > _least(W, V) * (1 - 1e-6)), "one of the variances is smaller"


def _never_below_one(shown: Shown, _: Text) -> None:
    figure = shown.figure
    assert isinstance(figure, LineFigure)
    least = float(np.min(figure.curves[0].y))
    assert least > 1 - 1e-6, f"LQR comes down to {least:.6g}"


def _recovered(shown: Shown, _: Text) -> None:
    s = shown.outcome.study
    assert s.cost.total > s.plain_cost.total, "it is not dearer"
    assert s.real.margins.nearest > s.plain.margins.nearest, "the loop is no farther from −1"


def least_cost(shown: Shown) -> float:
    """Of the best controller for the plant as it is, its true gain and noise, by scipy's Riccati equations on intensities near one."""
    case, setting = shown.outcome.study.case, shown.outcome.study.setting
    f, A, B, C = setting.factors, case.plant.A, setting.gain * case.plant.B, case.plant.C
    Q, R, V = f.alpha_q * case.Q, f.alpha_r * case.R, f.sensor * case.V
    W = case.true_disturbance(f) * case.G @ case.W @ case.G.T
    size = float(np.trace(W))
    S, P = solve_continuous_are(A, B, Q, R), size * solve_continuous_are(A.T, C.T, W / size, V / size)
    K = np.linalg.solve(R, B.T @ S)
    return float(np.trace(S @ W) + np.trace(K.T @ R @ K @ P))


def _cheapest(shown: Shown, _: Text) -> None:
    near(shown.outcome.study.cost.total, least_cost(shown), 1e-4)


def _bounded(stays: bool) -> Witness:
    def witness(shown: Shown, _: Text) -> None:
        s = shown.outcome.study.watched.sampled
        S, growth = np.eye(s.plant.n), 0.0
        for _k in range(400):
            S = shown["loss"] * s.plant.A @ S @ s.plant.A.T
            growth = float(np.linalg.norm(S))
            S /= max(growth, 1e-300)
        assert (growth < 1 + 1e-9) if stays else (growth > 1 - 1e-9), f"the lower bound grows by {growth:.4g} a sample"
    return witness


def _squares(shown: Shown, words: Text) -> None:
    """NIS and NEES of a filter written out here: predict, update by Joseph's form, after the first two seconds."""
    kf, start, record = shown.outcome.study.watcher.filter, shown.outcome.study.watcher.start, shown.outcome.study.truth
    x, P, nis, nees = start.mean, start.covariance, [], []
    for k, y in enumerate(record.y):
        S = kf.C @ P @ kf.C.T + kf.R
        M, nu = np.linalg.solve(S, kf.C @ P).T, y - kf.C @ x
        keep = np.eye(len(P)) - M @ kf.C
        x, P = x + M @ nu, keep @ P @ keep.T + M @ kf.R @ M.T
        e = (record.x[k] - x[:6])
        nis.append(nu @ np.linalg.solve(S, nu))
        nees.append(e @ np.linalg.solve(P[:6, :6], e))
        x, P = kf.A @ x + np.pad(kf.B, ((0, len(P) - len(kf.B)), (0, 0))) @ record.u[k], kf.A @ P @ kf.A.T + kf.Q
    near(value(words, "mean"), float(np.mean(nis[50:])), 2e-3)
    near(value(words, "mean2"), float(np.mean(nees[50:])), 2e-3)


WITNESSES: Mapping[str, Witness] = {
    "P − P_min has no negative eigenvalue: no combination of errors is smaller than the Kalman filter's.": _none_smaller,
    "The {name} error is as small as any observer can make it: {share} % of its variance is sensor noise.": _as_small,
    "The {name} error is {ratio:.3g} times the least possible; {share} % of its variance is sensor noise.": _times,
    "Slower would be better.": _other_speed(0.95),
    "Faster would be better.": _other_speed(1.05),
    "No other speed is half a per cent better; only another pattern is.": _other_speed(),
    "LQR never falls below 1; LQG comes down to {least}.": _never_below_one,
    "LQR never falls below 1; LQG comes down to {least}, with all inputs at once to {together}.": _never_below_one,
    "No other controller is cheaper on average under this noise.": _cheapest,
    "Margins are bought with noise in the input and a higher cost.": _recovered,
    "{lost} of the measurements are lost; up to {critical:.1f} % can be tolerated: the filter expects a bounded mean variance.":
        _bounded(True),
    "{lost} of the measurements are lost, and the limit is {critical:.1f} %: the mean variance that the filter expects diverges.":
        _bounded(False),
    "NIS {mean:.2f} (4 expected), NEES {mean2:.3g} (6 expected).": _squares,
}
