"""Compute the block's error variance: steady, over observer speed, and over time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm

from observer_lab.course.figures.claims import claim
from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome, Stage
from observer_lab.engine import Plant, Scenario, error_parts, lqe, observer_gain, simulate
from observer_lab.engine.design import Optimal
from observer_lab.engine.filters import ErrorParts
from observer_lab.engine.simulation import Run
from observer_lab.engine.systems import settled_covariance
from observer_lab.plants.spring_damper import STAGE_SCALE
from observer_lab.text import Text, text

from ..toolkit.boards import listed
from ..toolkit.knobs import held, kicks
from ..toolkit.latex import matrix, number
from ..toolkit.shares import percent
from .knobs import BY_POLES, BY_SPEED, DT, HORIZON, IM_HIGH, MODEL, RE_HIGH, RE_LOW, SPRING_PLANT, VELOCITY
from .readings_body import stage_with_readings, with_readings

OBSERVER_SPEEDS = np.logspace(-0.5, 2.5, 61)  # rad/s

MOTION_GAIN = 2.0  # so that noise and its estimate are seen to move
BODY = with_readings(replace(MODEL.body, gain=MOTION_GAIN))


@dataclass(frozen=True, eq=False)
class Ray:
    """Observers whose poles are those of one pattern times a factor.

    speed (n,): geometric mean of |pole| in rad/s; process, sensor (n, 2): variances of the error in position and
    velocity by cause; peak (n,): largest velocity error for each metre of starting error, without noise, in 1/s.
    """

    speed: np.ndarray
    process: np.ndarray
    sensor: np.ndarray
    peak: np.ndarray


@dataclass(frozen=True, eq=False)
class Trials:
    """Monte-Carlo: mean square (n_t, k) of k components of e about its noise-free course over `count` runs."""

    count: int
    square: np.ndarray


@dataclass(frozen=True, eq=False)
class Study:
    """Everything about the noise of one design. `quiet` is the error without noise (n_t, 2), `grown` P at each sample."""

    parts: ErrorParts
    kalman: Optimal
    ray: Ray
    quiet: np.ndarray
    grown: np.ndarray
    trials: Trials | None = None


def scenario_of(design: Design, L: np.ndarray) -> Scenario:
    """Plant and observer under both noises, nobody steering."""
    return Scenario(SPRING_PLANT, None, L, x0=(design["error0"], 0.0), xhat0=(0.0, 0.0), horizon=HORIZON, dt=DT,
                    W=[[design["w"]]], V=[[design["v"]]], G=SPRING_PLANT.B, impulses=kicks(design, MODEL, (DT, HORIZON)),
                    seed=int(design["seed"]))


def compute(design: Design) -> Outcome[Study]:
    """The observer's error covariance beside the least one, the ray through its poles, and one noisy run."""
    W, V = design["w"], design["v"]
    kalman = lqe(SPRING_PLANT.A, SPRING_PLANT.B, SPRING_PLANT.C, [[W]], [[V]])
    poles, L = _observer(design, kalman)
    parts = error_parts(SPRING_PLANT, L, SPRING_PLANT.B, [[W]], [[V]])
    scenario = scenario_of(design, L)
    run, quiet = simulate(scenario), simulate(replace(scenario, W=None, V=None))
    study = Study(parts, kalman, ray_of(SPRING_PLANT, poles, OBSERVER_SPEEDS, W, V), quiet.e,
                  growing(SPRING_PLANT, L, parts, V, DT, len(run.t)))
    metrics = _metrics(design, study, poles, L)
    ratio = metrics["variance_ratio"]
    checks = (
        Check("least", text("within 1 % of the least variance"), ratio <= 1.01, ratio, informative=True),
        Check("floor", text("no observer beats the Kalman filter: P − P_min ≥ 0"),
              metrics["floor"] > -1e-9, metrics["floor"]),
    )
    return Outcome(design, {"L": L, "L_kalman": kalman.gain}, {"observer": np.asarray(poles), "kalman": kalman.poles},
                   metrics, checks, run, _boards(poles, kalman, SPRING_PLANT.A - L @ SPRING_PLANT.C), _stage(run, study, design),
                   _formulas(L, study), _live(design, metrics), study)


def _observer(design: Design, kalman: Optimal) -> tuple[tuple[complex, ...], np.ndarray]:
    """Poles and gain. Raises KnobError where the error does not settle."""
    if design["method"] == BY_SPEED:
        poles = tuple(complex(p) * design["speed"] for p in kalman.poles)
        if design["speed"] == 1.0:
            return poles, kalman.gain
    else:
        poles = design["observer_poles"]
    if max(p.real for p in poles) > -0.02:
        raise KnobError(text("An observer pole is not left of −0.02, so the error has no settled variance; "
                             "drag it left."))
    return poles, observer_gain(SPRING_PLANT.A, SPRING_PLANT.C, poles).gain


def _metrics(design: Design, study: Study, poles: tuple[complex, ...], L: np.ndarray) -> dict[str, float]:
    P, least, i = study.parts.total, study.kalman.solution, int(design["watch"] == VELOCITY)
    size = np.abs(study.quiet)
    late = np.flatnonzero(size[:, 1] > 0.02 * max(float(size[:, 1].max()), 1e-12))
    return {
        "position_rms": float(np.sqrt(P[0, 0])), "velocity_rms": float(np.sqrt(P[1, 1])),
        "least_position_rms": float(np.sqrt(least[0, 0])), "least_velocity_rms": float(np.sqrt(least[1, 1])),
        "variance_ratio": float(P[i, i] / least[i, i]),
        "worst_ratio": float(max(P[0, 0] / least[0, 0], P[1, 1] / least[1, 1])),
        "floor": float(np.linalg.eigvalsh(P - least)[0] / np.trace(least)),
        "sensor_share": float(study.parts.sensor[i, i] / P[i, i]),
        "speed": float(np.sqrt(abs(poles[0] * poles[1]))), "kalman_speed": float(np.sqrt(np.abs(np.prod(study.kalman.poles)))),
        "peak": float(size[:, 1].max()),
        "settled_after": 0.0 if not len(late) else float(DT * (late[-1] + 1)) if late[-1] + 1 < len(size) else np.inf,
        "riccati_residual": study.kalman.residual, "largest_gain": float(np.abs(L).max()),
    }


def _boards(poles: tuple[complex, ...], kalman: Optimal, error: np.ndarray) -> tuple[Board, Board]:
    return (
        Board("kalman", text("poles of the Kalman filter"), listed(kalman.poles), side="left",
              re_low=RE_LOW, re_high=RE_HIGH, im_high=IM_HIGH),
        Board("observer", text("observer poles  eig(A − LC)"),
              listed(poles), "observer_poles", role="estimate", side="right", re_low=RE_LOW,
              re_high=RE_HIGH, im_high=IM_HIGH, also=(("method", BY_POLES),), landscape=error),
    )


def _stage(run: Run, study: Study, design: Design) -> Stage:
    """The block under its last readings; one reading, held for a step, has the variance V/dt."""
    plain = Stage(
        BODY, run.t, run.x, run.xhat, run.u_applied, 3 * STAGE_SCALE * MOTION_GAIN * np.sqrt(np.maximum(study.grown[:, 0, 0], 0.0)),
        held=held(design, MODEL),
    )
    return stage_with_readings(plain, run.y[:, 0], float(np.sqrt(design["v"] / DT)))


def _formulas(L: np.ndarray, study: Study) -> tuple[Formula, ...]:
    P = study.parts.total
    return (
        Formula("lyapunov", r"F P + P F^{\mathsf T} + B W B^{\mathsf T} + L V L^{\mathsf T} = 0,\quad F = A - LC"),
        Formula("L", rf"L = {matrix(L)}, \quad L_{{\mathrm{{Kalman}}}} = {matrix(study.kalman.gain)}"),
        Formula("P", rf"P = {matrix(P, 2)}"),
        Formula("least", rf"P_{{\min}} = {matrix(study.kalman.solution, 2)}, \quad "
                rf"\mathrm{{tr}}\,(P - P_{{\min}}) = {number(float(np.trace(P - study.kalman.solution)), 2)}"),
    )


def _live(design: Design, m: dict[str, float]) -> Text:
    ratio, share = np.sqrt(m["variance_ratio"]), percent(m["sensor_share"])
    name = text("velocity") if design["watch"] == VELOCITY else text("position")
    least = text("The {name} error is as small as any observer can make it: {share} % of its variance is "
                 "sensor noise.",
                 name=name, share=share)
    return claim(least, ratio, below=1.005, otherwise=text(
        "The {name} error is {ratio:.3g} times the least possible; {share} % of its variance is "
        "sensor noise.", name=name, ratio=ratio, share=share))


def ray_of(plant: Plant, pattern: tuple[complex, ...], speeds: np.ndarray, W: float, V: float) -> Ray:
    """All observers along a ray at once, for two states and one output: Ackermann's gain, Lyapunov by Kronecker."""
    unit = np.asarray(pattern) / np.sqrt(abs(pattern[0] * pattern[1]))
    damping, square = -np.real(unit.sum()) * speeds, np.real(unit[0] * unit[1]) * speeds**2  # s² + damping s + square
    A, C, eye = plant.A, plant.C, np.eye(2)
    last = np.linalg.solve(np.vstack([C, C @ A]), np.array([[0.0], [1.0]]))
    L = (A @ A + damping[:, None, None] * A + square[:, None, None] * eye) @ last
    F = A - L @ C
    M = np.einsum("kij,ab->kiajb", F, eye) + np.einsum("ij,kab->kiajb", eye, F)
    noise = np.stack([np.broadcast_to(W * plant.B @ plant.B.T, F.shape), V * L @ np.swapaxes(L, 1, 2)], axis=-1)
    P = np.linalg.solve(M.reshape(-1, 4, 4), -noise.reshape(-1, 4, 2)).reshape(-1, 2, 2, 2)
    variances = np.maximum(np.diagonal(P, axis1=1, axis2=2), 0.0)  # (n, cause, state)
    return Ray(speeds, variances[:, 0], variances[:, 1], peak_of(F[:, 1, 0], damping, square))


def peak_of(F21: np.ndarray, damping: np.ndarray, square: np.ndarray) -> np.ndarray:
    """max |e₂(t)| for ė = F e from e(0) = (1, 0): e₂ = F₂₁ e^{αt} sinh(δt)/δ with α = −damping/2, δ² = α² − square.

    Its slope vanishes at tanh(δt) = −δ/α, where sinh(δt)/δ = 1/√square.
    """
    alpha = -damping / 2
    gap = alpha**2 - square
    delta = np.sqrt(np.abs(gap))
    small = delta < 1e-6 * np.abs(alpha)
    safe = np.where(small, 1.0, delta)
    turning = np.arctan2(safe, -alpha) / safe
    real = np.arctanh(np.minimum(safe / -alpha, 1 - 1e-12)) / safe
    t = np.where(small, -1 / alpha, np.where(gap < 0, turning, real))
    return np.abs(F21) * np.exp(alpha * t) / np.sqrt(square)


def growing(plant: Plant, L: np.ndarray, parts: ErrorParts, V: float, dt: float, steps: int) -> np.ndarray:
    """Covariances (steps, 2, 2) of e at 0, dt, … from P(0) = 0, exactly as simulated: v is held over a step.

    P_k = P_h − Φᵏ P_h Φᵏᵀ, where P_h is the limit with the sampled sensor noise of covariance V/dt.
    """
    F = plant.A - L @ plant.C
    wide = np.zeros((4, 4))
    wide[:2, :2], wide[:2, 2:] = F, np.eye(2)
    both: np.ndarray = expm(wide * dt)
    Phi: np.ndarray = both[:2, :2]
    push: np.ndarray = both[:2, 2:] @ L
    limit = parts.process + settled_covariance(Phi, np.sqrt(V / dt) * push, dt=1.0)
    powers = np.empty((steps, 2, 2))
    powers[0], done = np.eye(2), 1
    jump: np.ndarray = Phi
    while done < steps:
        more = min(done, steps - done)
        powers[done:done + more] = powers[:more] @ jump
        done, jump = done + more, jump @ jump
    return limit - powers @ limit @ np.swapaxes(powers, 1, 2)
