"""Model the rigid deck with hardening springs and coils that weaken as the gap opens.

State (x, z, θ, vx, vz, ω) and inputs (u1, u2, u3) as in `platform.deck`. A spring of stiffness k stretched by e pulls with
k e (1 + γ (e/ℓ)²); a coil displaced by d from its middle pushes with u e^{−ν d/ℓ}. With γ = ν = 0 it is the linear deck.
Both laws are additions of ours: the report names such effects as reasons for an extended filter and gives no numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...engine import NonlinearPlant
from . import model


@dataclass(frozen=True)
class NonlinearLaws:
    """hardening γ: share by which a spring stretched by `length` is stiffer; weakening ν of the coils; length ℓ in m."""

    hardening: float = 0.5
    weakening: float = 0.2
    length: float = 0.005


DEFAULT = model.Parameters()


def plant(laws: NonlinearLaws = NonlinearLaws(), parameters: model.Parameters = DEFAULT) -> NonlinearPlant:
    """M q̈ + D q̇ + K q + Eᵀ diag(k γ/ℓ²) (E q)³ = G diag(e^{−ν G'q/ℓ}) u, y = S q̇ (VL, HL, VR, HR)."""
    k, (A, B, C, enter) = parameters, linear_parts(parameters)
    # the stretches of the three springs, then the displacements of the three coils
    middle = np.array([[0, 1, -k.a, 0, 0, 0], [0, 1, k.a, 0, 0, 0], [1, 0, k.h, 0, 0, 0],
                       [0, 1, -k.b, 0, 0, 0], [0, 1, k.b, 0, 0, 0], [1, 0, k.h, 0, 0, 0]])
    cubic = -enter * (np.array([k.kz, k.kz, k.kx]) * laws.hardening / laws.length**2)
    into, both = np.hstack([cubic, B]), np.vstack([A, middle])
    rate = -laws.weakening / laws.length

    def rhs(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        read = both @ x
        stretch, forces = read[6:9], read[6:]
        forces[3:] = u * np.exp(rate * read[9:])
        stretch *= stretch * stretch
        return read[:6] + into @ forces

    def slope(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        read = middle @ x
        read[:3] *= 3 * read[:3]
        read[3:] = rate * u * np.exp(rate * read[3:])
        return A + (into * read.T[:, None, :]) @ middle

    def output(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return C @ x

    def output_slope(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.broadcast_to(C, (x.shape[1], *C.shape))

    return NonlinearPlant(6, 3, 4, rhs, slope, output, output_slope, "deck on hardening springs")


@lru_cache(maxsize=4)
def linear_parts(parameters: model.Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A, B, C of the deck, and M⁻¹Eᵀ below zeros: how spring forces enter the six states."""
    deck, k = model.deck(parameters), parameters
    springs = np.array([[0, 1, -k.a], [0, 1, k.a], [1, 0, k.h]])
    return deck.A, deck.B, deck.C, np.vstack([np.zeros((3, 3)), np.linalg.solve(model.rigid(parameters).M, springs.T)])
