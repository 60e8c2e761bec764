"""Estimate x(0) from y, exact and noisy, and run two starts: do the readings tell them apart?"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from scipy.special import chdtri

from observer_lab.course.figures.records import Curve, LineFigure
from observer_lab.course.lesson import Design
from observer_lab.text import Text, format_number, text

from .cases import Case, Sensed, shown, unit

KNOWN_SHARE = 0.1  # a direction is known when its half axis has shrunk to a tenth
SIGMAS_FOR_95_PERCENT = tuple(float(np.sqrt(chdtri(k, 0.05))) for k in (1, 2, 3))  # σ that hold 95 % of 1, 2, 3 normal numbers
STARTS_TAB = text("Two starts")
SAME_READING = 1e-9  # of the difference of the starts: readings nearer than this differ by rounding alone
DECK_STATES = MappingProxyType({"x": 0, "z": 1, "theta": 2})  # of the deck: which state the second start changes


@dataclass(frozen=True, eq=False)
class Rebuilt:
    """x(0) from the first `rows` block rows of O: `guess` (n,), numerical `rank`, and per state the share fixed by them.

    `data` = (y, ẏ, ÿ, …) at t = 0 as read, `exact` the same without reading errors; `sizes`: singular values.
    """

    rows: int
    matrix: np.ndarray
    data: np.ndarray
    exact: np.ndarray
    guess: np.ndarray
    sizes: np.ndarray
    rank: int
    share: np.ndarray


@dataclass(frozen=True, eq=False)
class Belief:
    """What y on [0, t] with white noise of intensity v says about x(0), before which x(0) ~ N(0, I).

    `P` (n_t, n, n) = (I + W(t)/v)⁻¹, `mean` (n_t, n), `halves` (n_t, n) = half axes of the 1σ ellipsoid, longest first.
    """

    P: np.ndarray
    mean: np.ndarray
    halves: np.ndarray

    @property
    def known(self) -> int:
        """How many directions are known to a tenth at the end."""
        return int(np.count_nonzero(self.halves[-1] <= KNOWN_SHARE))


def rebuild(s: Sensed, start: np.ndarray, blocks: int, reading: float, rtol: float, seed: int) -> Rebuilt:
    """O_k x(0) = (y, ẏ, …, y^(k−1)) solved by least squares; each derivative is read with relative error `reading`.

    Singular values at or below rtol·σ₁ count as zero: those directions of x(0) stay open and are set to 0.
    """
    O = s.seen.matrix[:blocks * s.plant.p]
    exact = O @ start
    data = exact * (1 + reading * np.random.default_rng(seed).standard_normal(len(exact)))
    U, sizes, Vt = np.linalg.svd(O, full_matrices=False)
    rank = int(np.count_nonzero(sizes > rtol * sizes[0])) if sizes[0] > 0 else 0
    V = Vt[:rank].T
    guess = V @ ((U[:, :rank].T @ data) / sizes[:rank])
    return Rebuilt(blocks, O, data, exact, guess, sizes, rank, np.sum(V * V, axis=1))


def learn(s: Sensed, start: np.ndarray, noise: float, seed: int) -> Belief:
    """P(t)⁻¹ = I + W(t)/v, P⁻¹ mean = (1/v)∫e^{Aᵀτ}Cᵀ dy, with v = noise²·T: the noise in shares of a typical reading.

    The noise term of one step has covariance e^{Aᵀτ} W(h) e^{Aτ}/v exactly, so the ellipsoid and its centre agree.
    """
    v = noise**2 * s.t[-1]
    halves = 1 / np.sqrt(1 + s.heard / v)
    P = (s.axes * (halves**2)[:, None, :]) @ s.axes.transpose(0, 2, 1)
    draws = np.random.default_rng(seed).standard_normal((len(s.t) - 1, s.plant.n)) @ s.root.T / np.sqrt(v)
    drift = np.zeros((len(s.t), s.plant.n))
    np.cumsum(np.einsum("kji,kj->ki", s.powers[:-1], draws), axis=0, out=drift[1:])
    heard = s.energy @ start / v + drift
    return Belief(P, np.einsum("kij,kj->ki", P, heard), halves)


@dataclass(frozen=True, eq=False)
class TwoStarts:
    """Two free runs: their start, the difference v (n,) of the second, their states and readings (n_t, n) and (n_t, p).

    `gap`: the largest difference of the readings, |C e^{At} v|, in typical readings. `state`: the state that v changes most.
    """

    start: np.ndarray
    v: np.ndarray
    states: tuple[np.ndarray, np.ndarray]
    readings: tuple[np.ndarray, np.ndarray]

    @property
    def gap(self) -> float:
        """How far the readings come apart."""
        return float(np.abs(self.readings[1] - self.readings[0]).max(initial=0.0))

    @property
    def state(self) -> int:
        """The state in which the two starts differ most."""
        return int(np.argmax(np.abs(self.v)))


def two_starts(s: Sensed, start: np.ndarray, design: Design) -> TwoStarts:
    """x₁(0) = start and x₂(0) = start + Δ d: d is the chosen motion of the deck, else the direction that the readings show least.

    That direction is the eigenvector of the least eigenvalue of W(T), in the kernel of O where the plant is not observable.
    """
    chosen = dict(design.values).get("second") if dict(design.values).get("plant") == "deck" else None
    direction = s.axes[-1][:, 0] if chosen is None else np.eye(len(start))[DECK_STATES[chosen]]
    v = design["apart"] * direction
    states = tuple(s.powers @ x for x in (start, start + v))
    return TwoStarts(start, v, states, tuple(x @ s.plant.C.T for x in states))  # type: ignore[arg-type]


def starts_figures(case: Case, s: Sensed, found: TwoStarts, noise: float) -> tuple[LineFigure, LineFigure]:
    """The readings of both starts, and the state in which they differ most."""
    first, second = found.readings
    sensor = int(np.argmax(np.abs(second - first).max(axis=0)))
    quiet, alike = not np.any(s.plant.C), not np.any(found.v)
    said = text("No sensor is on: there is no reading.") if quiet else text("Both starts are the same.") if alike else (
        _told(s, found, noise))
    i = found.state
    values = [shown(case, x[:, [i]], (i,))[:, 0] for x in found.states]
    names = text("first start"), text("second start")
    readings = LineFigure(
        "two-readings", text("reading of both starts"), s.t,
        (Curve(names[0], first[:, sensor], "plant", "solid", 3.0), Curve(names[1], second[:, sensor], "second", "dash")),
        text("y, in typical readings"), tab=STARTS_TAB, caption=said)
    states = LineFigure(
        "two-states", text("the state in which they differ"), s.t,
        (Curve(names[0], values[0], "plant"), Curve(names[1], values[1], "second", "dash")), unit(case, i), tab=STARTS_TAB,
        caption=text("At the start they are {apart} {unit} apart.", apart=format_number(abs(values[1][0] - values[0][0]), ".3g"),
                     unit=case.units[i]) if case.units[i] else
        text("At the start they are {apart} apart.", apart=format_number(abs(values[1][0] - values[0][0]), ".3g")))
    return readings, states


def _told(s: Sensed, found: TwoStarts, noise: float) -> Text:
    """Whether the readings tell two different starts apart: not at all, only without noise, or clearly."""
    if not s.seen.observable and found.gap <= SAME_READING * float(np.abs(found.v).max()):
        return text("The readings of both starts agree at every time: no record distinguishes the two.")
    if found.gap < noise:
        return text("The readings differ by at most {gap:.2g} of a typical reading, less than their noise.", gap=found.gap)
    return text("The readings differ by up to {gap:.2g} of a typical reading, so they distinguish the two starts.", gap=found.gap)
