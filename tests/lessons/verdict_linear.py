"""Witnesses for single lessons of one loop: hidden modes, variances by scipy, structure by singular values, the arm's load."""

from __future__ import annotations

import re
from itertools import product

import numpy as np
from mpmath import mp
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov
from verdict_law import Judge, Said, Witness, witness
from verdict_runs import compensator, error_matrix, loop_of, noisy, observer, radius, scenario, size_of, stable, whole_loop
from verdict_saturation import error_law
from witnesses import read

from observer_lab.lessons.robust_observer.assumptions import assumed_run

TOLERANCE = 1e-8  # of the largest entry: what counts as zero
SMALL_PLANT, NEWTON_STEPS = 6, 3  # states up to which covariances are found in fifty digits; Newton's steps to the least one
UNSURE = 1e-4  # so small a distance may be called hidden or not
NUM = r"([−+-]?[\d.,]+(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?)"


def plant_of(one: Said):  # type: ignore[no-untyped-def]
    """The plant of the run, or of the structure that is shown."""
    if one.outcome.run is not None:
        return one.outcome.run.scenario.plant
    study = one.outcome.study
    return study.sensed.plant if hasattr(study, "sensed") else study.case.plant


def unseen(A: np.ndarray, C: np.ndarray) -> list[tuple[complex, float]]:
    """Every pole of A with the smallest singular value of [A − λI; C], states, outputs and time as they are."""
    return [(pole, float(np.linalg.svd(np.vstack([A - pole * np.eye(len(A)), C]))[1][-1])) for pole in np.linalg.eigvals(A)]


def balanced(A: np.ndarray, C: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same with entries of C of size 1."""
    return A / max(np.abs(A).max(), 1e-300), C / np.maximum(np.abs(C).max(axis=1, keepdims=True), 1e-300)


def hidden(one: Said, reached: bool) -> list[tuple[complex, float]]:
    plant = plant_of(one)
    A, C = (plant.A.T, plant.B.T) if reached else (plant.A, plant.C)
    scale = max(np.abs(A).max(), 1e-300)
    return [(pole * scale, d) for pole, d in unseen(*balanced(A, C))]


def observable(reached: bool, only_growing: bool, say_yes: bool = True) -> Judge:
    """Whether no mode, or no mode that does not decay, is hidden; between TOLERANCE and UNSURE both answers pass."""

    def judge(one: Said, _: re.Match[str]) -> None:
        plant = plant_of(one)
        found = [
            d
            for pole, d in hidden(one, reached)
            if not only_growing or (abs(pole) >= 1 - 1e-9 if plant.dt else pole.real >= -1e-9 * np.abs(plant.A).max())
        ]
        least = min(found, default=1.0)
        said = say_yes == one.true
        assert said or least < UNSURE, f"none is hidden, the nearest by {least:.2g}"
        assert not said or least > TOLERANCE * 1e-3, f"one is hidden, {least:.2g}"

    return judge


def follows(reached: bool) -> Judge:
    """That the named rate is that of a hidden mode."""

    def judge(one: Said, match: re.Match[str]) -> None:
        rate = read(next(group for group in match.groups() if group))
        near = [d for pole, d in hidden(one, reached) if abs(pole.real - rate) < 0.006 * max(abs(rate), 0.1)]
        assert near and min(near) < UNSURE, f"no hidden mode has the rate {rate:.3g}: {hidden(one, reached)}"

    return judge


def best_of_gains(one: Said, match: re.Match[str]) -> None:
    """No gain moves the fixed modes: the best of them is not left of the rightmost fixed one."""
    named = read(match[1])
    fixed = [pole.real for reached in (False, True) for pole, d in hidden(one, reached) if d < TOLERANCE]
    assert not fixed or named >= min(fixed) - 0.006 * abs(min(fixed)) or "fixed" not in one.words, f"fixed are {fixed}"


def error_goes(grows: bool) -> Judge:
    """e ~ e^(rate t): the named rate is an eigenvalue's of A − LC, and its sign says grows or decays."""

    def judge(one: Said, match: re.Match[str]) -> None:
        rate = read(next(group for group in match.groups() if group))
        rightmost = radius(error_matrix(scenario(one)), 0)
        assert abs(rightmost - rate) < 0.01 * max(abs(rate), 0.05), f"rightmost {rightmost:.3g}"
        assert (rate > 0) == grows, "the sign"

    return judge


# --- noise -------------------------------------------------------------------------------------------------------------
def _variances(one: Said) -> tuple[np.ndarray, np.ndarray]:
    """Steady P of the observer on the board, and the least one, of the block on a spring."""
    s = scenario(one)
    A, B, C, L = s.plant.A, s.plant.B, s.plant.C, s.L
    W, V = np.atleast_2d(s.W), np.atleast_2d(s.V)
    G = B if len(W) == B.shape[1] else np.eye(len(A))
    F = A - L @ C
    least = solve_continuous_are(A.T, C.T, G @ W @ G.T, V)
    if len(A) > SMALL_PLANT:
        return solve_continuous_lyapunov(F, -(G @ W @ G.T + L @ V @ L.T)), least
    best = least @ C.T @ np.linalg.inv(V)
    for _ in range(NEWTON_STEPS):
        least = _covariance(A, C, best, G @ W @ G.T, V)
        best = least @ C.T @ np.linalg.inv(V)
    return _covariance(A, C, L, G @ W @ G.T, V), least


def _covariance(A: np.ndarray, C: np.ndarray, L: np.ndarray, GWG: np.ndarray, V: np.ndarray) -> np.ndarray:
    """The settled covariance of an observer in fifty digits: a variance far below the others keeps its own digits."""
    with mp.workdps(50):
        A_, C_, L_, V_ = (mp.matrix(M.tolist()) for M in (A, C, L, V))
        F, Q, n = A_ - L_ * C_, mp.matrix(GWG.tolist()) + L_ * V_ * L_.T, len(A)
        sums = mp.zeros(n * n)
        for i, j, k in product(range(n), repeat=3):
            sums[n * i + j, n * k + j] += F[i, k]
            sums[n * i + j, n * i + k] += F[j, k]
        P = mp.lu_solve(sums, -mp.matrix([Q[i, j] for i, j in product(range(n), repeat=2)]))
        return np.array([float(value) for value in P]).reshape(n, n)


def within_the_least(one: Said, match: re.Match[str]) -> None:
    P, least = _variances(one)
    i = int(one.outcome.design["watch"] == "velocity") if "watch" in dict(one.outcome.design.values) else 0
    share, ratio = read(match[1]) / 100, P[i, i] / least[i, i]
    assert abs(ratio - 1 - share) < 1e-4 or (ratio <= 1 + share) == one.true or _both(P, least, share) == one.true, f"{ratio:.4g}"


def _both(P: np.ndarray, least: np.ndarray, share: float) -> bool:
    return bool(np.all(np.diag(P) <= (1 + share) * np.diag(least)))


def the_least(one: Said, match: re.Match[str]) -> None:
    """σ and the least σ of a caption."""
    P, least = _variances(one)
    i = int("m/s" in one.words)
    for said, true in ((read(match[1]), P), (read(match[2]), least)):
        assert abs(said - np.sqrt(true[i, i])) < 0.01 * said, f"{np.sqrt(true[i, i]):.4g}"


def times_the_least(one: Said, match: re.Match[str]) -> None:
    P, least = _variances(one)
    if one.lesson.plant:  # of the watched signal: a state, an output, or a weighted sum that the study names
        row = one.outcome.study.rows[one.outcome.study.judged]
        ratio = float(np.sqrt(row @ P @ row / (row @ least @ row)))
        assert np.linalg.norm(row) > 0 and abs(ratio - read(match[1])) < 0.01 * ratio, f"{ratio:.4g}"
        return
    i = int("velocity" in one.words)
    ratio = float(np.sqrt(P[i, i] / least[i, i]))
    assert min(abs(read(match[1]) - ratio), abs(read(match[1]) - ratio**2)) < 0.01 * ratio**2, f"{ratio:.4g}"


def none_below_the_least(one: Said, _: re.Match[str]) -> None:
    P, least = _variances(one)
    assert np.all(np.diag(P) >= np.diag(least) * (1 - 1e-6)), "one is below"


# --- sandbox -----------------------------------------------------------------------------------------------------------
def near_the_filter(one: Said, match: re.Match[str]) -> None:
    assert read(next(group for group in match.groups() if group)) >= 1 - 1e-6, "less than the least"


# --- arm ---------------------------------------------------------------------------------------------------------------
def _away(one: Said) -> tuple[np.ndarray, np.ndarray, float]:
    run = one.outcome.run
    assert run is not None
    return run.t, np.abs(run.x[:, 3] - run.xhat[:, 3]), abs(float(one.outcome.design["load"]))


def load_found(found: bool) -> Judge:
    def judge(one: Said, match: re.Match[str]) -> None:
        t, away, load = _away(one)
        late = np.flatnonzero(away > 0.05 * load)
        ends = len(late) == 0 or late[-1] < len(t) - 1
        if found:
            assert ends, "it is not, at the end"
            after = float(t[late[-1] + 1]) if len(late) else 0.0
            assert min(abs(read(match[1]) - after), abs(read(match[1]) - after + 1.0)) < 0.02, f"at {after:.3g} s"
        else:
            assert not ends or load == 0, "it is"

    return judge


def run_lost(one: Said, match: re.Match[str]) -> None:
    run = one.outcome.run
    assert run is not None and run.diverged_at is not None and abs(run.diverged_at - read(match[1])) < 0.02, "it is not"


def no_bias(one: Said, _: re.Match[str]) -> None:
    """A constant load is estimated without bias: the observer has a state for it that integrates, and A − LC is stable."""
    s = scenario(one)
    M = s.plant if s.model is None else s.model
    load = len(M.A) > 3 and np.abs(s.L[3]).max() > 0 and radius(*observer(one)) < 0
    assert load == one.true, "L moves the load's state" if load else "nothing moves the load's state"


# --- robust and bilinear -----------------------------------------------------------------------------------------------
def true_loop(want: bool) -> Judge:
    def judge(one: Said, _: re.Match[str]) -> None:
        worst = float(np.max(one.outcome.poles["loop"].real))
        study = one.outcome.study
        e = np.abs(study.true.e) if hasattr(study, "search") else np.zeros(1)  # of an own plant the run may end before an error grows
        late, early = float(e[-len(e) // 10 :].max()), float(e.max())
        said = want == one.true
        if abs(worst) > 1e-6:
            assert (worst < 0) == said, f"rightmost {worst:.3g}"
        assert said or late >= 0.01 * early or len(e) < 10, "its error is small at the end"

    return judge


def assumed_loop(one: Said, match: re.Match[str]) -> None:
    """The rightmost of eig(A − BK) and eig F: what is fed back is K x, of a mode that no sensor sees nothing; with T = 0 it is M C x."""
    case = assumed_run(one.outcome.design["assumed"])
    fed = case.N @ case.T + case.M @ case.plant.C
    rightmost = max(float(np.linalg.eigvals(M).real.max()) for M in (case.plant.A - case.plant.B @ fed, case.F) if len(M))
    assert abs(rightmost - read(match[1])) < 0.006 * max(1.0, abs(rightmost)), f"rightmost {rightmost:.4g}"
    assert (rightmost < 0) == (match[2] == "stable")


def law_of_one_pole(one: Said, match: re.Match[str]) -> None:
    """|ε| and e^{pole t} part by the named share at most, without a kick."""
    pole = float(one.outcome.poles["observer"].real.max())
    assert abs(pole - read(match[1])) < 0.01 * max(abs(pole), 1e-3) + 6e-3, f"the pole is {pole:.4g}"
    if "leaves" in one.words or "grows" in one.words:
        assert pole > -1e-9 or "leaves" in one.words, "it decays"
    elif "decays" in one.words:
        assert pole < 0, "it does not decay"


def any_pole(one: Said, _: re.Match[str]) -> None:
    observer = one.outcome.study.observer
    A, B = observer.A_star, observer.B_star
    rank = np.linalg.matrix_rank(np.hstack([np.linalg.matrix_power(A, k) @ B for k in range(len(A))]), tol=1e-9) if B.size else 0
    assert (rank == len(A)) == one.true, f"rank {rank} of {len(A)}"


# --- virtual sensor ----------------------------------------------------------------------------------------------------
def copy(one: Said) -> tuple[np.ndarray, float]:
    s = scenario(one)
    return (s.plant if s.model is None else s.model).A, s.plant.dt


def driven_error(one: Said, _: re.Match[str]) -> None:
    """The input enters plant and observer alike, and so does the state: ė = (A − LC) e whatever the input."""
    s = scenario(one)
    m = s.plant if s.model is None else s.model
    corner = s.plant.A - s.L @ s.plant.C - m.A + s.L @ m.C
    alike = (
        np.abs(corner).max() < 1e-12
        and np.abs(s.plant.B - s.L @ s.plant.D - m.B + s.L @ m.D).max() < 1e-12
        and not s.delay
        and (s.fed == "applied" or not one.outcome.run.saturated)
    )  # type: ignore[union-attr]
    assert alike == one.true, "the input enters plant and observer " + ("alike" if alike else "in different ways")


def no_trust(one: Said, _: re.Match[str]) -> None:
    s, trust = scenario(one), one.outcome.design["trust"]
    m = s.plant if s.model is None else s.model
    if trust > 0:
        best = min(float(np.linalg.eigvals(m.A - theta / trust * s.L @ m.C).real.max()) for theta in np.linspace(0, 2, 401))
        assert best > -1e-3, f"some θ gives {best:.3g}"


def trusts(one: Said, _: re.Match[str]) -> None:
    """Of the trusts up to 2: all, some or none make A − θLC stable."""
    s, trust = scenario(one), one.outcome.design["trust"]
    m = s.plant if s.model is None else s.model
    if trust > 0:
        rates = np.array([radius(m.A - theta / trust * s.L @ m.C, m.dt) for theta in np.linspace(0, 2, 131)])
        edge = 1e-6 * size_of(m.A)
        assert not one.words.startswith("All") or rates.max() < edge, f"one has {rates.max():.3g}"
        assert not one.words.startswith("No") or rates.min() > -edge, f"one has {rates.min():.3g}"
        assert not one.words.startswith("Only a trust") or (rates[0] > -edge and rates.min() < edge), "not so"
        assert not one.words.startswith("Some") or rates.max() > -edge, "none is unstable"


def at_zero_trust(one: Said, _: re.Match[str]) -> None:
    assert radius(*copy(one)) < 0, "the copy does not decay"


def known(one: Said, match: re.Match[str]) -> None:
    run = one.outcome.run
    assert run is not None
    late = np.abs(run.e[run.t > read(match[1]) + 0.011, 0])
    assert not late.size or float(late.max()) < 1.02, f"up to {late.max():.3g} K"


def plain_loop(one: Said) -> tuple[np.ndarray, float]:
    s = scenario(one)
    return loop_of(s), s.plant.dt


def bare(one: Said) -> tuple[np.ndarray, float]:
    s = scenario(one)
    return s.plant.A, s.plant.dt


def named_right(match: re.Match[str]) -> float:
    return read(match[1])


def compensator_pole(one: Said, match: re.Match[str]) -> None:
    true = radius(*compensator(one))
    assert abs(named_right(match) - true) < 0.01 * max(abs(true), size_of(compensator(one)[0]) * 1e-3), f"{true:.4g}"


def meter(one: Said, _: re.Match[str]) -> None:
    if not noisy(scenario(one)):
        error_law(False)(one, _)


ALL = tuple(
    witness(pattern, judge, *lessons)
    for lessons, rows in {
        ("error-dynamics",): (
            (r"the error does not depend on the input", driven_error),
            (r"the error decays by itself", stable(observer, True)),
            (r"[Bb]elow 2 % (?:of its peak )?after", None),
            (r"does not drive the error", driven_error),
            (r"An observer pole is not in the left half plane", stable(observer, False)),
        ),
        ("virtual-sensor",): (
            (r"the copy's wrong start decays", stable(copy, True)),
            (r"the observer's wrong start decays", stable(observer, True)),
            (r"No θ up to 2 is stable|no θ up to 2 is stable", no_trust),
            (r"the error decays even at θ = 0", at_zero_trust),
            (r"^The observer's error grows", stable(observer, False)),
            (rf"[Kk]nown within 1 K after {NUM} s|below 1 K after {NUM} s", known),
            (r"^(?:All trusts tried|Some of the values of trust|No trust tried|Only a trust of)", trusts),
            (r"Known within 1 K: ", None),
            (r"stays below", None),
            (r"Not every wrong start of the observer decays", stable(observer, False)),
            (r"Every wrong start of the observer decays", stable(observer, True)),
        ),
        ("separation",): (
            (r"error dynamics are no longer autonomous", meter),
            (r"This loop is unstable: it settles to no response", stable(plain_loop, False)),
            (r"Without control the plant does not settle", stable(bare, False)),
            (rf"^The compensator's rightmost pole is {NUM}", compensator_pole),
            (r"loop is stable all the same|the loop is still stable", stable(whole_loop, True)),
            (r"are below 2 % after|is unstable and ends early|does not decay", None),
        ),
        ("hidden-modes",): (
            (r"observable: every mode leaves a trace", observable(False, False)),
            (r"controllable: every mode is reached", observable(True, False)),
            (r"detectable: what leaves no trace settles", observable(False, True)),
            (r"stabilizable: what is out of reach settles", observable(True, True)),
            (r"with this L the error decays", stable(observer, True)),
            (r"with this K and L the plant settles", stable(whole_loop, True)),
            (rf"part of e follows e\^\({NUM}t\)|part of e follows e\^\({NUM} t\)", follows(False)),
            (rf"part of x follows e\^\({NUM} t\)", follows(True)),
            (rf"has its rightmost pole at {NUM}", best_of_gains),
            (rf"e grows like e\^\({NUM} t\)|The error still grows like e\^\({NUM} t\)", lambda one, m: error_goes(True)(one, m)),
            (rf"e decays like e\^\({NUM} t\)", error_goes(False)),
            (
                r"There is no fixed mode|^No mode is hidden|Nothing is hidden",
                lambda one, m: (observable(False, False)(one, m), observable(True, False)(one, m))[0],
            ),
            (r"There is still a fixed mode", lambda one, m: _some_hidden(one)),
            (r"^Hidden from (?:the sensor|y):", observable(False, False, say_yes=False)),
            (r"Hidden|hidden", None),
            (r"are at rest, below 2 %", None),
        ),
        ("observability",): (
            (r"^every mode leaves a trace|^Observable:|^No mode is hidden", observable(False, False)),
            (r"^Not observable", observable(False, False, say_yes=False)),
            (r"hidden|observable|known to a tenth|Known to a tenth|smallest", None),
        ),
        ("noise",): (
            (r"No entry of the column both is below", none_below_the_least),
            (rf"within {NUM} % of the least", within_the_least),
            (rf"σ = {NUM} m.*the least is {NUM} m", the_least),
            (rf"error is {NUM} times the least possible", times_the_least),
            (r"the least|[Ss]ettled", None),
        ),
        ("sandbox",): (
            (r"loop stable: \d+ poles|^loop stable", stable(whole_loop, True)),
            (r"^The loop is not stable", stable(whole_loop, False)),
            (r"^observable: nearest mode", observable(False, False)),
            (r"^controllable: nearest mode", observable(True, False)),
            (r"^detectable:", observable(False, True)),
            (r"^stabilizable:", observable(True, True)),
            (rf"error {NUM} times the least|errs {NUM} times as much as the best|error is {NUM} times the least", near_the_filter),
            (r"error dynamics autonomous", None),
            (r"observer's error does not settle", stable(observer, False)),
            (r"Unstable states, set aside first: (\d+)", lambda one, m: _count_unstable(one, int(m[1]))),
            (r"not one mode is hidden|Hidden from y|[Hh]idden", None),
            (r"Kalman filter consistent|consistent|White is zero|This record|Hankel values|Disk margin", None),
            (r"^Not (?:for this plant|with this design): The loop is not stable", stable(whole_loop, False)),
        ),
        ("arm",): (
            (rf"[Tt]he load is found to 5 % after {NUM} s", load_found(True)),
            (r"The load is not found to 5 %", load_found(False)),
            (rf"This loop is lost after {NUM} s", run_lost),
            (r"error follows ė|error dynamics are autonomous", error_law(True)),
            (r"the load is found without bias", no_bias),
            (r"departs|never find|Found after|is found after|the load found", None),
        ),
        ("robust-observer",): (
            (r"the loop with the true plant is stable", true_loop(True)),
            (r"With the true plant the loop is unstable", true_loop(False)),
            (r"e_u settles to an amplitude", true_loop(True)),
            (rf"rightmost pole of the loop is {NUM}: the loop is (stable|unstable)", assumed_loop),
            (r"the loop is unstable|[Tt]he loop is unstable, so|least value|[Ll]east|grows", None),
        ),
        ("bilinear-observer",): (
            (r"controllable", any_pole),
            (
                rf"decays as e\^\({NUM}t\)|follows e\^\({NUM}t\)|leaves the line e\^\({NUM}t\)",
                lambda one, m: law_of_one_pole(one, re.search(rf"e\^\({NUM}t\)", one.words)),
            ),
            (rf"observer's pole is {NUM}: ε (?:grows|does not decay)", law_of_one_pole),
            (r"ε follows|ε\| leaves its law|ε\| follows ẇ|does not stay below|stays below", None),
            (r"does not settle|observable|does not decay|unaffected|least|settles|decays", None),
        ),
    }.items()
    for pattern, judge in rows
)


def _some_hidden(one: Said) -> None:
    least = min(d for reached in (False, True) for _, d in hidden(one, reached))
    assert least < UNSURE, f"the nearest is {least:.2g} from hidden"


def _count_unstable(one: Said, count: int) -> None:
    plant = plant_of(one)
    poles = np.linalg.eigvals(plant.A)
    right = np.abs(poles) >= 1 - 1e-9 if plant.dt else poles.real >= -1e-9 * max(np.abs(poles).max(), 1e-12)
    sure = np.abs(poles) >= 1 + 1e-6 if plant.dt else poles.real > 1e-6 * max(np.abs(poles).max(), 1e-12)
    assert sure.sum() <= count <= right.sum() or count >= sure.sum(), f"{right.sum()} poles"


WITNESSES: tuple[Witness, ...] = ALL
