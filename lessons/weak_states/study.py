"""What a design leads to: ranks by tolerance and unit of time, the truncation, the motion on the stage, two regulators."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from app.engine import controllability, observability
from app.lesson.lesson import Check, Design, Formula, Outcome
from app.plants.platform import Parameters, in_time_units
from app.text.words import Text

from ..toolkit.latex import number
from .body import share, slower, swing
from .regulator import Compared, compare
from .system import STATES, Cut, Motion, System, closed_forms, cut, system

RELATIVE, ABSOLUTE = "relative", "absolute"
MEASURES = ((RELATIVE, Text("of the largest", "相对最大值")), (ABSOLUTE, Text("as they are", "绝对值")))
REPORT = (1e-12, 1e-6)  # tolerances that the report names


@dataclass(frozen=True, eq=False)
class Ranks:
    """Singular values (10,) of both matrices, time counted in units of `clock` seconds."""

    clock: float
    reached: np.ndarray
    seen: np.ndarray

    def at(self, tolerance: float, measure: str) -> tuple[int, int]:
        """Rank of both matrices: singular values above the tolerance, or above the tolerance times the largest."""
        return _count(self.reached, tolerance, measure), _count(self.seen, tolerance, measure)


@lru_cache(maxsize=64)
def ranks(s: System, clock: float) -> Ranks:
    """Singular values with time in units of `clock` seconds; metres, radians and newtons stay."""
    counted = in_time_units(s.plant, clock)
    return Ranks(clock, controllability(counted).singular_values, observability(counted).singular_values)


def _count(values: np.ndarray, tolerance: float, measure: str) -> int:
    return int(np.count_nonzero(values > tolerance * (values[0] if measure == RELATIVE else 1.0)))


@dataclass(frozen=True, eq=False)
class Study:
    """All that a design leads to."""

    system: System
    ranks: Ranks
    cut: Cut
    compared: Compared


def compute(design: Design) -> Outcome[Study]:
    """Ranks, Hankel values, the truncation with its error, the motion on the stage, LQG on ten states and on fewer."""
    s = system(Parameters(**{name: design[name] for name in ("s", "h", "a", "mu", "kp")}))
    order = int(design["order"])
    study = Study(s, ranks(s, design["clock"]), cut(s, order), compare(s, order, design["v0"], design["pressed"]))
    motion = s.motions[int(design["pair"]) - 1]
    metrics = _metrics(design, study, motion)
    return Outcome(design, {"K": study.compared.small.design.K, "L": study.compared.small.design.L},
                   {"plant": s.plant.poles, "model": study.cut.model.poles}, metrics, _checks(study, metrics),
                   stage=swing(s, motion, order), formulas=_formulas(study), live=_live(study, motion, metrics), study=study)


def _metrics(design: Design, study: Study, motion: Motion) -> dict[str, float]:
    s, c = study.system, study.compared
    reached, seen = study.ranks.at(design["tolerance"], design["measure"])
    found = {
        "rank_controllability": float(reached), "rank_observability": float(seen), "error": study.cut.peak,
        "error_at": study.cut.where, "bound": study.cut.bound, "held": share(s, motion, study.cut.order),
        "frequency": motion.frequency, "growth": c.growth, "gap": c.gap, "extra": c.extra,
        **{f"sigma{k + 1}": float(v) for k, v in enumerate(s.hankel)},
    }
    return {name: float(value) for name, value in found.items() if value is not None}


def _checks(study: Study, m: dict[str, float]) -> tuple[Check, ...]:
    c = study.compared
    return (
        Check("rank", Text("both matrices have rank 10 at this tolerance", "在此容差下两矩阵的秩都是 10"),
              m["rank_controllability"] == m["rank_observability"] == STATES, min(m["rank_controllability"], m["rank_observability"])),
        Check("bound", Text("the error keeps below 2Σσ", "误差不超过 2Σσ"), m["error"] <= m["bound"] * (1 + 1e-6) + 1e-8, m["error"]),
        Check("stable", Text("LQG on the cut model holds the platform", "基于截断模型的 LQG 使平台稳定"), c.small.stable,
              c.small.rightmost),
        Check("same", Text("both loops agree within 1 %", "两个闭环相差不到 1 %"), c.gap is not None and c.gap < 0.01,
              1.0 if c.gap is None else c.gap),
        Check("growth", Text("ten states ask for at most 5 % more gain", "十个状态所需增益最多大 5 %"), c.growth < 0.05, c.growth),
    )


def _formulas(study: Study) -> tuple[Formula, ...]:
    s, forms = study.system, closed_forms(study.system.parameters)
    bound = (rf"\|G-G_{{{study.cut.order}}}\|_\infty = {number(study.cut.peak)} \le 2\sum_{{i>{study.cut.order}}}\sigma_i = "
             rf"{number(study.cut.bound)}") if study.cut.order < STATES else r"G_{10} = G"
    return (
        Formula("hankel", r"\sigma_i = \sqrt{\lambda_i(W_c W_o)}"),
        Formula("bound", bound),
        Formula("sigma7", rf"\sigma_7 \approx \frac{{2\sqrt2\, k_z\mu^2}}{{m^2 c_p}} = {number(forms[1][1])}, \quad \sigma_7 = "
                          rf"{number(float(s.hankel[6]))}"),
        Formula("sigma9", rf"\sigma_9 \approx \frac{{\sqrt2\, k_x h \mu^2 s^2\sqrt{{s^2+h^2}}}}{{J^2 c_p}} = {number(forms[2][1])}, "
                          rf"\quad \sigma_9 = {number(float(s.hankel[8]))}"),
    )


def _live(study: Study, motion: Motion, m: dict[str, float]) -> Text:
    order = study.cut.order
    ghost = (Text("the ghost moves with it", "虚影随之运动") if m["held"] > 0.9 else
             Text("the ghost stands still", "虚影静止不动") if m["held"] < 0.1 else
             Text("the ghost moves in part", "虚影部分随动"))
    factor = slower(motion)
    shown = Text(f"On the stage: {motion.name.en}, {motion.frequency:.3g} Hz, drawn {factor:.2g} times slower; ",
                 f"场景中：{motion.name.zh}，{motion.frequency:.3g} Hz，放慢 {factor:.2g} 倍；")
    if order == STATES:
        return Text(f"{shown.en}all ten states are kept.", f"{shown.zh}十个状态全部保留。")
    return Text(f"{shown.en}{ghost.en}: {order} of 10 states are kept, error {m['error']:.3g}.",
                f"{shown.zh}{ghost.zh}：保留 {order}/10 个状态，误差 {m['error']:.3g}。")
