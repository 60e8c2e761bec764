"""Witnesses where noise decides or loops are assembled: whiteness, bands by scipy, faults against the design."""

from __future__ import annotations

import re

import numpy as np
from scipy.linalg import block_diag
from scipy.stats import chi2
from verdict_law import Judge, Said, Witness, witness
from verdict_runs import radius, size_of
from witnesses import read
from witnesses_of_noise import COILS, _read_by_geophones

from observer_lab.lessons.decoupling.loops import AXIS_POLE_RAD_S, lower_of, platform_of
from observer_lab.lessons.showdown.simulation import loop_of
from observer_lab.plants.platform.siso_loops import T_u, T_y

NUM = r"([−+-]?[\d.,]+(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?)"


# --- record ------------------------------------------------------------------------------------------------------------
def _nis(one: Said) -> tuple[float, float, float]:
    judged, gate = one.outcome.study.judged, one.outcome.design["gate"]
    values = judged.nis.values[np.isfinite(judged.nis.values)]
    count, p = len(values), one.outcome.study.found.record.y.shape[1]
    mean = float(np.mean(values))
    if gate != "off":  # what passes has the mean of χ² below its quantile
        mean *= float(gate) / float(chi2(p).expect(ub=float(chi2(p).ppf(float(gate)))))
    return mean, *(float(chi2.ppf(q, p * count) / count) for q in (0.025, 0.975))


def nis_says(one: Said, match: re.Match[str]) -> None:
    """Over and under need the χ² band of the mean; inside may use twice the band that counts the error of a fit to fewer rows."""
    mean, low, high = _nis(one)
    judged, slack = one.outcome.study.judged, 0.02 * mean
    wider = 2 * np.sqrt(1 + len(judged.nis.values) / max(judged.first, 1))
    if "over-confident" in one.words:
        assert mean > high - slack, f"{mean:.3g} of {low:.3g} to {high:.3g}"
    elif "under-confident" in one.words:
        assert mean < low + slack, f"{mean:.3g} of {low:.3g} to {high:.3g}"
    else:
        inside = 1 - wider * (1 - low) - slack <= mean <= 1 + wider * (high - 1) + slack
        assert inside, f"{mean:.3g} of {low:.3g} to {high:.3g}, {wider:.2g} times wider by the fit"


def white(one: Said, _: re.Match[str]) -> None:
    """Portmanteau of the whitened innovations: white about their mean at least, not white where a mean is left or some lag is not small.

    Between p = 1e-5 and 0.5 both answers pass: the page allows for the errors of the fit, this test does not.
    """
    judged = one.outcome.study.judged
    nu = judged.track.innovations[judged.first :]
    nu = nu[np.all(np.isfinite(nu), axis=1)]
    if len(nu) < 40:
        return
    centred, raw = (_portmanteau(each) for each in (nu - nu.mean(axis=0), nu))
    if ("not white" not in one.words) == one.true:
        assert centred > 1e-5, f"p = {centred:.2g}"
    else:
        assert min(centred, raw) < 0.5, f"p = {centred:.2g}, with their mean {raw:.2g}"


def _portmanteau(nu: np.ndarray) -> float:
    """p of all lags up to 20 of innovations (N, p), over their own covariance."""
    nu = nu @ np.linalg.inv(np.linalg.cholesky(np.cov(nu.T).reshape(nu.shape[1], -1))).T
    lags, N = min(20, len(nu) // 5), len(nu)
    q = N * N * sum(float(np.sum((nu[k:].T @ nu[:-k] / N) ** 2)) / (N - k) for k in range(1, lags + 1))
    return float(chi2.sf(q, lags * nu.shape[1] ** 2))


def fitted_model(one: Said) -> np.ndarray:
    """A of the fitted model: the bias of a sensor, a state of the filter alone, is no part of it."""
    fitted = one.outcome.study.found.fitted
    own = fitted.plant.n - fitted.biases
    return fitted.plant.A[:own, :own]


def fitted_unstable(one: Said, _: re.Match[str]) -> None:
    A = fitted_model(one)
    assert np.abs(np.linalg.eigvals(A)).max() > 1 - 1e-6, "it is stable"


def fitted_stable(one: Said, _: re.Match[str]) -> None:
    A = fitted_model(one)
    assert (np.abs(np.linalg.eigvals(A)).max() < 1) == one.true


def related(lags: range) -> Judge:
    """Cross-correlation of whitened innovations with the inputs that many rows earlier; in between both answers pass."""

    def judge(one: Said, _: re.Match[str]) -> None:
        judged, record = one.outcome.study.judged, one.outcome.study.found.record
        nu, u = judged.track.innovations[judged.first :], record.u[judged.first :]
        reach, N = max(map(abs, lags)), len(nu)
        rows = np.flatnonzero(np.all(np.isfinite(nu), axis=1))
        rows = rows[(rows >= reach) & (rows < N - reach)]
        if len(rows) < 40 or not u.shape[1]:
            return
        table = np.hstack([np.ones((len(rows), 1)), *(u[rows - lag] for lag in lags)])
        left = nu[rows] - table @ np.linalg.lstsq(table, nu[rows], rcond=None)[0]
        away = nu[rows] - nu[rows].mean(axis=0)
        share = 1 - (left**2).sum(axis=0) / (away**2).sum(axis=0)
        p = float(chi2.sf(len(rows) * share.max(), table.shape[1] - 1))
        said = one.true if "not depend" in one.words else not one.true
        assert p > 1e-7 if said else p < 0.7, f"p = {p:.2g}"
    return judge


def explains(one: Said, _: re.Match[str]) -> None:
    judged, record = one.outcome.study.judged, one.outcome.study.found.record
    nu, y = judged.track.innovations[judged.first :], record.y[judged.first :]
    rows = np.all(np.isfinite(nu), axis=1)
    away = y[rows] - y[rows].mean(axis=0)
    fit = float((1 - np.linalg.norm(nu[rows], axis=0) / np.linalg.norm(away, axis=0)).min())
    assert (fit >= 0.05) == (one.true if "a part" in one.words else not one.true)


# --- network -----------------------------------------------------------------------------------------------------------
def delayed(unstable: bool) -> Judge:
    """The loop of plant and the state of `delay` samples ago, or the one that is shown, by a run of 3000 samples."""

    def judge(one: Said, _: re.Match[str]) -> None:
        M = one.outcome.study.loop
        z, grown = np.ones(len(M)), 0.0
        for _k in range(3000):
            z = M @ z
            size = float(np.abs(z).max())
            grown += np.log(max(size, 1e-300))
            z /= max(size, 1e-300)
        rate = grown / 3000
        assert abs(rate) < 2e-3 or (rate > 0) == (unstable == one.true), f"ln of the radius {rate:.3g}"

    return judge


def bounded(one: Said, _: re.Match[str]) -> None:
    """The recursion for the mean with the gain that drops a measurement: bounded at p where p |λ|² < 1 for the largest λ."""
    plant = one.outcome.study.watched.sampled.plant
    p, r = float(one.outcome.design["loss"]), float(np.abs(np.linalg.eigvals(plant.A)).max())
    growth = p * r * r
    said = not re.search(r"diverges|without end|grows", one.words) and one.true
    assert abs(growth - 1) < 1e-3 or (growth < 1) == said or r < 1, f"p |λ|² = {growth:.3g}"


def autonomous(one: Said, _: re.Match[str]) -> None:
    """The error of the run beside that of an observer that gets the applied input, by the drawn curves' numbers."""
    assert (one.outcome.metrics["separation_meter"] < 1e-6) == one.true


# --- faults ------------------------------------------------------------------------------------------------------------
def _starts(one: Said) -> dict[str, int]:
    """The sample at which each part of the design fails: there may be two."""
    case = one.outcome.study.case
    return {fault.place: fault.start for fault in (case, case.also) if fault is not None and fault.place != "none"}


def names_right(right: bool) -> Judge:
    def judge(one: Said, match: re.Match[str]) -> None:
        starts, decided = _starts(one), one.outcome.study.verdict.decided
        assert (match[1] in starts and starts[match[1]] <= decided) == right, f"{starts} fail, decided at {decided}"
        if right and len(match.groups()) > 1:
            assert read(match[2]) >= 0, "before it failed"

    return judge


def nothing_named(one: Said, _: re.Match[str]) -> None:
    verdict = one.outcome.study.verdict
    assert (verdict.decided is None or not verdict.who) == one.true, f"{verdict.who} is diagnosed"


def right_part(one: Said, _: re.Match[str]) -> None:
    verdict, starts = one.outcome.study.verdict, _starts(one)
    named = verdict.who if verdict.decided is not None else None
    right = named in starts and starts[named] <= verdict.decided if starts else named is None
    assert right == one.true, f"{named} for {starts}"


# --- lqg, decoupling, weak states ----------------------------------------------------------------------------------------
def _lqg(one: Said, gain: float) -> np.ndarray:
    """The loop of Doyle's kind: the plant's input times `gain`, the filter's model without it."""
    study, K, L = one.outcome.study, one.outcome.gains["K"], one.outcome.gains["L"]
    p = study.case.plant
    A, B, C, D = p.A, p.B[:, : len(K)], p.C, np.asarray(p.D)[:, : len(K)]
    return np.block([[A, -gain * B @ K], [L @ C, A - B @ K - L @ C + L @ D @ K - gain * L @ D @ K]])


def lqg_stable(want: bool) -> Judge:
    def judge(one: Said, _: re.Match[str]) -> None:
        rate = radius(_lqg(one, float(one.outcome.study.setting.gain)), 0)
        assert abs(rate) < 1e-7 or (rate < 0) == (want == one.true), f"rightmost {rate:.3g}"

    return judge


def lqg_gains(one: Said, match: re.Match[str]) -> None:
    """Stable between the named gains of all inputs together, where there is one input."""
    if len(one.outcome.gains["K"]) == 1:
        low, high = (read(group) for group in match.groups() if group)
        for g in np.linspace(max(low, 0) + 0.01 * (1 - low), high - 0.01 * (high - 1) if np.isfinite(high) else 50, 7):
            M = _lqg(one, float(g))
            assert abs(g - 1) < 2e-3 or radius(M, 0) < 1e-6 * size_of(M), f"unstable at {g:.3g}"


def cut_loop(one: Said, match: re.Match[str]) -> None:
    study = one.outcome.study
    plant, k = study.system.plant, study.compared.small.design.controller
    B, C = plant.B[:, : k.C.shape[0]], plant.C
    M = np.block([[plant.A, B @ k.C], [k.B @ C, k.A]])
    assert radius(M, 0) > 0, "it is stable"


def decoupled_unstable(one: Said, _: re.Match[str]) -> None:
    class Here:
        outcome = one.outcome

        def __getitem__(self, knob: str):  # type: ignore[no-untyped-def]
            return one.outcome.design[knob]

    c, plant = one.outcome.study.controllers, _read_by_geophones(platform_of(lower_of(one.outcome.design)), Here())  # type: ignore[arg-type]
    parts, B = (c.vertical, c.rotation, c.horizontal), plant.B[:, :COILS] @ T_u @ one.outcome.gains["S"]
    closed = [part is not None and (k != 1 or bool(one.outcome.design["pitch"])) for k, part in enumerate(parts)]
    used = [(k, p) for k, (p, on) in enumerate(zip(parts, closed, strict=True)) if on]
    A = plant.A + sum((np.outer(B[:, k], T_y[k] @ plant.C) * float(np.asarray(p.D)[0, 0]) for k, p in used), np.zeros_like(plant.A))
    own = block_diag(*(p.A for _, p in used))
    push = np.hstack([np.outer(B[:, k], p.C[0]) for k, p in used])
    seen = np.vstack([np.outer(p.B[:, 0], T_y[k] @ plant.C) for k, p in used])
    poles = np.linalg.eigvals(np.block([[A, push], [seen, own]]))
    right = float(np.real(poles[np.abs(poles) >= AXIS_POLE_RAD_S]).max())
    assert right > -1e-6, f"rightmost {right:.3g}"


# --- showdown ----------------------------------------------------------------------------------------------------------
SHORT = ("none", "SISO", "LQE", "recursive", "decoupled")


def players_unstable(one: Said, match: re.Match[str]) -> None:
    """The named loops have a pole outside the unit circle, by the eigenvalues of their step without the bias; no other one has."""
    m, named = one.outcome.study, re.split(r",\s*", match[1])
    for name, player in zip(SHORT, m.five, strict=True):
        loop = loop_of(m.world, player)
        keep = np.setdiff1d(np.arange(loop.n), np.arange(loop.n)[loop.bias])
        step = loop.F[-1] + loop.F_m[-1] @ loop.Y + loop.F_s[-1] @ (loop.U[-1] + loop.T[-1] @ loop.Y)
        radius_ = float(np.abs(np.linalg.eigvals(step[np.ix_(keep, keep)])).max())
        assert abs(radius_ - 1) < 1e-6 or (radius_ > 1) == (name in named), f"{name}: radius {radius_:.7g}"


def least_named(one: Said, match: re.Match[str]) -> None:
    """The named players are within 1 % of the least drawn density's area; a limit or friction that acts is named first."""
    m, d = one.outcome.study, one.outcome.design
    acts = bool(d["limited"]) or float(dict(d.values).get("friction", 0) or 0) > 0
    assert not acts or d["ground"] != "shaped" or one.words.startswith("Predicted without"), "it leaves limit or friction out"
    if "RMS" in one.words:
        for j, channel in enumerate(
            re.findall(r"(?:velocity: |vertically, |in rotation, )(.*?)(?= vertically| in rotation| horizontally)", one.words)
        ):
            named = [SHORT.index(name) for name in re.split(r",\s*", channel)]
            least = float(np.min(m.rms[:, j]))
            assert all(m.rms[i, j] <= 1.011 * least for i in named), f"{channel}: {m.rms[:, j]}"
            assert all(m.rms[i, j] > 1.009 * least for i in range(5) if i not in named), f"others tie: {m.rms[:, j]}"


def least_raced(one: Said, match: re.Match[str]) -> None:
    """The named players are within 1 % of the least motion of the runs in each channel; NaN is a lost run."""
    rms = one.outcome.study.trials.raced.rms
    for j, names in enumerate(match.groups()):
        least = float(np.nanmin(rms[:, j]))
        assert {SHORT.index(name) for name in re.split(r",\s*", names)} == set(np.flatnonzero(rms[:, j] <= 1.01 * least)), rms[:, j]


ALL = tuple(
    witness(pattern, judge, *lessons)
    for lessons, rows in {
        ("record",): (
            (r"^Mean NIS", nis_says),
            (r"white", white),
            (r"fitted model is unstable", fitted_unstable),
            (r"fitted model is stable", fitted_stable),
            (r"depend on earlier inputs", related(range(0, 20))),
            (r"Later inputs are related|do not depend on the outputs", related(range(-5, 0))),
            (r"predictions explain|Predictions explain", explains),
            (r"input of its own row|An information criterion|Step [\d.]+ s", None),
            (r"NIS|consistent|confident|least", None),
        ),
        ("network",): (
            (r"the loop with its delay is stable", delayed(False)),
            (r"With this delay the loop is unstable", delayed(True)),
            (r"enough for a bounded mean", None),  # names a bound, claims nothing of this design
            (r"bounded|diverges|grows without end|without end", bounded),
            (r"error dynamics are autonomous", autonomous),
            (r"Growth|better stand-in|tolerated|decays|unstable|least|lost", None),
        ),
        ("fault-diagnosis",): (
            (rf"^(\w+) is correctly identified {NUM} s after", names_right(True)),
            (r"^(\w+) is diagnosed at .*wrongly", names_right(False)),
            (r"no fault is diagnosed", nothing_named),
            (r"the right part is diagnosed", right_part),
            (r"names no pair|diagnos|identified|detect|best|least|faulty|lose|lost|found|hidden|isolated|smallest", None),
        ),
        ("kalman",): ((r"[Oo]nce settled|white|best|least|consistent|confident|flag|found|settles|Known", None),),
        ("lqg",): (
            (r"^Unstable: this loop|^The loop is unstable|^An unstable loop costs", lqg_stable(False)),
            (r"^stable with the true gain m|^Stable up to", lqg_stable(True)),
            (rf"stays stable while the input's gain is between {NUM} and {NUM} times|^Gains from {NUM} to {NUM} keep", lqg_gains),
            (r"stable|unstable|least|optimal|best|[Oo]ptimal|tolerates|recover", None),
        ),
        ("decoupling",): ((r"[Tt]he loop is unstable", decoupled_unstable), (r"stable|unstable|worse|lost|least", None)),
        ("weak-states",): ((r"is unstable on the platform", cut_loop), (r"stable|unstable|least|largest|smallest|known|observable", None)),
        ("showdown",): (
            (r"^(?:Predicted without coil limit and friction: )?(?:Least RMS|Best by area)", least_named),
            (r"in runs with limit and friction: (.*) vertically, (.*) in rotation, (.*) horizontally", least_raced),
            (r"^(?:Predicted without coil limit and friction: )?Unstable with these settings: (.*)\.", players_unstable),
            (r"[Uu]nstable|stable|least|[Bb]est|[Rr]ecovered|lost|[Ss]ettle|noisier|better|optimal|white", None),
        ),
    }.items()
    for pattern, judge in rows
)
WITNESSES: tuple[Witness, ...] = ALL
