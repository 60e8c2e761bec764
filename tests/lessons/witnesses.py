"""Who can say whether a shown sentence is true: computations that do not use what the lesson used.

`WITNESSES` has one for each message that is tried; it gets what is shown and the message, and fails with what is the case.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import expm, solve_continuous_are, solve_continuous_lyapunov

from app.engine import simulate
from app.engine.simulation import Run, Scenario
from app.lesson.figures import Figure, LineFigure
from app.lesson.lesson import Lesson, Outcome
from app.plants.bilinear import PRINTED_FORM
from app.text import Text
from lessons.noise.knobs import PLANT as BLOCK
from lessons.robust_observer.study import errors

LONGER = 3.0  # times the horizon: a claim about what is to come is tried there


@dataclass(frozen=True)
class Shown:
    """A sentence where it stands: in which figure, None for the live sentence, of which outcome."""

    lesson: Lesson
    outcome: Outcome
    figure: Figure | None

    @property
    def run(self) -> Run:
        run = self.outcome.run
        assert run is not None
        return run

    def __getitem__(self, knob: str) -> Any:
        return self.outcome.design[knob]


def value(words: Text, name: str) -> float:
    """A number that stands in a message."""
    found = dict(words.values)[name]
    return float(str(found).replace("−", "-").split()[0]) if not isinstance(found, (int, float)) else float(found)


# --- the run and what its matrices say ----------------------------------------------------------------------------------
def matrices(run: Run) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A, B, C of the plant, and A − LC, B of what the observer believes."""
    s = run.scenario
    model = s.plant if s.model is None else s.model
    L = np.zeros((s.plant.n, s.plant.p)) if s.L is None else s.L
    return s.plant.A, s.plant.B, s.plant.C, model.A - L @ model.C, model.B


def rightmost(M: np.ndarray) -> float:
    return float(np.max(np.real(np.linalg.eigvals(M))))


def gone_on(run: Run) -> np.ndarray:
    """‖e‖ of the same scenario simulated for longer, from the end of this run on."""
    s: Scenario = run.scenario
    t = s.dt * np.arange(round(LONGER * s.horizon / s.dt) + 1)
    r = s.reference
    if isinstance(r, np.ndarray) and len(r) == s.n_t:
        r = np.concatenate([r, np.repeat(r[-1:], len(t) - len(r), axis=0)])
    longer = simulate(replace(s, horizon=float(t[-1]), reference=r))
    return np.linalg.norm(longer.e[len(run.t) - 1:], axis=1)


def by_itself(run: Run) -> float:
    """How far the run's error leaves e^{(A − LC)t} e(0), over its own peak; kicks start it anew."""
    A, _, _, F, _ = matrices(run)
    jumps = {round(t / run.scenario.dt): jump for t, jump in run.scenario.impulses}
    step = expm((F if A.shape == F.shape else A) * (run.t[1] - run.t[0]))
    e, off = run.e[0], 0.0
    for k in range(1, len(run.t)):
        e = step @ e
        if k in jumps or k - 1 in jumps:
            e = run.e[k]
        off = max(off, float(np.max(np.abs(e - run.e[k]))))
    return off / max(float(np.max(np.abs(run.e))), 1e-12)


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


def near(said: float, true: float, relative: float = 1e-6) -> None:
    assert abs(said - true) <= relative * max(abs(true), abs(said)) + 1e-12, f"says {said:.6g}, is {true:.6g}"


def _meter_zero(shown: Shown, _: Text) -> None:
    if shown.run.scenario.V is None:
        off = by_itself(shown.run)
        assert off < 1e-6, f"the error leaves A − LC by {off:.2g} of its peak"


def _meter_not_zero(shown: Shown, _: Text) -> None:
    if shown.run.scenario.V is None:
        off = by_itself(shown.run)
        assert off > 1e-10, "the error follows A − LC"


def whole(run: Run) -> np.ndarray:
    """The matrix of (x, x̂)."""
    A, B, C, F, Bm = matrices(run)
    K, L = run.scenario.K, run.scenario.L
    return np.block([[A, -B @ K], [L @ C, F - Bm @ K]])


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


def _isolates(sign: float) -> Callable[[Shown, Text], None]:
    def witness(shown: Shown, words: Text) -> None:
        figure = shown.figure
        assert isinstance(figure, LineFigure)
        assert rightmost(whole(shown.run)) < 0, "the loop is unstable"
        bare, steered = (float(np.max(figure.curves[k].y)) for k in (0, 2))
        near(sign * value(words, "peak"), 20 * np.log10(bare / steered), 1e-3)
        assert sign * np.log(bare / steered) >= -1e-9
    return witness


# --- single lessons -------------------------------------------------------------------------------------------------------
def _too(small: bool) -> Callable[[Shown, Text], None]:
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
    L = shown.run.scenario.L
    assert L is not None
    assert float(np.max(np.abs(A - L @ C - F))) > 1e-9 or rightmost(F) > 0, "the observer copies the plant"


def _home(shown: Shown, _: Text) -> None:
    s = shown.outcome.study.shown.scenario
    A, B, C, F, Bm = matrices(shown.outcome.study.shown)
    loop = rightmost(np.block([[A, -B @ s.K], [s.L @ C, F - Bm @ s.K]]))
    assert loop < 0, f"its loop has a pole at {loop:.3g}: it leaves again"
    longer = simulate(replace(s, horizon=2 * s.horizon))
    assert longer.diverged_at is None and float(np.linalg.norm(longer.x[-1])) < 0.05, "it does not stay"


def variance(poles: np.ndarray, W: float, V: float) -> np.ndarray:
    """Variances of the error of the observer with these poles on the block, by coefficients and scipy's Lyapunov equation."""
    A, B, C = BLOCK.A, BLOCK.B, BLOCK.C
    O, last = np.vstack([C, C @ A]), np.array([[0.0], [1.0]])
    a1, a0 = -float(np.real(np.sum(poles))), float(np.real(np.prod(poles)))
    L = (A @ A + a1 * A + a0 * np.eye(2)) @ np.linalg.solve(O, last)
    return np.diag(solve_continuous_lyapunov(A - L @ C, -(W * B @ B.T + V * L @ L.T)))


def _least(W: float, V: float) -> np.ndarray:
    return np.diag(solve_continuous_are(BLOCK.A.T, BLOCK.C.T, W * BLOCK.B @ BLOCK.B.T, np.array([[V]])))


def _as_small(shown: Shown, _: Text) -> None:
    i, W, V = int(shown["watch"] == "velocity"), shown["w"], shown["v"]
    now = variance(shown.outcome.poles["observer"], W, V)[i]
    assert now < 1.011 * _least(W, V)[i], f"{np.sqrt(now / _least(W, V)[i]):.4g} times the least"


def _times(shown: Shown, words: Text) -> None:
    i, W, V = int(shown["watch"] == "velocity"), shown["w"], shown["v"]
    near(value(words, "ratio"), float(np.sqrt(variance(shown.outcome.poles["observer"], W, V)[i] / _least(W, V)[i])), 1e-4)


def _other_speed(*better: float) -> Callable[[Shown, Text], None]:
    def witness(shown: Shown, _: Text) -> None:
        i, W, V = int(shown["watch"] == "velocity"), shown["w"], shown["v"]
        poles = shown.outcome.poles["observer"]
        now = variance(poles, W, V)[i]
        for factor in better:
            assert variance(factor * poles, W, V)[i] < now, f"{factor} times the speed is not better"
        if not better:
            best = min(variance(f * poles, W, V)[i] for f in (0.7, 0.85, 1.18, 1.4))
            assert best > now * (1 - 1.01e-2), f"another speed has {np.sqrt(best / now):.4g} times the error"
    return witness


def _never_below_one(shown: Shown, _: Text) -> None:
    figure = shown.figure
    assert isinstance(figure, LineFigure)
    least = float(np.min(figure.curves[0].y))
    assert least > 1 - 1e-6, f"LQR comes down to {least:.6g}"


def _bounded(stays: bool) -> Callable[[Shown, Text], None]:
    def witness(shown: Shown, _: Text) -> None:
        s = shown.outcome.study.watched.sampled
        S, growth = np.eye(s.plant.n), 0.0
        for _k in range(400):
            S = shown["loss"] * s.plant.A @ S @ s.plant.A.T
            growth = float(np.linalg.norm(S))
            S /= max(growth, 1e-300)
        assert (growth < 1 + 1e-9) if stays else (growth > 1 - 1e-9), f"the lower bound grows by {growth:.4g} a sample"
    return witness


def _flat(shown: Shown, _: Text) -> None:
    y = shown.run.y[:, 0]
    assert float(np.max(np.abs(y[-len(y) // 8:]))) <= 0.0201 * float(np.max(np.abs(y))), "the sensor still reads"


def _law(shown: Shown, _: Text) -> None:
    figure = shown.figure
    assert isinstance(figure, LineFigure)
    mine, law = (c.y for c in figure.curves[:2])
    off = float(np.max(np.abs(np.abs(mine) - np.abs(law)))) / max(float(np.max(np.abs(law))), 1e-12)
    assert off < 1e-5, f"leaves the line by {off:.2g} of its peak"


def _silent(shown: Shown) -> np.ndarray:
    """(V₂ − L V₁) A T₂, if L takes u and the rest of the state out of the error: asked of its matrices."""
    study = shown.outcome.study
    o, L = study.wanted.solved if hasattr(study, "wanted") else study.observer, shown.outcome.gains["L"]
    P, (_, T2, T3), A = o.V[1] - L @ o.V[0], o.T, o.plant.A
    each = np.hsplit(o.plant.F, o.plant.B.shape[1])
    for M, X in (*((F, T2) for F in each), (A, T3), *((F, T3) for F in each)):
        terms = (np.abs(o.V[1]) + np.abs(L) @ np.abs(o.V[0])) @ np.abs(M) @ np.abs(X)
        scale = np.maximum(terms, 1e-6 * terms.max(initial=0.0))
        off = np.max(np.abs(P @ M @ X) / np.where(scale > 0, scale, 1.0), initial=0.0)
        assert off < 1e-8, f"L lets u or the state into the error: {off:.2g}"
    return P @ A @ T2


def _silenced(shown: Shown, _: Text) -> None:
    _silent(shown)


def _dies_out(shown: Shown, _: Text) -> None:
    run, pole = shown.outcome.study.run, rightmost(_silent(shown))
    assert pole < 0, "the error does not die out"
    if shown["kick"] < 0 and shown["form"] != "filtered":
        size = np.abs(run.errors.reshape(len(run.t), 3, -1)[:, ("plain", "exact").index(shown["form"])])
        floor = 1e-6 * max(1.0, float(np.abs(run.g).max()))
        assert np.all(size[-1] <= 1e3 * np.exp(pole * run.t[-1]) * size.max() + floor), "the run ends with an error"


def _noise_of(shown: Shown, words: Text) -> None:
    """The promise at u = 0 as a sum over all past steps of what one held value does, by matrix exponentials."""
    study = shown.outcome.study
    own = hasattr(study, "wanted")
    L = shown.outcome.gains["L"]
    exact, plain = (study.wanted.solved if own else study.observer).forms(L)
    sigma = shown["noise"] / 100 * study.here.readings if own else np.full(L.shape[1], shown["noise"])
    size = np.maximum(np.abs(study.run.g).max(axis=0), 1e-300) if own else np.ones(1)
    form, tau, h, q, m = shown["form"], shown["tau"], float(study.run.t[1]), len(L), L.shape[1]
    if not own and (shown["problem"], shown["gain"]) == ("paper", "rounded"):  # what runs then is step 8 as the paper prints it
        plain = PRINTED_FORM
    A, Y, G, H = plain.A, plain.Y, plain.G_y, plain.G_z
    if form != "plain":
        A, Y, G, H = exact.A, exact.Y, exact.G_y, exact.G_z
    if form == "filtered":  # (L y − d)/τ stands for L ẏ
        A = np.block([[A, -np.eye(q) / tau], [np.zeros((q, q)), -np.eye(q) / tau]])
        Y, H = np.vstack([Y + L / tau, L / tau]), np.hstack([H, np.zeros_like(H)])
    step = expm(np.block([[A, Y * sigma], [np.zeros((m, len(A) + m))]]) * h)
    Phi, z = step[:len(A), :len(A)], step[:len(A), len(A):]
    total = np.sum((G * sigma) ** 2, axis=1)
    for _ in range(200_000):
        more = np.sum((H @ z) ** 2, axis=1)
        total, z = total + more, Phi @ z
        if np.all(more <= 1e-9 * total):
            break
    near(value(words, "promised"), float(np.max(np.sqrt(total) / size)), 1e-3)
    late = study.run.heard.reshape(len(study.run.t), 3, -1)[len(study.run.t) // 2:, ("plain", "exact", "filtered").index(form)] / size
    near(value(words, "rms"), float(np.max(np.sqrt(np.mean(late ** 2, axis=0)))), 1e-6)


def _unstable_loop(shown: Shown, _: Text) -> None:
    assert shown.outcome.metrics["slowest_loop"] >= 0


def _bound(shown: Shown, words: Text) -> None:
    assert value(words, "peak") <= value(words, "bound") * (1 + 1e-3) + 1e-8, "the error exceeds the bound"


def _largest_input(shown: Shown, words: Text) -> None:
    figure = shown.figure
    assert isinstance(figure, LineFigure)
    near(value(words, "peak"), float(np.max(np.abs(figure.curves[0].y))), 1e-6) if len(figure.curves) == 1 else None


def _recovered(shown: Shown, _: Text) -> None:
    s = shown.outcome.study
    assert s.cost.total > s.plain_cost.total, "it is not dearer"
    assert s.real.margins.nearest > s.plain.margins.nearest, "the loop is no farther from −1"


def _cheapest(shown: Shown, _: Text) -> None:
    c = shown.outcome.study.cost
    assert c.total < 1.00001 * c.least


def _corner(shown: Shown, _: Text) -> None:
    A, B, C, F, Bm = matrices(shown.run)
    K, L = shown.run.scenario.K, shown.run.scenario.L
    assert K is not None and L is not None
    corner = A - L @ C - F - (B - Bm) @ K  # ė = … x + … e where the model is not the plant
    assert float(np.max(np.abs(corner))) < 1e-6 * float(np.max(np.abs(whole(shown.run)))), "the state drives the error"


def _none_smaller(shown: Shown, _: Text) -> None:
    W, V = shown["w"], shown["v"]
    assert np.all(variance(shown.outcome.poles["observer"], W, V) > _least(W, V) * (1 - 1e-6)), "one of the variances is smaller"


def _none_hidden(shown: Shown, _: Text) -> None:
    plant = shown.run.scenario.plant
    for pole in np.linalg.eigvals(plant.A):
        pencil = plant.A - pole * np.eye(plant.n)
        for stacked in (np.vstack([pencil, plant.C]), np.hstack([pencil, plant.B])):
            assert np.linalg.svd(stacked, compute_uv=False)[-1] > 1e-4 * np.linalg.norm(plant.A, 2), f"{pole:.3g} is nearly hidden"


def _load_found(shown: Shown, words: Text) -> None:
    run, after = shown.run, value(words, "found")
    away = np.abs(run.x[:, 3] - run.xhat[:, 3]) - 0.05 * abs(shown["load"])
    assert float(np.max(away[run.t > 1 + after - 1e-9])) <= 1e-12, "not even in the run"
    assert not after > 0 or away[run.index(1 + after) - 1] > 0, "it was found before"


def _on_target(shown: Shown, _: Text) -> None:
    tail = np.degrees(shown.run.x[-max(len(shown.run.t) // 10, 1):, 2])
    assert abs(float(tail.mean()) - shown["target"]) < 0.05, f"it stands at {tail.mean():.4g}°"


def _below_target(shown: Shown, words: Text) -> None:
    tail = np.degrees(shown.run.x[-max(len(shown.run.t) // 10, 1):, 2])
    near(value(words, "droop"), shown["target"] - float(tail.mean()))


def _claimed_in_vain(shown: Shown, words: Text) -> None:
    early = shown.run.t < 1 - 1e-9
    near(value(words, "false"), float(np.max(np.abs(shown.run.xhat[early, 3]))))


def _off_the_motor(shown: Shown, words: Text) -> None:
    assert value(words, "apart") <= shown["gap"] / 2 * (1 + 1e-4) and shown["encoder"] != "joint"


def _on_a_flank(shown: Shown, words: Text) -> None:
    figure = shown.figure
    assert isinstance(figure, LineFigure)
    near(abs(float(figure.curves[0].y[-1])), shown["gap"] / 2, 1e-4)
    near(value(words, "apart"), shown["gap"] / 2, 1e-4)


def _at_rest(shown: Shown, _: Text) -> None:
    s = shown.run.scenario
    r = s.reference
    longer = simulate(replace(s, horizon=LONGER * s.horizon, reference=None if r is None else np.asarray(r)[0]))
    tail = shown.run.x[-max(len(shown.run.t) // 10, 1):].mean(axis=0)
    assert abs(np.degrees(longer.x[-1, 2] - tail[2])) < 0.05, "it goes on from there"


def _obeys(clipped: bool) -> Callable[[Shown, Text], None]:
    def witness(shown: Shown, words: Text) -> None:
        run, limit = shown.run, shown["u_max"]
        assert bool(np.any(np.abs(run.u_asked) > limit * (1 + 1e-9))) == clipped, "clipped, or not, otherwise than said"
        _meter_zero(shown, words)
    return witness


def missed(shown: Shown) -> np.ndarray:
    """û − Kx of a robust observer on the true plant (n_t,): the loop written out and joined to the oscillator that makes v."""
    d, o = shown.outcome.design, shown.outcome.study.observer
    A, B, C = o.plant.A, o.plant.B, o.plant.C
    dA, dC = errors(d)
    true_A, true_B, true_C = A + dA, (1 + d["input"]) * B, C + dC
    steer, turns = -np.hstack([o.M @ true_C, o.N]), np.array([[0.0, 5.0], [-5.0, 0.0]])
    n, q = len(A), o.order
    open_loop = np.block([[true_A, np.zeros((n, q))], [o.L @ true_C, o.F]])
    drive = np.vstack([true_B, o.T @ B])
    whole = np.block([[open_loop + drive @ steer, drive @ np.array([[-4.0, 0.0]])], [np.zeros((2, n + q)), turns]])
    state = np.concatenate([shown.outcome.study.true.x[0], shown.outcome.study.true.z[0], [1.0, 0.0]])  # sin, cos of 5t + π/2
    step, out = expm(whole * 0.015), []
    for _ in range(401):
        out.append(float((steer @ state[:-2] + o.K @ state[:n])[0]))
        state = step @ state
    return np.abs(np.array(out))


def _misses(shown: Shown, words: Text) -> None:
    far = missed(shown)
    near(value(words, "late_error"), min(float(far[301:].max()), 1e3), 1e-4)


def _fixed(shown: Shown, words: Text) -> None:
    """N and M are the only solution: the rows of [T; C] span K, and none depends on the others."""
    g, C = shown.outcome.gains, shown.outcome.study.observer.plant.C
    rows = np.vstack([g["T"], C])
    solved = np.linalg.lstsq(rows.T, g["K"].T, rcond=None)[0].T @ rows
    near(value(words, "rank"), float(len(rows)))
    assert np.linalg.norm(solved - g["K"]) < 1e-8 * np.linalg.norm(g["K"]) and np.linalg.matrix_rank(rows, tol=1e-12) == len(rows)


def _settles(shown: Shown, words: Text) -> None:
    late = float(missed(shown)[301:].max())
    assert late < 1.21 * value(words, "steady") + 1e-6, f"at the end it is still {late:.3g}"


def _leaves_a_trace(all_of_them: bool) -> Callable[[Shown, Text], None]:
    """Hautus by hand, on A balanced by its own states' typical sizes: a hidden mode is one whose pencil loses rank."""
    def witness(shown: Shown, _: Text) -> None:
        plant = shown.outcome.study.sensed.plant
        least = []
        for pole in np.linalg.eigvals(plant.A):
            pencil = np.vstack([plant.A - pole * np.eye(plant.n), plant.C])
            least.append(float(np.linalg.svd(pencil, compute_uv=False)[-1]) / float(np.linalg.norm(plant.A, 2)))
        assert (min(least) > 1e-13) == all_of_them, f"the least of the pencils' singular values is {min(least):.2g} of the size of A"
    return witness


def _squares(shown: Shown, words: Text) -> None:
    """NIS and NEES of a filter written out here: predict, update by Joseph's form, after the first two seconds."""
    kf, start, record = shown.outcome.study.watcher.filter, shown.outcome.study.watcher.start, shown.outcome.study.truth
    x, P, nis, nees = start.mean, start.covariance, [], []
    for k, y in enumerate(record.y):
        S = kf.C @ P @ kf.C.T + kf.R
        M, nu = np.linalg.solve(S, kf.C @ P).T, y - kf.C @ x
        keep = np.eye(len(P)) - M @ kf.C
        x, P = x + M @ nu, keep @ P @ keep.T + M @ kf.R @ M.T
        e = (record.x[k] - x[:6])
        nis.append(nu @ np.linalg.solve(S, nu))
        nees.append(e @ np.linalg.solve(P[:6, :6], e))
        x, P = kf.A @ x + np.pad(kf.B, ((0, len(P) - len(kf.B)), (0, 0))) @ record.u[k], kf.A @ P @ kf.A.T + kf.Q
    near(value(words, "mean"), float(np.mean(nis[50:])), 2e-3)
    near(value(words, "mean2"), float(np.mean(nees[50:])), 2e-3)


def _rightly(shown: Shown, words: Text) -> None:
    assert dict(words.values)["who"] in (shown["place"], shown["place2"]) and value(words, "delay") > 0


WITNESSES: Mapping[str, Callable[[Shown, Text], None]] = {
    "The error stays below 2 % of its peak after {small:.2f} s.": _stays,
    "The estimate has caught up with the truth.": _caught,
    "In the last tenth of the run they differ by up to {gap:.2g} {unit}.": _apart,
    "Largest input applied: {peak:.3g} {input_unit}.": _largest_input,
    "Separation meter: 0.": lambda shown, words: None if shown.outcome.run is None else _meter_zero(shown, words),
    "Separation meter: {meter:.2g}; the error no longer lives by itself.": _meter_not_zero,
    "The {count} poles of the loop are the union of both boards to about {union_error}.": _union,
    "The compensator by itself is unstable.": _compensator,
    "Steering by the estimate lowers the peak by {peak:.1f} dB; the gap to the dashed line is the observer's share.": _isolates(1),
    "Steering by the estimate raises the peak by {peak:.1f} dB.": _isolates(-1),
    "The lower left block is zero: the error drives the state, never the other way round.": _meter_zero,
    "The lower left block of this matrix is zero.": _corner,
    "No mode is hidden: every distance is well above zero.": _none_hidden,
    "P − P_min has no negative eigenvalue: no combination of errors is smaller than the Kalman filter's.": _none_smaller,
    "The observer's error grows: L is too small for this chip.": _too(True),
    "The observer's error grows: L is too large for this chip.": _too(False),
    "The observer's error grows: no θ up to 2 is stable with these poles.": _no_trust,
    "No θ up to 2 is stable with these poles.": _no_trust,
    "The observer knows the core within 1 K after {after:.2f} s.": _core_known,
    "The input moves the state by up to {moved} and the error by {error_moved:.0e}: rounding, nothing else.": _not_driven,
    "The input moves the state by up to {moved} and the error by up to {error_moved:.2g}: the error is not left alone.": _driven,
    "The pole comes home.": _home,
    "Caught.": _home,
    "The {name} error is as small as any observer can make it: {share:.0f} % of its variance is sensor noise.": _as_small,
    "The {name} error is {ratio:.3g} times the least possible; {share:.0f} % of its variance is sensor noise.": _times,
    "Slower would be better.": _other_speed(0.95),
    "Faster would be better.": _other_speed(1.05),
    "No other speed is half a per cent better; only another pattern is.": _other_speed(),
    "LQR never falls below 1; LQG comes down to {least}.": _never_below_one,
    "LQR never falls below 1; LQG comes down to {least}, with all inputs at once to {together}.": _never_below_one,
    "No other controller is cheaper on average under this noise.": _cheapest,
    "Margins are bought with noise in the input and a higher cost.": _recovered,
    "{lost} of the measurements are lost, {critical:.1f} % may be: the mean stays bounded.": _bounded(True),
    "{lost} of the measurements are lost, {critical:.1f} % is the limit: the mean diverges.": _bounded(False),
    "The trace has gone flat: as far as the sensor can tell, all is at rest.": _flat,
    "|ε| follows e^({pole}t) to within {law_gap:.0e} of its peak, whatever u does.": _law,
    "|ε| follows ẇ = A_L w to within {law_gap:.0e} of its peak, whatever u does.": _silenced,
    "Case {case}: one state watches g, and ε dies out as e^({pole}t) under this u.": _dies_out,
    "Case {case}: an observer of order {order} watches g, and ε dies out with the poles {poles} under this u.": _dies_out,
    "The sensors' noise moves ĝ by {rms:.2g} (rms, second half of the run); at rest and u = 0 its law says {promised:.2g}.": _noise_of,
    "The sensors' noise moves ĝ by {rms:.2g} of g (rms, second half of the run); at rest and u = 0 its law says {promised:.2g}.": _noise_of,
    "With the true plant the loop is unstable.": _unstable_loop,
    "On the true plant û misses the wanted input by up to {late_error:.2g} at the end.": _misses,
    "The {rows} rows of [T; C] have rank {rank}, and with K no more: N and M exist and are fixed.": _fixed,
    "With the true plant e_u settles to an amplitude of {steady:.2g}; on the model it dies out.": _settles,
    "Not observable: {poles} leave no trace in y. Known to a tenth: {known} of {n} directions.": _leaves_a_trace(False),
    "No mode is hidden (nearest: {d}), yet this run fixes only {known} of {n} directions to a tenth; rank(O) = {rank}.":
        _leaves_a_trace(True),
    "Observable: the nearest mode is {d} from being hidden, and all {n} directions are known to a tenth.": _leaves_a_trace(True),
    "NIS {mean:.2f} (4 expected), NEES {mean2:.3g} (6 expected).": _squares,
    "{who} is accused {delay:.2f} s after it failed, rightly.": _rightly,
    "Nothing is clipped, so the error keeps its promise.": _obeys(False),
    "So the error obeys A − LC, whatever the observer is told.": _obeys(False),
    "The error obeys A − LC all the same.": _obeys(True),
    "The force is clipped, and the error keeps its promise.": _obeys(True),
    "White is zero: the error drives the state, never the other way round.": _meter_zero,
    "The error keeps its promise: the load enters it once, at {at:g} s, and it dies out from there.": _meter_zero,
    "The load enters the error at {at:g} s and stays there: nothing in this observer takes it in.": _meter_zero,
    "The load is found to 5 % after {found:.3f} s.": _load_found,
    "At the end the arm stands on its target.": _on_target,
    "At the end the arm is {droop:.3g}° below its target.": _below_target,
    "Before the load came it had claimed up to {false:.2g} N m.": _claimed_in_vain,
    "The arm stands up to {apart:.2g}° off the motor, and the encoder on the motor does not see it.": _off_the_motor,
    "At the end the arm rests on one flank, {apart:.3g}° from the motor.": _on_a_flank,
    "The run ends where the equations of rest say.": _at_rest,
    "Largest error {peak} at {where} Hz; the bound 2Σσ promises {bound}.": _bound,
}
