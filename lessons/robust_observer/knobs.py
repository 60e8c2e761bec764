"""The knobs of the robust observer: its poles, how wrong the model is, what J and RLO are told, the slips to find."""

from __future__ import annotations

from types import MappingProxyType

from app.engine.observers import Norm
from app.lesson.knobs import Choice, Number, Poles, Switch
from app.text.words import Text, same

ONE, TWO = "1", "2"
NORMS: MappingProxyType[str, Norm] = MappingProxyType({"1": 1, "2": 2, "inf": "inf"})
REMARKS = MappingProxyType({
    "printed": "(F, ΛF, ΛL, ΛNΛ⁻¹, M)",
    "left": "(F, ΛT, ΛL, NΛ⁻¹, M)",
    "forward": "(ΛFΛ⁻¹, ΛT, ΛL, NΛ, M)",
    "similar": "(ΛFΛ⁻¹, ΛT, ΛL, NΛ⁻¹, M)",
})
LINES = MappingProxyType({"TA": "TΔA", "LC": "LΔC", "MC": "MΔC", "N": "N"})
COLUMNS = MappingProxyType({"np": "n + p − r*", "nm": "n + m − r*", "mp": "m + p − r*"})
RE_LOW, RE_HIGH, IM_HIGH = -12.0, 1.0, 6.0  # of the observer's board
SLIPS = Text("Find the slips", "找出印刷错误")
ERRORS = Text("The plant is not the model", "对象与模型不符")
SEARCH = Text("Criterion and region", "指标与区域")


def _delta(name: str, symbol: str, example: str, en: str, zh: str, high: float, default: float) -> Number:
    return Number(name, symbol, Text(en, zh), low=-high, high=high, default=default, step=high / 50, group=ERRORS,
                  when=("example", (example,)),
                  hint=Text("How far the true plant is from the model the observer was designed for; 0: no error.",
                            "真实对象与设计观测器所用模型的偏差；0 表示没有偏差。"))


def _weight(name: str, symbol: str, what: str) -> Number:
    return Number(name, symbol, Text(f"weight of {what}", f"{what} 的权重"), low=0.0, high=3.0, default=1.0, step=0.1,
                  group=SEARCH, hint=Text(f"How much {what} counts in J; all ones in the paper.",
                                          f"{what} 在 J 中的分量；论文中都取 1。"))


def weight_knobs() -> tuple[Number, ...]:
    """The weights of the three sums in J."""
    return _weight("alpha", r"\alpha", "‖TAᵢ‖"), _weight("beta", r"\beta", "‖LCᵢ‖"), _weight("gamma", r"\gamma", "‖MCᵢ‖")


KNOBS = (
    Choice("example", "", Text("example", "算例"), default=ONE,
           options=((ONE, Text("Example 1: two states", "例 1：两个状态")), (TWO, Text("Example 2: three states", "例 2：三个状态"))),
           hint=Text("The two plants of the paper, each with its gain K.", "论文中的两个对象，各带一个反馈增益 K。")),
    Poles("pole", "s", Text("Observer pole", "观测器极点"), "rad/s", default=(-5 + 0j,), re_low=RE_LOW, re_high=RE_HIGH,
          im_high=IM_HIGH, role="estimate", when=("example", (ONE,)),
          hint=Text("Drag s along its axis and watch J.", "沿实轴拖动 s，观察 J。")),
    Poles("pair", r"s_1, s_2", Text("Observer poles", "观测器极点"), "rad/s", default=(-4 + 0j, -2.5 + 0j), re_low=RE_LOW,
          re_high=RE_HIGH, im_high=IM_HIGH, role="estimate", when=("example", (TWO,)),
          hint=Text("Drag s₁ and s₂; they must differ, and may be a pair.", "拖动 s₁ 与 s₂；二者不能相等，也可成共轭对。")),
    _delta("a1", r"\delta_a^1", ONE, "δ of a₂₁", "a₂₁ 的摄动 δ", 0.5, 0.1),
    _delta("a2", r"\delta_a^2", ONE, "δ of a₂₂", "a₂₂ 的摄动 δ", 0.5, -0.4),
    _delta("c", r"\delta_c", ONE, "δ of the sensor", "传感器的摄动 δ", 0.1, 0.05),
    _delta("b1", r"\delta_a^1", TWO, "δ of a₁", "a₁ 的摄动 δ", 0.5, 0.01),
    _delta("b2", r"\delta_a^2", TWO, "δ of a₂", "a₂ 的摄动 δ", 0.5, 0.05),
    _delta("d", r"\delta_c", TWO, "δ of the sensor", "传感器的摄动 δ", 0.1, 0.03),
    Number("w12", r"w_{12}", Text("coordinates W = [1 w; 0 1]", "坐标 W = [1 w; 0 1]"), low=-2.0, high=2.0, default=1.2,
           step=0.1, when=("example", (TWO,)),
           hint=Text("The observer's coordinates: F = W diag(s₁, s₂) W⁻¹.", "观测器的坐标：F = W diag(s₁, s₂) W⁻¹。")),
    Switch("carried", "", Text("carry z(0) along with W", "z(0) 随 W 变换"), when=("example", (TWO,)),
           hint=Text("On: z(0) becomes W z(0). Off: the same numbers whatever W is, as in the paper.",
                     "打开：z(0) 换成 W z(0)。关闭：不论 W 取什么都用同样的数，如论文所做。")),
    Choice("norm", "", Text("norm in J", "J 中的范数"), default="2", group=SEARCH, when=("example", (TWO,)),
           options=tuple((name, same("∞" if name == "inf" else name)) for name in NORMS),
           hint=Text("Column sum, spectral or row sum norm; in Example 1 all three agree.",
                     "列和范数、谱范数或行和范数；在例 1 中三者相同。")),
    *weight_knobs(),
    Number("region_low", "a", Text("region for RLO, left end", "RLO 区域左端"), "rad/s", low=-12.0, high=-4.0, default=-10.0,
           step=0.5, group=SEARCH, hint=Text("RLO keeps every pole right of this.", "RLO 使所有极点都在此线右侧。")),
    Number("region_high", "b", Text("region for RLO, right end", "RLO 区域右端"), "rad/s", low=-3.5, high=-0.2, default=-0.5,
           step=0.1, group=SEARCH, hint=Text("RLO keeps every pole left of this.", "RLO 使所有极点都在此线左侧。")),
    Choice("remark", "", Text("remark 3 should read", "注 3 应为"), default="printed", group=SLIPS, when=("example", (TWO,)),
           options=tuple((name, same(words)) for name, words in REMARKS.items()),
           hint=Text("Five matrices that are to meet the observer conditions again; Λ is any regular matrix.",
                     "变换后应仍满足观测器条件的五个矩阵；Λ 为任意可逆矩阵。")),
    Choice("line", "", Text("line of example 2 with a wrong size", "例 2 中尺寸有误的一行"), default="TA", group=SLIPS,
           when=("example", (TWO,)), options=tuple((name, same(words)) for name, words in LINES.items()),
           hint=Text("The table sets the printed size beside the size of the product.", "表中列出印刷尺寸与实际乘积的尺寸。")),
    Choice("columns", "", Text("columns of the free M′", "自由参数阵 M′ 的列数"), default="np", group=SLIPS,
           when=("example", (TWO,)), options=tuple((name, same(words)) for name, words in COLUMNS.items()),
           hint=Text("In the paper's letters: n states, m outputs, p observer states, r* the rank of [T; C].",
                     "用论文的记号：n 个状态、m 个输出、p 个观测器状态，r* 为 [T; C] 的秩。")),
)
