"""Witnesses of lesson 14: three filters written out here, on the readings of the page's own runs and of 100 others."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache

import numpy as np
from scipy.stats import chi2
from verdict_law import Said, Witness, witness

from observer_lab.course.lesson import Outcome
from observer_lab.engine.filters import simulate_filters
from observer_lab.lessons.nonlinear.runs import experiment_of

SEEDS, SHARE_SIGMA = 100, 0.05  # of other runs, and the spread of a share of so many
FAR = 1e12  # a variance beyond it is no longer told
Batch = Callable[[np.ndarray], np.ndarray]


class Filter:
    """x̂ (n, N) and P (N, n, n) of N runs; `way` is kf, ekf, ukf, or printed: the moved points serve h too."""

    def __init__(self, way: str, rhs, h, Q, R, start, P, steps, step, parts, points) -> None:  # type: ignore[no-untyped-def]
        self.way, self.rhs, self.h, self.Q, self.R, self.step, self.parts = way, rhs, h, Q, R, step, parts
        self.m, self.P, self.moved = np.array(start), np.array(P), None
        n, (alpha, beta, kappa) = len(Q), points
        lam = alpha**2 * (n + kappa) - n
        self.reach, self.W = np.sqrt(n + lam), np.full(2 * n + 1, 0.5 / (n + lam))
        self.W[0], self.Wc = lam / (n + lam), self.W.copy()
        self.Wc[0] = self.W[0] + 1 - alpha**2 + beta
        self.rest, self.steps = np.array(start)[:, :1], steps

    def flow(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Runge and Kutta's four slopes, `parts` times a step."""
        d = self.step / self.parts
        for _ in range(self.parts):
            k1 = self.rhs(x, u)
            k2 = self.rhs(x + d / 2 * k1, u)
            k3 = self.rhs(x + d / 2 * k2, u)
            x = x + d / 6 * (k1 + 2 * k2 + 2 * k3 + self.rhs(x + d * k3, u))
        return x

    def slopes(self, f: Batch, x: np.ndarray) -> np.ndarray:
        """Central differences (N, rows, n), `steps` (n,) to either side."""
        columns = [(f(x + d[:, None]) - f(x - d[:, None])) / (2 * d.max()) for d in np.diag(self.steps)]
        return np.stack(columns, axis=1).transpose(2, 0, 1)

    def points(self) -> np.ndarray:
        """Sigma points (n, 2n + 1, N), by Cholesky factors."""
        U = self.reach * np.stack([_root(P) for P in self.P], axis=-1)
        m = self.m[:, None]
        return np.concatenate([m, m + U, m - U], axis=1)

    def through(self, f, points: np.ndarray, u: np.ndarray) -> np.ndarray:  # type: ignore[no-untyped-def]
        n, s, N = points.shape
        wide = np.repeat(np.broadcast_to(u, (len(u), N))[:, None], s, axis=1).reshape(len(u), s * N)
        return f(points.reshape(n, s * N), wide).reshape(-1, s, N)

    def correct(self, y: np.ndarray, u: np.ndarray) -> None:
        """x̂ and P after a reading (p, N)."""
        if self.way == "ukf" or self.way == "printed":
            X = self.points() if self.moved is None else self.moved
            Y = self.through(self.h, X, u)
            mean = np.einsum("psN,s->pN", Y, self.W)
            dy, dx = Y - mean[:, None], X - self.m[:, None]
            S = np.einsum("psN,s,qsN->Npq", dy, self.Wc, dy) + self.R
            across = np.einsum("isN,s,qsN->Niq", dx, self.Wc, dy)
        else:
            x = self.rest if self.way == "kf" else self.m
            H = self.slopes(lambda z: self.h(z, 0 * u[:, :1] if self.way == "kf" else u), x)
            mean = self.h(x, u) if self.way == "ekf" else self.h(x, 0 * u[:, :1]) + H[0] @ (self.m - x)
            across = self.P @ H.transpose(0, 2, 1)
            S = H @ across + self.R
        M = np.linalg.solve(S.transpose(0, 2, 1), across.transpose(0, 2, 1)).transpose(0, 2, 1)
        self.m = self.m + np.einsum("Nip,pN->iN", M, y - mean)
        self.P = self.P - M @ S @ M.transpose(0, 2, 1)
        self.P = (self.P + self.P.transpose(0, 2, 1)) / 2

    def predict(self, u: np.ndarray) -> None:
        """x̂ and P one step later."""
        if self.way == "ukf" or self.way == "printed":
            X = self.through(self.flow, self.points(), u)
            self.m = np.einsum("isN,s->iN", X, self.W)
            dx = X - self.m[:, None]
            self.P = np.einsum("isN,s,jsN->Nij", dx, self.Wc, dx) + self.Q
            self.moved = X if self.way == "printed" else None
        elif self.way == "ekf":
            F = self.slopes(lambda z: self.flow(z, u), self.m)
            self.m, self.P = self.flow(self.m, u), F @ self.P @ F.transpose(0, 2, 1) + self.Q
        else:
            none = 0 * u[:, :1]
            F = self.slopes(lambda z: self.flow(z, none), self.rest)[0]
            B = np.stack([self.flow(self.rest, none + d[:, None]) - self.flow(self.rest, none - d[:, None])
                          for d in 1e-3 * np.eye(len(u))], axis=1)[..., 0] / 2e-3 if len(u) else np.zeros((len(F), 0))
            self.m = self.flow(self.rest, none) + F @ (self.m - self.rest) + B @ u
            self.P = F @ self.P @ F.T + self.Q


def _root(P: np.ndarray) -> np.ndarray:
    """Cholesky's factor; where there is none, one with the least eigenvalues of correlations that the filter names."""
    try:
        return np.linalg.cholesky(P)
    except np.linalg.LinAlgError:
        unit = np.sqrt(np.maximum(np.diag(P), 1e-300))
        values, V = np.linalg.eigh(P / np.outer(unit, unit))
        return unit[:, None] * V * np.sqrt(np.maximum(values, 1e-12))


@lru_cache(maxsize=8)
def squares(outcome: Outcome, own: bool) -> dict[str, np.ndarray]:  # type: ignore[type-arg]
    """By filter NEES per state (n_t, N) of the page's runs, or of 100 others; NaN from where a pole fell or a filter is lost."""
    d, s = outcome.design, outcome.study
    rng = np.random.default_rng([int(d["seed"]), 14] if own else [int(d["seed"]) + 77_000, 4])
    runs = s.runs if own else SEEDS
    case, e = experiment_of(d, runs, len(s.t), rng)
    P, n = (d["size"] * np.diag(case.spread)) ** 2, len(case.guess)
    ways = {"kf": "kf", "ekf": "ekf", "ukf": "ukf" if d["redraw"] else "printed"}
    filters = {name: Filter(way, e.flow.rhs, e.output, d["wind"] * case.Q, d["sensor"] ** 2 * case.R,
                            np.repeat(case.guess[:, None], runs, axis=1), np.repeat(P[None], runs, axis=0), 1e-4 * case.spread,
                            case.step, case.parts, (d["alpha"], d["beta"], d["kappa"])) for name, way in ways.items()}
    found: dict[str, list[np.ndarray]] = {name: [] for name in filters}
    out = {name: np.zeros(runs, dtype=bool) for name in filters}
    with np.errstate(all="ignore"):
        for sample in simulate_filters(e, rng):
            fallen = np.abs(sample.x[1]) > np.pi / 2 if case.id == "pendulum" else np.zeros(runs, dtype=bool)
            for name, one in filters.items():
                one.correct(sample.y, sample.u)
                out[name] |= fallen | ~_sound(one)
                one.m[:, out[name]], one.P[out[name]] = case.guess[:, None], P
                found[name].append(np.where(out[name], np.nan, _square(sample.x - one.m, one.P) / n))
                one.predict(sample.u)
    return {name: np.array(values) for name, values in found.items()}


def _sound(one: Filter) -> np.ndarray:
    """Runs (N,) whose estimate and variances are numbers."""
    v = np.diagonal(one.P, axis1=1, axis2=2)
    return (np.abs(one.m) < FAR).all(axis=0) & ((v > 0) & (v < FAR)).all(axis=1)


def _square(e: np.ndarray, P: np.ndarray) -> np.ndarray:
    """eᵀ P⁻¹ e (N,) of errors (n, N), by states of unit variance; inf where P is singular."""
    unit = np.sqrt(np.maximum(np.diagonal(P, axis1=1, axis2=2), 1e-300))
    away = (e.T / unit)[..., None]
    each, scaled = np.full(len(P), np.inf), P / unit[:, :, None] / unit[:, None, :]
    for k, (one, a) in enumerate(zip(scaled, away, strict=True)):
        with suppress(np.linalg.LinAlgError):
            each[k] = (a.T @ np.linalg.solve(one, a)).item()
    return each


def nees_says(one: Said, match: re.Match[str]) -> None:
    """The word fits the mean NEES of the page's runs by its definition, and "consistent" holds of 100 other runs as well.

    Of a consistent filter half of all runs lie below the median of χ². A filter that is consistent in the few runs of the page may
    be lost in a rare one, so a mean over others decides nothing, and few runs cannot tell a NEES from one that differs by their spread.
    """
    who, word, s = match[1].lower(), match[2], one.outcome.study
    n, runs, count = s.x.shape[1], s.runs, len(s.t)
    each = squares(one.outcome, True)[who]
    kept = np.isfinite(each).any(axis=1)
    mean = np.array([np.nanmean(row) if some else np.nan for row, some in zip(each, kept, strict=True)])
    told, over = float(one.outcome.metrics[f"nees_{who}"]), float(np.nanmean(mean))
    if not kept.all() or s.lost[who] or over > 1e4:  # the page carries on the last mean where no run counts
        assert "consistent" not in word or kept[0], "no run counts"
    else:
        assert abs(told - over) <= 0.02 * over + 5e-3, f"NEES {told:.4g}, here {over:.4g}"
    low, high = (chi2.ppf(q, n * runs) / (n * runs) for q in (0.025, 0.975))
    late, inside = mean[count // 2:], float(np.mean((mean >= low) & (mean <= high)))
    rare = chi2.isf(1e-4 / count, n * runs) / (n * runs)
    if word == "consistent":
        assert inside >= 0.75 - 2 / count, f"{inside:.0%} of the samples in the band"
    elif "consistent" in word:
        assert abs(over - 1) <= 0.17, f"mean {over:.3g}"
    elif "at times" in word:
        assert np.nanmax(mean) > 0.98 * min(rare, 1.3 * high), f"largest {np.nanmax(mean):.3g} of {rare:.3g}"
    elif "over" in word:
        assert over > 1.1 or np.mean(late > high) > 0.3, f"mean {over:.3g}"
    else:
        assert over < 0.9, f"mean {over:.3g}"
    if "consistent" in word:
        others = squares(one.outcome, False)[who]
        others = np.where(np.isfinite(others), others, np.inf)
        beyond, median = float(np.median(np.mean(others > chi2.median(n) / n, axis=1))), chi2.median(n)
        factor = 1 + 0.15 * (word != "consistent") + 3 * np.sqrt(2 / (n * runs))  # that the page's runs cannot tell from 1
        least, most = chi2.sf(median * factor, n) - 2 * SHARE_SIGMA, chi2.sf(median / factor, n) + 2 * SHARE_SIGMA
        assert least < beyond < most, f"{beyond:.0%} of the runs above the median of χ², {least:.0%} to {most:.0%} expected"


def in_its_band(one: Said, match: re.Match[str]) -> None:
    """A check that a filter's NEES lies in its band says what the sentence says."""
    who = match[1].lower()
    each = squares(one.outcome, True)[who]
    if np.isfinite(each).any(axis=1).all():
        n, runs = one.outcome.study.x.shape[1], one.outcome.study.runs
        mean = np.nanmean(each, axis=1)
        low, high = (chi2.ppf(q, n * runs) / (n * runs) for q in (0.025, 0.975))
        inside, over = float(np.mean((mean >= low) & (mean <= high))), float(np.mean(mean))
        assert not one.true or inside >= 0.7 or abs(over - 1) <= 0.17, f"{inside:.0%} inside, mean {over:.3g}"
        assert one.true or inside < 0.8 or np.max(mean) > 1.25 * high, f"{inside:.0%} inside, largest {np.max(mean):.3g}"


def same_filters(one: Said, _: re.Match[str]) -> None:
    """EKF and UKF are the KF: their NEES is the KF's, in every run."""
    all_ = squares(one.outcome, True)
    apart = max(float(np.nanmax(np.abs(all_[name] - all_["kf"]))) for name in ("ekf", "ukf"))
    assert not one.true or apart < 1e-2 * max(1.0, float(np.nanmax(all_["kf"]))), f"NEES differ by {apart:.3g}"


WITNESSES: tuple[Witness, ...] = (
    witness(r"(?:In these runs|;) the (KF|EKF|UKF) is "
            r"((?:nearly |not )?consistent|over-?confident(?: at times)?|under-?confident|too cautious[^.]*)", nees_says, "nonlinear"),
    witness(r"^(KF|EKF|UKF): NEES in its band", in_its_band, "nonlinear"),
    witness(r"are the KF, to rounding", same_filters, "nonlinear"),
    witness(r"no filter|better filter|not yet wrong|unknown|grows|consistent|confident|line|slope|known", None, "nonlinear"),
)
