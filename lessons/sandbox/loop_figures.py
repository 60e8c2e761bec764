"""Figures of the loop, its noise and its robustness; where an analysis does not apply, the sentence why."""

from __future__ import annotations

import numpy as np

from app.engine import Plant, chi2_band
from app.engine.feedback import ClosedLoop
from app.lesson.figures import Curve, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure, nice, over_frequency
from app.plants.names import called
from app.text.words import Text, same

from ..toolkit.latex import tiny
from .analyses import Margins, Noise, Refusal, Trial
from .study import largest

VERDICT_TAB, STRUCTURE_TAB, LOOP_TAB = Text("Verdicts", "结论"), Text("Structure", "结构"), Text("Loop", "闭环")
NOISE_TAB, ROBUST_TAB = Text("Noise", "噪声"), Text("Robustness", "鲁棒性")
LOWEST = -17.0  # decades: what is smaller is drawn here
RIGHT = 0.05  # a filter whose NIS is this near to its due on average is right, whatever one record says
CIRCLE = np.linspace(0.0, 2 * np.pi, 121)


def decades(values: np.ndarray) -> np.ndarray:
    """log₁₀|values|, not below the lowest that is drawn."""
    return np.log10(np.maximum(np.abs(values), 10.0**LOWEST))


def why(refusal: Refusal) -> Text:
    """The sentence of an analysis that does not apply, as a caption."""
    return Text(f"Not for this plant: {refusal.text.en}", f"此处不适用：{refusal.text.zh}")


def empty_plane(name: str, title: Text, tab: Text, said: Text) -> PlaneFigure:
    """A plane with nothing in it but its sentence."""
    return PlaneFigure(name, title, tab=tab, caption=said)


def empty_time(name: str, title: Text, tab: Text, said: Text) -> LineFigure:
    """Axes with nothing on them but their sentence."""
    return LineFigure(name, title, np.array([0.0, 1.0]), (Curve(same("—"), np.zeros(2), "muted"),), tab=tab, caption=said)


def spectrum(loop: ClosedLoop, dt: float) -> PlaneFigure:
    """The 2n poles among the chosen ones and the compensator's own."""
    groups = ((loop.controller_poles, "plant", "cross"), (loop.observer_poles, "estimate", "cross"), (loop.poles, "reference", "circle"),
              (loop.compensator_poles, "force", "dot"))
    points = tuple(Point(float(p.real), float(p.imag), role, mark) for poles, role, mark in groups for p in poles)  # type: ignore[arg-type]
    near = np.abs(np.concatenate([loop.controller_poles, loop.observer_poles]))
    size = nice(1.1 * float(max(np.quantile(near, 0.8), 1e-12))) if not dt else max(1.2, min(float(near.max()), 2.5))
    circle = (Curve(Text("unit circle", "单位圆"), np.sin(CIRCLE), "reference", "solid", 1.2, np.cos(CIRCLE)),) if dt else ()
    low, high = (-size, size) if dt else (-1.2 * size, 0.4 * size)
    own = loop.compensator_stable
    said = (Text("The compensator is stable by itself.", "补偿器自身稳定。") if own else
            Text("The compensator by itself is unstable.", "补偿器自身不稳定。"))
    return PlaneFigure(
        "spectrum", Text("spectrum of the whole loop", "整个闭环的谱"), circle, points, "Re z" if dt else "Re s", "Im z" if dt else "Im s",
        (low, high), (-size, size), equal=bool(dt), unstable=not dt, tab=LOOP_TAB, caption=Text(
            f"Crosses: eig(A − BK), eig(A − LC). Circles: the {len(loop.poles)} poles of the loop. Green dots: the compensator's own. "
            f"What lies farther out is drawn at the edge. {said.en}",
            f"叉号：eig(A − BK) 与 eig(A − LC)。圆圈：闭环的 {len(loop.poles)} 个极点。绿点：补偿器自身的极点。更远的画在边缘。{said.zh}"))


def blocks(loop: ClosedLoop, plant: Plant) -> MatrixFigure:
    """The loop in (x, e)."""
    n = plant.n
    names = (*(called(plant, name) for name in plant.state_names), *(f"e{i + 1}" for i in range(n)))
    return MatrixFigure("blocks", Text("the loop in (x, e) coordinates", "(x, e) 坐标下的闭环矩阵"), loop.A_xe, names, names, (n,),
                        tab=LOOP_TAB, caption=Text("White is zero: the error drives the state, never the other way round.",
                                                   "白色为零：误差驱动状态，状态从不驱动误差。"))


def certificate_table(rows: tuple[tuple[Text, float], ...] | Refusal) -> TableFigure:
    """What theory says is zero, beside what rounding leaves."""
    title, heads = Text("zeros of theory, in double precision", "理论上为零的量（双精度）"), (Text("quantity", "量"), Text("size", "大小"))
    if isinstance(rows, Refusal):
        return TableFigure("certificates", title, heads, ((same("—"), same("—")),), why(rows), LOOP_TAB)
    worst = max(value for _, value in rows)
    return TableFigure("certificates", title, heads, tuple((name, tiny(value)) for name, value in rows), tab=LOOP_TAB, caption=Text(
        f"The largest is about {tiny(worst)} of its scale. Far above 10⁻⁹ the numbers of this loop are not to be trusted.",
        f"最大者约为其量级的 {tiny(worst)}。若远大于 10⁻⁹，这个闭环的数值就不可信。"))


# --- noise -------------------------------------------------------------------------------------------------------------
def valley(found: Noise | Refusal, belief: float) -> PlaneFigure:
    """Error of the Kalman filters of all beliefs, and of the design's own observer."""
    title = Text("estimation error over belief", "估计误差与设定值的关系")
    if isinstance(found, Refusal):
        return empty_plane("valley", title, NOISE_TAB, why(found))
    x = np.log10(found.ladder.ratio)

    def size(P: np.ndarray) -> float:
        return 0.5 * float(np.log10(max(float(np.mean(np.diag(P) / found.unit**2)), 1e-300)))
    total, process, sensor = (np.array([size(getattr(p, k)) for p in found.ladder.parts]) for k in ("total", "process", "sensor"))
    at = float(np.interp(np.log10(belief), x, total))
    far = abs(np.log10(belief)) > 0.5
    points = [Point(0.0, float(np.interp(0.0, x, total)), "reference", "circle", Text("Kalman", "卡尔曼")),
              Point(float(np.log10(belief)), at, "error", "dot", Text("this belief", "当前设定值") if far else same(""))]
    if isinstance(found.ours, Refusal):
        said = Text(f"The observer of the board: {found.ours.text.en}", f"极点板上的观测器：{found.ours.text.zh}")
    else:
        ours = size(found.ours.total)
        points.append(Point(2.2, ours, "estimate", "cross", Text("board", "极点板")))
        said = Text(f"The observer of the board errs {10 ** (ours - float(total.min())):.3g} times as much as the best.",
                    f"极点板上的观测器的误差是最小值的 {10 ** (ours - float(total.min())):.3g} 倍。")
    low = float(np.floor(2 * total.min()) / 2 - 0.5)
    return PlaneFigure("valley", title, (Curve(Text("both noises", "两种噪声合计"), total, "error", x=x),
                                         Curve(Text("process noise", "过程噪声"), process, "disturbance", "dash", 1.8, x),
                                         Curve(Text("sensor noise", "测量噪声"), sensor, "second", "dot", 1.8, x)), tuple(points),
                       "log₁₀ b", "log₁₀ σ", (float(x[0]), float(x[-1])),
                       (low, max(low + 2.0, float(total.max()) + 0.2)), tab=NOISE_TAB, caption=said)


def nis_figure(found: Trial | Refusal, outputs: int) -> LineFigure:
    """NIS of a filter with this belief."""
    title = Text("NIS of a filter with this belief", "当前设定值下滤波器的 NIS")
    if isinstance(found, Refusal):
        return empty_time("nis", title, NOISE_TAB, why(found))
    low, high = chi2_band(outputs, count=1)
    n, test = len(found.t), found.test
    said = {"consistent": ("as it should be", "符合预期"),
            "overconfident": ("above it, as with a filter that trusts its model too much", "偏大，像是滤波器过于相信模型"),
            "cautious": ("below it, as with a filter that doubts too much", "偏小，像是滤波器过于怀疑模型")}[test.verdict]
    if test.verdict != "consistent" and abs(found.expected / outputs - 1) < RIGHT:
        said = ("outside it by chance, as one record in twenty is", "偶然落在范围之外，二十次记录中约有一次如此")
    return LineFigure("nis", title, found.t, (Curve(Text("NIS", "NIS"), np.maximum(found.values, 1e-4), "error", width=1.4),
                                              Curve(Text(f"expected, {outputs}", f"期望值 {outputs}"), np.full(n, float(outputs)),
                                                    "reference", "dash", 1.4),
                                              Curve(Text("95 % band", "95 % 带"), np.full(n, high), "muted", "dot", 1.4),
                                              Curve(Text("lower edge", "下沿"), np.full(n, low), "muted", "dot", 1.4)), "NIS", log_y=True,
                      window=(0.01, 100.0), tab=NOISE_TAB,
                      caption=Text(f"This record: mean {test.mean:.3g}, band {test.mean_band[0]:.3g} … {test.mean_band[1]:.3g}: {said[0]}. "
                                   f"On average: {found.expected:.3g}.",
                                   f"本次记录：均值 {test.mean:.3g}，范围 {test.mean_band[0]:.3g} … {test.mean_band[1]:.3g}：{said[1]}。"
                                   f"这样的滤波器平均为 {found.expected:.3g}。"))


def gain_figure(found: Trial | Refusal) -> LineFigure:
    """How the recursive gain settles on the Riccati solution."""
    title = Text("distance of the gain from the Riccati gain", "增益与 Riccati 增益的距离")
    if isinstance(found, Refusal):
        return empty_time("gain", title, NOISE_TAB, why(found))
    late = np.flatnonzero(found.distance > 0.01)
    after = f"{found.t[min(late[-1] + 1, len(found.t) - 1)]:.3g}" if len(late) else "0"
    return LineFigure("gain", title, found.t, (Curve(Text("relative distance", "相对距离"), np.maximum(found.distance, 1e-12), "error"),),
                      "‖M − M∞‖ / ‖M∞‖", log_y=True, window=(1e-8, 1.0), tab=NOISE_TAB,
                      caption=Text(f"Within 1 % after {after} s; no reading has any part in this.",
                                   f"{after} s 后相差不到 1 %；这与任何读数都无关。"))


# --- robustness --------------------------------------------------------------------------------------------------------
def sensitivity_figure(found: Margins | Refusal, recovered: np.ndarray | None, grid: np.ndarray) -> LineFigure:
    """Largest singular value of S at the inputs: as it is, had the state been known, and recovered."""
    title = Text("sensitivity at the inputs, σ_max(S)", "输入端灵敏度 σ_max(S)")
    if isinstance(found, Refusal):
        return over_frequency("sensitivity", title, grid, (Curve(same("—"), np.ones(len(grid)), "muted"),), caption=why(found),
                              tab=ROBUST_TAB)
    curves = [Curve(Text("x known", "x 已知"), largest(found.target, grid), "reference", "dash"),
              Curve(Text("by the estimate", "估计反馈"), largest(found.loop, grid), "estimate")]
    if recovered is not None:
        curves.append(Curve(Text("recovered", "恢复后"), recovered, "force", "dot"))
    peak = float(curves[1].y.max())
    return over_frequency("sensitivity", title, grid, tuple(curves), "σ_max(S)", tab=ROBUST_TAB, window=(0.1, 3.0),
                          caption=Text(f"Peak {peak:.3g}: at worst the loop comes within {1 / peak:.2g} of instability.",
                                       f"峰值 {peak:.3g}：最坏处离失稳只有 {1 / peak:.2g}。"))


def margin_table(found: Margins | Refusal, plant: Plant) -> TableFigure:
    """Gain, phase and disk margins, one input at a time."""
    title = Text("margins, one input at a time", "各输入通道的裕度")
    heads = (Text("input", "输入"), Text("gain between", "增益范围"), Text("phase", "相位"), Text("disk α", "圆盘裕度 α"))
    if isinstance(found, Refusal):
        return TableFigure("margins", title, heads, ((same("—"),) * 4,), why(found), ROBUST_TAB)
    rows = tuple((called(plant, c.name), f"{c.gain[0]:.2g} … " + ("∞" if np.isinf(c.gain[1]) else f"{c.gain[1]:.3g}"),
                  f"{np.degrees(c.phase):.0f}°", f"{c.disk.alpha:.3g}") for c in found.channels)
    return TableFigure("margins", title, heads, rows, tab=ROBUST_TAB, caption=Text(
        f"All inputs at once: disk margin α = {found.together:.3g}, so gains may change by a factor of "
        f"{(2 + min(found.together, 1.99)) / (2 - min(found.together, 1.99)):.2g} up or down together.",
        f"全部输入同时：圆盘裕度 α = {found.together:.3g}，即各增益可同时放大或缩小 "
        f"{(2 + min(found.together, 1.99)) / (2 - min(found.together, 1.99)):.2g} 倍。"))


def recovery_plane(steps: tuple[tuple[float, float, float], ...], total: int, refused: Text | None) -> PlaneFigure:
    """Disk margin and gap of the recovered loop over the knob q."""
    title = Text("loop transfer recovery", "回路传递恢复")
    if not steps:
        said = refused or Text("Not computed yet: press the button under the knobs.", "尚未计算：请按旋钮下方的按钮。")
        return empty_plane("recovery", title, ROBUST_TAB, said)
    q, alpha, target = (np.array(v) for v in zip(*steps, strict=True))
    x = np.log10(q)
    top = nice(1.1 * float(max(alpha.max(), target.max(), 0.1)))
    done = Text("", "") if len(steps) == total else Text(f" {len(steps)} of {total} steps so far.", f" 已完成 {len(steps)}/{total} 步。")
    return PlaneFigure("recovery", title, (Curve(Text("disk margin by the estimate", "估计反馈的圆盘裕度"), alpha, "force", x=x),
                                           Curve(Text("x known", "x 已知"), target, "reference", "dash", 1.4, x)), (), "log₁₀ q", "α",
                       (-3.0, 3.0), (0.0, top), tab=ROBUST_TAB,
                       caption=Text(f"With q = {q[-1]:.3g} the disk margin is {alpha[-1]:.3g}; with the state known it is "
                                    f"{target[-1]:.3g}.{done.en}",
                                    f"q = {q[-1]:.3g} 时圆盘裕度为 {alpha[-1]:.3g}；状态已知时为 {target[-1]:.3g}。{done.zh}"))
