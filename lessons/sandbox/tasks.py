"""Tasks of the sandbox, for any plant on which they can be done, and its exam item."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .analyses import Refusal
from .knobs import APPLIED
from .study import Study

EXACT = 1e-8
FOUND_OUT = 1.5  # times the expected NIS
LEAST = 0.05  # share of the run that the inputs must be clipped


def _through_the_limit(outcome: Outcome[Study]) -> Verdict:
    """Inputs clipped, and the error lives by itself all the same."""
    share, meter = outcome.metrics["clipped_share"], outcome.metrics["separation_meter"]
    if share < LEAST:
        return Verdict(False, Text(f"An input is clipped for {100 * share:.0f} % of the run; at least {100 * LEAST:.0f} % is wanted.",
                                   f"输入被截断的时间占 {100 * share:.0f} %；要求至少 {100 * LEAST:.0f} %。"))
    if meter > EXACT:
        return Verdict(False, Text(f"Clipped for {100 * share:.0f} % of the run, but the separation meter reads {meter:.2g}.",
                                   f"截断时间占 {100 * share:.0f} %，但分离度量为 {meter:.2g}。"))
    return Verdict(True, Text(f"Clipped for {100 * share:.0f} % of the run, and the meter reads 0.",
                              f"截断时间占 {100 * share:.0f} %，分离度量为 0。"))


def _wrong_belief(outcome: Outcome[Study]) -> Verdict:
    """A filter that its own NIS convicts of overconfidence."""
    trial = outcome.study.trial
    if isinstance(trial, Refusal):
        return Verdict(False, trial.text)
    p = trial.test.dof
    said = Text(f"On average NIS is {trial.expected:.3g} with {p} expected", f"NIS 平均为 {trial.expected:.3g}，应为 {p}")
    if outcome.design["belief"] > 0.1 or trial.expected < FOUND_OUT * p:
        return Verdict(False, Text(f"{said.en}; the filter must believe a tenth of the noise or less, and NIS reach 1.5 times that.",
                                   f"{said.zh}；过程噪声设定值应不超过真值的十分之一，且 NIS 达到应有值的 1.5 倍。"))
    return Verdict(True, Text(f"{said.en}: the innovations give it away.", f"{said.zh}：新息使它露了馅。"))


def _below_the_tolerance(outcome: Outcome[Study]) -> Verdict:
    """A rank that drops although no mode is hidden."""
    seen = outcome.study.structure.seen
    if isinstance(seen, Refusal):
        return Verdict(False, seen.text)
    n = len(seen.modes)
    rank = seen.matrix_rank(outcome.design["tolerance"])
    if not seen.observable:
        return Verdict(False, Text("A mode of this plant is hidden indeed.", "该对象确有隐藏的模态。"))
    if rank >= n:
        return Verdict(False, Text(f"rank(O) = {rank} of {n} at this tolerance; make it drop.",
                                   f"在此容差下 rank(O) = {rank}/{n}；请使它下降。"))
    return Verdict(True, Text(f"rank(O) = {rank} of {n} now, and not one mode is hidden: the tolerance decided, not the plant.",
                              f"现在 rank(O) = {rank}/{n}，而没有一个模态是隐藏的：作出判断的是容差，不是对象。"))


def exam(seed: int) -> ExamItem:
    """A = [a 1; 0 b], C = [1 c]: the mode at b has the direction (1, b − a) and is hidden where 1 + c (b − a) = 0."""
    rng = np.random.default_rng(seed)
    a, b = (int(v) for v in rng.choice(np.arange(-9, 0), 2, replace=False))
    return ExamItem({"a": str(a), "b": str(b)}, 1.0 / (a - b), 0.0051)  # two decimals


TASKS = (
    Task("through-the-limit", _through_the_limit, {"limited": True, "fed": APPLIED}),
    Task("wrong-belief", _wrong_belief, {"belief": 0.003, "sensor": 0.003}),
    Task("below-the-tolerance", _below_the_tolerance, {"tolerance": 0.9}),
)
