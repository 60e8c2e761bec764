"""Weak states: ranks that hang on the unit, Hankel values that do not, and the motion that the report cut away."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.lesson.knobs import Choice, Number
from app.lesson.lesson import Check, Design, Formula, Lesson, Outcome
from app.lesson.prose import read_prose
from app.plants.platform import Parameters
from app.text.words import Text

from ..toolkit.latex import number
from .body import NOMINAL, share, slower, swing
from .pictures import all_figures, sigmas
from .rank import MEASURES, RELATIVE, Ranks, ranks
from .regulator import OUTPUTS, PAIRS, PRESSED, Compared, compare
from .system import STATES, Cut, Motion, System, closed_forms, cut, system
from .tasks import TASKS, exam

GEOMETRY, RANK, MODEL, LQG = Text("Geometry", "几何"), Text("Rank", "秩"), Text("Model", "模型"), Text("LQG", "LQG")


def _size(name: str, symbol: str, label: Text, unit: str, low: float, high: float, hint: Text, step: float | None = None) -> Number:
    return Number(name, symbol, label, unit, low=low, high=high, default=getattr(NOMINAL, name),
                  scale="linear" if step else "log", step=step, group=GEOMETRY, hint=hint)


KNOBS = (
    Choice("pair", "", Text("pair on the stage", "场景中的一对"), default="1", group=MODEL,
           options=tuple((str(k + 1), Text(sigmas(k), sigmas(k))) for k in range(PAIRS)),
           hint=Text("Which motion is drawn, the strongest pair first.", "画出哪一种运动；从最强的一对开始。")),
    Number("order", "r", Text("states kept", "保留的状态数"), low=1, high=STATES, default=STATES, scale="integer", group=MODEL,
           hint=Text("Order of the balanced truncation. The ghost shows what that model can hold of the motion.",
                     "平衡截断的阶数。虚影是该模型所能容纳的运动。")),
    Number("clock", "T", Text("unit of time", "时间单位"), "s", low=1e-3, high=1.0, default=1.0, scale="log", group=RANK,
           hint=Text("Velocities and A are counted per this unit. The plant stays the same.", "速度与 A 按此单位计。对象不变。")),
    Number("tolerance", r"\tau", Text("tolerance", "容差"), low=1e-18, high=0.1, default=1e-9, scale="log", group=RANK,
           hint=Text("Singular values at or below it count as zero.", "不超过它的奇异值按零计。")),
    Choice("measure", "", Text("singular values", "奇异值"), default=RELATIVE, options=MEASURES, group=RANK,
           hint=Text("Measured against the largest, or taken as they are.", "以最大者为基准，或直接取其值。")),
    _size("s", "s", Text("sensors off the centre", "传感器离中心"), "m", 0.06, 0.18,
          Text("Half the distance of the two sensors.", "两传感器间距的一半。"), 0.002),
    _size("h", "h", Text("height of the centre of mass", "质心高度"), "m", 0.002, 0.06,
          Text("How far the centre of mass lies above the deck plane.", "质心高出台面的距离。"), 0.001),
    _size("a", "a", Text("springs off the centre", "弹簧离中心"), "m", 0.10, 0.21,
          Text("Half the distance of the two vertical springs.", "两竖直弹簧间距的一半。"), 0.002),
    _size("mu", r"\mu", Text("test mass", "测试质量"), "kg", 0.01, 0.5,
          Text("Mass inside each sensor.", "每个传感器内的质量。")),
    _size("kp", "k_p", Text("servo stiffness", "伺服刚度"), "N/m", 300.0, 20000.0,
          Text("Stiffness that holds each test mass.", "约束测试质量的伺服刚度。")),
    Number("v0", "V", Text("measurement noise", "测量噪声强度"), "m²/s", low=1e-12, high=1e-6, default=1e-9, scale="log", group=LQG,
           hint=Text("Intensity V of the noise on each velocity reading.", "每个速度读数的噪声强度 V。")),
    Choice("pressed", "", Text("the cost presses on", "代价所计的量"), default=OUTPUTS, options=PRESSED, group=LQG,
           hint=Text("The report's Q = α CᵀW_yC, or the same heavy weight on every balanced state.",
                     "报告的 Q = α CᵀW_yC，或对每个平衡状态取同样大的权重。")),
)


@dataclass(frozen=True, eq=False)
class Study:
    """All that a design leads to."""

    system: System
    ranks: Ranks
    cut: Cut
    compared: Compared


def compute(design: Design) -> Outcome:
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


LESSON = Lesson("weak-states", 12, KNOBS, compute, all_figures, answer=1, tasks=TASKS, exam=exam, kick=False,
                source="Platform report (003), chapter 3: rank, Hankel values (39), truncation, section 3.3",
                words=read_prose(Path(__file__).parent))

__all__ = ["LESSON"]
