"""Tasks: rare false alarms, a coil that half works, a fault that nothing shows, the loop that limps on; and the exam."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .bank import DT, PLACES
from .diagnosis import MEAN
from .runs import OPEN, SWITCH
from .study import Study, hourly

HOURLY, SOONEST, CALM = 1.0, 3.0, 1.5  # alarms an hour, s, mrad
HALF, MOST = 0.5, 1.0  # share lost, N


def _rare(o: Outcome[Study]) -> Verdict:
    s: Study = o.study
    if s.case.place != "VL" or s.case.kind != "bias" or s.case.size > 3:
        return Verdict(False, Text("Let VL have a bias of at most 3 mm/s.", "请令 VL 有不超过 3 mm/s 的恒定偏差。"))
    often, delay = hourly(s), s.forecast.delay
    when = Text("never", "无法") if delay is None else Text(f"after {DT * delay:.2f} s", f"在 {DT * delay:.2f} s 后")
    said = Text(f"{often:.2g} false alarms an hour; all six see it with 99 % {when.en}",
                f"每小时 {often:.2g} 次误报；六个成员{when.zh}都以 99 % 概率察觉")
    solved = often <= HOURLY * (1 + 1e-9) and delay is not None and DT * delay <= SOONEST
    tail = (Text(": as wanted.", "：达到要求。") if solved else
            Text(f"; wanted: at most {HOURLY:.0f} an hour, within {SOONEST:.0f} s.",
                 f"；要求每小时至多 {HOURLY:.0f} 次，且不超过 {SOONEST:.0f} s。"))
    return Verdict(solved, Text(said.en + tail.en, said.zh + tail.zh))


def _weak(o: Outcome[Study]) -> Verdict:
    s: Study = o.study
    if s.case.place != "u1" or s.case.size > HALF or s.case.force > MOST:
        return Verdict(False, Text(f"Let u1 lose at most {100 * HALF:.0f} % and keep the known force at or below {MOST:.0f} N.",
                                   f"请令 u1 失效不超过 {100 * HALF:.0f} %，且已知力不超过 {MOST:.0f} N。"))
    delay = s.forecast.delay
    seen = PLACES.index("u1")
    worst = 100 * float(np.max(np.min(np.delete(s.forecast.strength, seen, axis=1), axis=1)))
    if delay is None:
        return Verdict(False, Text(f"The member that sees least gets {worst:.0f} % of what 99 % power takes.",
                                   f"最不敏感的成员只得到 99 % 检出所需的 {worst:.0f} %。"))
    return Verdict(True, Text(f"All six see it with 99 % after {DT * delay:.2f} s.", f"{DT * delay:.2f} s 后六个成员都以 99 % 概率察觉。"))


def _unseen(o: Outcome[Study]) -> Verdict:
    s: Study = o.study
    if s.case.coil is None or s.case.size < 1:
        return Verdict(False, Text("Let a coil lose everything.", "请令某个线圈完全失效。"))
    moved = float(np.abs(s.record.asked - s.record.applied).max())
    if moved > 0:
        return Verdict(False, Text(f"Up to {moved:.2g} N are missing, and every member but one can see that.",
                                   f"最多缺少 {moved:.2g} N，除一个成员外都能察觉。"))
    return Verdict(True, Text("Nothing was asked, so nothing is missing: the residuals are those of a healthy deck.",
                              "没有指令就没有缺失：残差与健康平台完全相同。"))


def _limp(o: Outcome[Study]) -> Verdict:
    s: Study = o.study
    if s.case.place != "VR" or s.case.kind != "drift" or s.case.size < 4 or s.case.start * DT > 4.01 or s.case.loop == OPEN:
        return Verdict(False, Text("Let VR drift by at least 4 mm/s² from 4 s or before, the loop closed.",
                                   "请闭合回路，令 VR 在 4 s 或更早以不小于 4 mm/s² 漂移。"))
    pitch = 1e3 * s.calm
    said = Text(f"Without noise the pitch reaches {pitch:.1f} mrad", f"无噪声时俯仰角最大 {pitch:.1f} mrad")
    if pitch > CALM:
        return Verdict(False, Text(f"{said.en}; at most {CALM:.1f} mrad are wanted.", f"{said.zh}；要求不超过 {CALM:.1f} mrad。"))
    return Verdict(True, Text(f"{said.en} and the deck goes on without VR.", f"{said.zh}，平台不用 VR 继续工作。"))


def exam(seed: int) -> ExamItem:
    """The zero of (A, E, C) for two states, the first one measured: s = d − b e₂/e₁."""
    rng = np.random.default_rng(seed)
    a, b, c, d = (int(v) for v in (rng.integers(-4, 0), rng.integers(1, 5), rng.integers(-4, 0), rng.integers(-6, 0)))
    e1, e2 = int(rng.integers(1, 5)), int(rng.integers(1, 6)) * int(rng.choice([-1, 1]))
    numbers = {"a": str(a), "b": str(b), "c": str(c), "d": str(d), "e1": str(e1), "e2": str(e2)}
    return ExamItem(numbers, d - b * e2 / e1, 0.01)


TASKS = (
    Task("rare", _rare, {"place": "VL", "statistic": MEAN, "window": 100.0, "rate": 2e-5}),
    Task("weak", _weak, {"place": "u1", "loss": 50.0, "loop": OPEN, "tone": 1.4}),
    Task("unseen", _unseen, {"place": "u1", "loss": 100.0, "loop": OPEN, "force": 0.0}),
    Task("limp", _limp, {"place": "VR", "kind": "drift", "drift": 4.0, "loop": SWITCH, "statistic": MEAN}),
)
