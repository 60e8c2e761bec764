"""Compute a design of lesson 1: gain, observer run, open-loop copy run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeVar

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome
from observer_lab.engine import Plant, Scenario, observer_gain, simulate
from observer_lab.engine.observers import ReducedObserver, reduced_observer
from observer_lab.engine.simulation import Run
from observer_lab.engine.systems import settled_covariance
from observer_lab.plants import MODELS, Model, chip
from observer_lab.plants.model import Window
from observer_lab.text import Text, joined, text

from ..toolkit.boards import bolts, listed, stage
from ..toolkit.knobs import kicks
from ..toolkit.latex import gain_words, number
from .knobs import DT, HORIZON, MOST_TRUST, OBSERVER_WINDOW, RUNAWAY_ID

S = TypeVar("S")
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


@dataclass(frozen=True, eq=False)
class Tried:
    """The observer's run and the open-loop copy's, both with the model `belief`; `full`: L at θ = 1."""

    model: Model
    design: Design
    belief: Plant
    full: np.ndarray
    L: np.ndarray
    poles: np.ndarray
    run: Run
    copy: Run

    @property
    def rates(self) -> dict[str, float]:
        """The slowest modes of both errors, and the largest entry of L."""
        return {"slowest_observer": float(np.max(np.real(self.poles))), "slowest_copy": float(np.max(np.real(self.belief.poles))),
                "largest_gain": float(np.max(np.abs(self.L)))}


def tried_on(model: Model, design: Design, plants: tuple[Plant, Plant], full: np.ndarray, poles_of: Callable[[np.ndarray], np.ndarray],
             guess: Sequence[float], drive: np.ndarray, V: np.ndarray | float | None) -> Tried:
    """One run each of observer and copy on the first plant, which both believe to be the second; `drive` is the known input (n_t, m)."""
    truth, belief = plants
    L = design["trust"] * full
    watched = Scenario(
        truth, None, L, model=belief, x0=model.x0, xhat0=guess, horizon=model.horizon, dt=model.dt, reference=drive, V=V,
        impulses=kicks(design, model), seed=int(design["seed"]))
    return Tried(model, design, belief, full, L, poles_of(belief.A - L @ belief.C), simulate(watched), simulate(replace(watched, L=None)))


def compute(design: Design) -> Outcome[Study]:
    """The observer's gain on the believed chip, and one run each of observer and copy on the true one.

    Only the observer's run can end early, where badly chosen poles make it diverge; the copy's is the longer one.
    """
    model, belief = MODELS[design["plant"]], believed(design["plant"], design["air_error"])
    tried = tried_on(
        model, design, (model.plant, belief), observer_gain(belief.A, belief.C, design["observer_poles"]).gain,
        lambda A: np.sort_complex(_poles_of(A)), (design["guess_core"], design["guess_case"]), burst(design["power"]),
        design["noise"] ** 2 * DT if design["noise"] else None)
    trusts, (low, high) = _trusts(belief, tried.full), stable_trusts(belief, tried.full)
    reduced = reduced_observer(belief, (float(np.max(np.real(design["observer_poles"]))),)) if design["reduced"] else None
    estimates = None if reduced is None else _reduced_estimates(reduced, tried.run)
    if estimates is not None and len(estimates) < len(tried.run.t):  # all curves end where the first of them has diverged
        tried = replace(tried, run=simulate(replace(tried.run.scenario, horizon=float(tried.run.t[len(estimates) - 1]))))
    run = tried.run
    seen = Study(tried.copy, trusts, _poles_of(belief.A - trusts[:, None, None] * (tried.full @ belief.C)), (low, high),
                 None if estimates is None else estimates[:len(run.t)])
    metrics = _metrics(run, tried.copy) | tried.rates | {
        "core_sigma": core_sigma(belief.A - tried.L @ belief.C, tried.L, design["noise"]), "least_trust": max(0.0, low)}
    if reduced is not None:
        metrics["reduced_sigma"] = reduced_sigma(reduced, design["noise"])
        metrics["reduced_error"] = float(np.abs(run.x[:, 0] - seen.reduced[:, 0])[-max(len(run.t) // 10, 1):].max())
    return outcome_of(tried, OBSERVER_WINDOW, r"L = \theta L_1", metrics, _live(metrics, run, seen, design["trust"]), seen)


def outcome_of(tried: Tried, window: Window, letter: str, metrics: dict[str, float], live: Text, study: S) -> Outcome[S]:
    """What both runs of a design show; `letter`: what L is called in its formula."""
    observer, copy = metrics["slowest_observer"], metrics["slowest_copy"]
    checks = (Check("observer", text("the observer's wrong start decays"), observer < 0, observer),
              Check("copy", text("the copy's wrong start decays"), copy < 0, copy))
    L, belief = tried.L, tried.belief
    formulas = (Formula("observer", r"\dot{\hat x} = A\hat x + Bu + L\,(y - C\hat x)"),
                Formula("L", rf"{gain_words(letter, L)},\quad \theta = {number(tried.design['trust'])}"),
                Formula("error", gain_words("A - LC", belief.A - L @ belief.C)))
    return Outcome(tried.design, {"L": L}, {"observer": tried.poles, "copy": belief.poles}, metrics, checks, tried.run,
                   _boards(tried, window), stage(tried.model, tried.run, tried.design), formulas, live, study)


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


def _reduced_estimates(observer: ReducedObserver, run: Run) -> np.ndarray:
    """x̂ of the reduced-order observer over the same run, from the same guess of the core: w(0) takes the first reading into account."""
    given, first = np.asarray(run.scenario.xhat0), run.y[0] - run.yhat[0]
    w0 = observer.S @ given - (observer.N @ first) @ observer.M
    same = simulate(replace(run.scenario, model=observer.model, L=observer.G, K=None, xhat0=w0))
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


def _boards(tried: Tried, window: Window) -> tuple[Board, Board]:
    """The copy's poles and the observer's, which can be dragged; by hand they stand where the hand put them, with θ = 1."""
    model, design, belief = tried.model, tried.design, tried.belief
    by_hand = design["trust"] == 1.0
    whole = len(tried.poles) == len(model.observer_poles)
    return (
        Board("copy", text("the copy's poles  eig(A)"), listed(belief.poles), role="second",
              side="left", re_low=window.re_low, re_high=window.re_high, im_high=window.im_high),
        Board("observer", text("observer poles  eig(A − LC)"),
              design["observer_poles"] if by_hand else listed(tried.poles), "observer_poles" if by_hand or whole else None,
              bolts(model.observer, window) if by_hand else (), role="estimate", side="right", re_low=window.re_low,
              re_high=window.re_high, im_high=window.im_high, also=(("trust", 1.0),), landscape=belief.A - tried.L @ belief.C),
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
