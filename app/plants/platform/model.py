"""Model the platform: a rigid deck on three springs, moved by three voice coils.

With ten states it carries the two small test masses of its inertial sensors ("platform"); in the limit of a very
stiff servo spring they ride with the deck and six states remain ("deck"). The report that this plant is taken from
prints its structure and ten Hankel singular values but no matrices: these parameters reproduce the published list,
so this is a plausible plant, not the only one; `calibration` solves for them and says what stays open.

Coordinates q = (x, z, θ, p_L, p_R): centre of mass, pitch with the right side up positive, heights of the test
masses. M q̈ + D q̇ + K q = G u, y = S q̇, state (q, q̇). Inputs u1, u2 (left and right vertical coil, N), u3
(horizontal coil, N), zg, xg (ground motion, m). Outputs VL, HL, VR, HR in m/s, in this order; HR = −HL because the
right sensor is mounted turned by half a revolution, so C has rank three.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from ...engine import Plant
from ...text import text
from ..bodies.body import Body
from ..bodies.deck_body import deck_body, held_at, platform_body
from ..grip import Grip
from ..model import Model, Signal, Window

STATE_NAMES = ("x", "z", "theta", "vx", "vz", "omega")
MASS_STATES = ("x", "z", "theta", "pL", "pR", "vx", "vz", "omega", "vL", "vR")
COIL_IDS = ("u1", "u2", "u3")
GROUND_INPUTS = ("zg", "xg")
SENSOR_IDS = ("VL", "HL", "VR", "HR")
SIGNAL_UNITS = tuple({
    "x": "m", "z": "m", "theta": "rad", "pL": "m", "pR": "m",
    "vx": "m/s", "vz": "m/s", "omega": "rad/s", "vL": "m/s", "vR": "m/s",
    "u1": "N", "u2": "N", "u3": "N", "zg": "m", "xg": "m",
    "VL": "m/s", "HL": "m/s", "VR": "m/s", "HR": "m/s",
}.items())
SOURCE = "Course report on a three-degree-of-freedom active platform; parameters reconstructed from its Hankel values"


@dataclass(frozen=True)
class Parameters:
    """Deck, springs, coils and sensors.

    m kg, J kg m²: deck with payload. kz, kx N/m and cz, cx N s/m: each vertical spring and the horizontal one.
    a, b, s m: half distances of the vertical springs, the vertical coils, the sensors. h m: how far the centre of
    mass lies above the deck plane. mu kg, kp N/m, cp N s/m: test mass, servo spring and damper of a sensor.
    lower m: how far below the deck plane, where the horizontal spring pulls, the horizontal coil pushes.
    ground: share of the ground motion that the springs pass on (1 = all of it).
    """

    m: float = 12.0
    J: float = 0.48
    kz: float = 533.0
    cz: float = 0.658
    kx: float = 475.74
    cx: float = 0.90826
    a: float = 0.158
    h: float = 0.014978
    b: float = 0.20
    s: float = 0.072391
    mu: float = 0.050
    kp: float = 1800.0
    cp: float = 0.479852
    lower: float = 0.0
    ground: float = 1.0


@dataclass(frozen=True)
class Mechanics:
    """The second-order form M q̈ + D q̇ + K q = G u, y = S q̇."""

    M: np.ndarray
    D: np.ndarray
    K: np.ndarray
    G: np.ndarray
    S: np.ndarray

    def reduced(self, T: np.ndarray) -> Mechanics:
        """The same mechanism with its motion restricted to q = T r (Lagrange: TᵀMT and so on)."""
        return Mechanics(T.T @ self.M @ T, T.T @ self.D @ T, T.T @ self.K @ T, T.T @ self.G, self.S @ T)

    def matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A, B, C of the state (q, q̇)."""
        n = len(self.M)
        A = np.block([[np.zeros((n, n)), np.eye(n)],
                      [-np.linalg.solve(self.M, self.K), -np.linalg.solve(self.M, self.D)]])
        B = np.vstack([np.zeros((n, self.G.shape[1])), np.linalg.solve(self.M, self.G)])
        return A, B, np.hstack([np.zeros((len(self.S), n)), self.S])


def mechanics(parameters: Parameters = Parameters()) -> Mechanics:
    """M, D, K (5×5), G (5×5), S (4×5) of the deck with its two test masses."""
    k = parameters
    left, right = np.array([0, 1, -k.a, 0, 0]), np.array([0, 1, k.a, 0, 0])
    across, coil = np.array([1, 0, k.h, 0, 0]), np.array([1, 0, k.h + k.lower, 0, 0])
    servo_left, servo_right = np.array([0, 1, -k.s, -1, 0]), np.array([0, 1, k.s, 0, -1])

    def joined(vertical: float, horizontal: float, servo: float) -> np.ndarray:
        return (vertical * (np.outer(left, left) + np.outer(right, right)) + horizontal * np.outer(across, across)
                + servo * (np.outer(servo_left, servo_left) + np.outer(servo_right, servo_right)))

    G = np.column_stack([np.array([0, 1, -k.b, 0, 0]), np.array([0, 1, k.b, 0, 0]), coil,
                         k.ground * k.kz * (left + right), k.ground * k.kx * across])
    S = np.array([[0, 1, -k.s, 0, 0], [1, 0, k.h, 0, 0], [0, 1, k.s, 0, 0], [-1, 0, -k.h, 0, 0]])
    return Mechanics(np.diag([k.m, k.m, k.J, k.mu, k.mu]), joined(k.cz, k.cx, k.cp), joined(k.kz, k.kx, k.kp), G, S)


def plant(parameters: Parameters = Parameters()) -> Plant:
    """All ten states, inputs (u1, u2, u3, zg, xg), outputs (VL, HL, VR, HR)."""
    A, B, C = mechanics(parameters).matrices()
    return Plant(A, B, C, state_names=MASS_STATES, input_names=COIL_IDS + GROUND_INPUTS, output_names=SENSOR_IDS, units=SIGNAL_UNITS,
                 name="platform")


def in_time_units(full: Plant, unit: float) -> Plant:
    """The same plant with time counted in units of `unit` seconds, τ = t/unit; the outputs stay in m/s.

    x = S x̃ with S = diag(1, …, 1/unit, …), for velocities are per unit of τ: Ã = unit S⁻¹AS, B̃ = unit S⁻¹B, C̃ = CS.
    Hankel values stay, the singular values of controllability and observability matrices do not.
    """
    half = full.n // 2
    S = np.concatenate([np.ones(half), np.full(full.n - half, 1 / unit)])
    return Plant(unit * full.A * S / S[:, None], unit * full.B / S[:, None], full.C * S, name=full.name)


def deck(parameters: Parameters = Parameters()) -> Plant:
    """Six states, three coils: the limit kp → ∞, where the test masses belong to the deck (m + 2μ, J + 2μs²)."""
    A, B, C = rigid(parameters).matrices()
    return Plant(A, B[:, :3], C, state_names=STATE_NAMES, input_names=COIL_IDS, output_names=SENSOR_IDS, units=SIGNAL_UNITS, name="deck")


def deck_disturbance(parameters: Parameters = Parameters()) -> np.ndarray:
    """G (6×2): how ground motion (zg, xg) in m enters the six states of `deck`."""
    return rigid(parameters).matrices()[1][:, 3:]


def rigid(parameters: Parameters = Parameters()) -> Mechanics:
    """The mechanism with p_L = z − sθ and p_R = z + sθ held rigidly."""
    s = parameters.s
    T = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, -s], [0, 1, s]], dtype=float)
    return mechanics(parameters).reduced(T)


def body(parameters: Parameters = Parameters()) -> Body:
    """The platform on the stage, with test masses that move: state (x, z, θ, p_L, p_R, …)."""
    return platform_body(parameters.a, parameters.b, parameters.s, parameters.h)


def rigid_body(parameters: Parameters = Parameters()) -> Body:
    """The rigid deck on the stage: state (x, z, θ, …)."""
    return deck_body(parameters.a, parameters.b, parameters.s, parameters.h)


def _pairs(*upper: complex) -> tuple[complex, ...]:
    return tuple(pole for p in upper for pole in (p.conjugate(), p))


def _watched(width: int) -> tuple[Signal, ...]:
    def weights(index: int) -> tuple[float, ...]:
        return tuple(float(i == index) for i in range(width))

    return (
        Signal(text("height of the deck z"), weights(1), "mm", 1e3),
        Signal(text("pitch of the deck θ"), weights(2), "mrad", 1e3),
        Signal(text("horizontal position x"), weights(0), "mm", 1e3),
    )


def grips(plant: Plant) -> tuple[Grip, ...]:
    """A hand pulls the deck up or down where its right coil acts."""
    return (Grip("pull", text("force of a hand on the deck"), ("deck",), partial(held_at, Parameters.h), (0.0, 0.0, 1.0),
                 tuple(plant.B[:, 1].tolist()), 1.5),)


CONTROLLER_POLES = _pairs(-6 + 7j, -5 + 6j, -4 + 5j)
OBSERVER_POLES = _pairs(-13 + 8j, -11 + 7j, -9 + 6j)
START_OFFSETS = (0.0015, 0.002, -0.009)

DECK_MODEL = Model(
    id="deck",
    label=text("Platform, rigid deck"),
    plant=deck(),
    body=rigid_body(),
    x0=(*START_OFFSETS, 0.0, 0.0, 0.0),
    guess=(0.0,) * 6,
    horizon=3.0,
    dt=0.006,
    controller_poles=CONTROLLER_POLES,
    observer_poles=OBSERVER_POLES,
    controller_window=Window(-16.0, 4.0, 12.0),
    observer_window=Window(-20.0, 4.0, 12.0),
    kick=(0.0, 0.0, 0.0, 0.015, -0.02, 0.09),
    grips=grips(deck()),
    watched=_watched(6),
    u_max=3.0,
    source=SOURCE,
)


def _platform_poles(of_deck: tuple[complex, ...]) -> tuple[complex, ...]:
    """Move the deck's three modes, leave the two modes of the test masses where nature put them."""
    natural = plant().poles
    return of_deck + tuple(complex(p) for p in natural if abs(p) > 100)


PLATFORM_MODEL = Model(
    id="platform",
    label=text("Platform with its sensors' test masses"),
    plant=plant(),
    body=body(),
    x0=(
        *START_OFFSETS,
        START_OFFSETS[1] - Parameters.s * START_OFFSETS[2],
        START_OFFSETS[1] + Parameters.s * START_OFFSETS[2],
        *(0.0,) * 5,
    ),
    guess=(0.0,) * 10,
    horizon=3.0,
    dt=0.006,
    controller_poles=_platform_poles(CONTROLLER_POLES),
    observer_poles=_platform_poles(OBSERVER_POLES),
    controller_window=Window(-16.0, 4.0, 12.0),
    observer_window=Window(-20.0, 4.0, 12.0),
    kick=(0.0, 0.0, 0.0, 0.0, 0.0, 0.015, -0.02, 0.09, -0.02 - 0.09 * Parameters.s, -0.02 + 0.09 * Parameters.s),
    grips=grips(plant()),
    watched=(
        *_watched(10),
        Signal(text("test masses against each other"), (0.0, 0.0, 2 * Parameters.s, 1.0, -1.0, *(0.0,) * 5), "µm", 1e6),
    ),
    u_max=3.0,
    controls=(0, 1, 2),
    source=SOURCE,
)
