"""The knobs of the lesson, for one case or for several, and the lines of the report in doubt."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number
from app.plants.names import called
from app.text.words import Text, same

from ..toolkit.knobs import run_knobs
from .cases import DOYLE, REPORT, Case

STEADY, RECURSIVE = "steady", "recursive"
NONE, SPLIT, SENSOR, PROCESS, CAUTION, UNITS = "none", "split", "beta-r", "beta-q", "caution", "sigma"
SLIPS = (SENSOR, UNITS)
RULES = (
    (NONE, Text("none", "无")),
    (SPLIT, Text("tune LQR first, then LQE", "先调 LQR，再调 LQE")),
    (SENSOR, Text("β_R ↑: sensor noise is suppressed less", "β_R ↑：测量噪声抑制减弱")),
    (PROCESS, Text("β_Q ↑: the filter is faster and follows disturbances more", "β_Q ↑：滤波器更快，更多地跟随扰动")),
    (CAUTION, Text("LQG has no robustness of its own", "LQG 不具备内在鲁棒性")),
    (UNITS, Text("σ_v = 1e-9 gives V = 1e-9", "σ_v = 1e-9 对应 V = 1e-9")),
)
When = tuple[str, tuple[str, ...]] | None


def knobs_for(cases: tuple[Case, ...]) -> tuple[Choice | Number, ...]:
    """The knobs for these cases; with one case alone there is no choice of it."""
    first, several = cases[0], len(cases) > 1
    report: When = ("case", tuple(c.id for c in cases if c.id != DOYLE)) if several else None
    paper: When = ("case", (DOYLE,)) if several else None
    pick = () if not several else (Choice(
        "case", "", Text("case", "情形"), default=first.id, options=tuple((c.id, c.label) for c in cases),
        hint=Text("The platform with the report's weights, or the counterexample of 1978.",
                  "采用报告权重的平台，或 1978 年的反例。")),)
    doyle = _of_paper(paper) if DOYLE in [c.id for c in cases] else ()
    return (*pick, *_of_report(first, report), *doyle, *_for_all(first, report),
            *run_knobs(min(c.horizon for c in cases)))


def _factor(name: str, symbol: str, label: Text, low: float, high: float, default: float, hint: Text, when: When) -> Number:
    return Number(name, symbol, label, low=low, high=high, default=default, scale="log", hint=hint, when=when)


def _of_report(case: Case, when: When) -> tuple[Number, ...]:
    """α_Q, α_R, β_Q, β_R and the true noise of the sensors; on the platform in the report's units and with its values."""
    named = case.id == REPORT
    aq, ar, br = (100.0, 0.1, 1e9) if named else (1.0, 1.0, 1.0)
    unit = Text(" in units of 10⁻¹⁸ (m/s)² s", "，单位 10⁻¹⁸ (m/s)² s") if named else same("")
    return (
        _factor("alpha_q", r"\alpha_Q", Text("state weight α_Q", "状态权重 α_Q"), 1e-2, 1e6, aq,
                Text("Q = α_Q Q₀: what motion costs. Only α_Q/α_R matters for K.",
                     "Q = α_Q Q₀：运动的代价。K 只取决于 α_Q/α_R。"), when),
        _factor("alpha_r", r"\alpha_R", Text("input weight α_R", "输入权重 α_R"), 1e-4, 1e4, ar,
                Text("R = α_R I: what force costs.", "R = α_R I：用力的代价。"), when),
        _factor("beta_q", r"\beta_Q", Text("disturbance believed β_Q", "设定的扰动强度 β_Q"), 1e-3, 1e3, 1.0,
                Text("W = β_Q W₀ is what the filter is told; the disturbance itself stays.",
                     "告诉滤波器 W = β_Q W₀；扰动本身并不改变。"), when),
        _factor("beta_r", r"\beta_R", Text("sensor noise believed β_R", "设定的测量噪声 β_R"), 1e-3, 1e12, br,
                Text(f"V = β_R I{unit.en}: what the filter is told of its sensors.",
                     f"V = β_R I{unit.zh}：告诉滤波器的测量噪声。"), when),
        _factor("sensor", r"V_{\mathrm{true}}", Text("true sensor noise", "真实测量噪声"), 1e-2, 1e12, 1.0,
                Text("In the unit of β_R: what the sensors really do.", "与 β_R 同单位：传感器实际的噪声强度。"), when),
    )


def _of_paper(when: When) -> tuple[Number, ...]:
    return (
        _factor("q", "q", Text("state weight q", "状态权重 q"), 0.1, 1e4, 5.0,
                Text("Q = q [1 1]ᵀ[1 1], R = 1.", "Q = q [1 1]ᵀ[1 1]，R = 1。"), when),
        _factor("sigma", r"\sigma", Text("disturbance σ", "扰动强度 σ"), 0.1, 1e4, 5.0,
                Text("W = σ [1 1]ᵀ[1 1], V = 1, as they are and as the filter believes.",
                     "W = σ [1 1]ᵀ[1 1]，V = 1：真值与设定值相同。"), when),
    )


def _for_all(case: Case, report: When) -> tuple[Choice | Number, ...]:
    inputs = tuple((str(i + 1), called(case.plant, name)) for i, name in enumerate(case.plant.input_names))
    cut = () if len(inputs) < 2 else (Choice(
        "cut", "", Text("loop cut at", "断开的输入"), default="1", options=inputs, when=report,
        hint=Text("Nyquist and margins: this input is cut, the others stay closed.",
                  "Nyquist 曲线与裕度：断开这个输入，其余保持闭合。")),)
    return (
        Number("recovery", r"\rho", Text("recovery ρ", "恢复 ρ"), low=0.0, high=10.0, default=0.0, step=0.5,
               hint=Text("Decades of fictitious noise on the inputs that the filter is told of; 0 is plain LQG.",
                         "告诉滤波器输入端有多少个数量级的虚构噪声；0 即普通 LQG。")),
        Number("gain", "m", Text("true gain of the inputs", "输入的真实增益"), low=0.5, high=2.0, default=1.0, step=0.001,
               hint=Text("How strong the inputs really are, times what the model says.",
                         "输入的实际强度是模型值的多少倍。")),
        *cut,
        Choice("filter", "", Text("filter", "滤波器"), default=STEADY,
               options=((STEADY, Text("steady gain (LQE)", "稳态增益（LQE）")),
                        (RECURSIVE, Text("recursive, on a computer", "递推（计算机实现）"))),
               hint=Text("The gain of the Riccati equation, or Joseph's recursion step by step.",
                         "Riccati 方程的增益，或逐步的 Joseph 递推。")),
        Choice("rule", "", Text("line of the report in doubt", "报告中可疑的一行"), default=NONE, options=RULES,
               hint=Text("The tab Report shows what this loop says about it.", "“报告”标签页显示本回路对这一行的检验。")),
    )
