"""Virtual sensor: the core that nobody can touch. An open-loop copy of the chip beside a Luenberger observer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from app.engine import Plant, Scenario, observer_gain, simulate
from app.engine.simulation import Run
from app.lesson.figures import Curve, Figure, PlaneFigure, Point, TimeFigure
from app.lesson.knobs import Choice, Number, Poles
from app.lesson.lesson import Board, Check, Design, Formula, Lesson, Outcome, Task
from app.lesson.prose import read_prose
from app.plants import MODELS, Model, chip
from app.text.words import Text

from ..toolkit.boards import listed, stage
from ..toolkit.figures import TIME_TAB
from ..toolkit.knobs import kicks, run_knobs
from ..toolkit.latex import matrix, number
from .tasks import HORIZON, RUNAWAY, TAME, exam, feel_the_core, lucky_copy, tame_the_runaway, wrong_fan

WINDOW = MODELS[TAME].observer_window
DT = MODELS[TAME].dt
PERIOD, IDLE = 6.0, 0.25  # s of a burst of work and the rest after it; share of the power at rest
MOST_TRUST = 2.0
KNOWN = 1.0  # K: a core error below this counts as known
ERROR_TAB = Text("Error", "误差")
TRUST_TAB = Text("Trust", "信任")
TRUE, COPY, OBSERVER = Text("true", "真实"), Text("open-loop copy", "开环副本"), Text("observer", "观测器")

KNOBS = (
    Choice("plant", "", Text("chip", "芯片"), default=TAME, options=(
        (TAME, Text("cools by itself", "能自行冷却")), (RUNAWAY, Text("runs away", "会热失控"))),
        hint=Text("Leakage current that grows with temperature can make the chip heat itself without end.",
                  "漏电流随温度增大，可使芯片无休止地自我加热。")),
    Number("trust", r"\theta", Text("trust in the sensor θ", "对传感器的信任 θ"), low=0.0, high=MOST_TRUST, default=1.0,
           step=0.01, hint=Text("The gain is θ times the one for the poles below; θ = 0 is the open-loop copy.",
                                "实际增益是下面极点所对应增益的 θ 倍；θ = 0 就是开环副本。")),
    Poles("observer_poles", "q", Text("Observer poles at θ = 1", "θ = 1 时的观测器极点"), "rad/s",
          default=MODELS[TAME].observer_poles, re_low=WINDOW.re_low, re_high=WINDOW.re_high, im_high=WINDOW.im_high,
          role="estimate", hint=Text("The error dies as fast as the rightmost of these; far left asks for a large gain.",
                                     "误差消失的快慢由最右边的极点决定；越靠左，需要的增益越大。")),
    Number("guess_core", r"\hat T_1(0)", Text("first guess of the core", "内核温度初始猜测"), "K", low=-40.0, high=80.0,
           default=0.0, step=1.0, hint=Text("Above ambient. The core really starts at 45 K, or 12 K if it runs away.",
                                            "相对环境温度。内核实际从 45 K 开始；热失控的芯片从 12 K 开始。")),
    Number("guess_case", r"\hat T_2(0)", Text("first guess of the case", "外壳温度初始猜测"), "K", low=-40.0, high=80.0,
           default=0.0, step=1.0, hint=Text("Above ambient. The case really starts at 20 K, or 6 K if it runs away.",
                                            "相对环境温度。外壳实际从 20 K 开始；热失控的芯片从 6 K 开始。")),
    Number("air_error", r"\delta_R", Text("case-to-air resistance wrong by", "外壳到空气的热阻误差"), "%", low=-50.0,
           high=50.0, default=0.0, step=1.0,
           hint=Text("What both models believe of the fan: positive, they think it cools worse than it does.",
                     "两个模型对风扇的看法：为正时，以为散热比实际差。")),
    Number("power", "P", Text("computing power", "计算功率"), "W", low=0.0, high=40.0, default=10.0, step=1.0,
           hint=Text("Work for 3 s, then a quarter of it for 3 s. Chip, copy and observer are all told.",
                     "满功率 3 s，再以四分之一功率 3 s。芯片、副本和观测器都知道它。")),
    Number("noise", r"\sigma", Text("sensor noise", "传感器噪声"), "K", low=0.0, high=2.0, default=0.0, step=0.05,
           hint=Text("Standard deviation of each reading, one every 30 ms.", "每 30 ms 一次读数，这是单次读数的标准差。")),
    *run_knobs(HORIZON),
)


@dataclass(frozen=True, eq=False)
class Seen:
    """What the figures need beside the observer's run: the copy's run, and how the poles move with trust."""

    copy: Run
    trusts: np.ndarray
    poles: np.ndarray  # (n_trusts, 2)


@lru_cache(maxsize=128)
def believed(plant: str, air_error: float) -> Plant:
    """The chip as the copy and the observer believe it: the resistance from case to air off by a percentage."""
    p = chip.Parameters()
    return chip.plant(replace(p, outer=p.outer * (1 + air_error / 100)), chip.LEAKAGE if plant == RUNAWAY else 0.0)


def burst(power: float) -> np.ndarray:
    """The power over the run (n_t, 1) in W: work for half a period, a quarter of it for the other half."""
    t = DT * np.arange(round(HORIZON / DT) + 1)
    return np.where(t % PERIOD < PERIOD / 2 - 1e-9, power, IDLE * power)[:, None]


def _poles_of(A: np.ndarray) -> np.ndarray:
    """Both eigenvalues of 2×2 matrices (…, 2, 2), in an order that does not jump along a path."""
    half = np.trace(A, axis1=-2, axis2=-1) / 2
    root = np.sqrt((half**2 - np.linalg.det(A)).astype(complex))
    return np.stack([half - root, half + root], axis=-1)


def _trusts(model: Plant, L: np.ndarray) -> np.ndarray:
    """Values of θ for the paths of both poles, crowded where they meet on the real axis and part from it.

    There the discriminant of det(sI − A + θLC), a parabola in θ, is zero.
    """
    at = [np.trace(M) ** 2 - 4 * np.linalg.det(M) for M in (model.A - theta * (L @ model.C) for theta in (0.0, 1.0, 2.0))]
    meet = np.roots([(at[2] - 2 * at[1] + at[0]) / 2, (4 * at[1] - at[2] - 3 * at[0]) / 2, at[0]])
    near = np.concatenate([[0.0], *(sign * np.geomspace(1e-5, 0.03, 12) for sign in (-1, 1))])
    close = (meet.real[np.abs(meet.imag) < 1e-9][:, None] + near).ravel()
    return np.unique(np.concatenate([np.linspace(0.0, MOST_TRUST, 81), close[(close > 0) & (close < MOST_TRUST)]]))


def least_trust(model: Plant, L: np.ndarray) -> float:
    """The θ above which A − θLC is stable, given that it is so at θ = 1; 0 if the plant is stable by itself.

    LC has rank one, so trace and determinant of A − θLC are straight lines in θ.
    """
    A, full = model.A, model.A - L @ model.C
    lines = ((-np.trace(A), -np.trace(full)), (np.linalg.det(A), np.linalg.det(full)))
    return float(max(0.0, *(start / (start - end) if start < 0 < end else 0.0 for start, end in lines)))


def compute(design: Design) -> Outcome:
    """The observer's gain on the believed chip, and one run each of observer and copy on the true one.

    Only the observer's run can end early, where badly chosen poles make it diverge; the copy's is the longer one.
    """
    model = MODELS[design["plant"]]
    belief = believed(design["plant"], design["air_error"])
    L_full = observer_gain(belief.A, belief.C, design["observer_poles"]).gain
    L = design["trust"] * L_full
    watched = Scenario(
        model.plant, None, L, model=belief, x0=model.x0, xhat0=(design["guess_core"], design["guess_case"]),
        horizon=HORIZON, dt=DT, reference=burst(design["power"]), V=design["noise"] ** 2 * DT if design["noise"] else None,
        impulses=kicks(design, model), seed=int(design["seed"]))
    run, copy = simulate(watched), simulate(replace(watched, L=None))
    poles, own = np.sort_complex(_poles_of(belief.A - L @ belief.C)), belief.poles
    trusts = _trusts(belief, L_full)
    seen = Seen(copy, trusts, _poles_of(belief.A - trusts[:, None, None] * (L_full @ belief.C)))
    metrics = _metrics(run, copy) | {
        "slowest_observer": float(np.max(np.real(poles))), "slowest_copy": float(np.max(np.real(own))),
        "largest_gain": float(np.max(np.abs(L))), "least_trust": least_trust(belief, L_full)}
    return Outcome(
        design, {"L": L}, {"observer": poles, "copy": own}, metrics, checks_of(metrics), run,
        _boards(design, poles, own, belief.A - L @ belief.C), stage(model, run), _formulas(belief, L, design["trust"]),
        _live(metrics, run, copy), seen)


def checks_of(metrics: dict[str, float]) -> tuple[Check, Check]:
    """Whether the error of the observer and that of the copy die out."""
    observer, copy = metrics["slowest_observer"], metrics["slowest_copy"]
    return (Check("observer", Text("the observer forgets its wrong start", "观测器能忘掉错误的初值"), observer < 0, observer),
            Check("copy", Text("the copy forgets its wrong start", "开环副本能忘掉错误的初值"), copy < 0, copy))


def _metrics(run: Run, copy: Run) -> dict[str, float]:
    core, of_copy = np.abs(run.e[:, 0]), np.abs(copy.e[:, 0])
    tail = max(len(core) // 10, 1)
    known = _known_after(run.t, core)
    return {
        "core_error": float(core[-tail:].max()), "copy_core_error": float(of_copy[-tail:].max()),
        "largest_copy_error": float(of_copy.max()), "case_error": float(np.abs(run.e[-tail:, 1]).max()),
        "known_after": HORIZON + DT if known is None else known, "largest_guess": float(np.max(np.abs(run.xhat[:, 0])))}


def _known_after(t: np.ndarray, error: np.ndarray) -> float | None:
    """From when on the core is known within KNOWN, None if it is not so at the end."""
    off = np.flatnonzero(error >= KNOWN)
    if not len(off):
        return 0.0
    return None if off[-1] == len(t) - 1 else float(t[off[-1] + 1])


def _boards(design: Design, poles: np.ndarray, own: np.ndarray, error: np.ndarray) -> tuple[Board, Board]:
    shown = listed(poles)
    by_hand = design["observer_poles"] if design["trust"] == 1.0 else shown
    return (
        Board("copy", Text("the copy's poles  eig(A)", "开环副本的极点  eig(A)"), listed(own), role="second",
              side="left", re_low=WINDOW.re_low, re_high=WINDOW.re_high, im_high=WINDOW.im_high),
        Board("observer", Text("observer poles  eig(A − LC)", "观测器极点  eig(A − LC)"), by_hand, "observer_poles",
              role="estimate", side="right", re_low=WINDOW.re_low, re_high=WINDOW.re_high, im_high=WINDOW.im_high,
              also=(("trust", 1.0),), landscape=error),
    )


def _formulas(belief: Plant, L: np.ndarray, trust: float) -> tuple[Formula, ...]:
    return (
        Formula("observer", r"\dot{\hat x} = A\hat x + Bu + L\,(y - C\hat x)"),
        Formula("L", rf"L = \theta L_1 = {matrix(L)},\quad \theta = {number(trust)}"),
        Formula("error", rf"A - LC = {matrix(belief.A - L @ belief.C)}"),
    )


def _live(m: dict[str, float], run: Run, copy: Run) -> Text:
    true, guess, other = (float(v) for v in (run.x[-1, 0], run.xhat[-1, 0], copy.xhat[len(run.t) - 1, 0]))
    doubt = (Text(" The observer's error grows: L is too small for this chip.", " 观测器误差在增长：对这块芯片来说 L 太小。")
             if m["slowest_observer"] >= 0 else Text("", ""))
    return Text(f"At the end the core is {_kelvin(true)} above ambient; the observer says {_kelvin(guess)}, the copy "
                f"{_kelvin(other)}.{doubt.en}",
                f"末刻内核比环境高 {_kelvin(true)}；观测器说 {_kelvin(guess)}，开环副本说 {_kelvin(other)}。{doubt.zh}")


def _kelvin(value: float) -> str:
    return f"{value:.1f} K".replace("-", "−")


def _at_most(value: float) -> Text:
    return (Text(f"at most {value:.2g} K", f"不超过 {value:.2g} K") if value >= 1e-3 else
            Text("less than 0.001 K", "小于 0.001 K"))


def figures(outcome: Outcome) -> tuple[Figure, ...]:
    """Core, case and power over time; the errors and what the observer hears; the poles as trust grows."""
    run, seen = outcome.run, outcome.study
    assert run is not None
    return (_core(outcome, run, seen.copy), _case(outcome, run, seen.copy), _power(run), _errors(outcome, run, seen.copy),
            _innovation(outcome, run), _locus(outcome, seen))


def _core(outcome: Outcome, run: Run, copy: Run) -> TimeFigure:
    m = outcome.metrics
    known = (Text(f"The observer knows the core within 1 K after {m['known_after']:.2f} s; ",
                  f"{m['known_after']:.2f} s 之后，观测器对内核的误差小于 1 K；") if m["known_after"] <= HORIZON else
             Text("The observer does not know the core within 1 K; ", "观测器对内核的误差没有降到 1 K 以内；"))
    off = f"{m['copy_core_error']:.2g}"
    return TimeFigure("core", Text("core temperature (nobody can measure it)", "内核温度（无法测量）"), run.t, (
        Curve(TRUE, run.x[:, 0]), Curve(COPY, copy.xhat[:len(run.t), 0], "second", "dot"),
        Curve(OBSERVER, run.xhat[:, 0], "estimate", "dash")), "T₁ [K]", tab=TIME_TAB, window=(0.0, 50.0),
        caption=Text(f"{known.en}the copy is off by up to {off} K at the end.",
                     f"{known.zh}开环副本在末段最多差 {off} K。"))


def _case(outcome: Outcome, run: Run, copy: Run) -> TimeFigure:
    gap = _at_most(outcome.metrics["case_error"])
    reading = (Curve(Text("sensor", "传感器读数"), run.y[:, 0], "muted", "solid", 1.0),) if outcome.design["noise"] else ()
    return TimeFigure("case", Text("case temperature (the sensor sits here)", "外壳温度（传感器在此）"), run.t, (
        *reading, Curve(TRUE, run.x[:, 1]), Curve(COPY, copy.xhat[:len(run.t), 1], "second", "dot"),
        Curve(OBSERVER, run.xhat[:, 1], "estimate", "dash")), "T₂ [K]", tab=TIME_TAB, window=(0.0, 25.0),
        caption=Text(f"In the last tenth of the run the observer's case is off by {gap.en}.",
                     f"最后十分之一时间里，观测器的外壳温度误差{gap.zh}。"))


def _power(run: Run) -> TimeFigure:
    peak = float(np.max(run.u_applied))
    return TimeFigure("power", Text("computing power, known to all three", "计算功率，三者都知道"), run.t,
                      (Curve(Text("power", "功率"), run.u_applied[:, 0], "force"),), "P [W]", tab=TIME_TAB,
                      window=(0.0, 20.0), caption=Text(f"Bursts of {peak:g} W; a quarter of it in between.",
                                                       f"每次突发 {peak:g} W，间歇时为其四分之一。"))


def _errors(outcome: Outcome, run: Run, copy: Run) -> TimeFigure:
    ours, theirs = outcome.metrics["slowest_observer"], outcome.metrics["slowest_copy"]
    return TimeFigure("error", Text("size of the core error", "内核温度误差的大小"), run.t, (
        Curve(COPY, np.abs(copy.e[:len(run.t), 0]), "second", "dot"), Curve(OBSERVER, np.abs(run.e[:, 0]), "error")),
        "|e₁| [K]", log=True, tab=ERROR_TAB, window=(1e-4, 100.0), caption=Text(
            f"Slowest modes: copy {_rate(theirs)}, observer {_rate(ours)} per second.",
            f"最慢的模态：副本 {_rate(theirs)}，观测器 {_rate(ours)}（每秒）。"))


def _rate(value: float) -> str:
    return f"{value:+.3g}".replace("-", "−")


def _innovation(outcome: Outcome, run: Run) -> TimeFigure:
    heard = (run.y - run.yhat)[:, 0]
    tail = _at_most(float(np.max(np.abs(heard[-max(len(heard) // 10, 1):]))))
    return TimeFigure("innovation", Text("what the observer hears: y − ŷ", "观测器听到的：y − ŷ"), run.t,
                      (Curve(Text("y − ŷ", "y − ŷ"), heard, "error"),), "y − ŷ [K]", tab=ERROR_TAB, window=(-10.0, 20.0),
                      caption=Text(f"Sensor minus prediction, {tail.en} in the last tenth of the run; L carries it "
                                   "into both states.",
                                   f"读数减预测，最后十分之一时间内{tail.zh}；L 把它送进两个状态。"))


def _locus(outcome: Outcome, seen: Seen) -> PlaneFigure:
    path = Text("path of a pole", "极点的轨迹")
    curves = tuple(Curve(path, branch.imag, "muted", width=1.6, x=branch.real) for branch in seen.poles.T)
    points = (*(Point(float(p.real), float(p.imag), "second", "circle") for p in outcome.poles["copy"]),
              *(Point(float(p.real), float(p.imag), "estimate") for p in outcome.poles["observer"]))
    least = outcome.metrics["least_trust"]
    need = (Text(f"This chip needs θ above {least:.3f}.", f"这块芯片要求 θ 大于 {least:.3f}。") if least > 0 else
            Text("This chip forgives θ = 0, slowly.", "这块芯片允许 θ = 0，只是忘得慢。"))
    return PlaneFigure("locus", Text("poles of A − θL₁C as trust grows", "A − θL₁C 的极点随 θ 的轨迹"), curves, points,
                       "Re s", "Im s", (-5.0, 1.0), (-2.2, 2.2), unstable=True, tab=TRUST_TAB, caption=Text(
                           f"Circles: θ = 0, the copy. Crosses: θ = {outcome.design['trust']:g} now. {need.en}",
                           f"圆圈：θ = 0，即开环副本。叉号：现在的 θ = {outcome.design['trust']:g}。{need.zh}"))


def adapt(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant."""
    from .own import adapted

    return adapted(lesson, model)


LESSON = Lesson(
    "virtual-sensor", 1, KNOBS, compute, figures, answer=1,
    tasks=(
        Task("feel-the-core", feel_the_core, {"observer_poles": (-3.0, -3.5)}),
        Task("tame-the-runaway", tame_the_runaway, {"plant": RUNAWAY, "trust": 0.1}),
        Task("lucky-copy", lucky_copy, {"plant": RUNAWAY, "guess_core": 12.0, "guess_case": 6.0}),
        Task("wrong-fan", wrong_fan, {"air_error": 40.0, "trust": 0.21}),
    ),
    exam=exam, source="Tutorial (000), sections on the virtual sensor and on the error's own life",
    words=read_prose(Path(__file__).parent), adapt=adapt)
