"""Witnesses for what filters, regulators and the platform's loops claim: variances and poles found from the matrices by other means."""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import numpy as np
from scipy.linalg import block_diag, solve_continuous_lyapunov, solve_discrete_are, solve_discrete_lyapunov
from witnesses import Shown, Witness, near, read, value

from observer_lab.course.figures.records import LineFigure
from observer_lab.engine import Plant
from observer_lab.engine.filters import Experiment, simulate_filters
from observer_lab.engine.systems import slopes
from observer_lab.lessons.decoupling.loops import AXIS_POLE_RAD_S, lower_of, platform_of
from observer_lab.lessons.kalman.filters import ADC, tuned
from observer_lab.lessons.lqg.loops import gains, setting_of
from observer_lab.lessons.nonlinear.cases import judged
from observer_lab.lessons.nonlinear.runs import experiment_of
from observer_lab.lessons.weak_states.reduced_regulator import weights_of
from observer_lab.text import Text

LAST = 1.0  # percent of the final gain
COILS = 3
PITCH = 2  # the state θ of the platform


# --- kalman ------------------------------------------------------------------------------------------------------------
def _within_a_percent(shown: Shown, words: Text) -> None:
    """The gain by the recursion written out, beside that of scipy's Riccati solution."""
    who = shown.outcome.study.watcher
    kf, P = who.filter, who.start.covariance
    S = solve_discrete_are(kf.A.T, kf.C.T, kf.Q, kf.R)
    goal = np.linalg.solve(kf.C @ S @ kf.C.T + kf.R, kf.C @ S).T
    away, after = [], round(value(words, "after") / 0.04)
    for _ in range(301):
        M = np.linalg.solve(kf.C @ P @ kf.C.T + kf.R, kf.C @ P).T
        keep = np.eye(kf.n) - M @ kf.C
        P = kf.A @ (keep @ P @ keep.T + M @ kf.R @ M.T) @ kf.A.T + kf.Q
        away.append(100 * float(np.abs(M - goal).max() / np.abs(goal).max()))
    assert max(away[after:]) < 1.01 * LAST, f"{max(away[after:]):.3g} % away later on"
    assert after == 0 or away[after - 1] > 0.99 * LAST, "it was as near before"


def _right_about_itself(shown: Shown, _: Text) -> None:
    """Mean NIS and NEES over all records, from truth, the converter's relaxations and filter written out as one noisy system."""
    who, real = shown.outcome.study.watcher, tuned()
    kf, M = who.filter, who.steady.filter_gain
    a, each = ADC.relaxations if shown["noise"] != "white" else (np.zeros(0), 0.0)
    n, b, k = 6, 4 * len(a), kf.n
    C = np.hstack([real.C, np.kron(np.eye(4), np.ones((1, len(a))))])  # y = C (x, b) + white noise
    moves = block_diag(real.A, np.kron(np.eye(4), np.diag(a))) if b else real.A
    drive = block_diag(real.Q, each * np.kron(np.eye(4), np.diag(1 - a**2))) if b else real.Q
    A = np.block([[moves, np.zeros((n + b, k))], [kf.A @ M @ C, kf.A - kf.A @ M @ kf.C]])
    noise = np.vstack([np.zeros((n + b, 4)), kf.A @ M]) * 1e-3
    Z = solve_discrete_lyapunov(A, block_diag(drive, np.zeros((k, k))) + noise @ noise.T)
    nu = np.hstack([C, -kf.C])
    e = np.hstack([np.eye(n, n + b), -np.eye(n, k)]) - M[:n] @ nu
    P, S = who.steady.solution, kf.C @ who.steady.solution @ kf.C.T + kf.R
    seen = nu @ Z @ nu.T + 1e-6 * np.eye(4)
    after = ((np.eye(k) - M @ kf.C) @ P)[:n, :n]
    real_error = e @ Z @ e.T + 1e-6 * M[:n] @ M[:n].T
    m = shown.outcome.metrics
    for name, mean in (("nis", np.trace(np.linalg.solve(S, seen))), ("nees", np.trace(np.linalg.solve(after, real_error)))):
        assert m[f"{name}_low"] <= mean <= m[f"{name}_high"], f"the mean of {name} over all records is {mean:.4g}"


# --- lqg ---------------------------------------------------------------------------------------------------------------
def _nearest(shown: Shown, recovered: bool) -> float:
    """min |1 + ℓ| at the page's input: 1/|S| over frequency, the loop assembled here from A, B, C, K, L."""
    d, case = shown.outcome.design, shown.outcome.study.case
    setting = setting_of(case, d)
    reg, est = gains(case, setting if recovered else setting.plain())
    A, B, C, K, L = case.plant.A, case.plant.B, case.plant.C, reg.gain, est.gain
    inner = A - B @ K - L @ (C - np.asarray(case.plant.D) @ K)
    cut = min(int(dict(d.values).get("cut", "1")), case.plant.m) - 1
    least = np.inf
    rates = np.abs(np.concatenate([np.linalg.eigvals(M) for M in (A, inner, A - B @ K, A - L @ C)]))
    grid = np.geomspace(max(rates.min(), 1e-6 * rates.max()) / 100, 100 * rates.max(), 6000)
    for s in 1j * np.union1d(grid, rates[rates > 0]):
        P = C @ np.linalg.solve(s * np.eye(len(A)) - A, B) + np.asarray(case.plant.D)
        S = np.linalg.inv(np.eye(case.plant.m) + K @ np.linalg.solve(s * np.eye(len(A)) - inner, L) @ P)
        least = min(least, 1 / abs(S[cut, cut]))
    return float(least)


def _no_farther(shown: Shown, _: Text) -> None:
    s, now, before = shown.outcome.study, _nearest(shown, True), _nearest(shown, False)
    assert now <= before * (1 + 1e-3), f"min |1 + ℓ| is {now:.5g}, was {before:.5g}"
    assert s.cost.total > s.plain_cost.total, "it costs no more"


# --- weak states -------------------------------------------------------------------------------------------------------
def _costs_nothing(shown: Shown, _: Text) -> None:
    """Average xᵀQx + uᵀRu of both designs on ten states, from Lyapunov's equation of a loop assembled here."""
    study = shown.outcome.study
    s, plant, weights = study.system, study.system.plant, weights_of(study.system, shown["v0"])
    A, B, C, G, cost = plant.A, plant.B[:, :COILS], plant.C, plant.B[:, COILS:], []
    Q = weights.Q(plant) if shown["pressed"] == "outputs" else 1e10 * s.balanced.left.T @ s.balanced.left
    for design in (study.compared.full.design, study.compared.small.design):
        k = design.controller
        loop = np.block([[A, B @ k.C], [k.B @ C, k.A]])
        drive = block_diag(G @ weights.W @ G.T, k.B @ weights.V @ k.B.T)
        X = solve_continuous_lyapunov(loop, -drive)
        cost.append(float(np.trace(Q @ X[:10, :10]) + np.trace(weights.R @ k.C @ X[10:, 10:] @ k.C.T)))
    near(cost[1], cost[0], 1e-4)


def _bound(shown: Shown, words: Text) -> None:
    assert value(words, "peak") <= value(words, "bound") * (1 + 1e-3) + 1e-8, "the error exceeds the bound"


def _sharp_bound(shown: Shown, words: Text) -> None:
    """The error keeps to it, and it is the sum over pairs of the larger value or of both."""
    study = shown.outcome.study
    assert study.cut.peak <= value(words, "sharp") * (1 + 2e-3) + 1e-8, "the error exceeds the sharp bound"
    values, r = study.system.hankel, study.cut.order
    assert values[r::2].sum() * 2 * (1 - 0.05) - 1e-5 <= value(words, "sharp") <= 2 * values[r:].sum() * (1 + 0.05) + 1e-5


def _between_equal_values(shown: Shown, words: Text) -> None:
    values, r = shown.outcome.study.system.hankel, shown.outcome.study.cut.order
    assert values[r - 1] - values[r] < 2e-3 * values[r], "the values differ"


# --- decoupling --------------------------------------------------------------------------------------------------------
def _drifts(shown: Shown, words: Text) -> None:
    """The printed controller's poles in fifty digits."""
    with mpmath.workdps(50):
        poles = mpmath.eig(mpmath.matrix(shown.outcome.study.controllers.vertical.A.tolist()), right=False)
        near(value(words, "drift"), float(max(mpmath.re(p) for p in poles)), 6e-3)


def _read_by_geophones(plant: Plant, shown: Shown) -> Plant:
    """A mass in each sensor, r'' + 2 · 0.7 ω r' + ω² r = the deck's acceleration there (+ g θ, if it feels tilt); r' is read."""
    if shown["sensors"] == "ideal":
        return plant
    omega, n, felt = 2 * np.pi * shown["corner"], plant.n, plant.C @ plant.A
    if shown["tilt"]:
        felt[1, PITCH] += 9.81
        felt[3, PITCH] -= 9.81  # turned by half a revolution
    none, eye = np.zeros((4, 4)), np.eye(4)
    A = np.block([[plant.A, np.zeros((n, 8))], [np.zeros((4, n)), none, eye], [felt, -omega**2 * eye, -1.4 * omega * eye]])
    B = np.vstack([plant.B, np.zeros((4, plant.m)), plant.C @ plant.B])
    return Plant(A, B, np.hstack([np.zeros((4, n + 4)), eye]))


def _made_unstable(shown: Shown, words: Text) -> None:
    """Poles of the loop with the pitch controller and without it, assembled channel by channel: u = T diag(C) T_y y."""
    from observer_lab.plants.platform.siso_loops import T_u, T_y
    c, plant = shown.outcome.study.controllers, _read_by_geophones(platform_of(lower_of(shown.outcome.design)), shown)
    parts, B = (c.vertical, c.rotation, c.horizontal), plant.B[:, :COILS] @ T_u @ shown.outcome.gains["S"]

    def right(loops: tuple[bool, ...]) -> float:
        used = [(k, p) for k, (p, on) in enumerate(zip(parts, loops, strict=True)) if p is not None and on]
        A = plant.A + sum((np.outer(B[:, k], T_y[k] @ plant.C) * float(np.asarray(p.D)[0, 0]) for k, p in used), np.zeros_like(plant.A))
        own = block_diag(*(p.A for _, p in used)) if used else np.zeros((0, 0))
        push = np.hstack([np.outer(B[:, k], p.C[0]) for k, p in used])
        seen = np.vstack([np.outer(p.B[:, 0], T_y[k] @ plant.C) for k, p in used])
        poles = np.linalg.eigvals(np.block([[A, push], [seen, own]]))
        return float(np.real(poles[np.abs(poles) >= AXIS_POLE_RAD_S]).max())
    near(value(words, "right"), right((True, True, True)), 6e-3)
    assert right((True, False, True)) < 0 <= right((True, True, True)), "closing pitch is not what made it unstable"


PRINTED = {"report-vertical": (1, 2, 1e-8, 1e-18, 1e-17), "report-horizontal": (0.8, 1.25, 1e-11, 1e-15, 1e-15),
           "report-rotation": (1, 10, 1e-11, 1e-14, 1e-13)}  # (33)–(38): from and to Hz, without control, with it from and to


def _as_printed(shown: Shown, _: Text) -> None:
    """The highest points of the drawn curves, back in (m/s)²/Hz."""
    figure = shown.figure
    assert isinstance(figure, LineFigure)
    low, high, bare, least, most = PRINTED[figure.id]
    inside = (figure.x >= low) & (figure.x <= high)
    ours = [1e-12 * float(c.y[inside].max()) for c in figure.curves[:2]]
    assert bare / 2 <= ours[0] <= 2 * bare and least / 2 <= ours[1] <= 2 * most, f"peaks of {ours[0]:.2g} and {ours[1]:.2g}"


# --- nonlinear ---------------------------------------------------------------------------------------------------------
def _least(e: Experiment, F: np.ndarray, H: np.ndarray) -> np.ndarray:
    """The bound at the last sample, lengths by the start's deviations; with few inputs the start and all noise are what is unknown."""
    unit = np.sqrt(np.diag(e.start.covariance[0]))
    F, H, Q = F * unit / unit[:, None], H * unit, e.Q / np.outer(unit, unit)
    n, (samples, runs), R = len(unit), H.shape[:2], np.linalg.inv(e.R)
    J, start = np.zeros((samples * n, samples * n)), np.linalg.inv(e.start.covariance[0] / np.outer(unit, unit))
    J[:n, :n], at = start, [slice(k * n, k * n + n) for k in range(samples)]
    inverse = np.linalg.inv(Q) if Q.any() else np.zeros_like(Q)
    if len(e.inputs.T) > 1:  # the platform: all states are unknown
        for k in range(samples):
            J[at[k], at[k]] += np.mean(H[k].swapaxes(-1, -2) @ R @ H[k], axis=0)
            if k:
                J[at[k - 1], at[k - 1]] += np.mean(F[k - 1].swapaxes(-1, -2) @ inverse @ F[k - 1], axis=0)
                J[at[k - 1], at[k]], J[at[k], at[k - 1]] = -F[k - 1].mean(axis=0).T @ inverse, -inverse @ F[k - 1].mean(axis=0)
                J[at[k], at[k]] += inverse
        return np.outer(unit, unit) * np.linalg.inv(J)[at[-1], at[-1]]
    S = np.zeros((runs, n, samples * n))
    for k in range(samples):
        S = F[k - 1] @ S if k else S
        S[:, :, at[k]] = np.eye(n)
        J += np.mean(S.swapaxes(-1, -2) @ H[k].swapaxes(-1, -2) @ R @ H[k] @ S, axis=0)
        if k:
            J[at[k], at[k]] += inverse
    known = slice(0, samples * n if Q.any() else n)
    last = unit[:, None] * S.mean(axis=0)[:, known]
    return last @ np.linalg.solve(J[known, known], last.T)


def _near_the_bound(shown: Shown, words: Text) -> None:
    """The runs once more, with slopes by a complex step; and what the drawn errors leave above the drawn bound."""
    d, s, figure, rng = shown.outcome.design, shown.outcome.study, shown.figure, np.random.default_rng([int(shown["seed"]), 14])
    assert isinstance(figure, LineFigure)
    case, e = experiment_of(d, s.runs, len(s.t), rng)
    run = list(simulate_filters(e, rng))
    F, H = (np.stack([slopes(lambda x, u, f=f: f(x, u), k.x, np.broadcast_to(k.u, (len(k.u), s.runs)))[1] for k in run])
            for f in (e.flow, e.output))
    signal, curves = case.watched[judged(case)], {c.name("en"): c.y for c in figure.curves}
    low, high, late = curves["Cramér–Rao bound"], curves[str(shown["filter"]).upper()], slice(len(s.t) // 2, None)
    near(float(low[-1]), abs(signal.scale) * float(np.sqrt(signal.weights @ _least(e, F[:-1], H) @ signal.weights)), 1e-3)
    left = 100 * (1 - float(np.mean((high[late] / low[late]) ** 2)) ** -0.5)
    said = dict(words.values)
    assert "left" not in said or value(words, "left") >= left - 1, f"{left:.3g} %"
    assert "gap" not in said or value(words, "gap") <= left + 1, f"{left:.3g} %"


def _is_kalman(shown: Shown, words: Text) -> None:
    """The filter gives what the Kalman filter gives, on a plant whose slopes are the same everywhere."""
    d, s, rng = shown.outcome.design, shown.outcome.study, np.random.default_rng([int(shown["seed"]), 14])
    _, e = experiment_of(d, s.runs, len(s.t), rng)
    for k in simulate_filters(e, rng):
        own, best = (k.corrections[name].beliefs.mean for name in (str(shown["filter"]), "kf"))
        assert np.abs(own - best).max() <= 1e-6 * max(float(np.abs(best).max()), 1e-9), "not the Kalman filter"
        A, B = (slopes(lambda x, u: e.flow(x, u), x, np.broadcast_to(k.u, (len(k.u), s.runs)))[1] for x in (k.x, k.x * 3 + 1e-3))
        assert np.abs(A - B).max() <= 1e-9 * np.abs(A).max(), "the plant is not linear"


def _nees(shown: Shown, words: Text) -> None:
    """The runs once more: of each filter the squared errors by its own covariance, their mean over runs and samples, by state."""
    d, s, rng = shown.outcome.design, shown.outcome.study, np.random.default_rng([int(shown["seed"]), 14])
    if s.fallen or any(s.lost.values()):
        return
    _, e = experiment_of(d, s.runs, len(s.t), rng)
    run, said = list(simulate_filters(e, rng)), str(dict(words.values)["each"])
    for name in e.filters:
        squares = []
        for k in run:
            belief = k.corrections[name].beliefs
            away, unit = (k.x - belief.mean).T, np.sqrt(np.einsum("...ii->...i", belief.covariance))
            scaled = np.broadcast_to(belief.covariance / unit[..., :, None] / unit[..., None, :], (s.runs, len(k.x), len(k.x)))
            squares.append(np.einsum("ni,ni->n", away / unit, np.linalg.solve(scaled, (away / unit)[..., None])[..., 0]))
        true = float(np.mean(squares)) / s.x.shape[1]
        if true < 1e6:
            near(_number(said, name.upper()), true, 0.02)


def _number(said: str, name: str) -> float:
    """The number behind a name in a list."""
    return read(said.partition(f"{name} ")[2])


def _as_printed_in_algorithm_3(shown: Shown, words: Text) -> None:
    """Slopes by a complex step, and the covariances of both gains written out: Q is left out of the gain of Algorithm 3 alone."""
    d, case = shown.outcome.design, shown.outcome.study.case
    plain = shown.lesson.apply(d, {"hardening": 0.0, "weakening": 0.0, "kick": -1.0})
    _, e = experiment_of(plain, 1, 2, np.random.default_rng(0))
    rest, none = case.guess[:, None], np.zeros((len(e.inputs.T), 1))
    A, C = (slopes(lambda x, u, f=f: f(x, u), rest, none)[1][0] for f in (e.flow, e.output))
    right = real = believed = np.diag(case.spread**2)
    for k in range(24):
        Q, move = (e.Q, A) if k else (0 * e.Q, np.eye(len(A)))
        carried = move @ believed @ move.T
        right, real = (move @ P @ move.T + Q for P in (right, real))
        S = C @ carried @ C.T + e.R
        M, best = carried @ C.T @ np.linalg.inv(S), right @ C.T @ np.linalg.inv(C @ right @ C.T + e.R)
        keep = np.eye(len(A)) - M @ C
        right, real, believed = right - best @ C @ right, keep @ real @ keep.T + M @ e.R @ M.T, carried + Q - M @ C @ carried
    k = case.state
    for name, P in (("more", believed), ("worse", real)):
        true = 100 * (float(np.sqrt(P[k, k] / right[k, k])) - 1)
        assert true > -1e-6 and abs(value(words, name) - true) < 0.01 * true + 0.06, f"{name}: says {value(words, name):.3g}, is {true:.3g}"


WITNESSES: Mapping[str, Witness] = {
    "NEES per state over {runs} runs (1 expected): {each}. In these runs the {who} is {words}.": _nees,
    "On the linear plant the σ of Algorithm 3 is {more:.1f} % above the Kalman filter's, and its error is {worse:.1f} % larger.":
        _as_printed_in_algorithm_3,
    "As far as {runs} runs tell, no filter could have an error {left:.2g} % smaller than that of the {who}.": _near_the_bound,
    "A better filter than the {who} may exist: the bound lies at least {gap:.0f} % below its error.": _near_the_bound,
    "The plant is linear, so the {who} is the Kalman filter: no filter has a smaller mean square error.": _is_kalman,
    "Within 1 % after {after:.3g} s. No reading has any part in this.": _within_a_percent,
    "No test flags this filter.": _right_about_itself,
    "Flagged by chance: each test flags a right filter in a few records of a hundred.": _right_about_itself,
    "Recovery costs more here and brings the loop no farther from −1 at this input.": _no_farther,
    "Leaving the states out costs nothing that one could measure.": _costs_nothing,
    "Largest error {peak} at {where} Hz. The bound 2Σσ over all values cut is {bound}.": _bound,
    "With equal values counted once it is {sharp}.": _sharp_bound,
    "The cut runs between two equal values, where equal values may not be counted once.": _between_equal_values,
    "C_v keeps a pole at {drift} rad/s.": _drifts,
    "Both agree with the report to 3 dB.": _as_printed,
    "Closing pitch has made the loop unstable: rightmost pole {right} rad/s.": _made_unstable,
}
