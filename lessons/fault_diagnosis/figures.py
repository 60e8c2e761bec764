"""Figures of the lesson: residuals against thresholds, the isolation table, the loop, false alarms, what can be seen."""

from __future__ import annotations

import numpy as np

from app.lesson.figures import Curve, Dash, Figure, FrequencyFigure, PlaneFigure, Point, TableFigure, TimeFigure
from app.lesson.lesson import Outcome
from app.text.words import Text, same

from .bank import COILS, COUNT, DT, NAMES, PLACE_NAMES, PLACES, guard
from .diagnosis import POWER
from .reach import TONES, least, least_force
from .runs import NONE, OPEN, SWITCH
from .study import LEVEL, Study, unknown_coil

RESIDUAL_TAB, VERDICT_TAB, LOOP_TAB = Text("Residuals", "残差"), Text("Verdict", "判决"), Text("Loop", "回路")
RATE_TAB, REACH_TAB = Text("False alarms", "误报"), Text("Reach", "灵敏度")
T = DT * np.arange(COUNT)
T.setflags(write=False)
FLOOR = 0.1  # of the threshold: nothing lower is drawn
LOOKS: tuple[tuple[str, Dash], ...] = (("plant", "solid"), ("estimate", "dash"), ("force", "dot"), ("error", "solid"))
YES, NO, HERE = "●", "○", "▶ "


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything on the right of the stage."""
    s: Study = outcome.study
    return (_residuals(s, "sensors", Text("leaving out one sensor", "各去掉一个传感器"), range(4)),
            _residuals(s, "coils", Text("ignoring one coil", "各忽略一个线圈"), range(4, 7)), _reading(s),
            isolation(s), _members(), _pitch(s), _across(s), _forces(s), _rates(s), _counts(s), _tones(s), _least(s))


# --- residuals ---------------------------------------------------------------------------------------------------------
def _residuals(s: Study, name: str, title: Text, which: range) -> TimeFigure:
    curves = [Curve(same(NAMES[i]), np.maximum(s.verdict.values[:, i], FLOOR), *LOOKS[i % 4]) for i in which]
    curves.append(Curve(Text("threshold", "阈值"), np.ones(COUNT), "reference", "dash", 1.4))
    at = _decisive(s)
    loud = [NAMES[i] for i in which if s.verdict.values[at, i] > 1]
    when = f"{DT * at:.2f} s"
    said = (Text(f"At {when} over the threshold: {', '.join(loud)}.", f"{when} 时超过阈值：{'、'.join(loud)}。") if loud else
            Text(f"At {when} none is over the threshold.", f"{when} 时没有残差超过阈值。"))
    return TimeFigure(name, title, T, tuple(curves), "T / χ²", log=True, window=(0.1, 10.0), caption=said,
                      tab=RESIDUAL_TAB)


def _decisive(s: Study) -> int:
    """The sample that is talked about: the verdict's, else the last of those with most alarms."""
    if s.verdict.decided is not None:
        return s.verdict.decided
    return COUNT - 1 - int(np.argmax((s.verdict.values > 1).sum(axis=1)[::-1]))


def _reading(s: Study) -> TimeFigure:
    coil = s.case.coil
    if coil is not None:
        return TimeFigure("reading", Text("force of the weak coil", "失效线圈的力"), T,
                          (Curve(Text("asked", "指令"), s.record.asked[:, coil], "force", "dash"),
                           Curve(Text("delivered", "实际"), s.record.applied[:, coil], "error")), "u [N]", window=(-1.0, 1.0),
                          tab=RESIDUAL_TAB, caption=Text(
                              f"{COILS[coil]} delivers {100 * (1 - s.case.size):.0f} % from {DT * s.case.start:.1f} s on; the bank only "
                              "knows what was asked.",
                              f"{DT * s.case.start:.1f} s 之后 {COILS[coil]} 只输出 {100 * (1 - s.case.size):.0f} %；诊断器只知道指令。"))
    i = 1 if s.case.sensor is None else s.case.sensor
    said = (Text(f"{PLACES[i]} lies from {DT * s.case.start:.1f} s on.", f"{DT * s.case.start:.1f} s 之后 {PLACES[i]} 失真。")
            if s.case.sensor is not None else Text("All four sensors are honest.", "四个传感器都正常。"))
    return TimeFigure("reading", Text(f"reading of {PLACES[i]}", f"{PLACES[i]} 的读数"), T,
                      (Curve(Text("reading", "读数"), 1e3 * s.record.y[:, i], "error", width=1.4),
                       Curve(Text("true velocity", "真实速度"), 1e3 * s.record.honest[:, i])), "v [mm/s]", window=(-5.0, 5.0),
                      caption=said, tab=RESIDUAL_TAB)


# --- verdict -----------------------------------------------------------------------------------------------------------
def isolation(s: Study) -> TableFigure:
    """Fault against residual, the row that fits now marked, and below it what this run shows."""
    signature, at = guard().bank.signature, _decisive(s)
    now = s.verdict.named[at]
    rows: list[tuple[Text | str, ...]] = []
    for j, name in enumerate(PLACE_NAMES):
        mark = HERE if now == j else ""
        cells = [YES if seen else NO for seen in signature[:, j]]
        rows.append((Text(mark + name.en, mark + name.zh), *cells))
    rows.append((Text(f"alarms at {DT * at:.2f} s", f"{DT * at:.2f} s 时的报警"),
                 *(YES if v > 1 else NO for v in s.verdict.values[at])))
    rows.append((Text("T / threshold", "T / 阈值"), *(f"{v:.2f}" if v < 100 else f"{v:.0f}" for v in s.verdict.values[at])))
    said = (Text("No alarm: no row to look for.", "没有报警，无行可对。") if now == -1 else
            _unclear(s.verdict.values[at] > 1) if now == -2 else
            Text(f"The alarms fit the row of {PLACE_NAMES[now].en}, too briefly to accuse it.",
                 f"报警与“{PLACE_NAMES[now].zh}”一行相符，但持续太短，不足以指认。") if s.verdict.decided is None else
            Text(f"The alarms fit one row only: {PLACE_NAMES[now].en}.", f"报警只与一行相符：{PLACE_NAMES[now].zh}。"))
    return TableFigure("isolation", Text("isolation table", "故障隔离表"), (Text("fault", "故障"), *(same(n) for n in NAMES)),
                       tuple(rows), said, VERDICT_TAB)


def _unclear(alarms: np.ndarray) -> Text:
    """Why no row fits: everybody gives an alarm, or more than one member is quiet."""
    quiet = [name for name, loud in zip(NAMES, alarms, strict=True) if not loud]
    if not quiet:
        return Text("Every member gives an alarm: this is none of the seven faults.", "所有成员都报警：不是这七种故障之一。")
    return Text(f"No row fits: {len(quiet)} members are quiet, {', '.join(quiet[:3])}{' …' if len(quiet) > 3 else ''}.",
                f"没有一行相符：{len(quiet)} 个成员安静，即 {'、'.join(quiet[:3])}{'等' if len(quiet) > 3 else ''}。")


def _members() -> TableFigure:
    rows: list[tuple[Text | str, ...]] = []
    for i, m in enumerate(guard().bank.members):
        slow = -DT / np.log(np.max(np.abs(m.poles)))
        if i < 4:
            rows.append((NAMES[i], Text("the other three", "其余三个"), "—", str(m.size), f"{slow:.2f} s"))
        else:
            zeros = unknown_coil(i - 4).zeros
            zero = "—" if zeros is None or not len(zeros) else f"s = {abs(zeros[0]):.0f}"
            rows.append((NAMES[i], Text("all four", "全部四个"), zero, str(m.size), f"{slow:.2f} s"))
    return TableFigure("members", Text("the seven members", "七个成员"),
                       (Text("member", "成员"), Text("sensors", "传感器"), Text("zero", "零点"), Text("states", "状态数"),
                        Text("memory", "记忆")), tuple(rows),
                       Text("A coil's zero at s = 0: a constant force leaves every velocity at zero, so no observer of all six states "
                            "can ignore the coil; the residual needs five.",
                            "线圈的零点在 s = 0：恒定的力不改变任何速度，因此不存在能忽略它的全状态观测器；残差只需五个状态。"),
                       VERDICT_TAB)


# --- loop --------------------------------------------------------------------------------------------------------------
def _motion(s: Study, name: str, title: Text, i: int, unit: str) -> TimeFigure:
    true, guess = 1e3 * s.record.x[:, i], 1e3 * s.record.xhat[:, i]
    curves = [Curve(Text("true", "真实"), true), Curve(Text("what the loop believes", "回路所相信的"), guess, "estimate", "dash")]
    if s.record is not s.blind:
        curves.append(Curve(Text("had nobody acted", "若无人处理"), 1e3 * s.blind.x[:, i], "muted", "dot"))
    late = slice(-COUNT // 6, None)
    mean, error = float(true[late].mean()), float((true - guess)[late].mean())
    said = Text(f"Mean of the last 2 s: {mean:.2f} {unit}; the estimate is off by {error:.2f} {unit}.".replace("-", "−"),
                f"最后 2 s 的均值 {mean:.2f} {unit}，估计偏差 {error:.2f} {unit}。".replace("-", "−"))
    return TimeFigure(name, title, T, tuple(curves), f"[{unit}]", window=(-2.0, 2.0), caption=said, tab=LOOP_TAB)


def _pitch(s: Study) -> TimeFigure:
    return _motion(s, "pitch", Text("pitch of the deck θ", "平台俯仰角 θ"), 2, "mrad")


def _across(s: Study) -> TimeFigure:
    return _motion(s, "across", Text("horizontal position x", "水平位移 x"), 0, "mm")


def _forces(s: Study) -> TimeFigure:
    looks: tuple[tuple[str, Dash], ...] = (("force", "solid"), ("disturbance", "dash"), ("second", "dot"))
    curves = tuple(Curve(same(COILS[j]), s.record.applied[:, j], *looks[j]) for j in range(3))
    said = (Text("Open loop: the coils only do what the known force asks.", "开环：线圈只输出已知力。") if s.case.loop == OPEN else
            _acted(s) if s.case.loop == SWITCH else
            Text("The loop keeps believing all four sensors.", "回路始终相信全部四个传感器。"))
    return TimeFigure("forces", Text("forces delivered", "线圈实际输出的力"), T, curves, "u [N]", window=(-1.0, 1.0), caption=said,
                      tab=LOOP_TAB)


def _acted(s: Study) -> Text:
    who, at = s.verdict.who, s.verdict.decided
    if who is None or at is None:
        return Text("Nobody is accused: the loop is left as it is.", "无人被指认：回路保持不变。")
    if who in COILS:
        return Text(f"From {DT * at:.2f} s on {who} is asked for nothing; two coils do the work.",
                    f"{DT * at:.2f} s 起不再使用 {who}，由另外两个线圈承担。")
    return Text(f"From {DT * at:.2f} s on the loop believes the member without {who}.",
                f"{DT * at:.2f} s 起回路改信不含 {who} 的那个成员。")


# --- false alarms --------------------------------------------------------------------------------------------------------
def _rates(s: Study) -> PlaneFigure:
    x = np.array([0.5, 7.5])
    curves = [Curve(Text("designed", "设计值"), np.ones(2), "reference", "dash", 1.6, x)]
    points: list[Point] = []
    top = 2.0
    if s.trials is not None:
        low, high = (v / s.test.rate for v in s.trials.band(s.test.rate))
        shares = s.trials.alarms / s.trials.windows / s.test.rate
        top = max(top, 1.4 * high, 1.2 * float(shares.max()))
        curves.append(Curve(Text("99 % band", "99 % 区间"), np.array([low, high, high, low, low]), "disturbance", "dot", 1.6,
                            np.array([0.5, 0.5, 7.5, 7.5, 0.5])))
        points = [Point(i + 1.0, float(v), "plant" if low <= v <= high else "error", "dot", same(NAMES[i]))
                  for i, v in enumerate(shares)]
        inside = int(sum(low <= v <= high for v in shares))
        said = Text(f"{s.trials.windows} windows: {inside} of 7 members lie in the binomial {LEVEL:.0%} band.".replace("%", " %"),
                    f"{s.trials.windows} 个窗口：7 个成员中有 {inside} 个落在二项分布的 99 % 区间内。")
    else:
        said = Text("Press the button: healthy runs are drawn and their alarms counted.", "请按按钮：抽取无故障的运行并统计报警。")
    return PlaneFigure("rates", Text("false alarms, measured over designed", "误报率：实测 / 设计"), tuple(curves), tuple(points),
                       "", "α̂ / α", (0.0, 8.0), (0.0, top), caption=said, tab=RATE_TAB)


def _counts(s: Study) -> TableFigure:
    a, n = s.test.rate, s.test.window
    hourly = 7 * a * 3600 / (n * DT)
    rows: list[tuple[Text | str, ...]] = [
        (Text("threshold", "阈值"), f"{s.test.threshold:.2f}"),
        (Text("χ² degrees of freedom", "χ² 自由度"), str(s.test.dof)),
        (Text("designed, per window and member", "设计值（每窗口、每成员）"), f"{a:.2g}"),
        (Text("expected per hour, all members", "每小时预期误报（全部成员）"), f"{hourly:.3g}"),
        (Text(f"λ for {100 * POWER:.0f} % power", f"{100 * POWER:.0f} % 检出所需 λ"), f"{s.test.needed:.1f}"),
    ]
    t = s.trials
    some = "—" if t is None else f"{t.any / t.windows:.2g} ≤ {min(7 * a, 1.0):.2g}"
    rows.append((Text("at least one of seven, measured", "至少一个报警（实测）"), some))
    if t is not None and s.case.place != NONE:
        middle = f"{np.median(t.delays):.2f} s" if t.delays else "—"
        rows += [(Text("accused rightly / wrongly / nobody", "指认正确 / 错误 / 无"), f"{t.right} / {t.wrong} / {t.nobody}"),
                 (Text("median delay", "延迟中位数"), middle)]
    else:
        rows += [(Text("accused rightly / wrongly / nobody", "指认正确 / 错误 / 无"), "—"), (Text("median delay", "延迟中位数"), "—")]
    said = (Text(f"One threshold for all members: about {hourly:.2g} false alarms an hour.",
                 f"所有成员用同一个阈值：每小时约 {hourly:.2g} 次误报。"))
    return TableFigure("counts", Text("design of the threshold", "阈值的设计"), (Text("quantity", "量"), Text("value", "数值")),
                       tuple(rows), said, RATE_TAB)


# --- reach -------------------------------------------------------------------------------------------------------------
def _tones(s: Study) -> FrequencyFigure:
    values = np.clip(least_force(s.test), 1e-2, 1e2)
    missing = 0.0
    if s.case.coil is not None:
        lost = s.silent.asked - s.silent.applied
        missing = float(np.abs(lost[s.case.start:, s.case.coil]).max(initial=0.0))
    curves = [Curve(same("u1, u2"), values[:, 0], "plant"), Curve(same("u3"), values[:, 2], "estimate", "dash")]
    if missing > 0:
        curves.append(Curve(Text("missing now", "目前缺少"), np.full(len(TONES), max(missing, 1e-2)), "error", "dot"))
    best = TONES[int(np.argmin(values[:, 0]))]
    said = Text(f"A missing force of u1 is seen best at {best:.2f} Hz, from {values[:, 0].min():.2g} N on.",
                f"u1 缺少的力在 {best:.2f} Hz 处最易察觉，只需 {values[:, 0].min():.2g} N。")
    return FrequencyFigure("tones", Text("least missing force that all six see", "六个成员都能察觉的最小缺力"), TONES, tuple(curves),
                           "N", window=(0.1, 10.0), caption=said, tab=REACH_TAB)


def _least(s: Study) -> TableFigure:
    values = least(s.test, s.case.tone)
    rows: list[tuple[Text | str, ...]] = []
    for j, name in enumerate(PLACES):
        scale, unit = (1e3, "mm/s") if j < 4 else (1.0, "N")
        cells = [_short(scale * v) for v in values[:, j]]
        rows.append((f"{name} [{unit}]", *cells))
    weak = int(np.argmax(np.where(np.isfinite(values[:, 0]), values[:, 0], 0)))
    said = Text(f"Bias, or missing amplitude at {s.case.tone:.2g} Hz. A lie of VL is hardest to see for {NAMES[weak]}: it looks almost "
                "like what that member ignores.",
                f"偏差，或 {s.case.tone:.2g} Hz 处缺少的幅值。VL 失真时 {NAMES[weak]} 最难察觉：它几乎像该成员所忽略的故障。")
    return TableFigure("least", Text("least fault that each member sees with 99 %", "各成员以 99 % 概率察觉的最小故障"),
                       (Text("fault", "故障"), *(same(n) for n in NAMES)), tuple(rows), said, REACH_TAB)


def _short(value: float) -> str:
    return "—" if not np.isfinite(value) else f"{value:.2f}" if value < 10 else f"{value:.0f}" if value < 1000 else "∞"
