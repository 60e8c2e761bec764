"""Witnesses of lesson 9: the record through a plain loop of predict and update, its tests by scipy, averages over simulated records."""

from __future__ import annotations

import re
from functools import lru_cache

import numpy as np
from scipy.stats import chi2
from scipy.stats import t as student
from verdict_law import Judge, Said, Witness, witness
from witnesses import read

from observer_lab.course.lesson import Outcome

RECORDS, SAMPLES = 12, 2400
FIRST = 1e-4  # a chance below which a record is called wrong, wherever the page's own level lies


class Record:
    """x̂ and P after each reading, ν and S, of a record that is filtered here."""

    def __init__(self, A, B, C, Q, R, mean, P, y, u, x, first) -> None:  # type: ignore[no-untyped-def]
        n, self.first, nu, S, means, spreads = len(A), first, [], [], [], []
        for k in range(len(y)):
            if k:
                mean, P = A @ mean + B @ u[k - 1], A @ P @ A.T + Q
            S.append(C @ P @ C.T + R)
            nu.append(y[k] - C @ mean)
            M = np.linalg.solve(S[-1], C @ P).T
            mean = mean + M @ nu[-1]
            keep = np.eye(n) - M @ C
            P = keep @ P @ keep.T + M @ R @ M.T
            means.append(mean)
            spreads.append(P)
        self.nu, self.S, self.x = np.array(nu)[first:], np.array(S)[first:], x[first:]
        m = x.shape[1]
        self.e, self.P = self.x - np.array(means)[first:, :m], np.array(spreads)[first:, :m, :m]
        self.nis = np.einsum("ki,ki->k", self.nu, np.linalg.solve(self.S, self.nu[..., None])[..., 0])

    @property
    def nees(self) -> np.ndarray:
        scale = np.sqrt(np.maximum(np.einsum("kii->ki", self.P), 1e-300))
        unit = self.P / scale[:, :, None] / scale[:, None, :] + 1e-9 * np.eye(self.P.shape[1])
        e = self.e / scale
        return np.einsum("ki,ki->k", e, np.linalg.solve(unit, e[..., None])[..., 0])

    def chance_of_white(self) -> float:
        """p of the portmanteau of the innovations over their own covariance, 20 lags."""
        nu = self.nu - self.nu.mean(axis=0)
        N, p = nu.shape
        nu = nu @ np.linalg.inv(np.linalg.cholesky(nu.T @ nu / N)).T
        q = N * N * sum(float(np.sum((nu[k:].T @ nu[:-k] / N) ** 2)) / (N - k) for k in range(1, 21))
        return float(chi2.sf(q, 20 * p * p))


@lru_cache(maxsize=4)
def record_of(outcome: Outcome) -> Record:  # type: ignore[type-arg]
    """The record of an outcome, filtered by the loop here."""
    f, start, truth = outcome.study.watcher.filter, outcome.study.watcher.start, outcome.study.truth
    first = 40 if outcome.design.plant else 50
    return Record(f.A, f.B, f.C, f.Q, f.R, start.mean, start.covariance, truth.y, truth.u, truth.x, first)


def near(said: float, true: float, share: float = 0.01, least: float = 0.0) -> None:
    assert abs(said - true) <= max(share * abs(true), least), f"{true:.4g}"


def inside_sigma(one: Said, match: re.Match[str]) -> None:
    """The share of the time in which the truth lies within 2σ; a state or an output must have that share."""
    r, s = record_of(one.outcome), one.outcome.study
    rows = np.vstack([np.eye(r.x.shape[1]), s.watcher.filter.C]) if one.outcome.design.plant else np.eye(r.x.shape[1])
    spread = np.sqrt(np.maximum(np.einsum("ri,kij,rj->kr", rows, r.P, rows), 0))
    shares = 100 * np.mean(np.abs(r.e @ rows.T) <= 2 * spread, axis=0)
    assert np.abs(shares - read(match[1])).min() <= 1.3, f"{shares}"


def inside_root(one: Said, match: re.Match[str]) -> None:
    r = record_of(one.outcome)
    near(read(match[1]), 100 * float(np.mean(np.abs(r.nu[:, 0]) <= 2 * np.sqrt(r.S[:, 0, 0]))), least=1.3)


def inside_band(one: Said, match: re.Match[str]) -> None:
    """The share of NIS or NEES in the 95 % band of χ²."""
    r = record_of(one.outcome)
    if "trial" in one.words or "runs" in one.words:
        return
    said, begins, shares = read(match[1]), read(match[2]), []
    for values, dof in ((r.nis, r.nu.shape[1]), (r.nees, r.x.shape[1])):
        low, high = chi2.ppf(0.025, dof), chi2.ppf(0.975, dof)
        if abs(begins - low) <= 0.006 * low + 5e-4:
            shares.append(100 * float(np.mean((values >= low) & (values <= high))))
    assert min((abs(said - share) for share in shares), default=np.inf) <= 1.3, f"{shares}"


def live_means(one: Said, match: re.Match[str]) -> None:
    r = record_of(one.outcome)
    near(read(match[1]), float(r.nis.mean()), 0.01, 0.006)
    near(read(match[2]), float(r.nees.mean()), 0.02, 0.02)


def flagged(one: Said, _: re.Match[str]) -> None:
    """What is flagged is unlikely of a right filter; where nothing is, nothing is impossible."""
    r = record_of(one.outcome)
    count, p, white = len(r.nis), r.nu.shape[1], r.chance_of_white()
    mean, (low, high) = float(r.nis.mean()), (float(chi2.ppf(q, p * count)) / count for q in (0.05, 0.95))
    sure = [float(chi2.ppf(q, p * count)) / count for q in (FIRST, 1 - FIRST)]
    if "Nothing" in one.words:
        assert white > FIRST and sure[0] < mean < sure[1], f"p = {white:.2g}, NIS {mean:.4g} of {sure[0]:.4g} to {sure[1]:.4g}"
        return
    assert "correlated" not in one.words or white < 0.1, f"p = {white:.2g}"
    assert "NIS too large" not in one.words or mean > high, f"{mean:.4g} of {low:.4g} to {high:.4g}"
    assert "NIS too small" not in one.words or mean < low, f"{mean:.4g} of {low:.4g} to {high:.4g}"


def white_check(one: Said, _: re.Match[str]) -> None:
    p = record_of(one.outcome).chance_of_white()
    assert p > FIRST if one.true else p < 0.1, f"p = {p:.2g}"


@lru_cache(maxsize=8)
def over_all_records(outcome: Outcome) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    """Means of NIS and NEES over the late half of RECORDS long runs of the deck, which are simulated here."""
    from observer_lab.lessons.kalman.filters import ADC, SENSOR_SIGMA, tuned
    f, start, deck = outcome.study.watcher.filter, outcome.study.watcher.start, tuned()
    w_of, n = np.linalg.cholesky(deck.Q + 1e-12 * np.diag(np.diag(deck.Q))), len(deck.A)
    found = []
    for k in range(RECORDS):
        rng = np.random.default_rng([900_000, k])
        w, x = rng.standard_normal((SAMPLES, n)) @ w_of.T, np.zeros((SAMPLES, n))
        for j in range(1, SAMPLES):
            x[j] = deck.A @ x[j - 1] + w[j]
        coloured = outcome.design["noise"] != "white"
        v = ADC.draw(SAMPLES, 4, rng) if coloured else SENSOR_SIGMA * rng.standard_normal((SAMPLES, 4))
        r = Record(f.A, f.B, f.C, f.Q, f.R, start.mean, start.covariance, x @ deck.C.T + v, np.zeros((SAMPLES, f.B.shape[1])), x,
                   SAMPLES // 2)
        found.append((r.nis.mean(), r.nees.mean()))
    return tuple(np.array(found).T)  # type: ignore[return-value]


def averages(one: Said, match: re.Match[str]) -> None:
    """What is said to hold over all records, by RECORDS of them: Student's band that one in 10,000 leaves, and 3 % for the start."""
    sigmas = float(student.isf(5e-5, RECORDS - 1))
    for said, values in zip(match.groups(), over_all_records(one.outcome), strict=False):
        if said:
            mean, error = float(values.mean()), float(values.std(ddof=1)) / np.sqrt(RECORDS)
            assert abs(read(said) - mean) <= sigmas * error + 0.03 * mean, f"{mean:.4g} ± {error:.2g}"


def one_reading(one: Said, match: re.Match[str]) -> None:
    """One number, 1 before, and one reading, 4: M = P/(P + R), then 1 + 3 M, and 1/P⁺ = 1/P + 1/R."""
    P, R, say = float(one.outcome.design["one_p"]), float(one.outcome.design["one_r"]), [read(group) for group in match.groups()]
    for said, true in zip(say, (1 + 3 * P / (P + R), P, 1 / (1 / P + 1 / R)), strict=True):
        near(said, true, 0.006)


def judged_right(right: bool) -> Judge:
    """No test flags the filter: the averages of NIS and NEES lie in the bands of one record of 350 samples, 4 ± 11 % and 6 ± 31 %."""

    def judge(one: Said, _: re.Match[str]) -> None:
        nis, nees = (float(v.mean()) for v in over_all_records(one.outcome))
        if right:
            assert abs(nis / 4 - 1) < 0.12 and abs(nees / 6 - 1) < 0.34, f"NIS {nis:.4g}, NEES {nees:.4g}"
    return judge


NUM = r"([−\d.,]+(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?)"
WITNESSES: tuple[Witness, ...] = tuple(witness(pattern, judge, "kalman") for pattern, judge in (
    (rf"the truth is within the filter's own 2σ for {NUM} % of the time", inside_sigma),
    (rf"From \S+ s on {NUM} % lie within 2√S", inside_root),
    (rf"One run: from \S+ s on {NUM} % of the samples lie in the χ² band \[{NUM}", inside_band),
    (rf"The estimate moves from 1 to {NUM}, and its variance falls from {NUM} to {NUM}\.?$", one_reading),
    (rf"^NIS {NUM} \(4 expected\), NEES {NUM} \(6 expected\)", live_means),
    (rf"^NIS {NUM} in this record, .* NEES {NUM} \(", live_means),
    (r"^Nothing is flagged|^Flagged: ", flagged),
    (r"^innovations are white", white_check),
    (r"no test flags it|the coloured noise is now a state", judged_right(True)),
    (rf"Over all records NIS averages {NUM}, NEES {NUM}", averages),
    (rf"Over all records NIS averages {NUM} and whiteness", averages),
))
