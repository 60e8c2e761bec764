"""Kalman: how a filter knows what to trust, one step at a time, and how it is found out when it believes wrongly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from app.engine import innovation_test, nees, nis
from app.engine.filters import InnovationTest, SquaredError, Track
from app.lesson.knobs import Choice, Number
from app.lesson.lesson import Check, Design, Formula, Job, Lesson, Outcome, Stage
from app.lesson.prose import read_prose
from app.plants import Model
from app.plants.deck_body import GAIN
from app.plants.deck_body import STAGE as SCALE_OF_STAGE
from app.text.words import Text

from ..toolkit.knobs import run_knobs
from ..toolkit.latex import matrix, number
from .filters import (
    CARRIED,
    COLOURED,
    DT,
    HORIZON,
    MODEL,
    SKIP,
    WHITE,
    Forms,
    Truth,
    Watcher,
    compare,
    draw,
    truth,
    watch,
    watcher,
)
from .pictures import all_figures
from .report import LINES, NONE
from .tasks import TASKS, exam

PREDICT, UPDATE = "predict", "update"
SINGLE, FROZEN = "single", "frozen"
LAST = 60  # the latest sample that can be looked at step by step
RUNS, AT_ONCE = 100, 4
VIEWS = ("k", "phase", "arithmetic", "line")  # knobs that change no run


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
    _belief("r", "r", Text("believed R / true R", "R 的设定值 / 真值"), 1.55, 100.0,
            Text("Below 1 the filter trusts its sensors too much.", "小于 1：滤波器过于相信传感器。")),
    _belief("p0", "p_0", Text("believed / true P(0)", "P(0) 的设定值 / 真值"), 1.0, 1e4,
            Text("How unsure the filter is before the first reading.", "第一次读数之前滤波器有多不确定。")),
    Number("k", "k", Text("sample to look at", "查看第几个采样"), low=1, high=LAST, default=1, scale="integer",
           hint=Text("The tab One step shows this sample.", "“一步”标签页显示这一采样。")),
    Choice("phase", "", Text("the step", "步骤"), default=PREDICT,
           options=((PREDICT, Text("predict", "预测")), (UPDATE, Text("predict and update", "预测并更新"))),
           hint=Text("Before or after the reading is taken in.", "读数纳入之前或之后。")),
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


@dataclass(frozen=True, eq=False)
class Trials:
    """Means over `count` runs of NIS and NEES at each sample (n_t,)."""

    count: int
    nis: np.ndarray
    nees: np.ndarray


@dataclass(frozen=True, eq=False)
class Study:
    """One record through one filter, and all that judges it. `nis` and `nees` are of the whole record."""

    truth: Truth
    watcher: Watcher
    track: Track
    test: InnovationTest
    settled: SquaredError
    nis: np.ndarray
    nees: np.ndarray
    forms: Forms
    trials: Trials | None = None


def compute(design: Design) -> Outcome:
    """The deck, the filter with its beliefs, the record filtered and judged."""
    what = truth(int(design["seed"]), design["noise"] != WHITE, design["force"], design["kick"])
    who = watcher(design["noise"], design["q"], design["r"], design["p0"])
    track = watch(who, what)
    settled = nees(what.x[SKIP:], track.means[SKIP:, :6], track.covariances[SKIP:, :6, :6], independent=who.independent)
    first = nees(what.x[:SKIP], track.means[:SKIP, :6], track.covariances[:SKIP, :6, :6])
    test = innovation_test(track.innovations[SKIP:], track.S[SKIP:])
    early = nis(track.innovations[:SKIP], track.S[:SKIP])
    study = Study(what, who, track, test, settled, np.concatenate([early.values, test.nis.values]),
                  np.concatenate([first.values, settled.values]),
                  compare(design["q"], design["r"], design["p0"], design["arithmetic"] == SINGLE))
    metrics = _metrics(study)
    t = DT * np.arange(len(what.x))
    spread = 3 * SCALE_OF_STAGE * GAIN * np.sqrt(track.variances[:, 1])
    return Outcome(design, {"M": track.schedule.gains[-1], "M_riccati": who.steady.filter_gain},
                   {"filter": np.log(who.steady.poles.astype(complex)) / DT}, metrics, _checks(study, metrics), None, (),
                   Stage(MODEL.body, t, what.x, track.means[:, :6], what.u, spread), _formulas(design, study),
                   _live(study), study)


def _metrics(s: Study) -> dict[str, float]:
    M, last = s.watcher.steady.filter_gain, s.watcher.schedule.gains[-1]
    quiet = s.watcher.filter.R[0, 0]
    return {
        "nis_mean": s.test.nis.mean, "nis_low": s.test.nis.mean_band[0], "nis_high": s.test.nis.mean_band[1],
        "nees_mean": s.settled.mean, "nees_low": s.settled.mean_band[0], "nees_high": s.settled.mean_band[1],
        "white_p": s.test.whiteness.p_value, "bias_p": s.test.bias_p_value, "failures": float(len(s.test.failures)),
        "gain_gap": float(np.abs(last - M).max() / np.abs(M).max()), "riccati_residual": s.watcher.steady.residual,
        "S_over_R": float(s.watcher.schedule.S[-1][0, 0] / quiet),
        "seen_over_R": float(np.var(s.track.innovations[SKIP:, 0]) / quiet),
        "short_gap": float(s.forms.short.max()), "joseph_gap": float(s.forms.joseph.max()),
        "short_least": s.forms.least_short, "joseph_least": s.forms.least_joseph,
    }


def _checks(s: Study, m: dict[str, float]) -> tuple[Check, ...]:
    failed = s.test.failures
    return (
        Check("centred", Text("innovations have no bias", "新息无偏"), "biased" not in failed, m["bias_p"]),
        Check("white", Text("innovations are white", "新息为白噪声"), "coloured" not in failed, m["white_p"]),
        Check("nis", Text("NIS lies in its band", "NIS 在带内"), s.test.nis.verdict == "consistent", m["nis_mean"]),
        Check("nees", Text("NEES lies in its band", "NEES 在带内"), s.settled.verdict == "consistent", m["nees_mean"]),
        Check("riccati", Text("the gain has reached the Riccati solution", "增益已收敛到 Riccati 方程的解"), m["gain_gap"] < 1e-3,
              m["gain_gap"]),
    )


def _formulas(design: Design, s: Study) -> tuple[Formula, ...]:
    k = int(design["k"])
    at = int(s.watcher.schedule.index[k])
    pick = np.ix_([1, 4], [1, 4])
    prior, after = (1e6 * P[at][pick] for P in (s.watcher.schedule.prior, s.watcher.schedule.posterior))
    out = [Formula("predict", rf"P_{{{k}|{k - 1}}}^{{(z,v_z)}} = {matrix(prior)}",
                   Text("in mm², mm²/s, mm²/s²", "单位 mm²、mm²/s、mm²/s²"))]
    if design["phase"] == UPDATE:
        S, M = s.watcher.schedule.S[at], s.watcher.schedule.gains[at]
        out += [Formula("S", rf"S_{{VL}} = {number(1e6 * S[0, 0])}, \quad R = {number(1e6 * s.watcher.filter.R[0, 0])}"),
                Formula("M", rf"M_{{v_z}} = {matrix(M[4:5])}"),
                Formula("update", rf"P_{{{k}|{k}}}^{{(z,v_z)}} = {matrix(after)}")]
    return (*out, Formula("nis", rf"\mathrm{{NIS}}_{{{k}}} = \nu^{{\mathsf T}} S^{{-1}} \nu = {number(float(s.nis[k]))}"))


WORDS = (("biased", ("a bias", "有偏")), ("coloured", ("colour in the innovations", "新息有色")),
         ("overconfident", ("NIS too large", "NIS 偏大")), ("cautious", ("NIS too small", "NIS 偏小")))


def _live(s: Study) -> Text:
    found = [words for name, words in WORDS if name in s.test.failures]
    if s.settled.verdict != "consistent":
        large = s.settled.verdict == "overconfident"
        found.append(("NEES too large", "NEES 偏大") if large else ("NEES too small", "NEES 偏小"))
    head = Text(f"NIS {s.test.nis.mean:.2f} (4 expected), NEES {s.settled.mean:.3g} (6 expected).",
                f"NIS 均值 {s.test.nis.mean:.2f}（应为 4），NEES 均值 {s.settled.mean:.3g}（应为 6）。")
    tail = (Text(" Nothing is flagged.", " 没有任何检验报警。") if not found else
            Text(f" Flagged: {', '.join(w[0] for w in found)}.", f" 报警：{'、'.join(w[1] for w in found)}。"))
    return Text(head.en + tail.en, head.zh + tail.zh)


# --- many runs -------------------------------------------------------------------------------------------------------
def try_often(outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
    """The job: the same filter on many drawn runs; NIS and NEES averaged at each sample."""
    d, who = outcome.design, outcome.study.watcher
    seeds = np.random.SeedSequence(int(d["seed"])).generate_state(RUNS)
    squares = np.zeros((2, len(outcome.study.nis)))
    for count, seed in enumerate(seeds, start=1):
        what = draw(int(seed), d["noise"] != WHITE, d["force"], d["kick"])
        track = watch(who, what)
        squares[0] += nis(track.innovations, track.S).values
        squares[1] += nees(what.x, track.means[:, :6], track.covariances[:, :6, :6]).values
        if count % AT_ONCE == 0:
            outcome = _with(outcome, Trials(count, squares[0] / count, squares[1] / count))
            yield count / RUNS, outcome


def _with(outcome: Outcome, trials: Trials) -> Outcome:
    metrics = {**outcome.metrics, "trials": float(trials.count), "trials_nis": float(trials.nis[SKIP:].mean()),
               "trials_nees": float(trials.nees[SKIP:].mean())}
    return replace(outcome, study=replace(outcome.study, trials=trials), metrics=metrics)


def carry(before: Outcome, after: Outcome) -> Outcome:
    """The runs go over where only what is looked at has changed."""
    old, new = before.study.trials, after.study.trials
    if old is None or not before.design.same_but_for(after.design, VIEWS) or (new is not None and new.count >= old.count):
        return after
    return _with(after, old)


def adapt(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant."""
    from .own import adapted

    return adapted(lesson, model)


LESSON = Lesson(
    "kalman", 9, KNOBS, compute, all_figures, answer=2, tasks=TASKS, exam=exam,
    source="Platform report (003), chapter 4: equations (52)–(63), (68)–(70), Algorithm 1, figures 9–11",
    words=read_prose(Path(__file__).parent), job=Job(Text(f"Try {RUNS} runs", f"试验 {RUNS} 次"), try_often), carry=carry, adapt=adapt)

__all__ = ["LESSON"]
