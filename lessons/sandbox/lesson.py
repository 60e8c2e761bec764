"""Sandbox: your own plant, and everything that lessons 1 to 10 ask of theirs; what cannot be asked says why."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Literal, cast

import numpy as np

from app.engine import Scenario, closed_loop, loop_margins, recover, simulate
from app.engine.design import typical_rate
from app.engine.feedback import ClosedLoop, state_feedback_margins
from app.engine.simulation import separation_meter
from app.lesson.figures import Figure
from app.lesson.knobs import Choice, Knob, KnobError, Number, Switch
from app.lesson.lesson import Check, Design, Formula, Job, Lesson, Outcome, Task
from app.lesson.prose import read_prose
from app.plants import Model
from app.plants.examples import example
from app.plants.own import own_model, plant_of
from app.text.words import Text

from ..toolkit.boards import pole_boards, stage
from ..toolkit.gains import gains
from ..toolkit.knobs import kicks, method_knobs, pole_knobs, run_knobs
from ..toolkit.latex import gain_words
from ..toolkit.tasks import fair
from . import pictures
from .analyses import (
    Margins,
    Noise,
    Refusal,
    Structure,
    Trial,
    attempt,
    certificates,
    margins,
    noise,
    noises,
    structure,
    trial,
)
from .tasks import below_the_tolerance, exam, through_the_limit, wrong_belief
from .verdicts import verdicts

STEPS = np.logspace(-3, 3, 9)  # of the recovery knob q, in natural units
POINTS = 140  # of the sensitivity over frequency
COMMANDED, APPLIED = "commanded", "applied"
SAMPLED = Text("Recovery is for continuous plants: a sampled loop keeps the delay of a step.",
               "回路传递恢复只适用于连续对象：采样回路总有一步的时延。")


@dataclass(frozen=True, eq=False)
class Study:
    """All that was asked; each answer or the sentence why there is none. `steps` of recovery: (q, α, α with x known)."""

    structure: Structure
    loop: ClosedLoop
    certificates: tuple[tuple[Text, float], ...] | Refusal
    noise: Noise | Refusal
    trial: Trial | Refusal
    margins: Margins | Refusal
    meter: float
    steps: tuple[tuple[float, float, float], ...] = ()
    recovered: np.ndarray | None = None
    refused: Text | None = None


def knobs(model: Model) -> tuple[Knob, ...]:
    """Gains, limit, noise and tolerance, in the plant's own measures."""
    return (
        *method_knobs(),
        *pole_knobs(model),
        Switch("limited", "", Text("limit the inputs", "输入限幅"),
               hint=Text("Clip every input at the limit below.", "每个输入都按下面的限幅截断。")),
        Number("u_max", r"u_{\max}", Text("limit", "限幅"), model.input_unit, low=0.02 * model.u_max, high=20 * model.u_max,
               default=model.u_max, scale="log", when=("limited", (True,)),
               hint=Text("The largest input that is given, either way.", "两个方向上所能给出的最大输入。")),
        Choice("fed", "", Text("the observer is told", "送给观测器的是"), default=COMMANDED,
               options=((COMMANDED, Text("the commanded input", "指令输入")), (APPLIED, Text("the applied input", "实际输入"))),
               when=("limited", (True,)),
               hint=Text("What the controller asked for, or what was really given.", "控制器所要的，或实际给出的。")),
        Switch("noisy", "", Text("noise in the run", "运行中加入噪声"), hint=Text("Draw both noises in the run that is shown.",
                                                                        "在所示的运行中加入过程噪声和测量噪声。")),
        Number("sensor", r"\sigma", Text("sensor noise, share of the outputs", "测量噪声（占初始输出的比例）"), low=1e-3,
               high=1.0, default=0.01, scale="log",
               hint=Text("Beside a process noise of a tenth of the natural input.", "过程噪声固定为自然输入的十分之一。")),
        Number("belief", r"b", Text("believed / true process noise", "过程噪声：设定值 / 真值"),
               low=1e-3, high=1e3, default=1.0, scale="log",
               hint=Text("What the Kalman filter of the tab Noise believes; below 1 it trusts its model too much.",
                         "“噪声”标签页中卡尔曼滤波器的设定值；小于 1 时过于相信模型。")),
        Number("tolerance", r"\tau", Text("tolerance of the rank", "秩的容差"), low=1e-16, high=1.0, default=1e-12, scale="log",
               hint=Text("Singular values at or below τ times the largest count as zero.", "奇异值不超过最大值的 τ 倍者按零计。")),
        *run_knobs(model.horizon),
    )


def compute(model: Model, design: Design) -> Outcome:
    """Gains and one run, which every plant has, and each analysis for itself."""
    plant, seed = model.plant, int(design["seed"])
    K, L = gains(design, plant, model)
    loop = closed_loop(plant, K, L)
    G, W, V = noises(model, design["sensor"])
    limit, noisy = (design["u_max"] if design["limited"] else None), design["noisy"]
    run = simulate(Scenario(
        plant, K, L, x0=model.x0, xhat0=model.guess, horizon=model.horizon, dt=model.dt, u_min=None if limit is None else -limit,
        u_max=limit, fed=cast(Literal["applied", "commanded"], design["fed"]), impulses=kicks(design, model), seed=seed,
        W=W if noisy else None, V=V if noisy else None, G=G if noisy else None))
    study = Study(
        structure(plant), loop, attempt(lambda: certificates(plant, loop, K, L)), attempt(lambda: noise(model, L, design["sensor"])),
        attempt(lambda: trial(model, design["sensor"], design["belief"], seed)), attempt(lambda: margins(plant, K, L, False)),
        separation_meter(run), refused=SAMPLED if plant.dt else None)
    clipped = float(np.mean(np.any(np.abs(run.u_asked) > (limit or np.inf) * (1 + 1e-9), axis=1)))
    metrics = {"separation_meter": study.meter, "clipped_share": clipped, "union_error": loop.union_error,
               "slowest_loop": _slowest(loop.poles, plant.dt), "largest_input": float(np.abs(run.u_asked).max())}
    if not isinstance(study.margins, Refusal):
        metrics["disk_margin"] = study.margins.together
    if not isinstance(study.trial, Refusal):
        metrics["nis_mean"], metrics["nis_expected"] = study.trial.test.mean, study.trial.expected
    rows = verdicts(study.structure, loop, study.meter, limit is not None, study.noise, study.trial, study.margins)
    checks = tuple(Check(f"row{i}", Text(f"{name.en}: {said.en}", f"{name.zh}：{said.zh}"), holds)
                   for i, (name, holds, said) in enumerate(rows) if holds is not None)
    return Outcome(
        design, {"K": K, "L": L},
        {"controller": loop.controller_poles, "observer": loop.observer_poles, "loop": loop.poles, "compensator": loop.compensator_poles,
         "plant": plant.poles},
        metrics, checks, run, pole_boards(model, design, loop.controller_poles, loop.observer_poles, plant.A - L @ plant.C),
        stage(model, run), (Formula("K", gain_words("K", K)), Formula("L", gain_words(r"L^{\mathsf T}", L.T))),
        _live(rows), study)


def _slowest(poles: np.ndarray, dt: float) -> float:
    return float(np.abs(poles).max() - 1) if dt else float(np.real(poles).max())


def _live(rows: tuple[tuple[Text, bool | None, Text], ...]) -> Text:
    no = [name for name, holds, _ in rows if holds is False]
    if not no:
        return Text("No analysis that applies here says no.", "凡适用的分析，结论都是“是”。")
    return Text(f"Answered with no: {', '.join(n.en for n in no)}.", f"结论为“否”：{'、'.join(n.zh for n in no)}。")


def figures(model: Model, outcome: Outcome) -> tuple[Figure, ...]:
    """Verdicts; structure; the run; loop; noise; robustness."""
    study, run, design, plant = outcome.study, outcome.run, outcome.design, model.plant
    assert run is not None
    limit = design["u_max"] if design["limited"] else None
    rows = verdicts(study.structure, study.loop, study.meter, limit is not None, study.noise, study.trial, study.margins)
    return (
        pictures.lights(rows), pictures.modes_table(study.structure),
        *pictures.time_figures(model, run, limit),
        pictures.sizes_plane(study.structure, design["tolerance"]), pictures.decomposition_map(study.structure, plant.n),
        pictures.hankel_plane(study.structure),
        pictures.spectrum(study.loop, plant.dt), pictures.blocks(study.loop, plant),
        pictures.certificate_table(study.certificates),
        pictures.valley(study.noise, design["belief"]), pictures.nis_figure(study.trial, plant.p), pictures.gain_figure(study.trial),
        pictures.sensitivity_figure(study.margins, study.recovered, _frequencies(plant_rate=typical_rate(plant), dt=plant.dt)),
        pictures.margin_table(study.margins, plant), pictures.recovery_plane(study.steps, len(STEPS), study.refused))


@lru_cache(maxsize=64)
def _frequencies(plant_rate: float, dt: float) -> np.ndarray:
    """Hz, two decades around the plant's own pace, below half the sampling rate."""
    middle = plant_rate / (2 * np.pi)
    high = min(100 * middle, 0.499 / dt) if dt else 100 * middle
    return np.geomspace(min(middle / 100, high / 100), high, POINTS)


# --- recovery ----------------------------------------------------------------------------------------------------------
def try_recovery(model: Model, outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
    """The job: the loop recovered step by step towards what state feedback has, from the design's own K."""
    plant, K, design = model.plant, outcome.gains["K"], outcome.design
    if plant.dt:
        raise KnobError(SAMPLED)
    aim = state_feedback_margins(plant, K)
    if not aim.stable:
        raise KnobError(Text("A − BK is not stable, so there is nothing to recover; move a controller pole.",
                             "A − BK 不稳定，无从恢复；请移动控制器极点。"))
    G, W, V = noises(model, design["sensor"])
    size = np.sqrt(float(np.trace(G @ W @ G.T)) / max(float(np.trace(plant.B @ plant.B.T)), 1e-300))
    target = aim.input_disk.alpha
    if isinstance(outcome.study.margins, Refusal):
        outcome = replace(outcome, study=replace(outcome.study, margins=attempt(lambda: margins(plant, K, outcome.gains["L"], True))))
    grid, steps = _frequencies(plant_rate=typical_rate(plant), dt=plant.dt), ()
    for k, q in enumerate(STEPS, start=1):
        found = recover(plant, K, W, V, float(q) * size, G=G)
        built = loop_margins(plant, found.compensator)
        steps = (*steps, (float(q), float(built.input_disk.alpha), float(target)))
        outcome = replace(outcome, study=replace(outcome.study, steps=steps, recovered=pictures.largest(built.loop, grid)))
        yield k / len(STEPS), outcome


def carry(before: Outcome, after: Outcome) -> Outcome:
    """What was recovered goes over while K and the noise stay."""
    old, new = before.study, after.study
    alike = (np.array_equal(before.gains["K"], after.gains["K"]) and before.design["sensor"] == after.design["sensor"]
             and before.design.plant == after.design.plant)
    if not old.steps or not alike or len(new.steps) >= len(old.steps):
        return after
    return replace(after, study=replace(new, steps=old.steps, recovered=old.recovered))


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The sandbox for a person's plant, with the tasks that can be done on it."""
    return fair(replace(build(model), words=lesson.words))


def build(model: Model) -> Lesson:
    """The sandbox for a plant."""
    return Lesson(
        "sandbox", 19, knobs(model), partial(compute, model), partial(figures, model), answer=1,
        tasks=(
            Task("through-the-limit", through_the_limit, {"limited": True, "fed": APPLIED}),
            Task("wrong-belief", wrong_belief, {"belief": 0.003, "sensor": 0.003}),
            Task("below-the-tolerance", below_the_tolerance, {"tolerance": 0.9}),
        ),
        exam=exam, source="Lessons 1 to 10, with their sources; example plants in app/plants/data",
        words=read_prose(Path(__file__).parent), job=Job(Text("Recover the margins", "恢复裕度"), partial(try_recovery, model)),
        carry=carry, adapt=adapted, universal=True)


LESSON = build(own_model(plant_of(example("aircraft"))))

__all__ = ["LESSON", "build"]
