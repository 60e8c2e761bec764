"""Compute a design of lesson 14: runs under three filters and their verdicts."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Check, Design, Formula, Outcome, Stage
from observer_lab.engine import chi2_band
from observer_lab.plants.bodies import falling_body
from observer_lab.plants.bodies.front_bars import share_of_decades
from observer_lab.text import Text, listed, same, text

from ..toolkit.latex import number
from .cases import EKF, FALL_CASE, KF, PENDULUM_CASE, PLATFORM, TEST_DECADES, UKF, judged
from .knobs import TESTS
from .runs import FILTERS, Study, draft


@lru_cache(maxsize=16)
def band_of(dof: int, runs: int) -> tuple[float, float]:
    """Where the mean of `runs` values lies with 95 %."""
    return chi2_band(dof, count=runs)


CONSISTENT, NEARLY_CONSISTENT = text("consistent"), text("nearly consistent")
INSIDE_SHARE = 0.75  # of the samples in the band of 95 %: without process noise all samples of a run err together
BY_CHANCE = 1e-4  # how likely the largest of all samples of a consistent filter is beyond its limit
LATE = 2 / 3  # of the run: when errors are judged
NEARLY = 0.15  # of the expected mean: so far off a filter is still called nearly consistent


def verdict(values: np.ndarray, dof: int, runs: int) -> Text:
    """What a record of means says of a filter.

    Consistent is a filter whose NEES lies in the band in INSIDE_SHARE of the samples at least.
    """
    low, high = band_of(dof, runs)
    if np.mean(values[len(values) // 2:] > 1.1 * high) > 0.35:
        return text("overconfident")
    if np.max(values) > max(1.3 * high, chi2_band(dof, count=runs, level=1 - 2 * BY_CHANCE / len(values))[1]):
        return text("overconfident at times")
    if np.mean((values >= low) & (values <= high)) >= INSIDE_SHARE:
        return CONSISTENT
    mean = float(np.mean(values)) / dof
    if abs(mean - 1) <= NEARLY:
        return NEARLY_CONSISTENT
    return text("overconfident") if mean > 1 else text("under-confident")


def compute(design: Design) -> Outcome[Study]:
    """A few runs of the case, watched by three filters."""
    return outcome_of(design, draft(design))


def outcome_of(design: Design, study: Study) -> Outcome[Study]:
    """What a study shows."""
    who = design["filter"]
    metrics = LazyMap(lambda: _metrics(study))
    stage = _stage(study, who, design["bars"] == TESTS)
    return Outcome(design, {}, {}, metrics, LazySequence(lambda: _checks(study, metrics)), None, (), stage,
                   LazySequence(lambda: _formulas(design, study)), LazyValue(lambda: _live(design, study)), study)


def _bars(s: Study, who: str, tested: bool) -> np.ndarray:
    """Shares (n_t, 2) of the bars: mean NEES per state and mean NIS per reading, or the error that the filter states and the RMS error."""
    if tested:
        means = np.mean(s.nees[who]) / s.x.shape[1], np.mean(s.nis[who]) / len(s.case.R)
        return np.tile(share_of_decades(np.array(means), *TEST_DECADES), (len(s.t), 1))
    signal = s.case.watched[judged(s.case)]
    stated = np.sqrt(np.square(s.sigmas[who]) @ np.square(signal.weights))
    return share_of_decades(signal.scale * np.column_stack([stated, s.rms[who][:, judged(s.case)]]), *s.case.decades)


def _stage(s: Study, who: str, tested: bool) -> Stage:
    """One run behind two bars; the altitude's ±3σ is a band, else a ball."""
    case, bars = s.case, _bars(s, who, tested)
    sigma, away = s.sigmas[who][:, case.state], np.clip(s.means[who] - s.x, -1e9, 1e9)
    body = case.tested if tested else case.barred
    if case.id == FALL_CASE:
        tangent = {KF: np.full(len(s.t), case.guess[0]), EKF: np.clip(s.x[:, 0] + falling_body.ERROR_GAIN * away[:, 0], 0.0, None)}
        shown = away[:, 0], 3 * sigma, tangent.get(who, np.full(len(s.t), -1.0))
        x, xhat = (np.column_stack([s.x, *shown, np.full(len(s.t), ghostly), bars]) for ghostly in (0.0, 1.0))
        return _smooth(Stage(body, s.t, x, xhat))
    x, xhat = (np.column_stack([states, bars]) for states in (s.x, s.x + away))
    u = s.u if s.u.shape[1] else np.zeros((len(s.t), 1))
    return Stage(body, s.t, x, xhat, u, 3 * case.scale * sigma)


def _smooth(stage: Stage) -> Stage:
    """A sample a second is too coarse to watch: straight lines between."""
    t = np.linspace(0.0, float(stage.t[-1]), 10 * (len(stage.t) - 1) + 1)

    def fine(values: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(t, stage.t, column) for column in values.T], axis=1)

    assert stage.xhat is not None
    return Stage(stage.body, t, fine(stage.x), fine(stage.xhat))


def _metrics(s: Study) -> dict[str, float]:
    found = {f"nees_{n}": s.ratio(n) for n in FILTERS}
    found |= {f"nis_{n}": float(min(np.mean(s.nis[n]) / len(s.case.R), 1e9)) for n in FILTERS}
    found |= {f"largest_{n}": float(np.max(s.nees[n])) for n in FILTERS}
    found |= {f"apart_{n}": float(min(s.apart[n], 1e9)) for n in (EKF, UKF)}
    found |= {f"lost_{n}": float(s.lost[n]) for n in FILTERS}
    found |= {f"times_bound_{n}": float(min(s.bound.times[n], 1e9)) for n in FILTERS if s.bound.times[n] >= 0}
    at, signal = round(LATE * (len(s.t) - 1)), s.case.watched[judged(s.case)]
    found |= {f"late_rms_{n}": float(min(signal.scale * s.rms[n][at, judged(s.case)], 1e9)) for n in FILTERS}
    return found | {"runs": float(s.runs), "fallen": float(s.fallen), "horizon": float(s.t[-1])}


def _checks(s: Study, m: Mapping[str, float]) -> tuple[Check, ...]:
    n = s.x.shape[1]

    def held(name: str) -> bool:
        return verdict(s.nees[name], n, s.runs) in (CONSISTENT, NEARLY_CONSISTENT)

    return (
        *(Check(f"{f}_consistent", text("{f}: NEES in its band", f=f.upper()), held(f), m[f"nees_{f}"], informative=True)
          for f in FILTERS),
        Check("same", text("EKF and UKF are the KF, to rounding"),
              max(m["apart_ekf"], m["apart_ukf"]) < 1e-6, max(m["apart_ekf"], m["apart_ukf"]), informative=True),
    )


def _formulas(design: Design, s: Study) -> tuple[Formula, ...]:
    n = s.x.shape[1]
    reach = design["alpha"]**2 * (n + design["kappa"])
    first = 1 - n / reach
    law = {
        PLATFORM: rf"F_k = k e\,(1 + {number(design['hardening'])}\,(e/\ell)^2)",
        PENDULUM_CASE: r"\ell\ddot\theta = g\sin\theta - \ddot p\cos\theta",
        FALL_CASE: r"\dot v = -e^{-\kappa h} v^2 \beta, \quad y = \sqrt{M^2 + (h - H)^2}",
    }[design["case"]]
    out = [Formula("law", law),
           Formula("weights", rf"W_0^m = {number(first)}, \quad W_0^c = {number(first + 1 - design['alpha']**2 + design['beta'])}, \quad "
                   rf"W_i = {number(0.5 / reach)}", text("of {n} points", n=2 * n + 1)),
           Formula("nees", rf"\mathrm{{NEES}} / {n} = {number(s.ratio(KF))},\; {number(s.ratio(EKF))},\; {number(s.ratio(UKF))}",
                   same("KF, EKF, UKF"))]
    if design["case"] == PLATFORM:
        out.insert(1, Formula("coil", rf"F_u = u\, e^{{-{number(design['weakening'])}\, d/\ell}}, \quad \ell = 5\,\mathrm{{mm}}"))
    return tuple(out)


def _live(design: Design, s: Study) -> Text:
    n = s.x.shape[1]
    who = design["filter"]
    words = verdict(s.nees[who], n, s.runs)
    each = listed(text("{name} {ratio:.3g}", name=f.upper(), ratio=s.ratio(f)) for f in FILTERS)
    return text("NEES per state over {runs} runs (1 expected): {each}. In these runs the {who} is {words}.", runs=s.runs, each=each,
                who=who.upper(), words=words)
