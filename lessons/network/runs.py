"""One run of a design, the bounds of the mean covariance beside it, and the growth of a loop with lossy inputs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from app.engine import Link, NetworkScenario, simulate_network
from app.engine.network import (
    NetworkRun,
    delayed_loop,
    mean_bounds,
    mean_square_growth,
    network_meter,
    promised_error,
    spectral_radius,
)
from app.lesson.lesson import Design

from .cases import DECK, KINDS, SAMPLES, SCALAR, TWO, Watched, sampled, watched

ASKED, APPLIED, AHEAD = "asked", "applied", "ahead"
HOLD, ZERO = "hold", "zero"
MOST = 1e9  # ratios and signals beyond are drawn at the edge
LOSSES = np.linspace(0.0, 1.0, 21)
INPUT_LOSSES = np.linspace(0.0, 0.96, 17)


def key(design: Design) -> tuple[str, float, float, float]:
    """What the filter's mean depends on beside the loss: case, a, period, sensor noise; knobs that do not matter left out."""
    name = design["case"]
    return (name, design["a"] if name == SCALAR else 1.2, 1.0 if name in (SCALAR, TWO) else design["stretch"], design["noise"])


@dataclass(frozen=True, eq=False)
class Story:
    """One run of one design; arrays over SAMPLES, the last value held where the run diverged.

    teeth (SAMPLES, 2): ratio of the covariance just after the packets of a sample, and just before those of the next.
    lower, upper (SAMPLES + 1,): bounds of the mean of that before the packets. size, promised: error in standard
    deviations of the filter without loss. loop: z⁺ = loop z of the steady filter with delay and no loss.
    """

    watched: Watched
    run: NetworkRun
    x: np.ndarray
    xhat: np.ndarray
    asked: np.ndarray
    applied: np.ndarray
    heard: np.ndarray
    fresh: np.ndarray
    teeth: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    size: np.ndarray
    promised: np.ndarray
    meter: float
    loop: np.ndarray
    ages: tuple[np.ndarray, np.ndarray]


def tell(design: Design) -> Story:
    """Simulate the design and put beside it what is known about the mean."""
    who = watched(*key(design))
    s, kind = who.sampled, KINDS[design["case"]]
    delay, ahead = int(design["delay"]), int(design["delay"]) if design["told"] == AHEAD else 0
    told = ASKED if design["told"] == ASKED else APPLIED
    stamped = design["jitter"] == 0 or design["order"] == "stamped"
    run = simulate_network(NetworkScenario(
        s.plant, s.K, s.Q, who.R, who.steady.solution, kind.x0, SAMPLES, Link(design["loss"], 0, int(design["jitter"])),
        Link(design["loss_u"], delay), design["lost"], told, "stamped" if stamped else "arrival", ahead,
        _jumps(design, s.plant.dt), int(design["seed"])))
    after = run.plan.P
    before = s.plant.A @ after @ s.plant.A.T + s.Q
    lower, upper = _late(*bounds(design["loss"], key(design)), int(design["jitter"]), who)
    root = np.sqrt(who.weights)
    promised = promised_error(run)
    size, goal = (np.minimum(np.linalg.norm(e * root, axis=1), MOST) for e in (run.e, promised))
    return Story(
        watched=who, run=run, x=_held(run.x), xhat=_held(run.xhat), asked=_held(run.u_asked), applied=_held(run.u_applied),
        heard=np.isin(np.arange(SAMPLES), run.draw.sensed), fresh=np.isin(np.arange(SAMPLES), run.draw.acted),
        teeth=np.clip(np.column_stack([who.ratio(after), who.ratio(before)]), 1 / MOST, MOST), lower=lower, upper=upper,
        size=_held(size), promised=_held(goal), meter=min(network_meter(run, promised), MOST),
        loop=delayed_loop(s.plant, s.K, who.steady.filter_gain, delay, told, ahead),
        ages=(_held(run.sensor_age), _held(run.actuator_age)))


def _held(values: np.ndarray) -> np.ndarray:
    """Over SAMPLES, clipped, the last value held where the run ended early."""
    index = np.minimum(np.arange(SAMPLES), len(values) - 1)
    return np.clip(values, -MOST, MOST)[index]


def _jumps(design: Design, h: float) -> np.ndarray:
    """The kick, between two samples."""
    kind = KINDS[design["case"]]
    jumps = np.zeros((SAMPLES, len(kind.x0)))
    if design["kick"] >= 0:
        jumps[min(int(design["kick"] / h), SAMPLES - 2)] = kind.kick
    return jumps


@lru_cache(maxsize=64)
def bounds(loss: float, of: tuple[str, float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bound of the mean covariance, (SAMPLES + 1, n, n), from the filter without loss on."""
    who = watched(*of)
    s = who.sampled
    return mean_bounds(s.plant.A, s.plant.C, s.Q, who.R, who.steady.solution, loss, SAMPLES)


@lru_cache(maxsize=32)
def bounds_over_loss(of: tuple[str, float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Ratios of the lower and the upper bound after SAMPLES samples, over LOSSES."""
    who = watched(*of)
    s = who.sampled
    lower, upper = mean_bounds(s.plant.A, s.plant.C, s.Q, who.R, who.steady.solution, LOSSES, SAMPLES)
    return np.minimum(who.ratio(lower[:, -1]), MOST), np.minimum(who.ratio(upper[:, -1]), MOST)


def _late(lower: np.ndarray, upper: np.ndarray, late: int, who: Watched) -> tuple[np.ndarray, np.ndarray]:
    """The same as ratios where packets may be `late` samples late: the upper bound then waits for the last of them."""
    s = who.sampled
    top = upper
    for _ in range(late):  # one more sample without any measurement; at the start there are none to wait for
        top = np.concatenate([upper[:1], s.plant.A @ top[:-1] @ s.plant.A.T + s.Q])
    return np.clip(who.ratio(lower), 1 / MOST, MOST), np.clip(who.ratio(top), 1 / MOST, MOST)


@lru_cache(maxsize=32)
def input_growth(name: str, a: float, stretch: float) -> tuple[np.ndarray, np.ndarray]:
    """Growth of E‖x‖² a sample over INPUT_LOSSES under u = −K x, for held and for zeroed inputs."""
    s = sampled(name, a, stretch)
    losses = INPUT_LOSSES[::4] if name == DECK else INPUT_LOSSES
    held, zeroed = ([mean_square_growth(s.plant, s.K, p, how) for p in losses] for how in (HOLD, ZERO))
    return np.interp(INPUT_LOSSES, losses, held), np.interp(INPUT_LOSSES, losses, zeroed)


@lru_cache(maxsize=64)
def growth_now(name: str, a: float, stretch: float, loss: float) -> tuple[float, float]:
    """The same at one loss, held and zeroed."""
    s = sampled(name, a, stretch)
    return mean_square_growth(s.plant, s.K, loss, HOLD), mean_square_growth(s.plant, s.K, loss, ZERO)


def loop_radius(story: Story) -> float:
    """Largest modulus of the poles of the loop with delay."""
    return spectral_radius(story.loop)
