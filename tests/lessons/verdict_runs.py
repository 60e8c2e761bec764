"""Witnesses for what the captions of many lessons say: the error and the loop of a run, by matrices and a longer run written out here."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.linalg import expm
from verdict_law import Judge, Said, Witness, witness
from witnesses import read

from observer_lab.engine.simulation import Run, Scenario

TIMES_LONGER = 3


def scenario(one: Said) -> Scenario:
    """The scenario of the run on the screen."""
    assert one.outcome.run is not None
    return one.outcome.run.scenario


def loop_of(s: Scenario) -> np.ndarray:
    """The matrix of (x, x̂) of a loop without delay and limit."""
    A, B, C, D = s.plant.A, s.plant.B, s.plant.C, s.plant.D
    m = s.plant if s.model is None else s.model
    return np.block([[A, -B @ s.K], [s.L @ C, m.A - m.B @ s.K - s.L @ m.C - s.L @ (D - m.D) @ s.K]])


def late_loop(s: Scenario) -> np.ndarray:
    """The same with its delay as a chain of Padé's, of order 10 for each input."""
    M, n, m, tau = loop_of(s), s.plant.n, s.plant.m, s.delay
    if not tau:
        return M
    stages = 40  # each stage: u' of a Padé(1,1) piece of τ/stages, all-pass
    h, size = tau / stages, len(M)
    whole = np.zeros((size + m * stages, size + m * stages))
    whole[:size, :size] = M
    whole[:n, n:size] = 0.0
    gain = np.zeros((m, size))
    gain[:, n:] = -s.K
    # stage: q' = (2/h)(2 v − q), out = q − v with v its input
    source = np.hstack([gain, np.zeros((m, m * stages))])
    for k in range(stages):
        at = slice(size + m * k, size + m * (k + 1))
        whole[at] = 2 / h * 2 * source
        whole[at, at] -= 2 / h * np.eye(m)
        out = -source
        out[:, at] += np.eye(m)
        source = out
    whole[:n] += s.plant.B @ source
    return whole


def radius(M: np.ndarray, dt: float) -> float:
    """The rightmost eigenvalue, ln |z| where it is sampled."""
    poles = np.linalg.eigvals(M)
    return float(np.log(max(np.abs(poles).max(), 1e-300))) if dt else float(poles.real.max())


def size_of(M: np.ndarray) -> float:
    return max(float(np.abs(np.linalg.eigvals(M)).max()), 1e-12)


def error_matrix(s: Scenario) -> np.ndarray:
    m = s.plant if s.model is None else s.model
    return m.A - s.L @ m.C


@lru_cache(maxsize=16)
def longer(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """‖x‖ and ‖e‖ of the scenario for longer without noise, its inputs held over a part of a step where clipped or late."""
    s = run.scenario
    plant, model = s.plant, s.plant if s.model is None else s.model
    n, parts = plant.n, 1 if plant.dt or s.sampled else 5 if s.limited or s.delay else 1
    h = s.dt / parts
    x, estimate = s.x0.astype(float), s.xhat0.astype(float)
    r = s.reference if s.reference is not None else np.zeros(plant.m)
    held = np.atleast_2d(r) if np.ndim(r) == 2 else np.asarray(r)[None]
    kicks = {round(t / h): sum(jump for at, jump in s.impulses if at == t) for t, _ in s.impulses if t < s.horizon - s.dt}
    steps = (s.n_t - 1) * parts * TIMES_LONGER
    line = [np.zeros(plant.m)] * max(round(s.delay / h), 0)

    def flow(A: np.ndarray, B: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if plant.dt:
            return A, B
        M = expm(np.block([[A, B], [np.zeros((B.shape[1], A.shape[0] + B.shape[1]))]]) * h)
        return M[: len(A), : len(A)], M[: len(A), len(A) :]

    exact = not (s.limited or s.delay)
    corner, T = np.zeros((n, model.n)), np.kron([[1.0, 0.0], [1.0, -1.0]], np.eye(n))
    if exact:
        M = loop_of(s)
        into = np.vstack([plant.B, model.B + s.L @ (plant.D - model.D)])
        if model.n == n:  # (x, e): beside a state that grows the error keeps its digits
            M, into = (np.where(np.abs(each) < 1e-13 * np.abs(M).max(), 0.0, each) for each in (T @ M @ T, T @ into))
    else:  # u held over the small step
        M = np.block([[plant.A, corner], [s.L @ plant.C, model.A - s.L @ model.C]])
        into = np.block([[plant.B, np.zeros_like(plant.B)], [s.L @ plant.D, model.B - s.L @ model.D]])
    F, G = flow(M, into)
    z, states, by_error = np.concatenate([x, estimate]), [], exact and model.n == n
    if by_error:
        z = T @ z
        if not np.any(M[n:, :n]):
            F[n:, :n] = 0.0
    for k in range(steps + 1):
        if k in kicks:
            z[: 2 * n if by_error else n] += np.tile(kicks[k], 1 + by_error)
        if k % parts == 0:
            states.append(z.copy())
        ref = held[min(k // parts, len(held) - 1)]
        if exact:
            z = F @ z + G @ ref
        else:
            asked = ref - s.K @ (z[:n] if s.state_feedback else z[n:])
            given = np.clip(asked, s.u_min, s.u_max)
            seen = given if s.fed == "applied" else asked
            late = line.pop(0) if line else given
            if s.delay:
                line.append(given)
            z = F @ z + G @ np.concatenate([late, seen])
        if not np.all(np.abs(z) < 1e80):
            break
    Z = np.array(states)
    e = Z[:, :n] - Z[:, n:] if model.n == n and not by_error else Z[:, n:]
    return np.linalg.norm(Z[:, :n], axis=1), np.linalg.norm(e, axis=1)


def noisy(s: Scenario) -> bool:
    return s.V is not None or s.W is not None


def _does_not_stay(one: Said, _: re.Match[str]) -> None:
    run = one.outcome.run
    assert run is not None
    size = np.linalg.norm(run.e, axis=1)
    assert size[int(0.94 * len(size)):].max() > 0.019 * size.max(), "it does"


def _peak(run: Run) -> float:
    """The largest error of a run; a kick may be over before the next sample."""
    between = [run.e[np.searchsorted(run.t, at) - 1] + jump for at, jump in run.scenario.impulses if run.t[0] < at <= run.t[-1]]
    return max(float(np.linalg.norm(e)) for e in (*run.e, *between))


def _stays(one: Said, match: re.Match[str]) -> None:
    run, after = one.outcome.run, read(match[1])
    assert run is not None
    size = np.linalg.norm(run.e, axis=1)
    assert float(np.max(size[run.t > after + 0.011], initial=0.0)) <= 0.0201 * _peak(run), "not even in the run"
    if noisy(run.scenario):
        raise AssertionError("noise may lift it again")
    _, e = longer(run)
    late = e[round((after + 0.011) / run.scenario.dt) + 1 :]
    assert float(late.max()) <= 0.022 * float(e.max()), f"later it is {late.max() / e.max():.3g} of its peak"


def _below_so_far(one: Said, match: re.Match[str]) -> None:
    run, after = one.outcome.run, read(match[1])
    assert run is not None
    size = np.linalg.norm(run.e, axis=1)
    assert float(np.max(size[run.t > after + 0.011], initial=0.0)) <= 0.0201 * _peak(run), "not in the run"
    if "nothing keeps" in one.words:
        s = run.scenario
        free = not s.delay and (s.model is None or s.model is s.plant) and (s.fed == "applied" or not run.saturated)
        worst = max(radius(error_matrix(s), s.plant.dt), -1.0 if free or s.K is None else radius(late_loop(s), s.plant.dt))
        assert worst > -1e-6 * size_of(error_matrix(s)) or not np.any(s.K), f"its poles keep it there, {worst:.3g}"


def _not_below(one: Said, _: re.Match[str]) -> None:
    run = one.outcome.run
    assert run is not None
    size = np.linalg.norm(run.e, axis=1)
    assert float(size[-max(len(size) // 20, 2) :].max()) >= 0.019 * float(size.max()), "it is below"


def _error_grows(one: Said, _: re.Match[str]) -> None:
    s = scenario(one)
    F = error_matrix(s)
    if "loop is unstable" in one.words:
        assert radius(late_loop(s), s.plant.dt) > 0, "the loop is stable"
    else:
        assert radius(F, s.plant.dt) > -1e-9 * size_of(F), f"all its poles are inside, {radius(F, s.plant.dt):.3g}"


def _error_rests(one: Said, _: re.Match[str]) -> None:
    s = scenario(one)
    F = error_matrix(s)
    assert abs(radius(F, s.plant.dt)) < 1e-6 * size_of(F), f"{radius(F, s.plant.dt):.3g}"


def _zero(one: Said, _: re.Match[str]) -> None:
    run = one.outcome.run
    assert run is not None
    assert float(np.abs(run.x - run.xhat).max()) <= 1e-9 * max(float(np.abs(run.x).max()), float(np.abs(run.xhat).max()), 1e-12), "not zero"


def stable(matrix: Callable[[Said], tuple[np.ndarray, float]], want: bool) -> Judge:
    """A judge of "stable" (`want`) or "unstable" by the eigenvalues of a matrix built here; within rounding of the edge both hold."""

    def judge(one: Said, _: re.Match[str]) -> None:
        M, dt = matrix(one)
        rate = radius(M, dt)
        if abs(rate) > 1e-7 * (1.0 if dt else size_of(M)):
            assert (rate < 0) == (want == one.true), f"rightmost {rate:.4g}"

    return judge


def whole_loop(one: Said) -> tuple[np.ndarray, float]:
    s = scenario(one)
    return late_loop(s), s.plant.dt


def observer(one: Said) -> tuple[np.ndarray, float]:
    s = scenario(one)
    return error_matrix(s), s.plant.dt


def compensator(one: Said) -> tuple[np.ndarray, float]:
    s = scenario(one)
    m = s.plant if s.model is None else s.model
    return m.A - m.B @ s.K - s.L @ m.C + s.L @ m.D @ s.K, s.plant.dt


def controller(one: Said) -> tuple[np.ndarray, float]:
    s = scenario(one)
    return s.plant.A - s.plant.B @ s.K, s.plant.dt


def unstable_side(one: Said, match: re.Match[str]) -> None:
    """ "A controller pole …", "An observer pole …" and "A pole is not in the left half plane"."""
    worst = [radius(*each(one)) for each in (controller, observer)]
    named = [worst[0]] if match[0].startswith("A controller") else [worst[1]] if match[0].startswith("An observer") else worst
    if one.lesson.id == "separation" and one.outcome.design["integral"] and not match[0].startswith("An observer"):
        named = [*named, radius(*whole_loop(one))]  # K of the plant alone leaves out the integrator's pole
    assert max(named) > -1e-9 * size_of(controller(one)[0]), f"all are left: {named}"


WITNESSES: tuple[Witness, ...] = tuple(
    witness(pattern, judge)
    for pattern, judge in (
        (r"The error stays below 2 % of its peak after ([^ ]+) s\.", _stays),
        (r"The error does not stay below 2 % of its peak in this run", _does_not_stay),
        (r"From ([^ ]+) s to the end of this run the error is below 2 % of its peak", _below_so_far),
        (r"In the last twentieth of this run the error exceeds", _not_below),
        (r"^The error grows", _error_grows),
        (r"^The error does not decay: an observer pole is on", _error_rests),
        (r"The error is zero to rounding", _zero),
        (r"^(?:A controller|An observer|A) pole is not in the left half plane", unstable_side),
    )
)
SOME: tuple[Witness, ...] = (
    witness(r"^The loop is unstable\.", stable(whole_loop, False), "separation", "saturation", "error-dynamics"),
    witness(r"compensator (?:by )?itself is unstable|The compensator by itself is unstable", stable(compensator, False)),
    witness(r"compensator (?:itself is stable|stable by itself|is stable by itself)", stable(compensator, True)),
)
