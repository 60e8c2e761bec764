"""Witnesses for lesson 7: the limited loop by scipy's integrator, followed until it is at rest or past all return."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.integrate import solve_ivp
from verdict_law import Said, Witness, witness
from witnesses import by_itself

from observer_lab.course.lesson import Outcome
from observer_lab.engine.simulation import Scenario

FALLEN = np.radians(45.0)
SMALL, LARGE = 1e-6, 1e4  # of the largest start: at rest below the one, gone beyond the other
AT_REST = 1e-9  # of it, in a loop with a pole on the right
BEYOND = 1e50  # of the largest start: an estimate gone so far does not come back
LONGEST_S = 600.0


@dataclass(frozen=True)
class Told:
    """How a limited loop ends: at rest, fallen (past 45° at a time) or gone beyond all return; None of these where it is not clear."""

    rest: bool
    fell: float
    gone: bool
    clipped: bool

    @property
    def clear(self) -> bool:
        return self.rest or self.gone or np.isfinite(self.fell)


def told_of(s: Scenario, angle: int | None, known: bool) -> Told:
    """The loop of a scenario from its start, with x known or with its estimate."""
    A, B, C = s.plant.A, s.plant.B, s.plant.C
    K, L, n = s.K, s.L, s.plant.n
    low, high = s.u_min, s.u_max

    def slope(_: float, z: np.ndarray) -> np.ndarray:
        x, estimate = z[:n], z[n:]
        asked = -K @ (x if known else estimate)
        given = np.clip(asked, low, high)
        seen = given if s.fed == "applied" else asked
        return np.concatenate([A @ x + B @ given, A @ estimate + B @ seen + L @ C @ (x - estimate)])

    z = np.concatenate([s.x0, s.xhat0])
    size = float(max(np.abs(s.x0).max(), np.abs(s.x0 - s.xhat0).max(), *(np.abs(j).max() for _, j in s.impulses), 1e-9))
    events = []
    if angle is not None:

        def falls(_: float, z: np.ndarray) -> float:
            return float(np.abs(z[angle]) - FALLEN)

        falls.terminal, falls.direction = True, 1  # type: ignore[attr-defined]
        events.append(falls)

    def far(_: float, z: np.ndarray) -> float:
        return float(np.abs(z[:n]).max() - LARGE * size)

    far.terminal = True  # type: ignore[attr-defined]
    events.append(far)
    jumps = sorted(s.impulses, key=lambda impulse: impulse[0])
    slowest = max((1 / abs(p.real) for M in (A - B @ K, A - L @ C) for p in np.linalg.eigvals(M) if abs(p.real) > 1e-9), default=1.0)
    begin, clipped = 0.0, False
    unstable = max(float(np.linalg.eigvals(M).real.max()) for M in (A - B @ K, A - B @ K if known else A - L @ C)) > 1e-9
    last = max(LONGEST_S, s.horizon + 80 * slowest)
    ends = [t for t, _ in jumps] + [last, *(s.horizon * 2.0**k for k in range(int(np.log2(last / s.horizon)) + 1))]
    kicks = {t: sum(jump for at, jump in jumps if at == t) for t, _ in jumps}
    for end in sorted(set(ends)):
        if end > begin:
            run = solve_ivp(slope, (begin, end), z, method="LSODA", rtol=1e-8, atol=1e-10 * size, events=events, max_step=0.05 * s.horizon)
            asked = -K @ (run.y[:n] if known else run.y[n:])
            clipped |= bool(np.any((asked > high[:, None] * (1 + 1e-7)) | (asked < low[:, None] * (1 + 1e-7))))
            z, begin = run.y[:, -1], end
            if run.status != 1 and not np.all(np.isfinite(z)):  # an estimate has left every number, or the integrator has failed
                finite = run.y[:, np.all(np.isfinite(run.y), axis=0)]
                return Told(False, np.inf, bool(np.abs(finite[:, -1]).max() > BEYOND * size), clipped)
            if run.status == 1:
                fell = angle is not None and len(run.t_events[0]) > 0
                return Told(False, float(run.t[-1]) if fell else np.inf, not fell, clipped)
        if end in kicks:
            z[:n] = z[:n] + kicks[end]
        elif begin >= s.horizon and float(np.abs(z[:n] if known else z).max()) < (AT_REST if unstable else SMALL) * size:
            asked = -K @ (z[:n] if known else z[n:])
            if not unstable or not np.any(z) or bool(np.all((asked > low) & (asked < high))):  # a small limit holds a loop close to rest
                return Told(True, np.inf, False, clipped)
    return Told(False, np.inf, unstable, clipped)  # an unstable loop that has not come to rest never does


@lru_cache(maxsize=8)
def _told(outcome: Outcome, known: bool) -> Told:  # type: ignore[type-arg]
    assert outcome.run is not None
    return told_of(outcome.run.scenario, 1 if outcome.design.lesson == "saturation" and not outcome.design.plant else None, known)


def _ends(recovers: bool, known: bool = False):  # type: ignore[no-untyped-def]
    def judge(one: Said, _: re.Match[str]) -> None:
        told = _told(one.outcome, known)
        said = recovers == one.true
        assert told.clear, f"it neither rests nor leaves within {LONGEST_S:g} s"
        assert told.rest == said, f"{told}"

    return judge


def _falls(one: Said, match: re.Match[str]) -> None:
    told = _told(one.outcome, False)
    assert abs(float(match[1]) - told.fell) < 0.035, f"it falls at {told.fell:.3g} s"


def _open(one: Said, _: re.Match[str]) -> None:
    """Not decided is always true; its share is counted."""


def error_law(kept: bool):  # type: ignore[no-untyped-def]
    """Whether the run's error is e^{(A − LC)t} e(0), anew after each kick."""

    def judge(one: Said, _: re.Match[str]) -> None:
        run = one.outcome.run
        assert run is not None
        if kept == one.true:
            off = by_itself(run)
            assert off < 1e-6, f"the error leaves A − LC by {off:.2g} of its peak"
        else:  # beside its size so far: an error that grows later hides nothing
            off = by_itself(run, so_far=True)
            assert off > 1e-11, f"the error leaves A − LC by {off:.2g} of its size so far"

    return judge


def _windup(one: Said, _: re.Match[str]) -> None:
    s = one.outcome.run.scenario  # type: ignore[union-attr]
    A, B, C, K, L = s.plant.A, s.plant.B, s.plant.C, s.K, s.L
    M = A - L @ C if s.fed == "applied" else A - B @ K - L @ C + L @ s.plant.D @ K
    assert bool(np.all(np.linalg.eigvals(M).real < 1e-9)) == one.true, str(np.linalg.eigvals(M))


def _loop_unstable(one: Said, _: re.Match[str]) -> None:
    s = one.outcome.run.scenario  # type: ignore[union-attr]
    worst = max(float(np.linalg.eigvals(M).real.max()) for M in (s.plant.A - s.plant.B @ s.K, s.plant.A - s.L @ s.plant.C))
    assert worst > -1e-9, f"all poles are left, {worst:.3g}"


WITNESSES: tuple[Witness, ...] = tuple(
    witness(pattern, judge, "saturation")
    for pattern, judge in (
        (r"^(?:The pole|This start) recovers[.;]|^this start recovers$", _ends(True)),
        (r"^(?:The pole|This start) does not recover", _ends(False)),
        (r"With x known, the same start recovers\.", _ends(True, known=True)),
        (
            r"Even with x known, (?:the pole falls from this start|this start does not recover)\.|lost even with x known",
            _ends(False, known=True),
        ),
        (r"with x known the pole recovers, with the estimate", lambda one, m: (_ends(True, known=True)(one, m), _ends(False)(one, m))[0]),
        (
            r"^The pole falls: past 45° at ([\d.]+) s|^Fallen after ([\d.]+) s",
            lambda one, m: _falls(one, re.search(r"(?:at|after) ([\d.]+) s", m[0])),
        ),
        (r"^The pole is lost after ([\d.]+) s", _falls),
        (r"^It recovers (?:with|and asks)", _ends(True)),
        (r"not decided|does not decide", _open),
        (r"obeys A − LC|still follows ė|error follows ė|error dynamics are autonomous", error_law(True)),
        (r"error departs from|leaves its law|does not obey", error_law(False)),
        (r"compensator is stable while", _windup),
        (r"not in the left half plane", _loop_unstable),
    )
)
