"""Compute each analysis of a plant by itself, so that one failure affects no other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.engine import (
    EngineError,
    Plant,
    compensator,
    controllability,
    error_parts,
    hankel_singular_values,
    kalman_decomposition,
    loop_margins,
    nis,
    observability,
    sensitivity,
)
from observer_lab.engine.design import in_natural_units
from observer_lab.engine.feedback import ChannelMargins, ClosedLoop, Sensitivity
from observer_lab.engine.filters import ErrorParts, Ladder, SquaredError, noise_ladder, simulate_filter
from observer_lab.engine.structure import Controllability, KalmanDecomposition, Observability, StableSplit, split_stable
from observer_lab.plants import Model
from observer_lab.text import Text, error_words, text

from ..toolkit.gains import noise_units

T = TypeVar("T")
MAX_LIVE_STATES = 8  # states up to which margins are found while a knob moves, whatever the eigenvectors
LATER = text("The margins of this loop take a while: the button under the knobs works them out.")
ASSUMED_NOISE_RATIOS = np.logspace(-3, 3, 5)  # beliefs on the ladder, times the true process noise
RECORD_SAMPLES = 160  # of the Kalman filter's record
UNTESTED_SAMPLES = 20  # samples that its test does not look at
PROCESS = 0.1  # size of the process noise, as a share of the natural input


@dataclass(frozen=True)
class Refusal:
    """Why an analysis says nothing about this plant."""

    text: Text


def attempt(analysis: Callable[[], T]) -> T | Refusal:
    """What an analysis finds, or its sentence why not."""
    try:
        return analysis()
    except (EngineError, KnobError) as problem:
        return Refusal(error_words(problem))
    except (np.linalg.LinAlgError, FloatingPointError, ZeroDivisionError):
        return Refusal(text("Rounding defeats this analysis; choose other units for states or time."))


# --- of the plant alone ------------------------------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class Structure:
    """Everything that no gain changes. `kept`: states set aside before the Hankel values because they are not stable."""

    seen: Observability | Refusal
    reached: Controllability | Refusal
    decomposition: KalmanDecomposition | Refusal
    hankel: np.ndarray | Refusal
    kept: int


@lru_cache(maxsize=32)
def structure(plant: Plant) -> Structure:
    """Observability and controllability in natural units, Kalman decomposition, Hankel values of the stable part."""
    split = attempt(lambda: split_stable(plant))
    kept = 0 if isinstance(split, Refusal) else split.unstable.n
    even = in_natural_units(plant)
    return Structure(attempt(lambda: observability(even)), attempt(lambda: controllability(even)),
                     attempt(lambda: kalman_decomposition(plant)), attempt(lambda: _hankel(split)), kept)


def _hankel(split: StableSplit | Refusal) -> np.ndarray:
    if isinstance(split, Refusal):
        raise KnobError(split.text)
    stable = split.stable
    if stable.n == 0:
        raise KnobError(text("No state is stable by itself, so there are no Hankel values."))
    return hankel_singular_values(stable)


# --- of the loop -------------------------------------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class Margins:
    """Of the loop cut at the inputs: by channel, the disk margin of all at once, and S of the loop."""

    channels: tuple[ChannelMargins, ...]
    together: float  # disk margin α of all inputs at once
    loop: Sensitivity
    target: Sensitivity  # had the state been known


@lru_cache(maxsize=64)
def _margins(plant: Plant, K: bytes, L: bytes) -> Margins:
    K_, L_ = np.frombuffer(K).reshape(plant.m, plant.n), np.frombuffer(L).reshape(plant.n, plant.p)
    found = loop_margins(plant, compensator(plant, K_, L_))
    whole = Plant(plant.A, plant.B, np.eye(plant.n), np.zeros((plant.n, plant.m)), plant.dt)
    channels, together = found.inputs, found.input_disk.alpha
    if not found.stable:
        raise KnobError(text("The loop is not stable, so it has no margins; move a pole."))
    return Margins(channels, float(together), found.loop, sensitivity(whole, -K_))


def margins(plant: Plant, K: np.ndarray, L: np.ndarray, patient: bool) -> Margins:
    """Margins at the inputs; the same numbers are worked out once. Raises KnobError where the loop is not stable.

    A large loop whose eigenvectors are poor takes seconds: whoever is not `patient` is told to press the button.
    """
    if not patient and plant.n > MAX_LIVE_STATES and sensitivity(plant, compensator(plant, K, L)).modal is None:
        raise KnobError(LATER)
    return _margins(plant, np.ascontiguousarray(K).tobytes(), np.ascontiguousarray(L).tobytes())


def certificates(plant: Plant, loop: ClosedLoop, K: np.ndarray, L: np.ndarray) -> tuple[tuple[Text, float], ...]:
    """Duality and separation as residuals, relative: each is a number that theory says is zero."""
    left = np.linalg.eigvals(plant.A - L @ plant.C)
    twin = np.linalg.eigvals(plant.A.T - plant.C.T @ L.T)
    size = max(float(np.abs(left).max()), 1e-300)
    apart = float(np.abs(np.sort(np.abs(left)) - np.sort(np.abs(twin))).max() / size)
    n = plant.n
    corner = float(np.abs(loop.A_xe[n:, :n]).max() / max(np.abs(loop.A_xe).max(), 1e-300))
    return (
        (text("eig(A − LC) against its dual's"), apart),
        (text("spectrum of the loop against the union"), min(loop.union_error, loop.polynomial_error)),
        (text("corner of the loop in (x, e)"), corner),
    )


# --- of the noise ------------------------------------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class Noise:
    """The observer of the design among the Kalman filters of other beliefs; `ours`: its error's parts."""

    ladder: Ladder
    ours: ErrorParts | Refusal
    unit: np.ndarray  # (n,) what counts as one in each state


def noises(model: Model, sensor: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """G, W and V: process noise of a tenth of the natural input, sensor noise of `sensor` times the outputs at the start."""
    G, W, V = noise_units(model)
    return G, PROCESS**2 * W, sensor**2 * V


@lru_cache(maxsize=64)
def _ladder(plant: Plant, G: bytes, W: bytes, V: bytes) -> Ladder:
    G_ = np.frombuffer(G).reshape(plant.n, -1)
    q = G_.shape[1]
    return noise_ladder(plant, G_, np.frombuffer(W).reshape(q, q), np.frombuffer(V).reshape(plant.p, plant.p), ASSUMED_NOISE_RATIOS)


def noise(model: Model, L: np.ndarray, sensor: float) -> Noise:
    """The ladder of beliefs, and where the design's own observer stands."""
    G, W, V = noises(model, sensor)
    ladder = _ladder(model.plant, *(np.ascontiguousarray(M).tobytes() for M in (G, W, V)))
    size = np.abs(np.array(model.x0))
    return Noise(ladder, attempt(lambda: error_parts(model.plant, L, G, W, V)), np.where(size > 0, size, 1.0))


@dataclass(frozen=True, eq=False)
class Trial:
    """A Kalman filter with a belief, on one drawn record: how its gain settles, NIS at each sample, and the verdict.

    `expected`: what NIS is on average once all has settled, worked out and not drawn.
    """

    t: np.ndarray
    distance: np.ndarray
    values: np.ndarray
    test: SquaredError
    expected: float


def trial(model: Model, sensor: float, belief: float, seed: int) -> Trial:
    """The sampled plant held by its own filter's estimate, watched by a filter that believes `belief` times the noise."""
    G, W, V = (np.ascontiguousarray(M).tobytes() for M in noises(model, sensor))
    return _trial(model.plant, G, W, V, model.plant.dt or model.horizon / RECORD_SAMPLES, belief, seed)


@lru_cache(maxsize=64)
def _trial(plant: Plant, G: bytes, W: bytes, V: bytes, step: float, belief: float, seed: int) -> Trial:
    G_ = np.frombuffer(G).reshape(plant.n, -1)
    q = G_.shape[1]
    found = simulate_filter(plant, G_, np.frombuffer(W).reshape(q, q), np.frombuffer(V).reshape(plant.p, plant.p),
                            step, RECORD_SAMPLES,
                         believed=(belief, 1.0), seed=seed)
    track = found.track
    if len(found.run.t) <= 2 * UNTESTED_SAMPLES:
        raise KnobError(text("The plant grows without bound before the filter can be judged."))
    early, test = (
        nis(track.innovations[:UNTESTED_SAMPLES], track.S[:UNTESTED_SAMPLES]),
        nis(track.innovations[UNTESTED_SAMPLES:], track.S[UNTESTED_SAMPLES:]),
    )
    return Trial(found.run.t, found.distance, np.concatenate([early.values, test.values]), test, found.expected)
