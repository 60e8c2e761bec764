"""Model geophones: no velocity below a corner, tilt read as motion, noise that rises as 1/f."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from observer_lab.course.lesson import Design
from observer_lab.engine import Plant, frequency_response
from observer_lab.plants.platform import model
from observer_lab.plants.platform.channels import T_y

IDEAL, GEOPHONE = "ideal", "geophone"
SENSOR_DAMPING = 0.7  # of the suspended mass of a geophone, damped by its coil
GRAVITY = 9.81  # m/s²
HALF_DISTANCE_M = model.Parameters.s  # between the two sensors: the rotation channel reads −s times the pitch rate
BACK = 2 * T_y[:3].T  # from channels to readings; HL + HR is zero on a rigid deck


@dataclass(frozen=True)
class Sensors:
    """Corner of the geophones in Hz, 0 for sensors that read any velocity; whether the horizontal ones react to tilt."""

    corner: float = 0.0
    tilt: bool = False

    @property
    def omega(self) -> float:
        """The corner in rad/s."""
        return 2 * np.pi * self.corner


IDEAL_SENSORS = Sensors()


def sensors_of(design: Design) -> Sensors:
    """The sensors of a design."""
    return IDEAL_SENSORS if design["sensors"] == IDEAL else Sensors(design["corner"], bool(design["tilt"]))


def knee_of(design: Design) -> float:
    """Hz below which the sensors' own noise rises; 0 for white noise."""
    return 0.0 if design["sensors"] == IDEAL else design["knee"]


@lru_cache(maxsize=64)
def reading(sensors: Sensors) -> Plant:
    """From the true velocities of vertical, rotation and horizontal to those that are read (3×3).

    H = s²/(s² + 2ζω_c s + ω_c²) in each. Tilt θ looks like the acceleration g θ, and θ = −z₂/(s_m s) for sensors s_m from the
    middle: the horizontal reading has −(g/s_m)/(s² + 2ζω_c s + ω_c²) of the rotation z₂ in it.
    """
    if not sensors.corner:
        return Plant(np.zeros((0, 0)), np.zeros((0, 3)), np.zeros((3, 0)), np.eye(3))
    omega = sensors.omega
    own, seen = np.array([[0.0, -omega**2], [1.0, -2 * SENSOR_DAMPING * omega]]), np.array([[0.0, 1.0]])
    B = np.kron(np.eye(3), np.array([[-omega**2], [-2 * SENSOR_DAMPING * omega]]))
    if sensors.tilt:
        B[4, 1] = -GRAVITY / HALF_DISTANCE_M
    return Plant(np.kron(np.eye(3), own), B, np.kron(np.eye(3), seen), np.eye(3))


def behind_sensors(plant: Plant, sensors: Sensors) -> Plant:
    """The platform whose outputs (VL, HL, VR, HR) are what the sensors read; its own states come first."""
    if not sensors.corner:
        return plant
    s = reading(sensors)
    true = T_y[:3] @ plant.C
    A = np.block([[plant.A, np.zeros((plant.n, s.n))], [s.B @ true, s.A]])
    return Plant(A, np.vstack([plant.B, np.zeros((s.n, plant.m))]), BACK @ np.hstack([np.asarray(s.D) @ true, s.C]))


def reading_response(sensors: Sensors, omega: np.ndarray) -> np.ndarray:
    """`reading` at jω (n_ω, 3, 3)."""
    s = reading(sensors)
    return frequency_response(s.A, s.B, s.C, s.D, omega)


def own_gain(sensors: Sensors, f: np.ndarray) -> np.ndarray:
    """|H| of one sensor over f in Hz."""
    return np.abs(reading_response(sensors, 2 * np.pi * f)[:, 0, 0])


def rise(knee: float, f: np.ndarray) -> np.ndarray:
    """By how much the density of the self-noise has risen over its white part: 1 + knee/f."""
    return 1 + knee / f
