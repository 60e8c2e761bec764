"""Balance the platform: its modes by strength, and three Hankel values from its geometry."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from observer_lab.engine import Plant, balanced_truncation
from observer_lab.plants.platform.lqg_weights import COIL_COUNT
from observer_lab.plants.platform.model import Parameters, in_time_units, plant
from observer_lab.text import Text, subscript, text

from .study import Reduced, System

STATE_COUNT = 10
HEARD = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, np.sqrt(2.0), 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])  # HR = −HL: three rows do
MODE_NAMES = (text("up and down"), text("sideways, with pitch"), text("pitch, with sideways"), text("test masses together"),
         text("test masses against each other"))
VERTICAL_MODE, SIDEWAYS_MODE, PITCH_MODE, MASSES_TOGETHER_MODE, MASSES_AGAINST_MODE = range(5)


@dataclass(frozen=True, eq=False)
class Motion:
    """One mode: pole with Im > 0, shape of the ten states, and its strength ‖C v‖ ‖wᴴB‖/(2|Re λ|) with wᴴv = 1.

    The strength is what both Hankel values of a mode are if it is lightly damped and stands alone. kind: index into MODE_NAMES.
    """

    pole: complex
    shape: np.ndarray
    strength: float
    kind: int

    @property
    def frequency(self) -> float:
        """|λ|/2π in Hz."""
        return abs(self.pole) / (2 * np.pi)

    @property
    def damping(self) -> float:
        """−Re λ/|λ|."""
        return -self.pole.real / abs(self.pole)

    @property
    def name(self) -> Text:
        """What moves."""
        return MODE_NAMES[self.kind]


@dataclass(frozen=True, eq=False)
class Platform(System):
    """A platform, balanced. unit: metres of ground motion that count as one at the plant's last two inputs; its coils count newtons."""

    parameters: Parameters
    unit: float
    motions: tuple[Motion, ...]

    def pair(self, kind: int) -> int:
        """Which pair of Hankel values, counted from 0, is this kind of motion's."""
        return [m.kind for m in self.motions].index(kind)

    def heard(self, plant: Plant) -> np.ndarray:
        """The response with rows (VL, √2 HL, VR)."""
        return super().heard(Plant(plant.A, plant.B, HEARD @ plant.C, HEARD @ np.asarray(plant.D)))

    def counted(self, clock: float) -> Plant:
        """The plant with its time in units of `clock` seconds; metres, radians and newtons stay."""
        return in_time_units(self.plant, clock)

    def reduced(self, order: int) -> Reduced:
        """The first `order` balanced states, which is the balanced truncation to that order."""
        b = self.balanced
        small = Plant(b.plant.A[:order, :order], b.plant.B[:order], b.plant.C[:, :order], b.plant.D)
        return small, b.T[:, :order], b.left[:order], float(2 * self.hankel[order:].sum())


@lru_cache(maxsize=32)
def system(parameters: Parameters, unit: float = 1.0) -> Platform:
    """The plant of these parameters, the ground counted in units of `unit` m, balanced."""
    P = plant(parameters)
    P = replace(P, B=P.B * np.append(np.ones(COIL_COUNT), np.full(P.m - COIL_COUNT, unit)))
    motions = _motions(parameters, P)
    about = [m.frequency * (1 + m.damping * np.linspace(-3, 3, 13)) for m in motions]  # Hz: 0.01 to 300, denser about every mode
    f = np.unique(np.concatenate([np.geomspace(0.01, 300, 130), *about]))
    return Platform(P, balanced_truncation(P, STATE_COUNT), f, parameters, unit, motions)


def believed(s: Platform, order: int, x: np.ndarray) -> np.ndarray:
    """What a model of `order` states can hold of states x (…, 10): the projection T_r left_r x."""
    _, T, left, _ = s.reduced(order)
    return x @ (T @ left).T


def closed_forms(p: Parameters, unit: float = 1.0) -> tuple[tuple[int, float], ...]:
    """(kind of motion, Hankel value) of three pairs from the geometry alone, to first order in ζ and μ/m.

    With N_z = √(2 + (2k_z g)²) in N and N_θ = √(2b² + h² + (k_x h g)²) in N m, what one unit of every input lifts and turns
    (g: the unit of the ground): vertical √2 N_z/(4c_z), test masses together √2 N_z μ²/(m² c_p), against each other
    √2 N_θ μ² s² √(s²+h²)/(J² c_p). No k_p is left in any of them.
    """
    root, lift = np.sqrt(2), np.hypot(np.sqrt(2), 2 * p.kz * unit)
    turn = np.sqrt(2 * p.b**2 + p.h**2 + (p.kx * p.h * unit) ** 2)
    return ((VERTICAL_MODE, float(root * lift / (4 * p.cz))),
            (MASSES_TOGETHER_MODE, float(root * lift * p.mu**2 / (p.m**2 * p.cp))),
            (MASSES_AGAINST_MODE, float(root * turn * p.mu**2 * p.s**2 * np.hypot(p.s, p.h) / (p.J**2 * p.cp))))


def relative(p: Parameters, x: np.ndarray) -> np.ndarray:
    """(x, z, θ, p_L − z + sθ, p_R − z − sθ): the test masses as their sensors see them; x (…, 10) or (…, 5)."""
    left, right = x[..., 3] - x[..., 1] + p.s * x[..., 2], x[..., 4] - x[..., 1] - p.s * x[..., 2]
    return np.stack([x[..., 0], x[..., 1], x[..., 2], left, right], axis=-1)


def _motions(p: Parameters, P: Plant) -> tuple[Motion, ...]:
    poles, shapes = np.linalg.eig(P.A)
    upper = np.flatnonzero(np.imag(poles) > 0)
    into = np.linalg.inv(shapes)[upper] @ P.B
    strength = np.linalg.norm(P.C @ shapes[:, upper], axis=0) * np.linalg.norm(into, axis=1) / (2 * np.abs(np.real(poles[upper])))
    order = np.argsort(-strength)
    return tuple(Motion(complex(poles[upper[i]]), shapes[:, upper[i]], float(strength[i]), _kind(p, shapes[:, upper[i]]))
                 for i in order)


def _kind(p: Parameters, shape: np.ndarray) -> int:
    """By where the kinetic energy is: in the test masses against the deck, or in z, x, θ."""
    moved = relative(p, shape)
    energy = np.array([p.m, p.m, p.J, p.mu, p.mu]) * np.abs(moved) ** 2
    if energy[3] + energy[4] > energy[:3].sum():
        return MASSES_TOGETHER_MODE if (moved[3] * moved[4].conj()).real > 0 else MASSES_AGAINST_MODE
    return (SIDEWAYS_MODE, VERTICAL_MODE, PITCH_MODE)[int(energy[:3].argmax())]


def sigmas(pair: int) -> str:
    """σ₁, σ₂ of the first pair, and so on; pair counts from 0."""
    return subscript(f"σ{2 * pair + 1},\N{NO-BREAK SPACE}σ{2 * pair + 2}")
