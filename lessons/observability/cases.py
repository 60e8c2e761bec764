"""Define four plants with their sensors, and compute rank, distances and Gramian.

States and readings are measured in typical sizes (`scale`, `reading`), so that a distance has no unit: z = x/scale.
The notes' example and the two textbook cases have typical sizes of one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np
from scipy.linalg import expm

from observer_lab.course.lesson import Design
from observer_lab.engine import Plant, observability
from observer_lab.engine.structure import Observability, observability_gramian
from observer_lab.plants.platform.model import DECK_MODEL, Parameters
from observer_lab.text import Text, text

NOTES_A = np.array([[1.0, 2.0], [3.0, 4.0]])
READING = 0.018  # m/s, a typical reading of the deck's sensors


@dataclass(frozen=True, eq=False)
class Case:
    """A plant before its sensors: typical sizes, how long is listened, and which states are drawn.

    `start`: x(0) in typical sizes. `drawn`: states to the right, away and up in 3-D (None: nothing).
    `pair`: states of the plane figure. `units`: what a state is shown in, `shown` times its SI value.
    """

    id: str
    label: Text
    names: tuple[str, ...]
    scale: tuple[float, ...]
    start: tuple[float, ...]
    horizon: float
    steps: int
    drawn: tuple[int | None, int | None, int]
    pair: tuple[int, int]
    units: tuple[str, ...]
    shown: float = 1.0
    labels: tuple[Text, ...] = ()  # of the states, where they have names


@dataclass(frozen=True, eq=False)
class Sensed:
    """A plant with its present sensors, in typical sizes, and what they tell in time.

    `powers` (n_t, n, n) = e^{At}; `energy` (n_t, n, n) = W(t) = ∫₀ᵗ e^{Aᵀτ}CᵀCe^{Aτ}dτ with its eigenvalues
    `heard` (n_t, n), ascending, and eigenvectors `axes`; `root`: a square root of one step of W; `dust`: the size that
    rounding may have in an eigenvalue of W at the end.
    """

    plant: Plant
    seen: Observability
    t: np.ndarray
    powers: np.ndarray
    energy: np.ndarray
    heard: np.ndarray
    axes: np.ndarray
    root: np.ndarray
    dust: float


_RATE = 8.0  # rad/s, typical of the deck: turns sizes of positions into those of velocities
_SIZES = (0.002, 0.002, 0.01)
_MANY = tuple(f"x{i + 1}" for i in range(20))
PLANT_CASES: Mapping[str, Case] = MappingProxyType({case.id: case for case in (
    Case("deck", text("platform deck with sensors to move"), ("x", "z", "θ", "vx", "vz", "ω"),
         (*_SIZES, *(_RATE * s for s in _SIZES)), (0.75, 0.8, -0.6, 0.0, 0.3, 0.4), DECK_MODEL.horizon, 120, (0, 2, 1), (2, 1),
         ("mm", "mm", "mrad", "mm/s", "mm/s", "mrad/s"), 1e3),
    Case("notes", text("the notes' A = [1 2; 3 4]"), ("x1", "x2"), (1.0, 1.0), (0.7, -0.5), 1.0,
         120, (0, None, 1), (0, 1), ("", "")),
    Case("pair", text("two modes almost alike"), ("x1", "x2"), (1.0, 1.0), (0.7, -0.5), 4.0, 120,
         (0, None, 1), (0, 1), ("", "")),
    Case("many", text("modes −1, −2, … −n, one sensor"), _MANY, (1.0,) * 20,
         tuple(0.7 * (-1.0) ** i for i in range(20)), 4.0, 60, (0, 2, 1), (0, 1), ("",) * 20),
)})


def rows(case: Case, design: Design) -> np.ndarray:
    """C (p×n) in typical sizes: what the sensors that are on read."""
    if case.id == "deck":
        found = []
        if design["left_on"]:
            found.append((0, 0, 0, 0, 1, design["left"]))
        if design["right_on"]:
            found.append((0, 0, 0, 0, 1, design["right"]))
        if design["across_on"]:
            found.append((0, 0, 0, 1, 0, Parameters.h))
        return np.array(found or [(0.0,) * 6], dtype=float) * np.array(case.scale) / READING
    if case.id == "notes":
        return direction(design["angle"])
    return np.ones((1, 2 if case.id == "pair" else int(design["count"])))


def direction(degrees: float) -> np.ndarray:
    """C = [cos φ, sin φ], exactly [1 0] at 0°."""
    return np.array([[np.cos(np.radians(degrees)), np.sin(np.radians(degrees))]])


def dynamics(case: Case, design: Design) -> np.ndarray:
    """A (n×n) in typical sizes."""
    if case.id == "deck":
        S = np.array(case.scale)
        return DECK_MODEL.plant.A * S / S[:, None]
    if case.id == "notes":
        return NOTES_A
    return np.diag([-1.0, -1.0 - design["gap"]]) if case.id == "pair" else -np.diag(np.arange(1.0, design["count"] + 1))


def sensed(design: Design) -> Sensed:
    """The plant of a design with its sensors; the same numbers are worked out once."""
    case = PLANT_CASES[design["plant"]]
    A, C = dynamics(case, design), rows(case, design)
    return sensed_by(case, A.shape[0], A.tobytes(), C.tobytes())


@lru_cache(maxsize=64)
def sensed_by(case: Case, n: int, a: bytes, c: bytes) -> Sensed:
    """A plant (n×n, in typical sizes) with sensors (p×n), both as bytes, and what they tell in time."""
    plant = Plant(np.frombuffer(a).reshape(n, n), np.zeros((n, 1)), np.frombuffer(c).reshape(-1, n),
                  state_names=case.names[:n], name=case.id)
    t = np.linspace(0.0, case.horizon, case.steps + 1)
    step, first = expm(plant.A * t[1]), observability_gramian(plant, float(t[1]))
    powers = np.empty((len(t), n, n))
    powers[0] = np.eye(n)
    for k in range(1, len(t)):
        powers[k] = powers[k - 1] @ step
    energy = np.zeros_like(powers)
    np.cumsum(powers[:-1].transpose(0, 2, 1) @ first @ powers[:-1], axis=0, out=energy[1:])
    heard, axes = np.linalg.eigh(energy)
    values, vectors = np.linalg.eigh(first)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return Sensed(plant, observability(plant), t, powers, energy, np.maximum(heard, 0.0), axes, root,
                  _dust(powers, float(values[-1])))


def _dust(powers: np.ndarray, step: float) -> float:
    """n·eps·Σ‖e^{At}‖²‖W(h)‖: on a growing plant rounding is as large as what a hidden growing mode would leave."""
    return powers.shape[1] * float(np.finfo(float).eps * np.sum(powers**2)) * step


def label(case: Case, i: int) -> Text | str:
    """What a state is called: a symbol, or a name."""
    return case.labels[i] if case.labels else case.names[i]


def unit(case: Case, i: int) -> Text | str:
    """The name of a state with its unit, for an axis."""
    name, measure = label(case, i), case.units[i]
    if not measure:
        return name
    return f"{name} [{measure}]" if isinstance(name, str) else text("{name} [{measure}]", name=name, measure=measure)


def shown(case: Case, values: np.ndarray, indices: tuple[int, ...]) -> np.ndarray:
    """Values in typical sizes (…, len(indices)) as they are printed."""
    return values * np.array([case.scale[i] for i in indices]) * case.shown
