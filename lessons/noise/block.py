"""Compute what lesson 8 has on the block alone: observers over their speed, and what is said of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from observer_lab.colours import COLOURS
from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.diagram import DIAGRAM
from observer_lab.course.figures.scene import last_readings
from observer_lab.course.knobs import KnobError
from observer_lab.course.lazy import TabFigures, tab_figures
from observer_lab.course.lesson import Design, Formula, Outcome, Stage
from observer_lab.engine import Plant, observer_gain
from observer_lab.engine.design import Optimal
from observer_lab.plants import Signal
from observer_lab.plants.bodies.body import Ball, Body, Box, ErrorMarks, Part, PartName, Pose, Rod, bound_displacement, pose_between
from observer_lab.plants.model import Window
from observer_lab.plants.spring_damper import BLOCK_EDGE, MAX_DRAWN_DISPLACEMENT, RAIL_TOP, REST_POSITION, STAGE_SCALE
from observer_lab.text import Text, text

from ..toolkit.diagram import loop
from ..toolkit.knobs import held, untouched
from ..toolkit.latex import matrix, number, percent
from .knobs import BY_SPEED, DT, HORIZON, IM_HIGH, MODEL, POLES, RE_HIGH, RE_LOW, SPRING_PLANT, VELOCITY
from .study import Look, Setting, Study, Sweep, Trials

READINGS = 12  # that stand above the block, the latest lowest
LOWEST, STEP, FRONT = RAIL_TOP + BLOCK_EDGE + 0.08, 0.042, -0.1  # z of the latest reading, from one to the next, y of all
BAND_HIGH = READINGS * STEP
ASIDE = (0.85, -0.4, 0.3)  # from the block to its name: above it are the readings
LEAST_HALF = 0.01  # stage units: a band is no narrower
EXPECTED_Z, CAP, BAR, MIDDLE = LOWEST + BAND_HIGH + 0.08, 0.16, 0.028, 0.055  # of the bar of ŷ ± 3σ: its z, height of its ends, radii
ENDS = ("low", "high")
NAME_GAP = 0.1  # stage units from what is drawn to its letter
SPEED_LONG, SPEED_MOST, SPEED_THICK = 0.2, 1.4, 0.055  # stage units: a bar of 1 m/s, the longest, its radius
SPEED_Z, SPEED_STEP = EXPECTED_Z + 0.26, 0.2  # z of the bar of the velocity, and up to that of its estimate
LINE_TOP = SPEED_Z + 0.12  # where the line of the true position ends, from which the bar of the velocity begins
READING_PARTS = (
    *(Part(f"reading {k}", Ball(0.034), COLOURS["second"]) for k in range(READINGS)),
    Part("noise band", Box((2.0, 0.02, BAND_HIGH)), COLOURS["second"], opacity=0.22),
    Part("true position", Box((0.014, 0.03, LINE_TOP - LOWEST)), COLOURS["plant"]),
    Part("estimate bar", Rod(BAR), COLOURS["estimate"], twin=True, unseen=True, edged=False),
    Part("estimated position", Ball(MIDDLE), COLOURS["estimate"], twin=True, unseen=True, edged=False),
    *(Part(f"estimate {end}", Box((0.03, 0.1, CAP)), COLOURS["estimate"], twin=True, unseen=True, edged=False) for end in ENDS),
    Part("velocity", Rod(SPEED_THICK), COLOURS["plant"]),
    Part("estimated velocity", Rod(SPEED_THICK), COLOURS["estimate"], twin=True, unseen=True, edged=False),
)


def _long(speed: float) -> float:
    """How long the bar of a velocity in m/s is, to the left where it is negative."""
    return bound_displacement(SPEED_LONG * float(speed), SPEED_MOST)


def with_readings(body: Body) -> Body:
    """The block under its readings and the bar of its estimate ± 3σ, with a bar for its velocity and that of the estimate.

    After the two states a record holds σ of one reading, three times σ of the estimate, and the last readings, all in m.
    """
    def across(metres: float, gain: float) -> float:
        return REST_POSITION + bound_displacement(metres * STAGE_SCALE * gain, MAX_DRAWN_DISPLACEMENT)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        true, sigma, wide = map(float, (x[0], *x[2:4]))
        ends = across(true - sigma, gain), across(true + sigma, gain)
        expected = [(across(true + sign * wide, gain), FRONT, EXPECTED_Z) for sign in (-1, 1)]
        middle = LOWEST - STEP / 2 + BAND_HIGH / 2
        poses = {f"reading {k}": Pose((across(float(y), gain), FRONT, LOWEST + k * STEP)) for k, y in enumerate(x[4:])}
        poses |= {f"estimate {end}": Pose(at) for end, at in zip(ENDS, expected, strict=True)}
        half = max((ends[1] - ends[0]) / 2, LEAST_HALF)
        here, long = across(true, gain), _long(x[1])
        poses |= {name: pose_between((here, FRONT, z), (here + long, FRONT, z))
                  for name, z in (("velocity", SPEED_Z), ("estimated velocity", SPEED_Z + SPEED_STEP))}
        line = (across(true, gain), FRONT + 0.03, (LOWEST + LINE_TOP) / 2)
        return {**body.pose(x, gain), **poses, "true position": Pose(line),
                "estimate bar": pose_between(*expected), "estimated position": Pose((across(true, gain), FRONT, EXPECTED_Z)),
                "noise band": Pose(((ends[0] + ends[1]) / 2, FRONT + 0.06, middle), scale=(half, 1.0, 1.0))}

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        own = ErrorMarks((), ()) if body.marks is None else body.marks(x, xhat, gain)
        left = min(across(float(y), gain) for y in x[4:])
        return ErrorMarks(own.bars, (
            *own.words, ("ŷ ± 3σ", (across(float(xhat[0]) + float(x[3]), gain) + NAME_GAP, FRONT, EXPECTED_Z), "center-left"),
            ("y", (left - NAME_GAP, FRONT, LOWEST + 0.25 * BAND_HIGH), "center-right"),
            *((name, (across(float(at), gain) + long + (NAME_GAP if long > 0 else -NAME_GAP), FRONT, z),
               "center-left" if long > 0 else "center-right") for name, at, long, z in (
                ("v", x[0], _long(x[1]), SPEED_Z), ("v̂", xhat[0], _long(xhat[1]), SPEED_Z + SPEED_STEP)))))

    names = tuple(replace(name, away=name.away if name.ghost else ASIDE) for name in body.names if name.part != "spring")
    return replace(body, parts=(*body.parts, *READING_PARTS), pose=pose, marks=marks, names=(
        *names, PartName(text("the last 12 readings"), "reading 2", (0.8, -0.2, 0.15)),
        PartName(text("velocity"), "velocity", (-0.7, -0.1, 0.05))))


def stage_with_readings(stage: Stage, y: np.ndarray, sigma: float, expected: np.ndarray) -> Stage:
    """The stage of a run with the readings y (n_t,) of the sensor, before the first one none; 3σ of the estimate is `expected` (n_t,).

    Beside a running plant, whose start is not known, it is that at the end.
    """
    def with_bar(wide: np.ndarray) -> Stage:
        more = np.column_stack([np.full(len(y), sigma), wide, last_readings(y, READINGS)])
        return replace(stage, x=np.hstack([stage.x, more]), xhat=None if stage.xhat is None else np.hstack([stage.xhat, more]),
                       readings=READINGS)

    return replace(with_bar(expected), plain=with_bar(np.full(len(y), expected[-1])))


OBSERVER_SPEEDS = np.logspace(-0.5, 2.5, 61)  # rad/s

MOTION_GAIN = 2.0  # so that noise and its estimate are seen to move
BLOCK = replace(MODEL, body=with_readings(replace(MODEL.body, gain=MOTION_GAIN)), horizon=HORIZON, dt=DT, observer_poles=POLES,
                observer_window=Window(RE_LOW, RE_HIGH, IM_HIGH))
SIGNALS = (Signal(text("position"), (1.0, 0.0), "m"), Signal(text("velocity"), (0.0, 1.0), "m/s"))


def _observer(design: Design, kalman: Optimal) -> tuple[np.ndarray, np.ndarray]:
    """Poles and gain. Raises KnobError where the error does not settle."""
    if design["method"] == BY_SPEED:
        poles = tuple(complex(p) * design["speed"] for p in kalman.poles)
        if design["speed"] == 1.0:
            return np.asarray(poles), kalman.gain
    else:
        poles = design["observer_poles"]
    if max(p.real for p in poles) > -0.02:
        raise KnobError(text("An observer pole is not left of −0.02, so the error has no settled variance; "
                             "drag it left."))
    return np.asarray(poles), observer_gain(SPRING_PLANT.A, SPRING_PLANT.C, poles).gain


def speed_of(poles: np.ndarray) -> float:
    """The geometric mean of |pole| in rad/s."""
    return float(np.sqrt(np.abs(np.prod(poles))))


def _numbers(s: Study) -> dict[str, float]:
    P, least, size = s.parts.total, s.least, np.abs(s.quiet[:, 1])
    late = np.flatnonzero(size > 0.02 * max(float(size.max()), 1e-12))
    return {
        "position_rms": s.deviation(P, 0), "velocity_rms": s.deviation(P, 1),
        "least_position_rms": s.deviation(least, 0), "least_velocity_rms": s.deviation(least, 1),
        "variance_ratio": s.ratio**2, "worst_ratio": float(max(P[0, 0] / least[0, 0], P[1, 1] / least[1, 1])),
        "sensor_share": s.sensor_share, "speed": speed_of(s.poles), "kalman_speed": speed_of(s.kalman.poles),
        "settled_after": 0.0 if not len(late) else float(DT * (late[-1] + 1)) if late[-1] + 1 < len(size) else np.inf,
        "riccati_residual": s.kalman.residual,
    }


def _tried(s: Study, trials: Trials) -> dict[str, float]:
    tail = trials.square[-1] / np.diagonal(s.grown[-1])
    return {"trial_ratio_position": float(tail[0]), "trial_ratio_velocity": float(tail[1])}


def _stage(s: Study) -> Stage:
    """The block under its last readings; one reading, held for a step, has the variance V/dt."""
    plain = Stage(BLOCK.body, s.run.t, s.run.x, s.run.xhat, s.run.u_applied, held=held(s.design, MODEL))
    return stage_with_readings(plain, s.run.y[:, 0], float(np.sqrt(s.design["v"] / DT)), 3 * np.sqrt(np.maximum(s.grown[:, 0, 0], 0.0)))


def _formulas(s: Study) -> tuple[Formula, ...]:
    P = s.parts.total
    return (
        Formula("lyapunov", r"F P + P F^{\mathsf T} + B W B^{\mathsf T} + L V L^{\mathsf T} = 0,\quad F = A - LC"),
        Formula("L", rf"L = {matrix(s.L)}, \quad L_{{\mathrm{{Kalman}}}} = {matrix(s.kalman.gain)}"),
        Formula("P", rf"P = {matrix(P, 2)}"),
        Formula("least", rf"P_{{\min}} = {matrix(s.least, 2)}, \quad "
                rf"\mathrm{{tr}}\,(P - P_{{\min}}) = {number(float(np.trace(P - s.least)), 2)}"),
    )


def _live(s: Study) -> Text:
    name, share = SIGNALS[s.judged].name, percent(s.sensor_share)
    least = text("The {name} error is as small as any observer can make it: {share} % of its variance is "
                 "sensor noise.",
                 name=name, share=share)
    return claim(least, s.ratio, below=1.005, otherwise=text(
        "The {name} error is {ratio:.3g} times the least possible; {share} % of its variance is "
        "sensor noise.", name=name, ratio=s.ratio, share=share))


def ray_of(plant: Plant, pattern: tuple[complex, ...], speeds: np.ndarray, W: float, V: float) -> Sweep:
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
    return Sweep(speeds, variances[:, 0], variances[:, 1], peak_of(F[:, 1, 0], damping, square))


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


# --- what stands below the figures -------------------------------------------------------------------------------------
def _valley_words(s: Study) -> Text:
    i, unit = s.judged, SIGNALS[s.judged].unit
    now, least = s.deviation(s.parts.total, i), s.deviation(s.least, i)
    if now < 1.005 * least:
        return text("σ = {now:.3g} {units}: this is the bottom.", now=now, units=unit)
    total = s.sweep.process[:, i] + s.sweep.sensor[:, i]
    best = float(s.sweep.along[np.argmin(total)])
    away, gain = float(np.log(speed_of(s.poles) / best)), 100 * (now / float(np.sqrt(total.min())) - 1)
    turned = claim(text("Slower would be better."), away, above=0.0, otherwise=claim(text("Faster would be better."), away, below=0.0))
    advice = claim(text("No other speed is half a per cent better; only another pattern is."), gain, below=0.5, otherwise=turned)
    return text("σ = {now:.3g} {units}, {share} % of σ² from the sensor; the least is {least:.3g} {units}. "
                "{advice}",
                now=now, units=unit, share=percent(s.sensor_share), least=least, advice=advice)


def _peak_words(s: Study) -> Text:
    start = s.design["error0"]
    if untouched(s.design):
        return text("With {d:.2g} m of starting error the velocity estimate is wrong by up to {peak:.3g} m/s.", d=start, peak=s.peak)
    return text("With {d:.2g} m of starting error and the kick or pull the velocity estimate is wrong by up to "
                "{peak:.3g} m/s.",
                d=start, peak=s.peak)


def _floor_words(s: Study) -> Text:
    gap, worst = float(np.linalg.eigvalsh(s.parts.total - s.least)[0]), float(np.abs(s.least).max())
    return claim(text("P − P_min has no negative eigenvalue: no combination of errors is smaller than the Kalman "
                      "filter's."), gap, above=-1e-9 * worst, otherwise=text("P − P_min has a negative eigenvalue by rounding."))


def _reading_words(s: Study) -> Text:
    return text("A single reading is off by σ = {noise:.2g} m; the settled estimate by {position_rms:.2g} m.",
                noise=float(np.sqrt(s.design["v"] / DT)), position_rms=s.deviation(s.parts.total, 0))


def _velocity_words(s: Study) -> Text:
    return text("Nobody measures the velocity; its settled estimate is off by σ = {velocity_rms:.2g} m/s.",
                velocity_rms=s.deviation(s.parts.total, 1))


def _diagram(outcome: Outcome[Study]) -> tuple[TabFigures, ...]:
    return (tab_figures(DIAGRAM, lambda: (loop(SPRING_PLANT, outcome.study.run, outcome.study.L),)),)


LOOK = Look(
    text("error of {name} over observer speed"), text("force noise"), "|p| [rad/s]", (-0.5, 2.5),
    lambda s: (float(np.log10(speed_of(s.poles))), float(np.log10(speed_of(s.kalman.poles)))), (3.0, 3.0),
    (text("peak of the velocity error, without noise"), text("for 1 m of starting error"), "max|e₂| [m/s]"), (-0.5, 2.5),
    MappingProxyType({"measured": "q [m]", "velocity": "v [m/s]"}),
    MappingProxyType({"measured": (-0.5, 0.5), "velocity": (-0.5, 0.5), "error": (-0.2, 0.2)}),
    MappingProxyType({"valley": _valley_words, "peaks": _peak_words, "shares": _floor_words, "measured": _reading_words,
                      "velocity": _velocity_words}))
BLOCK_SETTING = Setting(
    BLOCK, SIGNALS, lambda design: int(design["watch"] == VELOCITY), lambda _: 1,
    lambda design: (SPRING_PLANT.B, np.array([[design["w"]]]), np.array([[design["v"]]])), lambda design: (design["error0"], 0.0),
    _observer, lambda s: ray_of(SPRING_PLANT, tuple(s.poles), OBSERVER_SPEEDS, s.design["w"], s.design["v"]), _stage, _numbers, _formulas,
    _live, LOOK, _diagram, _tried)
