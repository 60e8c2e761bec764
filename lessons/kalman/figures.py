"""Figures of the lesson: one step, the gain, the innovations, the tests, the spectra, the lines of the report."""

from __future__ import annotations

import numpy as np

from app.engine import chi2_band, psd
from app.lesson.figures import Curve, Figure, LineFigure, PlaneFigure, Point, TableFigure, nice, over_frequency
from app.lesson.lesson import Outcome
from app.text.words import Text, same

from ..toolkit.figures import TIME_TAB
from .filters import SKIP, STEPS
from .knobs import CARRIED, DT, GAIN, JOSEPH, LINES, MEANS, NEAR_R, NONE, SHORT, SLIPS
from .study import Study, expected

STEP_TAB, GAIN_TAB, TEST_TAB = Text("One step", "一步"), Text("Gain", "增益"), Text("Consistency", "一致性")
INNOVATION_TAB, SPECTRUM_TAB = Text("Innovations", "新息"), Text("Spectrum", "频谱")
STATES = (("x", "mm"), ("z", "mm"), ("θ", "mrad"), ("vx", "mm/s"), ("vz", "mm/s"), ("ω", "mrad/s"))
TURN = np.linspace(0, 2 * np.pi, 61)
CIRCLE = np.column_stack([np.cos(TURN), np.sin(TURN)])


def all_figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything on the right of the stage."""
    return (_ellipses(outcome), _step(outcome), _height(outcome), _pitch(outcome), _gain(outcome), _distance(outcome), _forms(outcome),
            _innovation(outcome), _correlation(outcome), _nis(outcome), _nees(outcome), _tests(outcome),
            _tracking(outcome), _colour(outcome), report_figure(outcome))


def _time(outcome: Outcome[Study]) -> np.ndarray:
    return DT * np.arange(len(outcome.study.nis))


# --- one step --------------------------------------------------------------------------------------------------------
def _ellipse(mean: np.ndarray, P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The 2σ ellipse of height and vertical speed in mm and mm/s."""
    at, part = 1e3 * mean[[1, 4]], 1e6 * P[np.ix_([1, 4], [1, 4])]
    values, vectors = np.linalg.eigh(part)
    ring = at + 2 * CIRCLE @ (vectors * np.sqrt(np.maximum(values, 0.0))).T
    return ring[:, 0], ring[:, 1]


def _ellipses(outcome: Outcome[Study]) -> PlaneFigure:
    s, k = outcome.study, int(outcome.design["k"])
    plan, updated = s.watcher.schedule, outcome.design["phase"] == "update"
    before, at = int(plan.index[k - 1]), int(plan.index[k])
    prior = plan.prior[at]
    old, new = _ellipse(s.track.means[k - 1], plan.posterior[before]), _ellipse(s.track.predicted[k], prior)
    middle = 1e3 * s.track.predicted[k][[1, 4]]
    half = [nice(float(2.6e3 * np.sqrt(max(P[i, i] for P in (prior, plan.posterior[before]))))) for i in (1, 4)]
    curves = [Curve(Text("last estimate", "上一步估计"), old[1], "muted", "dot", 1.6, old[0]),
              Curve(Text("prediction", "预测"), new[1], "disturbance", "dash", 2.0, new[0])]
    x = 1e3 * s.truth.x[k]
    points = [Point(float(x[1]), float(x[4]), "plant", "circle", Text("true", "真实")),
              Point(float(middle[0]), float(middle[1]), "disturbance", "cross")]
    said = Text(f"Prediction: σ(z) = {1e3 * np.sqrt(prior[1, 1]):.3g} mm, σ(vz) = {1e3 * np.sqrt(prior[4, 4]):.3g} mm/s.",
                f"预测：σ(z) = {1e3 * np.sqrt(prior[1, 1]):.3g} mm，σ(vz) = {1e3 * np.sqrt(prior[4, 4]):.3g} mm/s。")
    if updated:
        after = plan.posterior[at]
        ring = _ellipse(s.track.means[k], after)
        read = 1e3 * float(s.truth.y[k, 0] + s.truth.y[k, 2]) / 2
        curves += [Curve(Text("estimate", "估计"), ring[1], "estimate", "solid", 2.0, ring[0]),
                   Curve(Text("reading (VL + VR)/2", "读数 (VL + VR)/2"), np.full(2, read), "second", "solid", 1.4,
                         middle[0] + half[0] * np.array([-1.0, 1.0]))]
        mean = 1e3 * s.track.means[k]
        points.append(Point(float(mean[1]), float(mean[4]), "estimate", "cross"))
        said = Text(f"This sample shrinks σ(vz) from {1e3 * np.sqrt(prior[4, 4]):.3g} to {1e3 * np.sqrt(after[4, 4]):.3g} mm/s and "
                    f"σ(z) from {1e3 * np.sqrt(prior[1, 1]):.3g} to {1e3 * np.sqrt(after[1, 1]):.3g} mm.",
                    f"这次采样使 σ(vz) 由 {1e3 * np.sqrt(prior[4, 4]):.3g} 降到 {1e3 * np.sqrt(after[4, 4]):.3g} mm/s，σ(z) 由 "
                    f"{1e3 * np.sqrt(prior[1, 1]):.3g} 降到 {1e3 * np.sqrt(after[1, 1]):.3g} mm。")
    return PlaneFigure("ellipses", Text("height and vertical speed, 2σ", "高度与竖直速度，2σ 椭圆"), tuple(curves), tuple(points),
                       "z [mm]", "vz [mm/s]", (float(middle[0] - half[0]), float(middle[0] + half[0])),
                       (float(middle[1] - half[1]), float(middle[1] + half[1])), caption=said, tab=STEP_TAB)


def _step(outcome: Outcome[Study]) -> TableFigure:
    s, k = outcome.study, int(outcome.design["k"])
    plan, updated = s.watcher.schedule, outcome.design["phase"] == "update"
    at = int(plan.index[k])
    mean, P = (s.track.means[k], plan.posterior[at]) if updated else (s.track.predicted[k], plan.prior[at])
    rows = tuple((f"{name} [{unit}]", f"{1e3 * s.truth.x[k, i]:.3f}".replace("-", "−"), f"{1e3 * mean[i]:.3f}".replace("-", "−"),
                  f"{1e3 * np.sqrt(P[i, i]):.3f}") for i, (name, unit) in enumerate(STATES))
    return TableFigure("step", Text(f"sample {k}", f"第 {k} 个采样"),
                       (Text("state", "状态"), Text("true", "真实"), Text("estimate", "估计"), same("σ")), rows, tab=STEP_TAB,
                       caption=Text(f"t = {k * DT:.2f} s; NIS of this sample {s.nis[k]:.2f}.",
                                    f"t = {k * DT:.2f} s；这次采样的 NIS 为 {s.nis[k]:.2f}。"))


def _state(outcome: Outcome[Study], name: str, title: Text, i: int, unit: str) -> LineFigure:
    s = outcome.study
    spread, mean, e = 2e3 * np.sqrt(s.track.variances[:, i]), 1e3 * s.track.means[:, i], s.truth.x[:, i] - s.track.means[:, i]
    inside = 100 * float(np.mean(1e3 * np.abs(e[SKIP:]) <= spread[SKIP:]))
    return LineFigure(name, title, _time(outcome),
                      (Curve(Text("true", "真实"), 1e3 * s.truth.x[:, i]), Curve(Text("estimate", "估计"), mean, "estimate", "dash"),
                       Curve(same("+ 2σ"), mean + spread, "muted", "dot", 1.2), Curve(same("− 2σ"), mean - spread, "muted", "dot", 1.2)),
                      f"[{unit}]", window=(-10.0, 10.0), tab=TIME_TAB,
                      caption=Text(f"After 2 s the truth is within the filter's own 2σ for {inside:.0f} % of the time; 95 % are expected.",
                                   f"2 s 以后，真实值有 {inside:.0f} % 的时间落在滤波器自报的 2σ 之内；应为 95 %。"))


def _height(outcome: Outcome[Study]) -> LineFigure:
    return _state(outcome, "height", Text("height of the deck z", "平台高度 z"), 1, "mm")


def _pitch(outcome: Outcome[Study]) -> LineFigure:
    return _state(outcome, "pitch", Text("pitch of the deck θ", "平台俯仰角 θ"), 2, "mrad")


# --- gain ------------------------------------------------------------------------------------------------------------
def _gain(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    M, goal = s.track.gains[:100], s.watcher.steady.filter_gain
    shown = ((4, 0, "vz ← VL", "estimate"), (1, 0, "z ← VL", "force"), (3, 1, "vx ← HL", "second"))
    curves = [curve for i, j, name, role in shown for curve in (
        Curve(same(name), M[:, i, j], role), Curve(same(f"{name} ∞"), np.full(100, goal[i, j]), "reference", "dot", 1.2))]
    return LineFigure("gain", Text("entries of the gain M", "增益 M 的元素"), _time(outcome)[:100], tuple(curves), "M", tab=GAIN_TAB,
                      window=(-0.1, 0.6), caption=Text("Dotted: the gain that the Riccati equation promises for ever.",
                                                       "点线：Riccati 方程给出的稳态增益。"))


def _distance(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    goal = s.watcher.steady.filter_gain
    away = np.abs(s.track.gains - goal).max(axis=(1, 2)) / np.abs(goal).max()
    late = np.flatnonzero(away > 0.01)
    after = DT * (late[-1] + 1) if len(late) else 0.0
    return LineFigure("distance", Text("distance to the Riccati gain", "与 Riccati 增益的距离"), _time(outcome),
                      (Curve(Text("relative distance", "相对距离"), np.maximum(away, 1e-12), "error"),), "‖M − M∞‖ / ‖M∞‖",
                      log_y=True, window=(1e-10, 1.0), tab=GAIN_TAB,
                      caption=Text(f"Within 1 % after {after:.2f} s. No reading has any part in this.",
                                   f"{after:.2f} s 后相差不到 1 %。这与任何读数都无关。"))


def _forms(outcome: Outcome[Study]) -> LineFigure:
    f, m = outcome.study.forms, outcome.metrics
    single = outcome.design["arithmetic"] == "single"
    lost = (Text("; neither is a covariance any more.", "；两者都已不再是协方差。") if m["joseph_least"] < 0 else
            Text("; the short form is no covariance any more.", "；简短形式已不再是协方差。") if m["short_least"] < 0 else
            Text(".", "。"))
    said = (Text(f"Single precision: the short form is off by up to {m['short_gap']:.1e}, Joseph's by {m['joseph_gap']:.1e}{lost.en}",
                 f"单精度：简短形式最多偏差 {m['short_gap']:.1e}，Joseph 形式 {m['joseph_gap']:.1e}{lost.zh}") if single else
            Text(f"With the final gain from the start the short form is wrong by up to {m['short_gap']:.1e}; Joseph's is right for "
                 "every gain.",
                 f"从一开始就用稳态增益时，简短形式最多偏差 {m['short_gap']:.1e}；Joseph 形式对任何增益都正确。"))
    return LineFigure("forms", Text("two updates of P, distance to the right one", "P 的两种更新：与正确值的距离"), _time(outcome)[:STEPS],
                      (Curve(Text("short form", "简短形式"), np.maximum(f.short, 1e-12), "error"),
                       Curve(Text("Joseph's form", "Joseph 形式"), np.maximum(f.joseph, 1e-12), "force", "dash")), "‖ΔP‖ / ‖P‖", log_y=True,
                      window=(1e-9, 1.0), caption=said, tab=GAIN_TAB)


# --- innovations -------------------------------------------------------------------------------------------------------
def _innovation(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    spread, nu = 2e3 * np.sqrt(s.track.S[:, 0, 0]), 1e3 * s.track.innovations[:, 0]
    inside = 100 * float(np.mean(np.abs(nu[SKIP:]) <= spread[SKIP:]))
    return LineFigure("innovation", Text("innovation of sensor VL", "传感器 VL 的新息"), _time(outcome),
                      (Curve(same("ν"), nu, "error", width=1.4), Curve(same("+ 2√S"), spread, "muted", "dot", 1.4),
                       Curve(same("− 2√S"), -spread, "muted", "dot", 1.4)), "ν [mm/s]", window=(-5.0, 5.0), tab=INNOVATION_TAB,
                      caption=Text(f"After 2 s, {inside:.0f} % within 2√S; mean {s.test.scores[0]:+.2f} of its σ.",
                                   f"2 s 以后 {inside:.0f} % 在 2√S 之内；均值为其标准差的 {s.test.scores[0]:+.2f} 倍。"))


def _correlation(outcome: Outcome[Study]) -> PlaneFigure:
    w = outcome.study.test.whiteness
    lags = np.arange(1, len(w.correlation) + 1, dtype=float)
    dashes = (("VL", "estimate", "solid"), ("HL", "second", "solid"), ("VR", "disturbance", "dash"), ("HR", "plant", "dash"))
    curves = [Curve(same(name), w.correlation[:, i], role, dash, 1.8, lags)  # type: ignore[arg-type]
              for i, (name, role, dash) in enumerate(dashes)]
    ends = np.array([lags[0], lags[-1]])
    curves += [Curve(Text("band", "带"), np.full(2, sign * w.band), "reference", "dot", 1.2, ends) for sign in (1, -1)]
    said = (Text(f"White as far as one can tell: p = {w.p_value:.2g}.", f"看不出颜色：p = {w.p_value:.2g}。") if w.white else
            Text(f"Coloured: p = {w.p_value:.1e}; each sample foretells the next.", f"有色：p = {w.p_value:.1e}；前一个新息能预示后一个。"))
    return PlaneFigure("correlation", Text("autocorrelation of the innovations over lag k", "新息的自相关（滞后 k）"), tuple(curves), (),
                       "k", "r", (0.0, float(lags[-1] + 1)), (-0.6, 1.0), caption=said, tab=INNOVATION_TAB)


def _squares(outcome: Outcome[Study], name: str, title: Text, dof: int, values: np.ndarray, tried: np.ndarray | None) -> LineFigure:
    trials = outcome.study.trials
    count = 1 if trials is None else trials.count
    low, high = chi2_band(dof, count=count)
    shown, n = values if tried is None else tried, len(values)
    inside = 100 * float(np.mean((shown[SKIP:] >= low) & (shown[SKIP:] <= high)))
    who = Text("One run", "单次运行") if trials is None else Text(f"Mean of {count} runs", f"{count} 次运行的平均")
    return LineFigure(name, title, _time(outcome),
                      (Curve(Text(who.en.lower(), who.zh), np.maximum(shown, 1e-3), "error", width=1.4),
                       Curve(Text(f"expected, {dof}", f"期望值 {dof}"), np.full(n, float(dof)), "reference", "dash", 1.4),
                       Curve(Text("95 % band", "95 % 带"), np.full(n, high), "muted", "dot", 1.4),
                       Curve(Text("lower edge", "下沿"), np.full(n, low), "muted", "dot", 1.4)),
                      name.upper(), log_y=True, window=(0.1, 100.0), tab=TEST_TAB,
                      caption=Text(f"{who.en}: after 2 s, {inside:.0f} % of the samples lie in the χ² band [{low:.3g}, {high:.3g}].",
                                   f"{who.zh}：2 s 以后 {inside:.0f} % 的采样在 χ² 带 [{low:.3g}, {high:.3g}] 内。"))


def _nis(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    return _squares(outcome, "nis", Text("NIS of a sample of four readings", "每次采样（四个读数）的 NIS"), 4, s.nis,
                    None if s.trials is None else s.trials.nis)


def _nees(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    return _squares(outcome, "nees", Text("NEES, six states", "NEES（六个状态）"), 6, s.nees, None if s.trials is None else s.trials.nees)


def _tests(outcome: Outcome[Study]) -> TableFigure:
    m, held = outcome.metrics, {c.id: c.holds for c in outcome.checks}

    def verdict(name: str) -> Text:
        return Text("passes", "通过") if held[name] else Text("flagged", "报警")

    rows = (
        (Text("mean of NIS", "NIS 均值"), f"{m['nis_mean']:.3f}", f"{m['nis_low']:.3f} … {m['nis_high']:.3f}", verdict("nis")),
        (Text("mean of NEES", "NEES 均值"), f"{m['nees_mean']:.3g}", f"{m['nees_low']:.3g} … {m['nees_high']:.3g}", verdict("nees")),
        (Text("whiteness, p", "白性 p 值"), f"{m['white_p']:.2g}", "≥ 0.017", verdict("white")),
        (Text("bias, p", "偏差 p 值"), f"{m['bias_p']:.2g}", "≥ 0.017", verdict("centred")),
    )
    return TableFigure("tests", Text("tests after 2 s", "2 s 以后的检验"),
                       (Text("test", "检验"), Text("value", "数值"), Text("band", "范围"), Text("verdict", "结论")), rows, tab=TEST_TAB,
                       caption=_verdict(outcome, all(held[name] for name in ("nis", "nees", "white", "centred"))))


def _verdict(outcome: Outcome[Study], quiet: bool) -> Text:
    """What the tests of one record mean: a right filter is flagged now and then, and a wrong one may pass."""
    d = outcome.design
    right = expected(d["noise"], d["q"], d["r"]).right
    if quiet:
        return (Text("No test flags this filter.", "没有检验对该滤波器报警。") if right else
                Text("No test flags this record, yet over all records this filter is found out.",
                     "本次记录没有报警，但对全体记录而言，这个滤波器会被识破。"))
    return (Text("Flagged by chance: each test flags a right filter in a few records of a hundred.",
                 "偶然报警：即使滤波器完全正确，每项检验也会在百次记录中误报几次。") if right else
            Text("Over all records, too, this filter is wrong about itself.", "对全体记录而言，该滤波器对自身的判断也有误。"))


# --- spectra -----------------------------------------------------------------------------------------------------------
def _tracking(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    clean = s.truth.clean[SKIP:, 0]
    guess = s.track.means[SKIP:, :6] @ s.watcher.filter.C[0, :6]
    both = psd(1e3 * np.column_stack([clean, clean - guess]), 1 / DT, segment=len(clean))
    f, floor = both.frequency[1:], np.maximum(both.density[1:], 1e-9)
    near = int(np.argmin(np.abs(f - 0.16)))
    drop = 10 * np.log10(floor[near, 0] / floor[near, 1])
    said = (Text(f"At 0.16 Hz the error lies {drop:.0f} dB below the output.", f"在 0.16 Hz 处，误差比输出低 {drop:.0f} dB。")
            if drop >= 0 else
            Text(f"At 0.16 Hz the error lies {-drop:.0f} dB above the output.", f"在 0.16 Hz 处，误差比输出高 {-drop:.0f} dB。"))
    return over_frequency("tracking", Text("output VL and its error", "输出 VL 及其误差"), f,
                          (Curve(Text("true output", "真实输出"), floor[:, 0]),
                           Curve(Text("output error", "输出误差"), floor[:, 1], "error", "dash")), "(mm/s)²/Hz", tab=SPECTRUM_TAB,
                          window=(1e-4, 1e3), caption=said)


def _colour(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    seen = psd(1e3 * s.track.innovations[SKIP:, 0], 1 / DT, segment=64)
    f, promised = seen.frequency[1:], 2e6 * DT * float(s.track.S[-1, 0, 0])
    carried = outcome.design["noise"] == CARRIED
    low, high = (float(np.mean(seen.density[1:][part])) for part in (f < 3.0, f > 6.0))
    said = Text(f"Below 3 Hz {low / high:.2g} times as dense as above 6 Hz; white noise is flat.",
                f"3 Hz 以下的密度是 6 Hz 以上的 {low / high:.2g} 倍；白噪声应当平坦。")
    if carried:
        said = Text(said.en + " The converter's noise is carried as 16 states.", said.zh + "ADC 噪声由 16 个状态承担。")
    return over_frequency("colour", Text("spectrum of the innovation of VL", "VL 新息的频谱"), f,
                          (Curve(Text("seen", "实测"), np.maximum(seen.density[1:], 1e-9), "error"),
                           Curve(Text("promised by S", "S 给出的值"), np.full(len(f), promised), "reference", "dash", 1.4)),
                          "(mm/s)²/Hz", window=(1e-2, 10.0), caption=said, tab=SPECTRUM_TAB)


PRINTED_MEAN, PRINTED_SIGMA, PRINTED_SAMPLES = 5.46e-10, 1e-9, 20_000  # (61), (77), 20 s at 1 kHz as assumed here


def report_figure(outcome: Outcome[Study]) -> TableFigure:
    """The lines one by one; the chosen one with its evidence."""
    m, chosen = outcome.metrics, outcome.design["line"]
    sigmas = PRINTED_MEAN / (PRINTED_SIGMA / np.sqrt(PRINTED_SAMPLES))
    evidence = {
        GAIN: Text("holds: S = C P Cᵀ + R", "成立：S = C P Cᵀ + R"),
        JOSEPH: Text("holds: right for every gain", "成立：对任何增益都正确"),
        SHORT: Text(f"exact for the optimal gain only, against (59)'s advice; off by up to {m['short_gap']:.1e} here, "
                    f"Joseph {m['joseph_gap']:.1e}",
                    f"只对最优增益成立，与 (59) 的建议相悖；此处最多偏差 {m['short_gap']:.1e}，Joseph 为 {m['joseph_gap']:.1e}"),
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
            Text("This line goes against what the report advises.", "这一行与报告自己的建议相悖。") if chosen == SHORT else
            Text("This line is a slip.", "这一行有误。") if chosen in SLIPS else Text("This line holds.", "这一行成立。"))
    return TableFigure("report", Text("lines of the report", "报告中的若干行"),
                       (Text("line", "行"), Text("printed", "所印"), Text("this filter says", "本滤波器的检验")), rows, said,
                       Text("Report", "报告"))
