"""Compute a design of lesson 18: one run, covariance bounds, growth under lossy inputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Check, Design, Formula, Outcome, Stage
from observer_lab.engine import Link, NetworkScenario, simulate_network
from observer_lab.engine.network import (
    NetworkRun,
    delayed_loop,
    mean_bounds,
    mean_square_growth,
    network_meter,
    promised_error,
    spectral_radius,
)
from observer_lab.text import NO_WORDS, Text, joined, text

from ..toolkit.latex import matrix, number
from .bodies import PACKETS, SCALE
from .cases import CASE_KINDS, DECK_CASE, RUN_SAMPLES, SCALAR_CASE, TWO, Watched, sampled, watched

TOLD_COMMANDED, TOLD_APPLIED, TOLD_AHEAD = "asked", "applied", "ahead"
HOLD_INPUT, ZERO_INPUT = "hold", "zero"
DISPLAY_LIMIT = 1e9  # ratios and signals beyond are drawn at the edge
LOSSES = np.linspace(0.0, 1.0, 21)
INPUT_LOSSES = np.linspace(0.0, 0.96, 17)
OVER = np.linspace(0.05, 0.95, 19)
FIRST_BAR_SHARE = 0.2  # share of the bar for the loss of the design
AUTONOMOUS_TOLERANCE = 1e-6  # of the separation meter: below it the error lives by itself
FARTHEST = 1e3  # cm: a place beyond is drawn at the edge
LATE_FORCE = text("Green ball: the place for which the acting force is right")
FRAME_S, MAX_FRAMES_PER_SAMPLE = 0.04, 12  # s, how finely the stage plays, and in how many parts of a sample at most


def key(design: Design) -> tuple[str, float, float, float]:
    """What the filter's mean depends on beside the loss: case, a, period, sensor noise; knobs that do not matter left out."""
    name = design["case"]
    return (name, design["a"] if name == SCALAR_CASE else 1.2, 1.0 if name in (SCALAR_CASE, TWO) else design["stretch"], design["noise"])


@dataclass(frozen=True, eq=False)
class Trials:
    """Ratios of P[k|k−1] over RUN_COUNT records, every packet either lost or at once there.

    `mean` (RUN_SAMPLES + 1,) at `loss`, empty where that is not the loss of the design; `means`, `medians`: after RUN_SAMPLES
    samples for the first losses of OVER.
    """

    loss: float
    mean: np.ndarray
    means: tuple[float, ...] = ()
    medians: tuple[float, ...] = ()

    @property
    def done(self) -> float:
        """How far the job has come."""
        return (FIRST_BAR_SHARE if len(self.mean) else 0.0) + (1 - FIRST_BAR_SHARE) * len(self.means) / len(OVER)


@dataclass(frozen=True, eq=False)
class Study:
    """One run of one design and what many runs have shown so far; arrays over RUN_SAMPLES, the last value held where the run diverged.

    teeth (RUN_SAMPLES, 2): ratio of the covariance just after the packets of a sample, and just before those of the next.
    lower, upper (RUN_SAMPLES + 1,): bounds of the mean of that before the packets. loop: z⁺ = loop z of the steady filter with
    delay and no loss.
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
    bounds: LazyValue[tuple[np.ndarray, np.ndarray]]
    loop: np.ndarray
    ages: tuple[np.ndarray, np.ndarray]
    trials: Trials | None = None

    @cached_property
    def told_all(self) -> np.ndarray:
        """The error (N, n) of an observer that is told everything."""
        return promised_error(self.run)

    @cached_property
    def meter(self) -> float:
        """How far the error is not its own."""
        return min(network_meter(self.run, promised=self.told_all), DISPLAY_LIMIT)

    @property
    def size(self) -> np.ndarray:
        """The error, in standard deviations of the filter without loss."""
        return self._sized(self.run.e)

    @property
    def promised(self) -> np.ndarray:
        """The same of an observer that is told everything."""
        return self._sized(self.told_all)

    def _sized(self, e: np.ndarray) -> np.ndarray:
        return _held(np.minimum(np.linalg.norm(e * np.sqrt(self.watched.weights), axis=1), DISPLAY_LIMIT))

    @property
    def lower(self) -> np.ndarray:
        """The lower bound."""
        return self.bounds.value[0]

    @property
    def upper(self) -> np.ndarray:
        """The upper bound."""
        return self.bounds.value[1]


def tell(design: Design) -> Study:
    """Simulate the design and put beside it what is known about the mean."""
    who = watched(*key(design))
    s, kind = who.sampled, CASE_KINDS[design["case"]]
    delay, ahead = int(design["delay"]), int(design["delay"]) if design["told"] == TOLD_AHEAD else 0
    told = TOLD_COMMANDED if design["told"] == TOLD_COMMANDED else TOLD_APPLIED
    stamped = design["jitter"] == 0 or design["order"] == "stamped"
    run = simulate_network(NetworkScenario(
        s.plant, s.K, s.Q, who.R, who.steady.solution, kind.x0, RUN_SAMPLES, Link(design["loss"], 0, int(design["jitter"])),
        Link(design["loss_u"], delay), design["lost"], told, "stamped" if stamped else "arrival", ahead,
        _jumps(design, s.plant.dt), int(design["seed"])))
    after = run.plan.P
    before = s.plant.A @ after @ s.plant.A.T + s.Q
    limits = LazyValue(lambda: _late(*bounds(design["loss"], key(design)), int(design["jitter"]), who))
    return Study(
        watched=who, run=run, x=_held(run.x), xhat=_held(run.xhat), asked=_held(run.u_asked), applied=_held(run.u_applied),
        heard=np.isin(np.arange(RUN_SAMPLES), run.draw.sensed), fresh=np.isin(np.arange(RUN_SAMPLES), run.draw.acted),
        teeth=np.clip(np.column_stack([who.ratio(after), who.ratio(before)]), 1 / DISPLAY_LIMIT, DISPLAY_LIMIT), bounds=limits,
        loop=delayed_loop(s.plant, s.K, who.steady.filter_gain, delay, told=told, ahead=ahead),
        ages=(_held(run.sensor_age), _held(run.actuator_age)))


def _held(values: np.ndarray) -> np.ndarray:
    """Over RUN_SAMPLES, clipped, the last value held where the run ended early."""
    index = np.minimum(np.arange(RUN_SAMPLES), len(values) - 1)
    return np.clip(values, -DISPLAY_LIMIT, DISPLAY_LIMIT)[index]


def _jumps(design: Design, h: float) -> np.ndarray:
    """The kick, between two samples."""
    kind = CASE_KINDS[design["case"]]
    jumps = np.zeros((RUN_SAMPLES, len(kind.x0)))
    if design["kick"] >= 0:
        jumps[min(int(design["kick"] / h), RUN_SAMPLES - 2)] = kind.kick
    return jumps


@lru_cache(maxsize=64)
def bounds(loss: float, of: tuple[str, float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper bound of the mean covariance, (RUN_SAMPLES + 1, n, n), from the filter without loss on."""
    who = watched(*of)
    s = who.sampled
    return mean_bounds(s.plant.A, s.plant.C, s.Q, who.R, who.steady.solution, loss, RUN_SAMPLES)


@lru_cache(maxsize=32)
def bounds_over_loss(of: tuple[str, float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Ratios of the lower and the upper bound after RUN_SAMPLES samples, over LOSSES."""
    who = watched(*of)
    s = who.sampled
    lower, upper = mean_bounds(s.plant.A, s.plant.C, s.Q, who.R, who.steady.solution, LOSSES, RUN_SAMPLES)
    return np.minimum(who.ratio(lower[:, -1]), DISPLAY_LIMIT), np.minimum(who.ratio(upper[:, -1]), DISPLAY_LIMIT)


def _late(lower: np.ndarray, upper: np.ndarray, late: int, who: Watched) -> tuple[np.ndarray, np.ndarray]:
    """The same as ratios where packets may be `late` samples late: the upper bound then waits for the last of them."""
    s = who.sampled
    top = upper
    for _ in range(late):  # one more sample without any measurement; at the start there are none to wait for
        top = np.concatenate([upper[:1], s.plant.A @ top[:-1] @ s.plant.A.T + s.Q])
    return np.clip(who.ratio(lower), 1 / DISPLAY_LIMIT, DISPLAY_LIMIT), np.clip(who.ratio(top), 1 / DISPLAY_LIMIT, DISPLAY_LIMIT)


@lru_cache(maxsize=32)
def input_growth(name: str, a: float, stretch: float) -> tuple[np.ndarray, np.ndarray]:
    """Growth of E‖x‖² a sample over INPUT_LOSSES under u = −K x, for held and for zeroed inputs."""
    s = sampled(name, a, stretch)
    losses = INPUT_LOSSES[::4] if name == DECK_CASE else INPUT_LOSSES
    held, zeroed = ([mean_square_growth(s.plant, s.K, p, how) for p in losses] for how in (HOLD_INPUT, ZERO_INPUT))
    return np.interp(INPUT_LOSSES, losses, held), np.interp(INPUT_LOSSES, losses, zeroed)


@lru_cache(maxsize=64)
def growth_now(name: str, a: float, stretch: float, loss: float) -> tuple[float, float]:
    """The same at one loss, held and zeroed."""
    s = sampled(name, a, stretch)
    return mean_square_growth(s.plant, s.K, loss, HOLD_INPUT), mean_square_growth(s.plant, s.K, loss, ZERO_INPUT)


def loop_radius(study: Study) -> float:
    """Largest modulus of the poles of the loop with delay."""
    return spectral_radius(study.loop)


def compute(design: Design) -> Outcome[Study]:
    """One run over the two links, bounds of the mean covariance, the loop with its delay."""
    study = tell(design)
    s = study.watched.sampled
    poles = LazyMap(lambda: {"controller": np.linalg.eigvals(s.plant.A - s.plant.B @ s.K), "observer": study.watched.steady.poles,
                              "loop": np.linalg.eigvals(study.loop)})
    metrics = LazyMap(lambda: {
        "critical": s.edge.lost, "safe": s.edge.safe, "growth": design["loss"] * s.radius**2, "radius": s.radius,
        "period": s.plant.dt, "separation_meter": study.meter, "loop_radius": loop_radius(study),
        "designed_radius": float(max(np.abs(p).max() for name, p in poles.items() if name != "loop")),
        "lower": float(study.lower[-1]), "upper": float(study.upper[-1]), "peak": float(study.teeth.max()),
        "lost_measurements": float(np.sum(~study.heard)), "lost_inputs": float(np.sum(study.run.draw.acted < 0)),
    })
    checks = LazySequence(lambda: (
        Check("bounded", text("the filter expects a bounded mean covariance"), s.edge.bounded(design["loss"]) is True, metrics["growth"]),
        Check("separation", text("the error dynamics are autonomous"), study.meter < AUTONOMOUS_TOLERANCE, study.meter),
        Check("loop", text("the loop with its delay is stable"), metrics["loop_radius"] < 1, metrics["loop_radius"]),
    ))
    return Outcome(design, {"K": s.K, "L": study.watched.steady.gain, "M": study.watched.steady.filter_gain}, poles, metrics,
                   checks, None, (), _stage(design, study), LazySequence(lambda: _formulas(design, study)),
                   LazyValue(lambda: _live(design, metrics)), study)


def last_packets(came: np.ndarray) -> np.ndarray:
    """Which of the last PACKETS packets came at each sample, the newest first: 1 or 0, and −1 before the run; (samples, PACKETS)."""
    before = np.concatenate([np.full(PACKETS - 1, -1.0), came])
    return np.lib.stride_tricks.sliding_window_view(before, PACKETS)[:, ::-1]


def _stage(design: Design, study: Study) -> Stage:
    """The run played finely, straight between samples, with packets as lamps and on belts, and 3σ of the filter as a cloud or gate."""
    kind, s = CASE_KINDS[design["case"]], study.watched.sampled
    fine = int(np.clip(np.ceil(s.plant.dt / FRAME_S), 1, MAX_FRAMES_PER_SAMPLE))
    index, share = np.divmod(np.arange((RUN_SAMPLES - 1) * fine + 1), fine)
    share = (share / fine)[:, None]
    after = np.minimum(index + 1, RUN_SAMPLES - 1)
    sensed, acted = (last_packets(came)[index] for came in (study.heard, study.fresh))
    packets = np.hstack([sensed[:, :1], acted[:, :1], share, sensed[:, 1:], acted[:, 1:]])
    late = design["case"] == SCALAR_CASE and design["delay"] > 0
    if design["case"] == SCALAR_CASE:  # the place for which the acting force is right: u = −K x
        packets = np.hstack([packets, np.full_like(share, late), np.clip(-study.applied / s.K[0, 0], -FARTHEST, FARTHEST)[index]])

    def played(x: np.ndarray) -> np.ndarray:
        return x[index] * (1 - share) + x[after] * share
    row = np.array(kind.shown)
    sigma = np.sqrt(np.maximum(np.einsum("i,kij,j->k", row, study.run.plan.P, row), 0.0))  # rounding of a huge P may go below
    spread = 3 * np.minimum(sigma, FARTHEST)[index]
    if design["case"] == SCALAR_CASE:  # its spread is a gate
        packets = np.hstack([packets, np.clip(played(study.xhat), -FARTHEST, FARTHEST), spread[:, None] / SCALE])
    x, xhat = (np.hstack([played(states), packets]) for states in (study.x, study.xhat))
    t = np.arange(len(index)) * s.plant.dt / fine
    return Stage(kind.body, t, x, xhat, study.applied[index], None if design["case"] == SCALAR_CASE else spread,
                 (LATE_FORCE,) if late else ())


def _formulas(design: Design, study: Study) -> tuple[Formula, ...]:
    s, p = study.watched.sampled, design["loss"]
    sign = "<" if p * s.radius**2 < 1 else r"\ge"
    out = [
        Formula("mean", r"P^+ = A (P - \gamma\, M C P) A^{\mathsf T} + Q",
                text("γ is 1 when the packet comes and 0 when it is lost")),
        Formula("edge", rf"p_c = \frac{{1}}{{\max|\lambda|^2}} = \frac{{1}}{{{number(s.radius, 4)}^2}} = {number(1 / s.radius**2, 4)}"
                if s.radius > 1 else rf"\max|\lambda| = {number(s.radius, 4)} \le 1"),
        Formula("growth", rf"p \max|\lambda|^2 = {number(p * s.radius**2, 4)} {sign} 1"),
    ]
    if not s.edge.exact:
        out.append(Formula("safe", rf"p < \prod|\lambda|^{{-2}} = {number(s.edge.safe, 4)}",
                           text("enough for a bounded mean with one sensor")))
    if s.plant.n <= 4:
        out += [Formula("A", rf"A = {matrix(s.plant.A)}"), Formula("K", rf"K = {matrix(s.K)}"),
                Formula("M", rf"M = {matrix(study.watched.steady.filter_gain)}", text("filter gain without loss"))]
    return tuple(out)


def _live(design: Design, m: Mapping[str, float]) -> Text:
    lost = f"{100 * design['loss']:.0f} %"
    if m["critical"] >= 1:
        first = text("{lost} of the measurements are lost; this plant has no unstable mode, so the filter expects a bounded mean variance.",
                     lost=lost)
    else:
        first = claim(text("{lost} of the measurements are lost; up to {critical:.1f} % can be tolerated: the filter expects "
                           "a bounded mean variance.",
                           lost=lost, critical=100 * m["critical"]), design["loss"], below=m["critical"], otherwise=text(
            "{lost} of the measurements are lost, and the limit is {critical:.1f} %: the mean variance that the filter expects diverges.",
            lost=lost, critical=100 * m["critical"]))
    second = claim(text("Separation meter: 0."), m["separation_meter"], below=AUTONOMOUS_TOLERANCE, otherwise=text(
        "Separation meter: {separation_meter:.2g}.", separation_meter=m["separation_meter"]))
    unstable = text("With this delay the loop is unstable: its spectral radius is {radius:.3g}.", radius=m["loop_radius"])
    wrong = text("The true error does not follow the filter's variance.")
    return joined(unstable if m["loop_radius"] >= 1 else NO_WORDS, first, second,
                  wrong if m["separation_meter"] >= AUTONOMOUS_TOLERANCE else NO_WORDS)
