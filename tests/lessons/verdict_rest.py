"""Witnesses of lists of loops, of lost inputs, of delays that are tolerated, and of a diagnosis before the fault."""

from __future__ import annotations

import re
from functools import lru_cache

import numpy as np
from scipy.stats import chi2
from verdict_law import Said, Witness, witness
from verdict_noise import NUM, SHORT, _lqg
from verdict_runs import radius, size_of
from witnesses import read

from observer_lab.course.lesson import Outcome
from observer_lab.lessons import LESSONS
from observer_lab.lessons.fault_diagnosis.observer_bank import DT as FAULT_DT
from observer_lab.lessons.showdown.simulation import loop_of

PARTS = 96  # all-passes that stand for a delay


@lru_cache(maxsize=4)
def radii(outcome: Outcome) -> tuple[float, ...]:  # type: ignore[type-arg]
    """The spectral radius of the step of each of the five loops, without the bias."""
    m, found = outcome.study, []
    for player in m.five:
        loop = loop_of(m.world, player)
        keep = np.setdiff1d(np.arange(loop.n), np.arange(loop.n)[loop.bias])
        step = loop.F[-1] + loop.F_m[-1] @ loop.Y + loop.F_s[-1] @ (loop.U[-1] + loop.T[-1] @ loop.Y)
        found.append(float(np.abs(np.linalg.eigvals(step[np.ix_(keep, keep)])).max()))
    return tuple(found)


def every_loop(one: Said, _: re.Match[str]) -> None:
    largest = max(radii(one.outcome))
    assert abs(largest - 1) < 1e-6 or (largest < 1) == one.true, f"radius {largest:.7g}"


def list_of_loops(one: Said, _: re.Match[str]) -> None:
    """Where a list says that a loop is unstable, it is; where it gives a number, it is not."""
    for name, size in zip(SHORT, radii(one.outcome), strict=True):
        if (said := re.search(rf"\b{name} (\S+)", one.words)) and abs(size - 1) > 1e-6:
            assert (size > 1) == said[1].startswith("unstable"), f"{name}: radius {size:.7g}"


def _growth(one: Said) -> tuple[float, float]:
    """E‖x‖² per sample under lost inputs: held, and zero in their place, by the mean of z zᵀ over one sample."""
    w = one.outcome.study.watched.sampled
    A, B, K, p = w.plant.A, w.plant.B, w.K, float(one.outcome.design["loss_u"])
    n, m = B.shape
    closed = A - B @ K
    zero = (1 - p) * np.kron(closed, closed) + p * np.kron(A, A)
    got = np.block([[closed, np.zeros((n, m))], [-K, np.zeros((m, m))]])
    lost = np.block([[A, B], [np.zeros((m, n)), np.eye(m)]])
    held = (1 - p) * np.kron(got, got) + p * np.kron(lost, lost)
    return tuple(float(np.abs(np.linalg.eigvals(M)).max()) for M in (held, zero))  # type: ignore[return-value]


def stand_in(one: Said, match: re.Match[str]) -> None:
    held, zero = _growth(one)
    now = zero if one.outcome.design["lost"] == "zero" else held
    assert abs(now - read(match[1])) < 0.006 * now, f"{now:.4g}"
    better = held < zero if match[2] == "holding" else zero < held
    assert abs(held - zero) < 1e-6 * zero or better, f"held {held:.6g}, zero {zero:.6g}"


def bounded_up_to(one: Said, match: re.Match[str]) -> None:
    """The limit of losses is 1/max|λ|²."""
    limit = float(np.abs(np.linalg.eigvals(one.outcome.study.watched.sampled.plant.A)).max()) ** -2
    assert abs(read(match[1]) - limit) < 0.002 * limit, f"{limit:.4g}"


def no_difference(one: Said, _: re.Match[str]) -> None:
    held, zero = _growth(one)
    assert abs(held - zero) < 1e-9 * zero, f"held {held:.6g}, zero {zero:.6g}"


def _late(one: Said, delay: float) -> float:
    """The rightmost real part of the loop of one input, which arrives late through a chain of all-passes of first order.

    Of each v → 2 x − v with ẋ = r (v − x), r = 2 N / delay.
    """
    study, K, L = one.outcome.study, one.outcome.gains["K"], one.outcome.gains["L"]
    p = study.case.plant
    n, rate, N = p.n, 2 * PARTS / delay, PARTS
    gain = 1.0 if "gain of the model" in one.words else float(study.setting.gain)
    signs = (-1.0) ** np.arange(N + 1)
    before = np.array([[2 * signs[k - 1 - j] if j < k else 0.0 for j in range(N)] for k in range(N)])  # what part k gets of the x before it
    M = np.zeros((2 * n + N,) * 2)
    M[:n, :n], M[:n, 2 * n:] = p.A, gain * p.B[:, :1] * (2 * signs[N - 1 - np.arange(N)])
    M[:n, n:2 * n] = -signs[N] * gain * p.B[:, :1] @ K
    M[n:2 * n, :n], M[n:2 * n, n:2 * n] = L @ p.C, p.A - p.B[:, :1] @ K - L @ p.C
    M[2 * n:, n:2 * n], M[2 * n:, 2 * n:] = -rate * signs[:N, None] * K, rate * (before - np.eye(N))
    return radius(M, 0)


def delay_margin(one: Said, match: re.Match[str]) -> None:
    """Of a loop of one input: stable with a little less delay, unstable with a little more."""
    if len(one.outcome.gains["K"]) == 1 and not np.any(one.outcome.study.case.plant.D):
        delay = read(match[1])
        assert _late(one, 0.95 * delay) < 0 < _late(one, 1.05 * delay), "no edge there"


def breaks_easily(one: Said, _: re.Match[str]) -> None:
    """A loop of one input that a little error breaks is unstable somewhere between 0.6 and 1.7 times its gain, or nearly so."""
    if len(one.outcome.gains["K"]) == 1:
        worst = max(radius(_lqg(one, float(g)), 0) / size_of(_lqg(one, float(g))) for g in np.geomspace(0.5, 2.0, 41))
        assert worst > -0.05, f"rightmost {worst:.3g} of its size"


def not_early(one: Said, _: re.Match[str]) -> None:
    s = one.outcome.study
    early = s.verdict.decided is not None and s.case.place != "none" and s.verdict.decided < s.case.start
    assert early != one.true or s.case.place == "none", f"decided at {s.verdict.decided}, faulty from {s.case.start}"


def faulty_from(one: Said, match: re.Match[str]) -> None:
    """The reading of that sensor departs from its true value from then on, and not before."""
    case = one.outcome.study.case
    since = FAULT_DT * case.start
    assert match[1] == case.place and abs(read(match[2]) - since) < 0.051, f"{case.place} from {since:.4g} s"


def alone_quiet(one: Said, match: re.Match[str]) -> None:
    """At the moment of the figure's title the sums of the last residuals are above the χ² quantile in all members but that one."""
    shown, rho = one.outcome.design, one.outcome.study.record.residuals
    title = next(figure.title("en") for figure in LESSONS["fault-diagnosis"].figures(one.outcome) if figure.id == "bank")
    N, mean, last = int(shown["window"]), shown["statistic"] == "mean", round(read(title.split(" at ")[1].split()[0]) / FAULT_DT) + 1
    part = rho[max(last - N, 0):last]
    T = (part.sum(axis=0) ** 2).sum(axis=1) / N if mean else (part ** 2).sum(axis=(0, 2))
    above = chi2.isf(shown["rate"], 3 if mean else 3 * N) < T
    named = next(k for k, name in enumerate(("VL", "HL", "VR", "HR", "u1", "u2", "u3")) if name in match[1])
    assert [k for k in range(7) if not above[k]] == [named], f"quiet: {np.flatnonzero(~above)}"


WITNESSES: tuple[Witness, ...] = tuple(witness(pattern, judge, *lessons) for lessons, rows in {
    ("showdown",): (
        (r"^every loop is stable", every_loop),
        (r"(?:none|SISO|LQE|recursive|decoupled) (?:unstable|not in|[−+\d])", list_of_loops)),
    ("network",): (
        (rf"lost: {NUM}; (holding|zero) is the better stand-in there", stand_in),
        (r"with nothing lost there is no difference", no_difference),
        (r"bounded up to p\b.*?([\d.]+)", bounded_up_to)),
    ("record",): ((r"^With order \S+ the whiteness test", None),),  # a number without a verdict
    ("lqg",): (
        (rf"this input tolerates {NUM} s of delay", delay_margin),
        (r"little error of gain, phase or timing breaks", breaks_easily)),
    ("fault-diagnosis",): (
        (r"^no diagnosis before the fault", not_early),
        (r"^Only the observer that ignores (.+) stays below the threshold", alone_quiet),
        (rf"^(\w+) is faulty from {NUM} s on", faulty_from)),
}.items() for pattern, judge in rows)
