"""The Kalman filter on a person's own plant: one step at a time, its gain, its innovations, and what it believes wrongly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from app.engine import chi2_band, innovation_test, nees, nis
from app.engine.filters import FilterTrial, InnovationTest, SquaredError, simulate_filter
from app.lesson.figures import Curve, Figure, LineFigure, PlaneFigure, TableFigure
from app.lesson.knobs import Choice, Knob, KnobError, Number
from app.lesson.lesson import Check, Design, Formula, Job, Lesson, Outcome, Stage
from app.plants import Model, Signal
from app.plants.names import called, with_unit
from app.text.words import Text, same, symbol

from ..toolkit.figures import TIME_TAB
from ..toolkit.gains import noise_units
from ..toolkit.knobs import run_knobs
from ..toolkit.latex import gain_words, number
from .figures import GAIN_TAB, INNOVATION_TAB, STEP_TAB, TEST_TAB
from .job import RUNS
from .knobs import PREDICT, UPDATE
from .study import Trials

SAMPLES, SKIP, LAST = 160, 40, 60
MOST_STATES = 10  # rows of the table of one step
AT_ONCE = 2


@dataclass(frozen=True, eq=False)
class Study:
    """One record through one filter, and what judges it."""

    found: FilterTrial
    test: InnovationTest
    settled: SquaredError
    nis: np.ndarray
    nees: np.ndarray
    trials: Trials | None = None


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """Beliefs, true noises in the plant's own measures, and the step to look at."""
    return (
        Number("q", "q", Text("believed Q / true Q", "Q 的设定值 / 真值"), low=0.01, high=100.0, default=0.05, scale="log",
               hint=Text("Below 1 the filter trusts its model too much.", "小于 1：滤波器过于相信模型。")),
        Number("r", "r", Text("believed R / true R", "R 的设定值 / 真值"), low=0.01, high=100.0, default=1.0, scale="log",
               hint=Text("Below 1 the filter trusts its sensors too much.", "小于 1：滤波器过于相信传感器。")),
        Number("w", r"\sigma_w", Text("process noise, share of the natural input", "过程噪声（占自然输入的比例）"), low=1e-3, high=10.0,
               default=0.1, scale="log", hint=Text("How strongly an unknown input shakes the plant.", "未知输入对对象扰动的强度。")),
        Number("v", r"\sigma_v", Text("sensor noise, share of the outputs", "测量噪声（占初始输出的比例）"), low=1e-4, high=1.0,
               default=0.003,
               scale="log", hint=Text("As a share of the outputs at the start.", "以初始输出为单位。")),
        Number("k", "k", Text("sample to look at", "查看第几个采样"), low=1, high=LAST, default=1, scale="integer",
               hint=Text("The tab One step shows this sample.", "“一步”标签页显示这一采样。")),
        Choice("phase", "", Text("the step", "步骤"), default=PREDICT,
               options=((PREDICT, Text("predict", "预测")), (UPDATE, Text("predict and update", "预测并更新"))),
               hint=Text("Before or after the sample is taken in.", "采样纳入之前或之后。")),
        *run_knobs(model.horizon),
    )


def tried(model: Model, design: Design, seed: int) -> FilterTrial:
    """The filter of a design on the record of a seed. Raises EngineError where there is no filter."""
    G, W, V = noise_units(model)
    kick = (design["kick"], np.array(model.kick)) if design["kick"] >= 0 else None
    found = simulate_filter(model.plant, G, design["w"] ** 2 * W, design["v"] ** 2 * V, model.horizon / SAMPLES,
                            SAMPLES,
                         believed=(design["q"], design["r"]), seed=seed, kick=kick)
    if len(found.run.t) < 2 * SKIP:
        raise KnobError(Text("The plant runs away before the filter can be judged.", "在能评判滤波器之前，对象已经发散。"))
    return found


def compute(model: Model, design: Design) -> Outcome[Study]:
    """The record filtered and judged."""
    study = _judged(tried(model, design, int(design["seed"])))
    found, p, n = study.found, model.plant.p, model.plant.n
    metrics = {
        "nis_mean": study.test.nis.mean, "nis_expected": found.expected, "nees_mean": study.settled.mean,
        "white_p": study.test.whiteness.p_value, "gain_gap": float(found.distance[-1]), "riccati_residual": found.steady.residual}
    failed = study.test.failures
    checks = (
        Check("centred", Text("innovations have no bias", "新息无偏"), "biased" not in failed, study.test.bias_p_value),
        Check("white", Text("innovations are white", "新息为白噪声"), "coloured" not in failed, metrics["white_p"]),
        Check("nis", Text("NIS lies in its band", "NIS 在带内"), study.test.nis.verdict == "consistent", metrics["nis_mean"]),
        Check("nees", Text("NEES lies in its band", "NEES 在带内"), study.settled.verdict == "consistent", metrics["nees_mean"]),
        Check("riccati", Text("the gain has reached the Riccati solution", "增益已收敛到 Riccati 方程的解"), metrics["gain_gap"] < 1e-3,
              metrics["gain_gap"]))
    k, at = int(design["k"]), int(found.track.schedule.index[int(design["k"])])
    formulas = [Formula("M", gain_words(rf"M_{{{k}}}", found.track.schedule.gains[at]))]
    if design["phase"] == UPDATE:
        formulas.append(Formula("nis", rf"\mathrm{{NIS}}_{{{k}}} = \nu^{{\mathsf T}} S^{{-1}} \nu = {number(float(study.nis[k]))}"))
    live = Text(f"NIS {metrics['nis_mean']:.3g} in this record, {found.expected:.3g} on average ({p} expected); NEES "
                f"{metrics['nees_mean']:.3g} ({n} expected).",
                f"本次记录 NIS 均值 {metrics['nis_mean']:.3g}，平均应为 {found.expected:.3g}（调好时为 {p}）；NEES "
                f"{metrics['nees_mean']:.3g}（调好时为 {n}）。")
    stage = Stage(model.body, found.run.t, found.run.x, found.track.means, found.run.u_applied)
    poles = np.log(np.where(np.abs(found.steady.poles) > 1e-12, found.steady.poles, 1e-12)) * SAMPLES / model.horizon
    return Outcome(design, {"M": found.track.schedule.gains[-1], "M_riccati": found.steady.filter_gain}, {"filter": poles}, metrics, checks,
                   None, (), stage, tuple(formulas), live, study)


def _judged(found: FilterTrial) -> Study:
    track, x = found.track, found.run.x
    P, S = track.covariances, track.S
    tests = innovation_test(track.innovations[SKIP:], S[SKIP:])
    settled, first = nees(x[SKIP:], track.means[SKIP:], _solid(P[SKIP:])), nees(x[:SKIP], track.means[:SKIP], _solid(P[:SKIP]))
    early = nis(track.innovations[:SKIP], S[:SKIP])
    return Study(found, tests, settled, np.concatenate([early.values, tests.nis.values]), np.concatenate([first.values, settled.values]))


def _solid(P: np.ndarray) -> np.ndarray:
    """Covariances with a floor of 1e-9 of each variance: a state known exactly has no NEES."""
    spread = np.maximum(np.diagonal(P, axis1=1, axis2=2), 1e-300)
    return P + 1e-9 * spread[:, :, None] * np.eye(P.shape[1])


# --- figures -----------------------------------------------------------------------------------------------------------
def figures(model: Model, outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """One step; two signals; the gain; innovations; consistency."""
    second = next((s for s in model.watched if s.name.en.startswith("state")), model.watched[-1])
    return (_step(model, outcome), _state(outcome, "height", model.watched[0]), _state(outcome, "pitch", second), _gain(outcome),
            _distance(outcome), _innovation(model, outcome), _correlation(model, outcome),
            _squares(outcome, "nis", Text("NIS of a sample", "每次采样的 NIS"), model.plant.p, 0),
            _squares(outcome, "nees", Text("NEES of the states", "NEES（状态）"), model.plant.n, 1),
            _tests(outcome))


def _step(model: Model, outcome: Outcome[Study]) -> TableFigure:
    study, k, plant = outcome.study, int(outcome.design["k"]), model.plant
    track, updated = study.found.track, outcome.design["phase"] == UPDATE
    at = int(track.schedule.index[k])
    mean, P = (track.means[k], track.schedule.posterior[at]) if updated else (track.predicted[k], track.schedule.prior[at])

    def digits(value: float) -> str:
        return f"{value:.4g}".replace("-", "−")
    rows = tuple((with_unit(plant, name), digits(study.found.run.x[k, i]), digits(mean[i]),
                  digits(float(np.sqrt(max(P[i, i], 0.0))))) for i, name in enumerate(plant.state_names[:MOST_STATES]))
    return TableFigure("step", Text(f"sample {k}", f"第 {k} 个采样"),
                       (Text("state", "状态"), Text("true", "真实"), Text("estimate", "估计"), same("σ")), rows, tab=STEP_TAB,
                       caption=Text(f"t = {study.found.run.t[k]:.3g} s, {'after' if updated else 'before'} the sample is taken in; its NIS "
                                    f"{study.nis[k]:.3g}.",
                                    f"t = {study.found.run.t[k]:.3g} s，采样纳入{'之后' if updated else '之前'}；"
                                    f"其 NIS 为 {study.nis[k]:.3g}。"))


def _state(outcome: Outcome[Study], name: str, signal: Signal) -> LineFigure:
    found, row = outcome.study.found, np.array(signal.weights)
    true, mean = signal.of(found.run.x), signal.of(found.track.means)
    spread = 2 * np.sqrt(np.maximum(np.einsum("i,kij,j->k", row, found.track.covariances, row), 0.0))
    inside = 100 * float(np.mean(np.abs(true - mean)[SKIP:] <= spread[SKIP:] + 1e-300))
    return LineFigure(name, signal.name, found.run.t, (
        Curve(Text("true", "真实"), true), Curve(Text("estimate", "估计"), mean, "estimate", "dash"),
        Curve(same("+ 2σ"), mean + spread, "muted", "dot", 1.2), Curve(same("− 2σ"), mean - spread, "muted", "dot", 1.2)),
        f"[{signal.unit}]", tab=TIME_TAB, caption=Text(
            f"Once settled, the truth is within the filter's own 2σ for {inside:.0f} % of the time; 95 % are expected.",
            f"稳定之后，真实值有 {inside:.0f} % 的时间落在滤波器自报的 2σ 之内；应为 95 %。"))


def _gain(outcome: Outcome[Study]) -> LineFigure:
    found = outcome.study.found
    M, goal, count = found.track.gains, found.steady.filter_gain, min(len(found.run.t), 80)
    largest = np.argsort(np.abs(goal).ravel())[::-1][:3]
    curves = []
    for place, role in zip(largest, ("estimate", "force", "second"), strict=False):
        i, j = divmod(int(place), goal.shape[1])
        curves += [Curve(same(symbol(f"M{i + 1}{j + 1}")), M[:count, i, j], role),
                   Curve(same(symbol(f"M{i + 1}{j + 1}") + " ∞"), np.full(count, goal[i, j]), "reference", "dot", 1.2)]
    return LineFigure("gain", Text("largest entries of the gain M", "增益 M 的最大元素"), found.run.t[:count], tuple(curves),
                      "M", tab=GAIN_TAB,
                      caption=Text("Dotted: the gain that the Riccati equation promises for ever.", "点线：Riccati 方程给出的稳态增益。"))


def _distance(outcome: Outcome[Study]) -> LineFigure:
    found = outcome.study.found
    late = np.flatnonzero(found.distance > 0.01)
    after = f"{found.run.t[min(late[-1] + 1, len(found.run.t) - 1)]:.3g}" if len(late) else "0"
    return LineFigure("distance", Text("distance to the Riccati gain", "与 Riccati 增益的距离"), found.run.t,
                      (Curve(Text("relative distance", "相对距离"), np.maximum(found.distance, 1e-12), "error"),),
                      "‖M − M∞‖ / ‖M∞‖", log_y=True,
                      window=(1e-10, 1.0), tab=GAIN_TAB, caption=Text(f"Within 1 % after {after} s. No reading has any part in this.",
                                                                      f"{after} s 后相差不到 1 %。这与任何读数都无关。"))


def _innovation(model: Model, outcome: Outcome[Study]) -> LineFigure:
    found, name = outcome.study.found, model.plant.output_names[0]
    nu, spread = found.track.innovations[:, 0], 2 * np.sqrt(found.track.S[:, 0, 0])
    inside = 100 * float(np.mean(np.abs(nu[SKIP:]) <= spread[SKIP:]))
    return LineFigure("innovation", Text("innovation of {}", "{} 的新息").format(called(model.plant, name)), found.run.t, (
        Curve(same("ν"), nu, "error", width=1.4), Curve(same("+ 2√S"), spread, "muted", "dot", 1.4),
        Curve(same("− 2√S"), -spread, "muted", "dot", 1.4)), f"ν [{model.plant.unit(name)}]", tab=INNOVATION_TAB,
        caption=Text(f"Once settled, {inside:.0f} % within 2√S.", f"稳定之后 {inside:.0f} % 在 2√S 之内。"))


def _correlation(model: Model, outcome: Outcome[Study]) -> PlaneFigure:
    w = outcome.study.test.whiteness
    lags = np.arange(1, len(w.correlation) + 1, dtype=float)
    roles, ends = ("estimate", "second", "disturbance", "plant"), np.array([lags[0], lags[-1]])
    curves = [Curve(called(model.plant, name), w.correlation[:, i], roles[i % 4], "solid", 1.8, lags)
              for i, name in enumerate(model.plant.output_names[:4])]
    curves += [Curve(Text("band", "带"), np.full(2, sign * w.band), "reference", "dot", 1.2, ends) for sign in (1, -1)]
    said = (Text(f"White as far as one can tell: p = {w.p_value:.2g}.", f"看不出颜色：p = {w.p_value:.2g}。") if w.white else
            Text(f"Coloured: p = {w.p_value:.1e}; each sample foretells the next.", f"有色：p = {w.p_value:.1e}；前一个新息能预示后一个。"))
    return PlaneFigure("correlation", Text("autocorrelation of the innovations", "新息的自相关"), tuple(curves), (),
                       Text("lag [samples]", "滞后 [采样]"), "r", (0.0, float(lags[-1] + 1)), (-0.6, 1.0), caption=said, tab=INNOVATION_TAB)


def _squares(outcome: Outcome[Study], name: str, title: Text, dof: int, which: int) -> LineFigure:
    study = outcome.study
    trials = study.trials
    count, shown = ((1, (study.nis, study.nees)[which]) if trials is None else
                    (trials.count, (trials.nis, trials.nees)[which]))
    t, (low, high) = study.found.run.t[:len(shown)], chi2_band(dof, count=count)
    inside = 100 * float(np.mean((shown[SKIP:] >= low) & (shown[SKIP:] <= high)))
    who = Text("One run", "单次运行") if trials is None else Text(f"Mean of {count} runs", f"{count} 次运行的平均")
    n = len(t)
    return LineFigure(name, title, t, (
        Curve(Text(who.en.lower(), who.zh), np.maximum(shown, 1e-4), "error", width=1.4),
        Curve(Text(f"expected, {dof}", f"期望值 {dof}"), np.full(n, float(dof)), "reference", "dash", 1.4),
        Curve(Text("95 % band", "95 % 带"), np.full(n, high), "muted", "dot", 1.4),
        Curve(Text("lower edge", "下沿"), np.full(n, low), "muted", "dot", 1.4)), name.upper(), log_y=True, window=(0.05 * dof, 20.0 * dof),
        tab=TEST_TAB,
        caption=Text(f"{who.en}: once settled, {inside:.0f} % of the samples lie in the χ² band [{low:.3g}, {high:.3g}].",
                     f"{who.zh}：稳定之后 {inside:.0f} % 的采样在 χ² 带 [{low:.3g}, {high:.3g}] 内。"))


def _tests(outcome: Outcome[Study]) -> TableFigure:
    study, held = outcome.study, {c.id: c.holds for c in outcome.checks}

    def verdict(name: str) -> Text:
        return Text("passes", "通过") if held[name] else Text("flagged", "报警")
    bands = [f"{s.mean_band[0]:.3g} … {s.mean_band[1]:.3g}" for s in (study.test.nis, study.settled)]
    rows = ((Text("mean of NIS", "NIS 均值"), f"{study.test.nis.mean:.3g}", bands[0], verdict("nis")),
            (Text("mean of NEES", "NEES 均值"), f"{study.settled.mean:.3g}", bands[1], verdict("nees")),
            (Text("whiteness, p", "白性 p 值"), f"{study.test.whiteness.p_value:.2g}", "≥ 0.017", verdict("white")),
            (Text("bias, p", "偏差 p 值"), f"{study.test.bias_p_value:.2g}", "≥ 0.017", verdict("centred")))
    return TableFigure("tests", Text("tests of this record, once settled", "本次记录稳定之后的检验"),
                       (Text("test", "检验"), Text("value", "数值"), Text("band", "范围"), Text("verdict", "结论")), rows,
                       tab=TEST_TAB, caption=Text(
                           "Each test flags a right filter in a few records of a hundred.",
                           "即使滤波器完全正确，每项检验也会在百次记录中误报几次。"))


def try_often(model: Model, outcome: Outcome[Study]) -> Iterator[tuple[float, Trials]]:
    """The job: the same filter on many records; NIS and NEES averaged at each sample."""
    study, design = outcome.study, outcome.design
    sums = np.zeros((2, len(study.nis)))
    for count, seed in enumerate(np.random.SeedSequence(int(design["seed"])).generate_state(RUNS), start=1):
        other = _judged(tried(model, design, int(seed)))
        shared = min(sums.shape[1], len(other.nis))
        sums = sums[:, :shared] + np.vstack([other.nis[:shared], other.nees[:shared]])
        if count % AT_ONCE == 0:
            yield count / RUNS, Trials(count, sums[0] / count, sums[1] / count)


def shown(outcome: Outcome[Study], trials: Trials) -> Outcome[Study]:
    """The outcome with what the records showed."""
    return replace(outcome, study=replace(outcome.study, trials=trials))


def key(design: Design) -> Design:
    """What the records rest on: all but the sample that is looked at."""
    return design.with_values(k=1, phase=PREDICT)


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, where a Kalman filter for it exists; report and converter stay with the deck."""
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, model), figures=partial(figures, model), tasks=(),
                   job=Job(Text(f"Try {RUNS} runs", f"试验 {RUNS} 次"), partial(try_often, model), key, shown))
