"""Compute a design of lesson 1: gain, observer run, open-loop copy run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome
from observer_lab.engine import Plant, Scenario, observer_gain, simulate
from observer_lab.engine.observers import ReducedObserver, reduced_observer
from observer_lab.engine.simulation import Run
from observer_lab.engine.systems import settled_covariance
from observer_lab.plants import MODELS, Model, chip
from observer_lab.text import Text, joined, text

from ..toolkit.boards import bolts, listed, stage
from ..toolkit.knobs import kicks
from ..toolkit.latex import gain_words, number
from .knobs import DT, HORIZON, MOST_TRUST, RUNAWAY_ID

BURST_PERIOD_S, IDLE_SHARE = 6.0, 0.25  # s of a burst of work and the rest after it; share of the power at rest
KNOWN_ERROR_K = 1.0  # K: a core error below this counts as known


@dataclass(frozen=True, eq=False)
class Setting:
    """A design on the chip, or on a person's own plant: the first of `plants` moves, observer and copy believe it to be the second.

    `full`: L at θ = 1, called `letter` in its formula; `guess`: x̂(0); `drive` (n_t, m): the known input; `V`: of the sensor noise.
    `trusts`: values of θ for the paths of the poles, by `poles_of` a matrix. `numbers`: all metrics, from those of every plant.
    """

    model: Model
    plants: tuple[Plant, Plant]
    full: np.ndarray
    letter: str
    guess: Sequence[float]
    drive: np.ndarray
    V: np.ndarray | float | None
    trusts: np.ndarray
    poles_of: Callable[[np.ndarray], np.ndarray]
    numbers: Callable[[dict[str, float], Study], dict[str, float]]
    live: Callable[[dict[str, float], Study], Text]
    reduced: ReducedObserver | None = None

    @property
    def belief(self) -> Plant:
        """The model that both have."""
        return self.plants[1]


@dataclass(frozen=True, eq=False)
class Study:
    """What the figures need: the runs of observer and copy, how the poles move with trust, the reduced-order estimate.

    `reduced`: x̂ (n_t, 2) of the reduced-order observer along the same readings, as long as the run; None where it is switched off.
    """

    here: Setting
    run: Run
    copy: Run
    reduced: np.ndarray | None

    @property
    def trusts(self) -> np.ndarray:
        """Values of θ (n_trusts,)."""
        return self.here.trusts

    @cached_property
    def poles(self) -> np.ndarray:
        """Those of the observer at each of them (n_trusts, n)."""
        belief = self.here.belief
        return self.here.poles_of(belief.A - self.trusts[:, None, None] * (self.here.full @ belief.C))

    @property
    def stable(self) -> tuple[float, float]:
        """The open interval of θ for which the observer is stable, empty if low ≥ high; one output and two states."""
        return stable_trusts(self.here.belief, self.here.full)


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


def compute(setting_of: Callable[[Design], Setting], design: Design) -> Outcome[Study]:
    """The observer's gain on the believed plant, and one run each of observer and copy on the true one.

    On the chip only the observer's run can end early, where badly chosen poles make it diverge; the copy's is the longer one.
    """
    here = setting_of(design)
    model, (truth, belief), L = here.model, here.plants, design["trust"] * here.full
    watched = Scenario(
        truth, None, L, model=belief, x0=model.x0, xhat0=here.guess, horizon=model.horizon, dt=model.dt, reference=here.drive, V=here.V,
        impulses=kicks(design, model), seed=int(design["seed"]))
    run, copy = simulate(watched), simulate(replace(watched, L=None))
    reduced = None if here.reduced is None else _reduced_estimates(here.reduced, run)
    if reduced is not None and len(reduced) < len(run.t):  # all curves end where the first of them has diverged
        run = simulate(replace(watched, horizon=float(run.t[len(reduced) - 1])))
    study = Study(here, run, copy, None if reduced is None else reduced[:len(run.t)])
    poles = np.sort_complex(here.poles_of(belief.A - L @ belief.C))
    ours, theirs = float(np.max(np.real(poles))), float(np.max(np.real(belief.poles)))
    metrics = here.numbers({"slowest_observer": ours, "slowest_copy": theirs, "largest_gain": float(np.max(np.abs(L)))}, study)
    checks = (Check("observer", text("the observer's wrong start decays"), ours < 0, ours),
              Check("copy", text("the copy's wrong start decays"), theirs < 0, theirs))
    formulas = (Formula("observer", r"\dot{\hat x} = A\hat x + Bu + L\,(y - C\hat x)"),
                Formula("L", rf"{gain_words(here.letter, L)},\quad \theta = {number(design['trust'])}"),
                Formula("error", gain_words("A - LC", belief.A - L @ belief.C)))
    return Outcome(design, {"L": L}, {"observer": poles, "copy": belief.poles}, metrics, checks, run, _boards(here, design, poles, L),
                   stage(model, run, design), formulas, here.live(metrics, study), study)


def late_peak(values: np.ndarray) -> float:
    """The largest size in the last tenth of a record."""
    return float(np.abs(values[-max(len(values) // 10, 1):]).max())


def chip_setting(design: Design) -> Setting:
    """The chip of a design, which cools or runs away."""
    belief = believed(design["plant"], design["air_error"])
    full = observer_gain(belief.A, belief.C, design["observer_poles"]).gain
    reduced = reduced_observer(belief, (float(np.max(np.real(design["observer_poles"]))),)) if design["reduced"] else None
    model = MODELS[design["plant"]]
    return Setting(
        model, (model.plant, belief), full, r"L = \theta L_1", (design["guess_core"], design["guess_case"]), burst(design["power"]),
        design["noise"] ** 2 * DT if design["noise"] else None, _trusts(belief, full), _poles_of, partial(_metrics, design),
        partial(_live, design["trust"]), reduced)


def _metrics(design: Design, rates: dict[str, float], seen: Study) -> dict[str, float]:
    run, here = seen.run, seen.here
    core, of_copy = np.abs(run.e[:, 0]), np.abs(seen.copy.e[:, 0])
    known, L = _known_after(run.t, core), design["trust"] * here.full
    found = {
        "core_error": late_peak(core), "copy_core_error": float(of_copy[-max(len(core) // 10, 1):].max()),
        "largest_copy_error": float(of_copy.max()), "case_error": late_peak(run.e[:, 1]),
        "known_after": np.inf if known is None else known, "largest_guess": float(np.max(np.abs(run.xhat[:, 0]))), **rates,
        "core_sigma": core_sigma(here.belief.A - L @ here.belief.C, L, design["noise"]), "least_trust": max(0.0, seen.stable[0])}
    if here.reduced is not None and seen.reduced is not None:
        found |= {"reduced_sigma": reduced_sigma(here.reduced, design["noise"]),
                  "reduced_error": late_peak(run.x[:, 0] - seen.reduced[:, 0])}
    return found


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


def _boards(here: Setting, design: Design, poles: np.ndarray, L: np.ndarray) -> tuple[Board, Board]:
    """The copy's poles and the observer's, which can be dragged; by hand they stand where the hand put them, with θ = 1."""
    model, belief, window = here.model, here.belief, here.model.observer_window
    by_hand = design["trust"] == 1.0
    whole = len(poles) == len(model.observer_poles)
    return (
        Board("copy", text("the copy's poles  eig(A)"), listed(belief.poles), role="second",
              side="left", re_low=window.re_low, re_high=window.re_high, im_high=window.im_high),
        Board("observer", text("observer poles  eig(A − LC)"),
              design["observer_poles"] if by_hand else listed(poles), "observer_poles" if by_hand or whole else None,
              bolts(model.observer, window) if by_hand else (), role="estimate", side="right", re_low=window.re_low,
              re_high=window.re_high, im_high=window.im_high, also=(("trust", 1.0),), landscape=belief.A - L @ belief.C),
    )


def _live(trust: float, m: dict[str, float], study: Study) -> Text:
    run = study.run
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
