"""Compute the margin of each loop with the others closed: distance to −1 and delay margin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from observer_lab.engine import Plant, frequency_response

from .loops import Controllers, three
from .sensors import IDEAL_SENSORS, Sensors, reading_response

WIDE_BAND_RAD_S = np.geomspace(1e-2, 1e6, 400)  # rad/s
RESONANCE_FACTORS = np.array([0.9, 0.97, 0.99, 0.997, 1.0, 1.003, 1.01, 1.03, 1.1])  # times each of the loop's own frequencies


@dataclass(frozen=True)
class Margin:
    """nearest: min |1 + ℓ(jω)|; delay: s at which the loop is lost, ∞ where |ℓ| = 1 nowhere."""

    nearest: float
    delay: float


def margins(built: Controllers, S: np.ndarray, lower: float, poles: np.ndarray,
            sensors: Sensors = IDEAL_SENSORS) -> tuple[Margin | None, ...]:
    """Of the vertical, the rotation and the horizontal loop, cut at v with the others closed; None for one that is open.

    S_ii = [(I − P K)⁻¹]_ii with P the mixed channels as the sensors read them and K = diag(C_v, C_θ, C_h), signs included;
    1 + ℓ = 1/S_ii. On a grid that has every frequency of the loop's poles on it; the loop must be stable but for drift.
    """
    own = np.abs(np.concatenate([poles, np.imag(poles)]))
    omega = np.unique(
        np.concatenate(
            [WIDE_BAND_RAD_S, *(own[(own > WIDE_BAND_RAD_S[0]) & (own < WIDE_BAND_RAD_S[-1])] * near for near in RESONANCE_FACTORS)]
        )
    )
    plant = three(lower)
    P = reading_response(sensors, omega) @ frequency_response(plant.A, plant.B @ S, plant.C, np.zeros((3, 3)), omega)
    K = np.stack([_response(c, omega) for c in (built.vertical, built.rotation, built.horizontal)], axis=1)
    inverse = np.linalg.inv(np.eye(3) - K[:, :, None] * P)  # (I − K P)⁻¹: cut at the channels' inputs
    return tuple(None if c is None else _margin(omega, inverse[:, i, i])
                 for i, c in enumerate((built.vertical, built.rotation, built.horizontal)))


def _response(controller: Plant | None, omega: np.ndarray) -> np.ndarray:
    if controller is None:
        return np.zeros(len(omega), dtype=complex)
    return frequency_response(controller.A, controller.B, controller.C, controller.D, omega)[:, 0, 0]


def _margin(omega: np.ndarray, s: np.ndarray) -> Margin:
    ell = 1 / s - 1
    over = np.log(np.maximum(np.abs(ell), 1e-300))
    k = np.flatnonzero(over[:-1] * over[1:] < 0)
    share = over[k] / (over[k] - over[k + 1])
    at = omega[k] * (omega[k + 1] / omega[k]) ** share
    turn = np.angle(ell[k + 1] / ell[k])
    phase = np.mod(np.pi + np.angle(ell[k]) + share * turn, 2 * np.pi)
    return Margin(float(1 / np.abs(s).max()), float(np.min(phase / at, initial=np.inf)))
