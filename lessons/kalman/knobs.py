"""Kalman: the deck and its clock, what a person may believe of it, and which line of the report to doubt."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number
from app.plants import MODELS
from app.text.words import Text

from ..toolkit.knobs import run_knobs

MODEL = MODELS["deck"]
DT, COUNT = 0.04, 301  # s and samples: 12 s
HORIZON = DT * (COUNT - 1)
WHITE, COLOURED, CARRIED = "white", "coloured", "carried"
NONE, GAIN, JOSEPH, SHORT, NEAR_R, MEANS = "none", "gain", "joseph", "short", "near-r", "means"
SLIPS = (SHORT, NEAR_R, MEANS)
LINES = (
    (NONE, Text("none", "无")),
    (GAIN, Text("(57): gain with S inverted", "(57)：增益用 S 的逆")),
    (JOSEPH, Text("(59): covariance update", "(59)：协方差更新")),
    (SHORT, Text("Algorithm 1, line 11", "算法 1 第 11 行")),
    (NEAR_R, Text("innovation covariance close to R", "新息协方差接近 R")),
    (MEANS, Text("(61): means close to zero", "(61)：均值接近 0")),
)
PREDICT, UPDATE = "predict", "update"
SINGLE, FROZEN = "single", "frozen"
LAST = 60  # the latest sample that can be looked at step by step


def _belief(name: str, symbol: str, label: Text, default: float, high: float, hint: Text) -> Number:
    return Number(name, symbol, label, low=0.01, high=high, default=default, scale="log", hint=hint)


KNOBS = (
    Choice("noise", "", Text("sensor noise", "测量噪声"), default=WHITE,
           options=((WHITE, Text("white", "白噪声")), (COLOURED, Text("converter, taken for white", "ADC 噪声，当作白噪声")),
                    (CARRIED, Text("converter, carried as states", "ADC 噪声，作为状态估计"))),
           hint=Text("White, or the 1/f noise of a converter, and what the filter makes of it.",
                     "白噪声，或 ADC 的 1/f 噪声；以及滤波器如何看待它。")),
    _belief("q", "q", Text("believed Q / true Q", "Q 的设定值 / 真值"), 0.05, 100.0,
            Text("Below 1 the filter trusts its model too much.", "小于 1：滤波器过于相信模型。")),
    _belief("r", "r", Text("believed R / true R", "R 的设定值 / 真值"), 1.73, 100.0,
            Text("Below 1 the filter trusts its sensors too much.", "小于 1：滤波器过于相信传感器。")),
    _belief("p0", "p_0", Text("believed / true P(0)", "P(0) 的设定值 / 真值"), 1.0, 1e4,
            Text("How unsure the filter is before the first sample.", "第一次采样之前滤波器有多不确定。")),
    Number("k", "k", Text("sample to look at", "查看第几个采样"), low=1, high=LAST, default=1, scale="integer",
           hint=Text("The tab One step shows this sample.", "“一步”标签页显示这一采样。")),
    Choice("phase", "", Text("the step", "步骤"), default=PREDICT,
           options=((PREDICT, Text("predict", "预测")), (UPDATE, Text("predict and update", "预测并更新"))),
           hint=Text("Before or after the sample is taken in.", "采样纳入之前或之后。")),
    Number("force", "F", Text("known force at 0.16 Hz", "0.16 Hz 的已知力"), "N", low=0.0, high=2.0, default=1.0, step=0.1,
           hint=Text("Amplitude on the vertical coils, half of it on the horizontal one; the filter is told.",
                     "两个竖直线圈的幅值，水平线圈减半；滤波器知道这个力。")),
    Choice("arithmetic", "", Text("updates compared", "更新公式的比较"), default=SINGLE,
           options=((SINGLE, Text("in single precision", "单精度")), (FROZEN, Text("with the final gain all along", "始终用稳态增益"))),
           hint=Text("Joseph's form beside the short form, tab Gain.", "Joseph 形式与简短形式的比较，见“增益”标签页。")),
    Choice("line", "", Text("line of the report in doubt", "报告中可疑的一行"), default=NONE, options=LINES,
           hint=Text("The tab Report shows what this filter says about it.", "“报告”标签页显示本滤波器对这一行的检验。")),
    *run_knobs(HORIZON),
)
