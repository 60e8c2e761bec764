"""Lines of the report in doubt, and what the filter at hand says about each."""

from __future__ import annotations

import numpy as np

from app.lesson.figures import TableFigure
from app.lesson.lesson import Outcome
from app.text.words import Text, same

NONE, GAIN, JOSEPH, SHORT, NEAR_R, MEANS = "none", "gain", "joseph", "short", "near-r", "means"
SLIPS = (SHORT, NEAR_R, MEANS)
PRINTED_MEAN, PRINTED_SIGMA, PRINTED_SAMPLES = 5.46e-10, 1e-9, 20_000  # (61), (77), 20 s at 1 kHz as assumed here

LINES = (
    (NONE, Text("none", "无")),
    (GAIN, Text("(57): gain with S inverted", "(57)：增益用 S 的逆")),
    (JOSEPH, Text("(59): covariance update", "(59)：协方差更新")),
    (SHORT, Text("Algorithm 1, line 11", "算法 1 第 11 行")),
    (NEAR_R, Text("innovation covariance close to R", "新息协方差接近 R")),
    (MEANS, Text("(61): means close to zero", "(61)：均值接近 0")),
)


def report_figure(outcome: Outcome) -> TableFigure:
    """The lines one by one; the chosen one with its evidence."""
    m, chosen = outcome.metrics, outcome.design["line"]
    sigmas = PRINTED_MEAN / (PRINTED_SIGMA / np.sqrt(PRINTED_SAMPLES))
    evidence = {
        GAIN: Text("holds: S = C P Cᵀ + R", "成立：S = C P Cᵀ + R"),
        JOSEPH: Text("holds: right for every gain", "成立：对任何增益都正确"),
        SHORT: Text(f"slip: not (59); off by up to {m['short_gap']:.1e} here, Joseph {m['joseph_gap']:.1e}",
                    f"笔误：与 (59) 不符；此处最多偏差 {m['short_gap']:.1e}，Joseph 为 {m['joseph_gap']:.1e}"),
        NEAR_R: Text(f"slip: it is S; S/R = {m['S_over_R']:.2f}, seen {m['seen_over_R']:.2f}; with σ_v = 1e-9 at 1 kHz, 8 million",
                     f"笔误：应为 S；S/R = {m['S_over_R']:.2f}，实测 {m['seen_over_R']:.2f}；按其 σ_v = 1e-9、1 kHz 则为八百万"),
        MEANS: Text(f"slip: {sigmas:.0f} σ of the mean (σ_v = 1e-9, 20 000 samples); HL and HR of one sign, though HR = −HL",
                    f"笔误：为均值标准差的 {sigmas:.0f} 倍（σ_v = 1e-9，20 000 个采样）；HR = −HL，二者均值却同号"),
    }
    printed = {
        GAIN: same("K = P Hᵀ S⁻¹"), JOSEPH: same("(I−KH) P (I−KH)ᵀ + K R Kᵀ"), SHORT: same("P = (I − K C) P"),
        NEAR_R: same("cov ν ≈ R"), MEANS: same("5.46e-10 ≈ 0"),
    }
    rows = tuple((label, printed[key], evidence[key] if key == chosen else same("—")) for key, label in LINES if key != NONE)
    said = (Text("Choose a line with the last knob.", "用最后一个旋钮选择一行。") if chosen == NONE else
            Text("This line is a slip.", "这一行有误。") if chosen in SLIPS else Text("This line holds.", "这一行成立。"))
    return TableFigure("report", Text("lines of the report", "报告中的若干行"),
                       (Text("line", "行"), Text("printed", "所印"), Text("this filter says", "本滤波器的检验")), rows, said,
                       Text("Report", "报告"))
