"""Noise: why an infinitely fast observer is a bad one, and which speed is the best."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from app.engine import Scenario, error_parts, lqe, observer_gain, simulate
from app.engine.design import Optimal
from app.engine.filters import ErrorParts
from app.engine.simulation import Run
from app.lesson.knobs import Choice, KnobError, Number, Poles
from app.lesson.lesson import Board, Check, Design, Formula, Job, Lesson, Outcome, Stage
from app.lesson.prose import read_prose
from app.plants import MODELS, Model
from app.plants.spring_damper import STAGE
from app.text.words import Text

from ..toolkit.boards import listed
from ..toolkit.knobs import kicks, run_knobs
from ..toolkit.latex import matrix, number
from .pictures import all_figures
from .tasks import TASKS, exam
from .variance import Ray, growing, ray_of

MODEL = MODELS["spring-damper"]
PLANT = MODEL.plant
HORIZON, DT = 6.0, 0.012
RE_LOW, RE_HIGH, IM_HIGH = -16.0, 2.0, 10.0
SPEED, POLES = "speed", "poles"
POSITION, VELOCITY = "position", "velocity"
SPEEDS = np.logspace(-0.5, 2.5, 61)  # rad/s
RUNS, AT_ONCE = 400, 5

KNOBS = (
    Choice("method", "", Text("observer by", "观测器由"), default=SPEED,
           options=((SPEED, Text("speed, in the Kalman pattern", "速度（卡尔曼极点的形状）")),
                    (POLES, Text("dragging poles", "拖动极点"))),
           hint=Text("One factor on the Kalman filter's poles, or two poles of your own on the right board.",
                     "把卡尔曼滤波器的极点乘以一个倍数，或在右侧板上自己放两个极点。")),
    Number("speed", r"\rho", Text("speed, times Kalman", "速度（卡尔曼的倍数）"), low=0.1, high=10.0, default=5.0, scale="log",
           when=("method", (SPEED,)), hint=Text("Both poles are ρ times those of the Kalman filter.",
                                                "两个极点都是卡尔曼滤波器极点的 ρ 倍。")),
    Poles("observer_poles", "q", Text("Observer poles", "观测器极点"), "rad/s", default=(-8 - 6j, -8 + 6j), re_low=RE_LOW,
          re_high=RE_HIGH, im_high=IM_HIGH, role="estimate", when=("method", (POLES,)),
          hint=Text("eig(A − LC): farther left is faster.", "eig(A − LC)：越靠左越快。")),
    Number("w", "W", Text("force noise W", "力噪声 W"), "N² s", low=1e-2, high=1.0, default=0.04, scale="log",
           hint=Text("Intensity of the unknown force on the block.", "作用在滑块上的未知力的强度。")),
    Number("v", "V", Text("sensor noise V", "测量噪声 V"), "m² s", low=1e-5, high=1e-2, default=4e-4, scale="log",
           hint=Text("Intensity of the noise on the measured position.", "位置测量噪声的强度。")),
    Number("error0", "e_1(0)", Text("position error at the start", "初始位置误差"), "m", low=0.0, high=1.0, default=0.3,
           step=0.05, hint=Text("Where the block really starts; the observer believes 0.", "滑块实际的起点；观测器以为是 0。")),
    Choice("watch", "", Text("judge by the error in", "评判依据"), default=VELOCITY,
           options=((POSITION, Text("position, measured", "位置误差（有测量）")),
                    (VELOCITY, Text("velocity, not measured", "速度误差（无测量）"))),
           hint=Text("Which error the curves show.", "曲线显示哪一个误差。")),
    *run_knobs(HORIZON),
)


@dataclass(frozen=True, eq=False)
class Trials:
    """Monte-Carlo: mean square (n_t, 2) of e about its noise-free course over `count` runs."""

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
    return Scenario(PLANT, None, L, x0=(design["error0"], 0.0), xhat0=(0.0, 0.0), horizon=HORIZON, dt=DT,
                    W=[[design["w"]]], V=[[design["v"]]], G=PLANT.B, impulses=kicks(design, MODEL),
                    seed=int(design["seed"]))


def compute(design: Design) -> Outcome:
    """The observer's error covariance beside the least one, the ray through its poles, and one noisy run."""
    W, V = design["w"], design["v"]
    kalman = lqe(PLANT.A, PLANT.B, PLANT.C, [[W]], [[V]])
    poles, L = _observer(design, kalman)
    parts = error_parts(PLANT, L, PLANT.B, [[W]], [[V]])
    scenario = scenario_of(design, L)
    run, quiet = simulate(scenario), simulate(replace(scenario, W=None, V=None))
    study = Study(parts, kalman, ray_of(PLANT, poles, SPEEDS, W, V), quiet.e,
                  growing(PLANT, L, parts, V, DT, len(run.t)))
    metrics = _metrics(design, study, poles, L)
    ratio = metrics["variance_ratio"]
    checks = (
        Check("least", Text("within 1 % of the least variance", "方差与最小值相差不超过 1 %"), ratio <= 1.01, ratio),
        Check("floor", Text("no observer beats the Kalman filter: P − P_min ≥ 0", "没有观测器优于卡尔曼滤波器：P − P_min ≥ 0"),
              metrics["floor"] > -1e-9, metrics["floor"]),
    )
    return Outcome(design, {"L": L, "L_kalman": kalman.gain}, {"observer": np.asarray(poles), "kalman": kalman.poles},
                   metrics, checks, run, _boards(poles, kalman, PLANT.A - L @ PLANT.C), _stage(run, study),
                   _formulas(L, study), _live(design, metrics), study)


def _observer(design: Design, kalman: Optimal) -> tuple[tuple[complex, ...], np.ndarray]:
    """Poles and gain. Raises KnobError where the error does not settle."""
    if design["method"] == SPEED:
        poles = tuple(complex(p) * design["speed"] for p in kalman.poles)
        if design["speed"] == 1.0:
            return poles, kalman.gain
    else:
        poles = design["observer_poles"]
    if max(p.real for p in poles) > -0.02:
        raise KnobError(Text("An observer pole is not left of −0.02, so the error has no variance to speak of; drag it left.",
                             "有观测器极点不在 −0.02 左侧，误差方差无法稳定；请把它向左拖。"))
    return poles, observer_gain(PLANT.A, PLANT.C, poles).gain


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
        "peak": float(size[:, 1].max()), "settled_after": float(DT * (late[-1] + 1)) if len(late) else 0.0,
        "riccati_residual": study.kalman.residual, "largest_gain": float(np.abs(L).max()),
    }


def _boards(poles: tuple[complex, ...], kalman: Optimal, error: np.ndarray) -> tuple[Board, Board]:
    return (
        Board("kalman", Text("poles of the Kalman filter", "卡尔曼滤波器的极点"), listed(kalman.poles), side="left",
              re_low=RE_LOW, re_high=RE_HIGH, im_high=IM_HIGH),
        Board("observer", Text("observer poles  eig(A − LC)", "观测器极点  eig(A − LC)"),
              listed(poles), "observer_poles", role="estimate", side="right", re_low=RE_LOW,
              re_high=RE_HIGH, im_high=IM_HIGH, also=(("method", POLES),), landscape=error),
    )


def _stage(run: Run, study: Study) -> Stage:
    return Stage(MODEL.body, run.t, run.x, run.xhat, run.u_applied, 3 * STAGE * np.sqrt(np.maximum(study.grown[:, 0, 0], 0.0)))


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
    ratio, share = np.sqrt(m["variance_ratio"]), 100 * m["sensor_share"]
    name = Text("velocity", "速度") if design["watch"] == VELOCITY else Text("position", "位置")
    if ratio < 1.005:
        return Text(f"The {name.en} error is as small as any observer can make it: {share:.0f} % of its variance is sensor noise.",
                    f"{name.zh}误差已小到任何观测器所能达到的极限：方差的 {share:.0f} % 来自测量噪声。")
    return Text(f"The {name.en} error is {ratio:.3g} times the least possible; {share:.0f} % of its variance is sensor noise.",
                f"{name.zh}误差是最小可能值的 {ratio:.3g} 倍；方差的 {share:.0f} % 来自测量噪声。")


# --- Monte-Carlo -----------------------------------------------------------------------------------------------------
def try_often(outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
    """The job: many runs of the design on fresh noise, each error taken about its noise-free course."""
    scenario, study = scenario_of(outcome.design, outcome.gains["L"]), outcome.study
    seeds = np.random.SeedSequence(int(outcome.design["seed"])).generate_state(RUNS)
    total = np.zeros_like(study.quiet)
    for k, seed in enumerate(seeds, start=1):
        total += (simulate(replace(scenario, seed=int(seed))).e - study.quiet) ** 2
        if k % AT_ONCE == 0:
            outcome = _with(outcome, Trials(k, total / k))
            yield k / RUNS, outcome


def _with(outcome: Outcome, trials: Trials) -> Outcome:
    tail = trials.square[-1] / np.diagonal(outcome.study.grown[-1])
    metrics = {**outcome.metrics, "trials": float(trials.count), "trial_ratio_position": float(tail[0]),
               "trial_ratio_velocity": float(tail[1])}
    return replace(outcome, study=replace(outcome.study, trials=trials), metrics=metrics)


def carry(before: Outcome, after: Outcome) -> Outcome:
    """The runs go over where only the error that is looked at has changed."""
    old, new = before.study.trials, after.study.trials
    if old is None or not before.design.same_but_for(after.design, ("watch",)) or (new is not None and new.count >= old.count):
        return after
    return _with(after, old)


def adapt(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant."""
    from .own import adapted

    return adapted(lesson, model)


LESSON = Lesson(
    "noise", 8, KNOBS, compute, all_figures, answer=2, tasks=TASKS, exam=exam,
    source="Observer notes (001) on fast poles; platform report (003), section 4.1, equations (43)–(50)",
    words=read_prose(Path(__file__).parent),
    job=Job(Text(f"Try {RUNS} runs", f"试验 {RUNS} 次"), try_often), carry=carry, adapt=adapt)

__all__ = ["LESSON"]
