"""Witnesses for a run and its loop: what its error does, how the poles of both boards join, what an input or a stop changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from witnesses import LONGER, Shown, Witness, by_itself, matrices, near, rightmost, value, whole

from observer_lab.course.figures.records import LineFigure
from observer_lab.engine import simulate
from observer_lab.engine.simulation import Run, Scenario
from observer_lab.text import Text


def gone_on(run: Run) -> np.ndarray:
    """‖e‖ of the same scenario simulated for longer, from the end of this run on."""
    s: Scenario = run.scenario
    t = s.dt * np.arange(round(LONGER * s.horizon / s.dt) + 1)
    r = s.reference
    if isinstance(r, np.ndarray) and len(r) == s.n_t:
        r = np.concatenate([r, np.repeat(r[-1:], len(t) - len(r), axis=0)])
    longer = simulate(replace(s, horizon=float(t[-1]), reference=r))
    return np.linalg.norm(longer.e[len(run.t) - 1:], axis=1)


def _stays(shown: Shown, words: Text) -> None:
    run, after = shown.run, value(words, "small")
    size = np.linalg.norm(run.e, axis=1)
    small = 0.02 * float(size.max())
    assert float(np.max(size[run.t > after + 1e-9], initial=0.0)) <= small * (1 + 1e-9), "not even in the run"
    if run.scenario.V is None:
        later = gone_on(run)
        assert float(later.max()) <= small * (1 + 1e-6), f"later the error is {later.max() / size.max():.2g} of its peak"


def _caught(shown: Shown, _: Text) -> None:
    figure = shown.figure
    assert isinstance(figure, LineFigure)
    true, guess = (c.y for c in figure.curves[:2])
    tail = slice(-max(len(true) // 10, 1), None)
    assert float(np.max(np.abs(true[tail] - guess[tail]))) <= 1.001e-3 * float(np.max(np.abs(true))), "apart in the last tenth"
    if shown.lesson.id != "saturation":
        _, _, _, F, _ = matrices(shown.run)
        moved = float(np.max(np.abs(true[tail] - guess[tail])))
        dt = shown.run.scenario.plant.dt
        spread = float(np.max(np.abs(np.linalg.eigvals(F)))) - 1 if dt else rightmost(F)
        assert spread < 1e-9 or moved == 0, f"the error grows, {spread:.2g}"


def _apart(shown: Shown, words: Text) -> None:
    figure = shown.figure
    assert isinstance(figure, LineFigure)
    true, guess = (c.y for c in figure.curves[:2])
    tail = slice(-max(len(true) // 10, 1), None)
    near(value(words, "gap"), float(np.max(np.abs(true[tail] - guess[tail]))))


def _meter_zero(shown: Shown, _: Text) -> None:
    if shown.run.scenario.V is None:
        off = by_itself(shown.run)
        assert off < 1e-6, f"the error leaves A − LC by {off:.2g} of its peak"


def _meter_not_zero(shown: Shown, _: Text) -> None:
    if shown.run.scenario.V is None:
        off = by_itself(shown.run)
        assert off > 1e-10, "the error follows A − LC"


def _union(shown: Shown, _: Text) -> None:
    M = whole(shown.run)
    poles = np.concatenate([shown.outcome.poles["controller"], shown.outcome.poles["observer"]])
    size = float(np.max(np.abs(poles)))
    for s in size * np.exp(1j * np.linspace(0.1, 3.0, 7)) * 1.5:
        loop = np.linalg.slogdet(s * np.eye(len(M)) - M)
        ratio = loop[0] * np.exp(loop[1] - float(np.sum(np.log(np.abs(s - poles))))) / np.prod((s - poles) / np.abs(s - poles))
        assert abs(ratio - 1) < 1e-4, f"the polynomials differ by {abs(ratio - 1):.2g} at {s:.3g}"
    assert shown.run.scenario.delay == 0 and np.allclose(shown.run.u_asked, shown.run.u_applied), "late or clipped"


def _compensator(shown: Shown, _: Text) -> None:
    _, _, _, F, B = matrices(shown.run)
    assert rightmost(F - B @ shown.run.scenario.K) > -1e-9, "its poles are all on the left"


def _corner(shown: Shown, _: Text) -> None:
    A, B, C, F, Bm = matrices(shown.run)
    K, L = shown.run.scenario.K, shown.run.scenario.L
    assert K is not None and L is not None
    corner = A - L @ C - F - (B - Bm) @ K  # ė = … x + … e where the model is not the plant
    assert float(np.max(np.abs(corner))) < 1e-6 * float(np.max(np.abs(whole(shown.run)))), "the state drives the error"


def _isolates(sign: float) -> Witness:
    def witness(shown: Shown, words: Text) -> None:
        figure = shown.figure
        assert isinstance(figure, LineFigure)
        assert rightmost(whole(shown.run)) < 0, "the loop is unstable"
        bare, steered = (float(np.max(figure.curves[k].y)) for k in (0, 2))
        near(sign * value(words, "peak"), 20 * np.log10(bare / steered), 1e-3)
        assert sign * np.log(bare / steered) >= -1e-9
    return witness


def _obeys(clipped: bool) -> Witness:
    def witness(shown: Shown, words: Text) -> None:
        run, limit = shown.run, shown["u_max"]
        assert bool(np.any(np.abs(run.u_asked) > limit * (1 + 1e-9))) == clipped, "clipped, or not, otherwise than said"
        _meter_zero(shown, words)
    return witness


def _largest_input(shown: Shown, words: Text) -> None:
    figure = shown.figure
    assert isinstance(figure, LineFigure)
    near(value(words, "peak"), float(np.max(np.abs(figure.curves[0].y))), 1e-6) if len(figure.curves) == 1 else None


# --- single lessons -------------------------------------------------------------------------------------------------------
def _too(small: bool) -> Witness:
    def witness(shown: Shown, _: Text) -> None:
        F = matrices(shown.run)[3]
        trust = shown["trust"]
        model = shown.run.scenario.model
        assert model is not None
        assert rightmost(F) > 0, "the error dies out"
        if trust > 0:
            L = shown.outcome.gains["L"] / trust
            grid = np.linspace(trust, 2.0, 400) if small else np.linspace(0.0, trust, 400)
            assert min(rightmost(model.A - theta * L @ model.C) for theta in grid) < 0, "no other trust is better"
    return witness


def _no_trust(shown: Shown, _: Text) -> None:
    model = shown.run.scenario.model
    assert model is not None
    if shown["trust"] > 0:
        L = shown.outcome.gains["L"] / shown["trust"]
        best = min(rightmost(model.A - theta * L @ model.C) for theta in np.linspace(0.0, 2.0, 801))
        assert best > -1e-3, f"some trust gives {best:.3g}"


def _core_known(shown: Shown, words: Text) -> None:
    run = shown.run
    late = np.abs(run.e[run.t > value(words, "after") - 1e-9, 0])
    assert float(late.max()) < 1.0, "not in the run"
    assert rightmost(matrices(run)[3]) < 0, "the error grows"


def _not_driven(shown: Shown, words: Text) -> None:
    if shown["kick"] < 0:
        off = by_itself(shown.run) * float(np.max(np.abs(shown.run.e)))
        size = max(1.0, float(np.max(np.abs(shown.run.x))), float(np.max(np.abs(shown.run.xhat))))
        assert off < 1e-7 * size, f"the error leaves its own law by {off:.2g}"


def _driven(shown: Shown, words: Text) -> None:
    A, _, C, F, _ = matrices(shown.run)
    s = shown.run.scenario
    L, model = s.L, s.plant if s.model is None else s.model
    assert L is not None
    leak = max(float(np.max(np.abs(A - L @ C - F))), float(np.max(np.abs(s.plant.B - L @ s.plant.D - model.B + L @ model.D))))
    assert leak > 1e-9 or rightmost(F) > 0, "the observer copies the plant"


def _home(shown: Shown, _: Text) -> None:
    s = shown.outcome.study.shown.scenario
    A, B, C, F, Bm = matrices(shown.outcome.study.shown)
    loop = rightmost(np.block([[A, -B @ s.K], [s.L @ C, F - Bm @ s.K]]))
    assert loop < 0, f"its loop has a pole at {loop:.3g}: it leaves again"
    longer = simulate(replace(s, horizon=6 * s.horizon))
    assert longer.diverged_at is None and float(np.linalg.norm(longer.x[-1])) < 0.05, "it does not stay"


WITNESSES: Mapping[str, Witness] = {
    "The error stays below 2 % of its peak after {small:.2f} s.": _stays,
    "At the end of the run the estimate has caught up with the truth.": _caught,
    "In the last tenth of the run they differ by up to {gap:.2g} {unit}.": _apart,
    "Largest input applied: {peak:.3g} {input_unit}.": _largest_input,
    "Separation meter: 0.": lambda shown, words: None if shown.outcome.run is None else _meter_zero(shown, words),
    "Separation meter: {meter:.2g}; the error dynamics are no longer autonomous.": _meter_not_zero,
    "The {count} poles of the loop are the union of both boards to about {union_error}.": _union,
    "The compensator by itself is unstable.": _compensator,
    "Feedback of the estimate lowers the peak by {peak:.1f} dB; the gap to the dashed line is the observer's share.": _isolates(1),
    "Feedback of the estimate raises the peak by {peak:.1f} dB.": _isolates(-1),
    "The lower left block is zero: the error drives the state, never the other way round.": _meter_zero,
    "The lower left block of this matrix is zero.": _corner,
    "White is zero: the error drives the state, never the other way round.": _meter_zero,
    "The observer's error grows: L is too small for this chip.": _too(True),
    "The observer's error grows: L is too large for this chip.": _too(False),
    "The observer's error grows: no θ up to 2 is stable with these poles.": _no_trust,
    "No θ up to 2 is stable with these poles.": _no_trust,
    "The observer's error in the core is below 1 K after {after:.2f} s.": _core_known,
    "The input moves the state by up to {moved} and the error by {error_moved:.0e}, which is rounding.": _not_driven,
    "The input moves the state by up to {moved} and the error by up to {error_moved:.2g}: the input drives the error.": _driven,
    "The pole recovers.": _home,
    "Nothing is clipped, so the error follows ė = (A − LC)e.": _obeys(False),
    "So the error obeys A − LC, whichever input the observer gets.": _obeys(False),
    "The error obeys A − LC all the same.": _obeys(True),
    "The force is clipped, and the error still follows ė = (A − LC)e.": _obeys(True),
    "The error follows ė = (A − LC)e: the load enters it once, at {at:g} s, and it decays from there.": _meter_zero,
    "The load enters the error at {at:g} s and stays there: nothing in this observer takes it in.": _meter_zero,
}
