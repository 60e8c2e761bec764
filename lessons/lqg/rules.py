"""The report's rules for tuning, and what the loop at hand says about each."""

from __future__ import annotations

from collections import defaultdict

from app.lesson.figures import TableFigure
from app.lesson.lesson import Outcome
from app.text.words import Text, same

from ..toolkit.latex import tiny

NONE, SPLIT, SENSOR, PROCESS, CAUTION, UNITS = "none", "split", "beta-r", "beta-q", "caution", "sigma"
SLIPS = (SENSOR, UNITS)
RULES = (
    (NONE, Text("none", "无")),
    (SPLIT, Text("tune LQR first, then LQE", "先调 LQR，再调 LQE")),
    (SENSOR, Text("β_R ↑: noise is suppressed less", "β_R ↑：噪声抑制减弱")),
    (PROCESS, Text("β_Q ↑: faster, more sensitive to disturbance", "β_Q ↑：更快，对扰动更敏感")),
    (CAUTION, Text("LQG has no robustness of its own", "LQG 不具备内在鲁棒性")),
    (UNITS, Text("σ_v = 1e-9 gives V = 1e-9", "σ_v = 1e-9 对应 V = 1e-9")),
)


def rules_figure(outcome: Outcome) -> TableFigure:
    """The rules one by one; the chosen one with its evidence."""
    m, chosen = defaultdict(lambda: float("inf"), outcome.metrics), outcome.design["rule"]
    evidence = {
        SPLIT: lambda: Text(f"holds: the loop's poles are both sets, off by {tiny(m['union_error'])}",
                            f"成立：回路极点即两组极点之并，偏差 {tiny(m['union_error'])}"),
        SENSOR: lambda: Text(f"slip: input from sensor noise ×{m['sensor_less']:.3g} at β_R/10, ×{m['sensor_more']:.3g} at 10 β_R",
                             f"有误：测量噪声引起的输入在 β_R/10 时为 {m['sensor_less']:.3g} 倍，10 β_R 时为 {m['sensor_more']:.3g} 倍"),
        PROCESS: lambda: Text(f"holds: the filter's poles move left, their sum ×{m['process_more']:.3g} at 10 β_Q",
                              f"成立：滤波器极点左移，10 β_Q 时极点之和为 {m['process_more']:.3g} 倍"),
        CAUTION: lambda: Text(f"holds: nothing is promised; here min |1 + ℓ| = {m['nearest']:.3g}",
                              f"成立：没有任何保证；此处 min |1 + ℓ| = {m['nearest']:.3g}"),
        UNITS: lambda: Text("slip: R_v = σ_v² I gives 1e-18; the figures use 1e-9 and 1e-6",
                            "有误：由 R_v = σ_v² I 应为 1e-18；图中用的是 1e-9 与 1e-6"),
    }
    rows = tuple((label, evidence[key]() if key == chosen else same("—")) for key, label in RULES if key != NONE)
    said = (Text("Choose a line with the last knob.", "用最后一个旋钮选择一行。") if chosen == NONE else
            Text("This line is wrong.", "这一行有误。") if chosen in SLIPS else Text("This line holds.", "这一行成立。"))
    return TableFigure("rules", Text("lines of the report, section 5.2", "报告第 5.2 节的若干行"),
                       (Text("line", "行"), Text("this loop says", "本回路的检验")), rows, said, Text("Report", "报告"))
