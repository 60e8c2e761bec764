"""Simulate the true deck with ground, sensors and coils: spectra, responses, one noisy run."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.interpolate import PchipInterpolator

from observer_lab.course.lesson import Design
from observer_lab.engine import Plant, sampled_loop, simulate_trial
from observer_lab.engine.sampled import (
    Hardware,
    MechanicsResponse,
    ResponseMeasures,
    SampledLoop,
    loop_density,
    mechanics_response,
    response_measures,
)
from observer_lab.plants.platform import model
from observer_lab.plants.platform.channels import T_y

from .controllers import DT, OPEN_LOOP, OWN_PAIR, Player, players

BAND_HZ = (0.5, 3.0)  # Hz: the main resonance band
FINE_SAMPLES, COARSE_STRIDE, LAST_SAMPLE = 200, 40, 12_000  # samples: one by one at first, then every 40th, up to 12 s
PART_SAMPLES = 500  # samples of a clipped response between two looks whether the rest is linear
RUN_SAMPLES, TOUCH_SAMPLE = 2401, 400  # samples of the noisy run, and when the deck is touched in it
# A touch of the deck: jumps of the velocities of x, z, θ and of the test masses that ride along.
TOUCH_JUMP = np.array([0, 0, 0, 0, 0, 2e-4, -2e-4, 1e-3, -2e-4 - 1e-3 * model.Parameters.s, -2e-4 + 1e-3 * model.Parameters.s])
GROUND_STEP_M = np.array([2e-5, 2e-5])  # m: the ground rises and moves aside
OUTPUTS = 5  # vertical, rotation, horizontal; VL, VR. HL is the horizontal channel
ASD = (2.5e-7, 6e-9)  # m/√Hz at 1 Hz of vertical and horizontal ground, falling as 1/f²
CORNERS = 2 * np.pi * np.array([0.03, 0.04])  # rad/s below which the ground filter is flat
BROAD = np.concatenate([np.geomspace(0.1, 499.0, 160), BAND_HZ])  # with the edges of the band
QUIET_SENSOR_INTENSITY = 1e-10  # (m/s)² s of noise where the sensors do not count
RESONANCE_OFFSETS = np.geomspace(5e-4, 0.3, 22)
RESONANCE_OFFSETS = np.concatenate([-RESONANCE_OFFSETS[::-1], [0.0], RESONANCE_OFFSETS])
MASSES = 30.2 + np.linspace(-1.8, 1.8, 7)  # Hz: the test masses stand still about here, however the deck is steered
WIDTHS = np.geomspace(0.4, 25.0, 8)  # half-widths of a resonance between it and the points beside it
WIDTHS = np.concatenate([-WIDTHS[::-1], [0.0], WIDTHS])


@dataclass(frozen=True)
class World:
    """Everything that is true whatever the controller believes."""

    parameters: model.Parameters
    hardware: Hardware
    sensor: float
    shaped: bool


@dataclass(frozen=True, eq=False)
class Analysis:
    """The loop of one player: stable or not, and densities (n_f, 5 + 3) in (µm/s)²/Hz, the rotation's likewise, and N²/Hz."""

    stable: bool
    density: np.ndarray


@dataclass(frozen=True, eq=False)
class Response:
    """Without noise, after the test: t (n_t,), the channels' velocities (n_t, 3) in µm/s, u (n_t, 3) in N, measures."""

    t: np.ndarray
    velocity: np.ndarray
    u: np.ndarray


def world_of(design: Design) -> World:
    """The world of a design's knobs."""
    p = model.Parameters()
    true = replace(p, kz=p.kz * (1 + design["stiffness"] / 100), kx=p.kx * (1 + design["stiffness"] / 100),
                   cz=p.cz * (1 + design["damping"] / 100), cx=p.cx * (1 + design["damping"] / 100),
                   s=p.s + design["placement"] / 1000)
    hardware = Hardware(
        limit=design["limit"] if design["limited"] else np.inf,
        bandwidth=np.inf if design["driver"] == "ideal" else design["bandwidth"], order=2 if design["driver"] == "second" else 1,
        walk=design["drift"] * 1e-6, step=design["adc"] * 1e-6, delay=design["delay"] / 1000)
    return World(true, hardware, design["sensor"], design["ground"] == "shaped")


@lru_cache(maxsize=64)
def plant_of(parameters: model.Parameters) -> tuple[Plant, np.ndarray]:
    """The true plant, and the rows of its recorded outputs."""
    plant = model.plant(parameters)
    return plant, np.vstack([T_y[:3] @ plant.C, plant.C[[0, 2]]])


@lru_cache(maxsize=1)
def ground_filter() -> Plant:
    """White noise to ground motion (z_g, x_g) of density ASD²/f⁴ above the corners."""
    A, B, C = np.zeros((4, 4)), np.zeros((4, 2)), np.zeros((2, 4))
    for i, asd in enumerate(ASD):
        A[2 * i:2 * i + 2, 2 * i:2 * i + 2] = [[-CORNERS[0], 1.0], [0.0, -CORNERS[1]]]
        B[2 * i + 1, i], C[i, 2 * i] = asd * (2 * np.pi) ** 2 / np.sqrt(2), 1.0
    return Plant(A, B, C)


@lru_cache(maxsize=128)
def loop_of(world: World, player: Player) -> SampledLoop:
    """The player's sampled loop in this world."""
    plant, outputs = plant_of(world.parameters)
    W, shaping = (np.eye(2), ground_filter()) if world.shaped else (1e-12 * np.eye(2), None)
    return sampled_loop(plant, player.controller, range(3), hardware=world.hardware, W=W, V=world.sensor * np.eye(4),
                        shaping=shaping, outputs=outputs)


@lru_cache(maxsize=64)
def grid(parameters: model.Parameters) -> np.ndarray:
    """Frequencies in Hz: evenly on the logarithmic axis, and close together at the deck's three resonances."""
    poles = plant_of(parameters)[0].poles
    peaks = [abs(p) / (2 * np.pi) for p in poles if p.imag > 0 and abs(p) < 100]
    return _apart(np.concatenate([BROAD, MASSES, *(peak + RESONANCE_OFFSETS for peak in peaks)]))


def _apart(f: np.ndarray) -> np.ndarray:
    """Frequencies in order, none twice."""
    f = np.unique(f)
    return f[np.concatenate([[True], np.diff(f) > 1e-9])]


def with_resonances(f: np.ndarray, loop: SampledLoop) -> np.ndarray:
    """f, and points about each resonance of a stable loop that is narrower than the points of f are apart: f itself if there is none."""
    poles = loop.poles
    s = np.log(poles[np.abs(poles) > 0.1].astype(complex)) / (2 * np.pi * DT)
    s = s[(s.imag > f[0]) & (s.imag < f[-1])]
    above = np.searchsorted(f, s.imag)
    narrow = s[np.abs(s.real) < 0.75 * (f[above] - f[above - 1])]
    more = np.concatenate([pole.imag + abs(pole.real) * WIDTHS for pole in narrow]) if len(narrow) else narrow.real
    return _apart(np.concatenate([f, more[(more > f[0]) & (more < f[-1])]])) if len(more) else f


@lru_cache(maxsize=256)
def _extra(world: World, player: Player) -> tuple[float, ...]:
    """What the player's own resonances add to the world's grid."""
    loop, f = loop_of(world, player), grid(world.parameters)
    return tuple(np.setdiff1d(with_resonances(f, loop), f).tolist()) if loop.stable else ()


def extra(world: World, five: tuple[Player, ...]) -> tuple[float, ...]:
    """What the resonances of all players add to the world's grid."""
    return tuple(sorted({f for player in five for f in _extra(world, player)}))


@lru_cache(maxsize=64)
def points(parameters: model.Parameters, more: tuple[float, ...]) -> np.ndarray:
    """The world's grid and more."""
    return _apart(np.concatenate([grid(parameters), more])) if more else grid(parameters)


@lru_cache(maxsize=64)
def _shared(world: World) -> World:
    """What of the world all densities have in common."""
    return replace(world, sensor=QUIET_SENSOR_INTENSITY, hardware=replace(world.hardware, limit=np.inf, step=0.0, walk=0.0))


@lru_cache(maxsize=64)
def _mechanics(world: World, more: tuple[float, ...]) -> MechanicsResponse:
    """What all players share: the responses of deck, drivers, delay and ground. `world` without sensor noise and limit."""
    return mechanics_response(loop_of(world, players(QUIET_SENSOR_INTENSITY, OWN_PAIR)[0]), points(world.parameters, more))


@lru_cache(maxsize=256)
def analyse(world: World, player: Player, more: tuple[float, ...] = ()) -> Analysis:
    """The player's densities on the world's grid and more, by transfer function; zero where the loop is not stable."""
    loop = loop_of(world, player)
    if not loop.stable:
        return Analysis(False, np.zeros((len(points(world.parameters, more)), OUTPUTS + 3)))
    units = np.array([1e12] * OUTPUTS + [1.0] * 3)
    return Analysis(True, units * loop_density(loop, _mechanics(_shared(world), more)))


def band_rms(f: np.ndarray, density: np.ndarray, low: float, high: float) -> np.ndarray:
    """Root of the area under densities (n_f, k) between two frequencies, by cubics that do not swing between the points."""
    inside = (f >= low) & (f <= high)
    return np.sqrt(PchipInterpolator(f[inside], density[inside]).integrate(*f[inside][[0, -1]]))


def _unrounded(loop: SampledLoop) -> SampledLoop:
    """The loop with an ideal converter; itself if it has one."""
    return replace(loop, hardware=replace(loop.hardware, step=0.0)) if loop.hardware.step else loop


@lru_cache(maxsize=256)
def respond(world: World, player: Player, step: bool) -> Response | None:
    """The test without noise: a touch at t = 0, or a step of the ground; None for a loop that is not stable.

    Exact; what is linear is worked out at few samples after 0.2 s, a clipped stretch sample by sample before that.
    """
    loop = loop_of(world, player)
    if not loop.stable:
        return None
    quiet = _unrounded(loop)
    w0, head = np.zeros(loop.n), [np.zeros((0, loop.n))]
    if not step:
        w0[loop.x] += TOUCH_JUMP
    gamma = loop.Gamma @ GROUND_STEP_M if step else np.zeros(loop.n)
    begun = 0
    while True:
        points, w = _linear(loop, w0, gamma, begun)
        u = w @ loop.feedback.T
        if begun >= LAST_SAMPLE - PART_SAMPLES or player.id == OPEN_LOOP or np.abs(u).max() <= loop.hardware.limit:
            break
        run = simulate_trial(quiet, PART_SAMPLES + 1, start=w0, disturbance=np.tile(GROUND_STEP_M, (PART_SAMPLES + 1, 1)) if step else None)
        head.append(run.w[:-1])
        w0, begun = run.w[-1], begun + PART_SAMPLES
    clipped = np.concatenate(head)
    keep = np.concatenate([np.arange(min(FINE_SAMPLES, begun)), np.arange(FINE_SAMPLES, begun, COARSE_STRIDE)]).astype(int)
    states = np.vstack([clipped[keep], w])
    limit = loop.hardware.limit
    return Response(DT * np.concatenate([keep, points]), 1e6 * states @ loop.outputs[:3].T,
                    np.clip(states @ loop.feedback.T, -limit, limit))


def _linear(loop: SampledLoop, w0: np.ndarray, gamma: np.ndarray, begun: int) -> tuple[np.ndarray, np.ndarray]:
    """Samples from `begun` to the end and the states there, one by one at first, of w⁺ = F_c w + gamma."""
    N = loop.n
    closed = np.zeros((N + 1, N + 1))  # the constant push rides along as a state
    closed[:N, :N], closed[:N, N], closed[N, N] = loop.closed(), gamma, 1.0
    first = _powers(closed, np.append(w0, 1.0), FINE_SAMPLES + 1)
    later = _powers(
        np.linalg.matrix_power(closed, COARSE_STRIDE), first[-1], max((LAST_SAMPLE - begun - FINE_SAMPLES) // COARSE_STRIDE + 1, 1)
    )
    points = begun + np.concatenate([np.arange(FINE_SAMPLES), FINE_SAMPLES + COARSE_STRIDE * np.arange(len(later))])
    return points, np.vstack([first[:-1], later])[:, :N]


def _powers(step: np.ndarray, start: np.ndarray, count: int) -> np.ndarray:
    """start, step start, step² start … (count, N), by doubling."""
    found = np.empty((count, len(start)))
    found[0], done = start, 1
    power: np.ndarray = step.T
    while done < count:
        more = min(done, count - done)
        found[done:done + more] = found[:more] @ power
        done += more
        power = power @ power
    return found


def measures(response: Response, reference: Response) -> tuple[ResponseMeasures, ...]:
    """Of each channel; recovered within 5 % of the largest velocity that the channel reaches without control."""
    bands = 0.05 * np.abs(reference.velocity).max(axis=0)
    return tuple(response_measures(response.t, response.velocity[:, i], response.u, float(bands[i])) for i in range(3))


def without_control(world: World) -> World:
    """The same deck and ground with ideal coils, and sensors to which nobody listens: what a deck that nobody steers meets."""
    return replace(world, hardware=Hardware(), sensor=QUIET_SENSOR_INTENSITY)


@lru_cache(maxsize=16)
def shake(world: World, player: Player, seed: int, step: bool, kick: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One noisy run with the test after 0.4 s: t, states x (n_t, 10) and forces u (n_t, 3), held if it diverges.

    Rounding is left to the Monte-Carlo here; `kick` is the time of one more touch, or −1.
    """
    loop = loop_of(world, player)
    quiet = _unrounded(loop)
    ground = np.zeros((RUN_SAMPLES, 2))
    kicks = [] if step else [(TOUCH_SAMPLE, TOUCH_JUMP)]
    if step:
        ground[TOUCH_SAMPLE:] = GROUND_STEP_M
    if kick >= 0:
        kicks.append((min(round(kick / DT), RUN_SAMPLES - 1), TOUCH_JUMP))
    run = simulate_trial(quiet, RUN_SAMPLES, seed=seed, disturbance=ground, kicks=tuple(kicks))
    x, u = np.zeros((RUN_SAMPLES, 10)), np.zeros((RUN_SAMPLES, 3))
    x[:len(run.x)], u[:len(run.x)] = run.x, run.applied
    x[len(run.x):], u[len(run.x):] = run.x[-1], run.applied[-1]
    t = DT * np.arange(RUN_SAMPLES)
    return t[::4], np.clip(x[::4], -1.0, 1.0), np.clip(u[::4], -100.0, 100.0)
