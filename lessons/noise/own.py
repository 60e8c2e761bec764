"""The valley of observer speed on a person's own plant: belief in the process noise takes the place of speed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from app.lesson.knobs import Choice, Knob, Number, Poles
from app.lesson.lesson import Job, Lesson, Outcome
from app.plants import Model
from app.text.words import Text

from ..toolkit.knobs import run_knobs
from .job import RUNS
from .knobs import POLES
from .own_figures import figures
from .own_study import BELIEF, Study, compute, drawn, scenario_of, signals, watched_signal
from .study import Trials

AT_ONCE = 5


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """The lesson's knobs in the plant's own measures."""
    window, (one, two) = model.observer_window, signals(model)
    return (
        Choice("method", "", Text("observer by", "观测器由"), default=BELIEF,
               options=((BELIEF, Text("belief in the process noise", "对过程噪声的信念")), (POLES, Text("dragging poles", "拖动极点"))),
               hint=Text("A Kalman filter that believes b times the process noise, or poles of your own.",
                         "相信过程噪声为 b 倍的卡尔曼滤波器，或自己拖动极点。")),
        Number("belief", "b", Text("believed / true process noise", "过程噪声：信念 / 真值"), low=1e-3, high=1e3, default=100.0,
               scale="log",
               when=("method", (BELIEF,)), hint=Text("Above 1 the observer is too fast, below 1 too slow.",
                                                     "大于 1：观测器太快；小于 1：太慢。")),
        Poles("observer_poles", "q", Text("Observer poles", "观测器极点"), "rad/s", default=model.observer_poles, re_low=window.re_low,
              re_high=window.re_high, im_high=window.im_high, role="estimate", when=("method", (POLES,)),
              hidden=not model.observer_poles, hint=Text("eig(A − LC): farther left is faster.", "eig(A − LC)：越靠左越快。")),
        Number("w", r"\sigma_w", Text("process noise, share of the natural input", "过程噪声（占自然输入的比例）"), low=1e-3, high=10.0,
               default=0.1, scale="log", hint=Text("An unknown input, as strong as this share of the natural one.",
                                                   "未知输入的强度，以自然输入为单位。")),
        Number("v", r"\sigma_v", Text("sensor noise, share of the outputs", "测量噪声（占初始输出的比例）"), low=1e-4, high=1.0,
               default=0.01,
               scale="log", hint=Text("As a share of the outputs at the start.", "以初始输出为单位。")),
        Number("start", r"\epsilon", Text("error at the start", "初始误差"), low=0.0, high=2.0, default=0.3, step=0.05,
               hint=Text("1 is as wrong as the plant is off rest; the observer believes it at rest.",
                         "1 表示与对象偏离静止的程度相同；观测器以为静止。")),
        Choice("watch", "", Text("judge by the error in", "评判依据"), default="second",
               options=(("first", one.name), ("second", two.name)), hint=Text("Which error the curves show.", "曲线显示哪一个误差。")),
        *run_knobs(model.horizon),
    )


def try_often(model: Model, outcome: Outcome[Study]) -> Iterator[tuple[float, Trials]]:
    """The job: many runs on fresh noise, each error taken about its noise-free course."""
    scenario, study, row = (scenario_of(model, outcome.design, outcome.gains["L"]), outcome.study,
                            np.array(watched_signal(model, outcome.design).weights))
    total = np.zeros(len(study.grown))
    for k, seed in enumerate(np.random.SeedSequence(int(outcome.design["seed"])).generate_state(RUNS), start=1):
        e = drawn(replace(scenario, seed=int(seed))).e
        shared = min(len(e), len(total))
        total[:shared] += ((e[:shared] - study.quiet[:shared]) @ row) ** 2
        if k % AT_ONCE == 0:
            yield k / RUNS, Trials(k, (total / k)[:, None])


def shown(outcome: Outcome[Study], trials: Trials) -> Outcome[Study]:
    """The outcome with what the runs showed."""
    return replace(outcome, study=replace(outcome.study, trials=trials))


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, where a Kalman filter for it exists; the tasks stay with the block."""
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, model), figures=partial(figures, model), tasks=(),
                   job=Job(Text(f"Try {RUNS} runs", f"试验 {RUNS} 次"), partial(try_often, model), shown=shown))
