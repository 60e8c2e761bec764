"""Build the loop of lesson 11: controllers, mixing, closed loop, spectra and one run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import expm

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Design
from observer_lab.engine import Plant, noisy_loop
from observer_lab.engine.design import Diophantine, LoopShape, loop_shaped, negated
from observer_lab.engine.feedback import NoisyLoop
from observer_lab.engine.structure import Coupling, Dominance, Mixing, best_mixing, coupling, dominance, mixing_matrix
from observer_lab.engine.systems import held_scan
from observer_lab.plants import MODELS
from observer_lab.plants.platform import model
from observer_lab.plants.platform import siso_loops as siso
from observer_lab.plants.platform.channels import T_y, in_channels
from observer_lab.plants.platform.lqg_weights import coils, ground
from observer_lab.text import text

from .sensors import IDEAL_SENSORS, Sensors, behind_sensors, rise

PUBLISHED_LOOP, SHAPED_LOOP, BY_POLES, BY_GAIN, OPEN_LOOP = "published", "shaped", "poles", "gain", "open"
NO_MIX, OWN_MIX, BEST_MIX = "none", "own", "best"
WHITE, FALLING = "white", "falling"
MODEL = MODELS["platform"]
PLATFORM_PLANT = model.plant()
GROUND_MATRIX = ground(PLATFORM_PLANT)
HORIZON, DT = 10.0, 0.02
AXIS_POLE_RAD_S = 1e-7  # rad/s: poles nearer to zero stand on the plant's zero at s = 0; they are read off the controllers
MODES = (0.9953, 1.1811, 1.1925, 1.4938)  # Hz: the deck's three, and the zeros that P_h has between them
BAND_HZ = (0.1, 10.0)  # Hz, where peaks are compared
SWEEP = np.unique(np.concatenate([np.geomspace(0.01, 200.0, 150), *(m * np.linspace(0.97, 1.03, 13) for m in MODES)]))
CHANNEL_FREQUENCIES_HZ = np.unique(np.concatenate([np.geomspace(0.1, 10.0, 90), np.linspace(0.95, 1.3, 71)]))
INDEX_FREQUENCIES = 80  # frequencies in J
WHITE_ASD = 1e-6  # m/√Hz
FALLING_ASD = (2.5e-7, 6e-9)  # m/√Hz at 1 Hz, vertical and horizontal, falling as 1/f²
DISPLAY_LIMIT = 1.0  # m or m/s beyond which a run is drawn at the edge
STATE_JUMP = np.array(MODEL.kick) * 0.004
A_EDGE, B_EDGE = 0.6, 0.3
GRID_A, GRID_B = np.linspace(-A_EDGE, A_EDGE, 49), np.linspace(-B_EDGE, B_EDGE, 41)


@dataclass(frozen=True, eq=False)
class Mixed:
    """The channels over the band of J: the index, its optimum, the map, and the S that is used with its a, b and J."""

    index: Coupling
    best: Mixing
    map: np.ndarray
    a: float
    b: float
    J: float
    S: np.ndarray


@dataclass(frozen=True, eq=False)
class Controllers:
    """The three controllers, signs included (None: open), their joint form y → u, and the Diophantine solution if used."""

    vertical: Plant | None
    rotation: Plant | None
    horizontal: Plant | None
    whole: Plant
    placed: Diophantine | None


@dataclass(frozen=True, eq=False)
class Spectra:
    """One-sided densities over f (n_f,) in Hz: of vertical, rotation, horizontal velocity without control and with
    (n_f, 3) in (m/s)²/Hz, the part of the sensors in the latter, and of the three forces in N²/Hz."""

    f: np.ndarray
    bare: np.ndarray
    closed: np.ndarray
    sensors: np.ndarray
    forces: np.ndarray


@dataclass(frozen=True, eq=False)
class Shaken:
    """One run on a shaking ground: states with control and without (n_t, 10), forces (n_t, 3), ground (n_t, 2) in m."""

    t: np.ndarray
    x: np.ndarray
    bare: np.ndarray
    u: np.ndarray
    ground: np.ndarray


# --- channels and mixing -----------------------------------------------------------------------------------------------
@lru_cache(maxsize=64)
def platform_of(lower: float) -> Plant:
    """The platform whose horizontal coil pushes `lower` m below the line of the spring: all that the coil's height moves is B."""
    return model.plant(model.Parameters(lower=lower))


@lru_cache(maxsize=64)
def three(lower: float = 0.0) -> Plant:
    """The platform from v to (vertical, rotation, horizontal)."""
    whole = in_channels(platform_of(lower))
    return Plant(whole.A, whole.B, whole.C[:3])


@lru_cache(maxsize=64)
def channels(lower: float = 0.0) -> Dominance:
    """G over the working band, without mixing."""
    return dominance(three(lower), 2 * np.pi * CHANNEL_FREQUENCIES_HZ)


@lru_cache(maxsize=128)
def band_of(low: float, high: float, lower: float = 0.0) -> tuple[Coupling, Mixing, np.ndarray]:
    """J over a band in Hz, its optimum, and its map over the grid."""
    J = coupling(dominance(three(lower), 2 * np.pi * np.geomspace(low, high, INDEX_FREQUENCIES)).response, channels=(1, 2))
    return J, best_mixing(J.response), J.map(GRID_A, GRID_B)


def lower_of(design: Design) -> float:
    """How far the horizontal coil pushes below the line of the spring, in m."""
    return 1e-3 * design["lower"]


def mixed(design: Design) -> Mixed:
    """The mixing of a design. Raises KnobError for a band that is none, EngineError for a singular mixing."""
    low, high = design["f_low"], design["f_high"]
    if high < 1.5 * low:
        raise KnobError(text("The band must reach from {low:g} Hz to at least {low2:.3g} Hz.",
                             low=low, low2=1.5 * low))
    J, best, over = band_of(low, high, lower_of(design))
    a, b = {NO_MIX: (0.0, 0.0), OWN_MIX: (design["a"], design["b"]), BEST_MIX: (best.a, best.b)}[design["mix"]]
    return Mixed(J, best, over, a, b, J(a, b), mixing_matrix(a, b, size=3, channels=(1, 2)))


# --- controllers -------------------------------------------------------------------------------------------------------
def controllers(design: Design, S: np.ndarray) -> Controllers:
    """The controllers of a design; those placed by poles are placed for the mixed plant."""
    placed = (siso.horizontal_by_poles(design["control_poles"], design["observer_poles"], S, model.Parameters(lower=lower_of(design)))
              if design["horizontal"] == BY_POLES else None)
    horizontal = {PUBLISHED_LOOP: lambda: negated(siso.published_ch()), BY_POLES: lambda: placed.controller() if placed else None,
                  BY_GAIN: lambda: loop_shaped(LoopShape(-design["gain_h"])), OPEN_LOOP: lambda: None}[design["horizontal"]]()
    vertical = {PUBLISHED_LOOP: siso.published_cv, SHAPED_LOOP: lambda: loop_shaped(shape_of(design)),
                OPEN_LOOP: lambda: None}[design["vertical"]]()
    rotation = siso.pitch_loop(design["bandwidth"]) if design["pitch"] else None
    return Controllers(vertical, rotation, horizontal, siso.from_channels(vertical, rotation, horizontal, mixing=S), placed)


def shape_of(design: Design) -> LoopShape:
    """The vertical controller by loop shaping; a corner of 0 leaves its part out."""
    lag, lead = design["lag"], 2 * np.pi * design["lead"]
    return LoopShape(-design["gain_v"], (lag, lag / 20) if lag > 0 else None, (lead / 3, 3 * lead) if lead > 0 else None,
                     2 * np.pi * design["roll_off"])


def close(controller: Plant, noise: float = 0.0, lower: float = 0.0, sensors: Sensors = IDEAL_SENSORS) -> NoisyLoop:
    """The loop with unit ground and readings of one-sided density noise², in m/s/√Hz; its outputs are the true velocities."""
    true = coils(platform_of(lower))
    read = behind_sensors(true, sensors)
    more = np.zeros((read.n - true.n, GROUND_MATRIX.shape[1]))
    loop = noisy_loop(read, controller, np.vstack([GROUND_MATRIX, more]), 1.0, V=noise**2 / 2)
    return loop.watching(true.C) if read.n > true.n else loop


def rightmost(loop: NoisyLoop, controller: Plant) -> tuple[float, float]:
    """(The rightmost pole of the loop but for drift, the rightmost drift pole or −∞).

    A controller's pole within 1e-7 rad/s of zero meets the plant's zero at s = 0 and hardly moves (less than one part in
    ten thousand); among poles of 1e5 rad/s an eigenvalue that small would be rounding.
    """
    own = controller.poles[np.abs(controller.poles) < AXIS_POLE_RAD_S] if controller.n else np.zeros(0)
    real = np.real(loop.poles[np.abs(loop.poles) >= AXIS_POLE_RAD_S])
    return float(real.max()), float(np.real(own).max(initial=-np.inf))


# --- spectra -----------------------------------------------------------------------------------------------------------
def ground_density(f: np.ndarray, kind: str) -> np.ndarray:
    """One-sided density of vertical and horizontal ground motion, (n_f, 2) in m²/Hz."""
    if kind == WHITE:
        return np.full((len(f), 2), WHITE_ASD**2)
    return np.array(FALLING_ASD) ** 2 / f[:, None] ** 4


@lru_cache(maxsize=1)
def bare_loop() -> NoisyLoop:
    """The platform without control."""
    return noisy_loop(coils(PLATFORM_PLANT), None, GROUND_MATRIX, 1.0)


@lru_cache(maxsize=1)
def bare_gains() -> np.ndarray:
    """|H|² of the platform without control over SWEEP: (n_f, 3, 2)."""
    bare = bare_loop()
    return np.abs(bare.response(SWEEP, bare.outputs(T_y[:3]))[..., :2]) ** 2


@lru_cache(maxsize=16)
def spectra(loop: NoisyLoop, kind: str, knee: float = 0.0) -> Spectra:
    """Densities over a sweep that has every resonance of platform and loop on it; the sensors' noise rises below `knee` Hz."""
    slow = loop.poles[(loop.poles.imag > 0) & (np.abs(np.real(loop.poles)) < 0.05 * np.abs(loop.poles))]
    extra = np.abs(slow) / (2 * np.pi)
    extra = extra[(extra > SWEEP[0]) & (extra < SWEEP[-1])][:12]
    f = np.union1d(SWEEP, extra)
    driven = ground_density(f, kind)
    rows = np.vstack([loop.outputs(T_y[:3]), loop.inputs()])
    moved, sensed = loop.parts(f, rows, ground=driven)
    sensed = sensed * rise(knee, f)[:, None]
    gains = bare_gains()
    if len(f) > len(SWEEP):
        gains = np.empty((len(f), 3, 2))
        old = np.isin(f, SWEEP)
        bare = bare_loop()
        gains[old], gains[~old] = bare_gains(), np.abs(bare.response(f[~old], bare.outputs(T_y[:3]))[..., :2]) ** 2
    both = moved + sensed
    return Spectra(f, (gains * driven[:, None]).sum(axis=2), both[:, :3], sensed[:, :3], both[:, 3:])


def suppression(s: Spectra) -> np.ndarray:
    """How far the highest peak of vertical, rotation, horizontal between 0.1 and 10 Hz comes down, in dB, sensors apart."""
    inside = (s.f >= BAND_HZ[0]) & (s.f <= BAND_HZ[1])
    moved = np.maximum(s.closed - s.sensors, 1e-300)
    return 10 * np.log10(s.bare[inside].max(axis=0) / moved[inside].max(axis=0))


# --- a run on a shaking ground -----------------------------------------------------------------------------------------
@lru_cache(maxsize=32)
def shaking(seed: int, kind: str) -> np.ndarray:
    """Ground motion (zg, xg) in m on the grid of the run, (n_t, 2): random, with the spectrum's shape above 0.1 Hz."""
    count = round(HORIZON / DT) + 1
    rng = np.random.default_rng(seed)
    f = np.fft.rfftfreq(count, DT)
    inside = f >= 0.1
    size = np.zeros((len(f), 2))
    size[inside] = np.sqrt(ground_density(f[inside], kind) / 2 * f[1] / 2)
    line = size * (rng.normal(size=size.shape) + 1j * rng.normal(size=size.shape)) * count
    return np.fft.irfft(line, count, axis=0)


def run(A: np.ndarray, B: np.ndarray, ground_motion: np.ndarray, kick: float) -> np.ndarray:
    """States from rest over the grid, the ground held between its points, the platform's velocities kicked at `kick` s."""
    n, q = B.shape
    block = np.zeros((n + q, n + q))
    block[:n, :n], block[:n, n:] = A * DT, B * DT
    with np.errstate(over="ignore", invalid="ignore"):
        power = expm(block)
    Phi, Gamma, steps = power[:n, :n], power[:n, n:], ground_motion[:-1]
    if not np.isfinite(power).all():
        return np.full((len(ground_motion), n), DISPLAY_LIMIT)
    at = min(round(kick / DT), len(steps)) if kick >= 0 else len(steps)
    first = held_scan(Phi, Gamma, steps[:at], np.zeros(n)) if at else np.zeros((1, n))
    if kick < 0:
        return first
    jumped = first[-1].copy()
    jumped[:len(STATE_JUMP)] += STATE_JUMP
    rest = held_scan(Phi, Gamma, steps[at:], jumped) if at < len(steps) else jumped[None]
    return np.vstack([first[:-1], rest])


@lru_cache(maxsize=32)
def bare_run(seed: int, kind: str, kick: float) -> np.ndarray:
    """The platform without control on the same ground."""
    return run(PLATFORM_PLANT.A, GROUND_MATRIX, shaking(seed, kind), kick)


def shaken(loop: NoisyLoop, design: Design) -> Shaken:
    """The loop of a design and the bare platform on the same ground; sensors without noise."""
    seed, kind, kick = int(design["seed"]), design["ground"], design["kick"]
    motion = shaking(seed, kind)
    z = np.clip(np.nan_to_num(run(loop.A, loop.B[:, :2], motion, kick), nan=DISPLAY_LIMIT, posinf=1e6, neginf=-1e6), -1e6, 1e6)
    return Shaken(DT * np.arange(len(motion)), np.clip(z[:, :10], -DISPLAY_LIMIT, DISPLAY_LIMIT), bare_run(seed, kind, kick),
                  np.clip(z @ loop.C[4:].T, -1e4, 1e4), motion)
