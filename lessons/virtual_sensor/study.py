"""Compute a design of lesson 1: gain, observer run, open-loop copy run."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome
from observer_lab.engine import Plant, Scenario, observer_gain, simulate
from observer_lab.engine.observers import ReducedObserver, reduced_observer
from observer_lab.engine.simulation import Run
from observer_lab.engine.systems import settled_covariance
from observer_lab.plants import MODELS, chip
from observer_lab.text import Text, joined, text

from ..toolkit.boards import listed, stage
from ..toolkit.knobs import kicks
from ..toolkit.latex import matrix, number
from .knobs import DT, HORIZON, MOST_TRUST, OBSERVER_WINDOW, RUNAWAY_ID

BURST_PERIOD_S, IDLE_SHARE = 6.0, 0.25  # s of a burst of work and the rest after it; share of the power at rest
KNOWN_ERROR_K = 1.0  # K: a core error below this counts as known


@dataclass(frozen=True, eq=False)
class Study:
    """What the figures need beside the observer's run: the copy's run, how the poles move with trust, the reduced-order estimate.

    `reduced`: x̂ (n_t, 2) of the reduced-order observer along the same readings, as long as the run; None where it is switched off.
    """

    copy: Run
    trusts: np.ndarray
    poles: np.ndarray  # (n_trusts, 2)
    stable: tuple[float, float]  # the open interval of θ for which the observer is stable, empty if low ≥ high
    reduced: np.ndarray | None = None


@lru_cache(maxsize=128)
def believed(plant: str, air_error: float) -> Plant:
    """The chip as the copy and the observer believe it: the resistance from case to air off by a percentage."""
    p = chip.Parameters()
    return chip.plant(replace(p, outer=p.outer * (1 + air_error / 100)), chip.LEAKAGE if plant == RUNAWAY_ID else 0.0)


def burst(power: float) -> np.ndarray:
    """The power over the run (n_t, 1) in W: work for half a period, a quarter of it for the other half."""
    t = DT * np.arange(round(HORIZON / DT) + 1)
    return np.where(t % BURST_PERIOD_S < BURST_PERIOD_S / 2 - 1e-9, power, IDLE_SHARE * power)[:, None]


def _poles_of(A: np.ndarray) -> np.ndarray:
    """Both eigenvalues of 2×2 matrices (…, 2, 2), in an order that does not jump along a path."""
    half = np.trace(A, axis1=-2, axis2=-1) / 2
    root = np.sqrt((half**2 - np.linalg.det(A)).astype(complex))
    return np.stack([half - root, half + root], axis=-1)


def _trusts(model: Plant, L: np.ndarray) -> np.ndarray:
    """Values of θ for the paths of both poles, crowded where they meet on the real axis and part from it.

    There the discriminant of det(sI − A + θLC), a parabola in θ, is zero.
    """
    at = [np.trace(M) ** 2 - 4 * np.linalg.det(M) for M in (model.A - theta * (L @ model.C) for theta in (0.0, 1.0, 2.0))]
    meet = np.roots([(at[2] - 2 * at[1] + at[0]) / 2, (4 * at[1] - at[2] - 3 * at[0]) / 2, at[0]])
    near = np.concatenate([[0.0], *(sign * np.geomspace(1e-5, 0.03, 12) for sign in (-1, 1))])
    close = (meet.real[np.abs(meet.imag) < 1e-9][:, None] + near).ravel()
    return np.unique(np.concatenate([np.linspace(0.0, MOST_TRUST, 81), close[(close > 0) & (close < MOST_TRUST)]]))


def stable_trusts(model: Plant, L: np.ndarray) -> tuple[float, float]:
    """The open interval of all θ for which A − θLC is stable; low ≥ high where there is none.

    LC has rank one, so trace and determinant of A − θLC are straight lines in θ, and both −trace and det are to be positive.
    """
    A, full = model.A, model.A - L @ model.C
    low, high = -np.inf, np.inf
    for start, end in ((-np.trace(A), -np.trace(full)), (np.linalg.det(A), np.linalg.det(full))):
        slope = float(end - start)
        if slope > 0:
            low = max(low, -float(start) / slope)
        elif slope < 0:
            high = min(high, -float(start) / slope)
        elif start <= 0:
            high = -np.inf
    return low, high


def compute(design: Design) -> Outcome[Study]:
    """The observer's gain on the believed chip, and one run each of observer and copy on the true one.

    Only the observer's run can end early, where badly chosen poles make it diverge; the copy's is the longer one.
    """
    model = MODELS[design["plant"]]
    belief = believed(design["plant"], design["air_error"])
    L_full = observer_gain(belief.A, belief.C, design["observer_poles"]).gain
    L = design["trust"] * L_full
    watched = Scenario(
        model.plant, None, L, model=belief, x0=model.x0, xhat0=(design["guess_core"], design["guess_case"]),
        horizon=HORIZON, dt=DT, reference=burst(design["power"]), V=design["noise"] ** 2 * DT if design["noise"] else None,
        impulses=kicks(design, model), seed=int(design["seed"]))
    run, copy = simulate(watched), simulate(replace(watched, L=None))
    poles, own = np.sort_complex(_poles_of(belief.A - L @ belief.C)), belief.poles
    trusts, (low, high) = _trusts(belief, L_full), stable_trusts(belief, L_full)
    reduced = reduced_observer(belief, (float(np.max(np.real(design["observer_poles"]))),)) if design["reduced"] else None
    estimates = None if reduced is None else _reduced_estimates(watched, reduced, run)
    if estimates is not None and len(estimates) < len(run.t):  # all curves end where the first of them has diverged
        run = simulate(replace(watched, horizon=float(run.t[len(estimates) - 1])))
    seen = Study(copy, trusts, _poles_of(belief.A - trusts[:, None, None] * (L_full @ belief.C)), (low, high),
                 None if estimates is None else estimates[:len(run.t)])
    metrics = _metrics(run, copy) | {
        "core_sigma": core_sigma(belief.A - L @ belief.C, L, design["noise"]),
        "slowest_observer": float(np.max(np.real(poles))), "slowest_copy": float(np.max(np.real(own))),
        "largest_gain": float(np.max(np.abs(L))), "least_trust": max(0.0, low)}
    if reduced is not None:
        metrics["reduced_sigma"] = reduced_sigma(reduced, design["noise"])
        metrics["reduced_error"] = float(np.abs(run.x[:, 0] - seen.reduced[:, 0])[-max(len(run.t) // 10, 1):].max())
    return Outcome(
        design, {"L": L}, {"observer": poles, "copy": own}, metrics, checks_of(metrics), run,
        _boards(design, poles, own, belief.A - L @ belief.C), stage(model, run, design), _formulas(belief, L, design["trust"]),
        _live(metrics, run, seen, design["trust"]), seen)


def checks_of(metrics: dict[str, float]) -> tuple[Check, Check]:
    """Whether the error of the observer and that of the copy die out."""
    observer, copy = metrics["slowest_observer"], metrics["slowest_copy"]
    return (Check("observer", text("the observer's wrong start decays"), observer < 0, observer),
            Check("copy", text("the copy's wrong start decays"), copy < 0, copy))


def _metrics(run: Run, copy: Run) -> dict[str, float]:
    core, of_copy = np.abs(run.e[:, 0]), np.abs(copy.e[:, 0])
    tail = max(len(core) // 10, 1)
    known = _known_after(run.t, core)
    return {
        "core_error": float(core[-tail:].max()), "copy_core_error": float(of_copy[-tail:].max()),
        "largest_copy_error": float(of_copy.max()), "case_error": float(np.abs(run.e[-tail:, 1]).max()),
        "known_after": np.inf if known is None else known, "largest_guess": float(np.max(np.abs(run.xhat[:, 0])))}


def core_sigma(A: np.ndarray, L: np.ndarray, noise: float) -> float:
    """Standard deviation in K of the core error that sensor noise alone leaves, ė = A e − L v; 0 without noise, ∞ if A is not stable."""
    if noise == 0:
        return 0.0
    if np.max(np.real(np.linalg.eigvals(A))) >= 0:
        return float("inf")
    return float(np.sqrt(settled_covariance(A, noise * np.sqrt(DT) * L)[0, 0]))


def _reduced_estimates(watched: Scenario, observer: ReducedObserver, run: Run) -> np.ndarray:
    """x̂ of the reduced-order observer over the same run, from the same guess of the core: w(0) takes the first reading into account."""
    given, first = np.asarray(watched.xhat0), run.y[0] - run.yhat[0]
    w0 = observer.S @ given - (observer.N @ first) @ observer.M
    same = simulate(replace(watched, model=observer.model, L=observer.G, K=None, xhat0=w0))
    return observer.estimates(same.xhat, same.y, same.u_applied)


def reduced_sigma(observer: ReducedObserver, noise: float) -> float:
    """Standard deviation in K of the core's estimate by sensor noise alone: each reading passes at once and, through w, later.

    w⁺ = φ w + γ v with φ = e^{F dt}: σ² (N₁² + M₁² γ²/(1 − φ²)). ∞ if F is not stable.
    """
    if noise == 0:
        return 0.0
    F, G = float(observer.F[0, 0]), float(observer.G[0, 0])
    if F >= 0:
        return float("inf")
    phi = np.exp(F * DT)
    later = float(observer.M[0, 0]) * G * (phi - 1) / F
    return float(noise * np.sqrt(observer.N[0, 0] ** 2 + later**2 / (1 - phi**2)))


def _known_after(t: np.ndarray, error: np.ndarray) -> float | None:
    """From when on the core is known within KNOWN_ERROR_K, None if it is not so at the end."""
    off = np.flatnonzero(error >= KNOWN_ERROR_K)
    if not len(off):
        return 0.0
    return None if off[-1] == len(t) - 1 else float(t[off[-1] + 1])


def _boards(design: Design, poles: np.ndarray, own: np.ndarray, error: np.ndarray) -> tuple[Board, Board]:
    shown = listed(poles)
    by_hand = design["observer_poles"] if design["trust"] == 1.0 else shown
    return (
        Board(
            "copy",
            text("the copy's poles  eig(A)"),
            listed(own),
            role="second",
            side="left",
            re_low=OBSERVER_WINDOW.re_low,
            re_high=OBSERVER_WINDOW.re_high,
            im_high=OBSERVER_WINDOW.im_high,
        ),
        Board(
            "observer",
            text("observer poles  eig(A − LC)"),
            by_hand,
            "observer_poles",
            role="estimate",
            side="right",
            re_low=OBSERVER_WINDOW.re_low,
            re_high=OBSERVER_WINDOW.re_high,
            im_high=OBSERVER_WINDOW.im_high,
            also=(("trust", 1.0),),
            landscape=error,
        ),
    )


def _formulas(belief: Plant, L: np.ndarray, trust: float) -> tuple[Formula, ...]:
    return (
        Formula("observer", r"\dot{\hat x} = A\hat x + Bu + L\,(y - C\hat x)"),
        Formula("L", rf"L = \theta L_1 = {matrix(L)},\quad \theta = {number(trust)}"),
        Formula("error", rf"A - LC = {matrix(belief.A - L @ belief.C)}"),
    )


def _live(m: dict[str, float], run: Run, study: Study, trust: float) -> Text:
    true, guess, other = (float(v) for v in (run.x[-1, 0], run.xhat[-1, 0], study.copy.xhat[len(run.t) - 1, 0]))
    low, high = study.stable
    why = (text("The observer's error grows: no θ up to 2 is stable with these poles.")
           if low >= min(high, MOST_TRUST) or high <= 0 else
           text("The observer's error grows: L is too small for this chip.") if trust <= low else
           text("The observer's error grows: L is too large for this chip."))
    doubt = claim(why, m["slowest_observer"], above=0.0)
    end = text("At the end the core is {true:.1f} K above ambient; the observer says {guess:.1f} K, the copy {other:.1f} K.",
               true=true, guess=guess, other=other)
    return joined(end, doubt)


