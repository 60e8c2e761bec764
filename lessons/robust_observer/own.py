"""The robust observer on a person's own plant: one wanted combination of its states, chosen poles, algorithm RLO beside."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import expm

from app.engine import (
    EngineError,
    FunctionalObserver,
    Perturbations,
    Plant,
    Region,
    RobustObserver,
    every_entry,
    functional_observer,
    observability,
    perturbations,
    rlo_steps,
    typical_rate,
)
from app.knobs import Choice, Knob, KnobError, Number, Poles
from app.lesson import Board, Check, Design, Formula, Job, Lesson, Outcome, Stage
from app.plants import Model
from app.words import Text, same

from ..toolkit import bolts, feedback, gain_words, number, pole_words
from .lesson import ERRORS, LESSON, MET, SEARCH, weight_knobs
from .loops import NORMS
from .own_pictures import DIVERGED, Run, Story, all_figures, inside

FEW = 3  # orders offered from the lowest on; the highest comes with them
NEAR = 1e-6  # poles nearer to each other than this, relative, coincide
WAVES = 3.0  # periods of v within the run
FREQUENCIES = 50
WORST_CONDITION = 1e4  # of [T; C]
NUDGES = (1e-6, 1e-5, 1e-4, 1e-3)
WHOLE = 1e8  # condition of [T; C] up to which the observer's state and y are taken for the whole state
WANTED = Text("What is wanted", "待估计的量")


@dataclass(frozen=True, eq=False)
class Scaled:
    """A plant in units of its own: states all about as large, time in 1/rate; both powers of two, so nothing is rounded.

    There polynomials keep their precision. The directions g of an observer have unit length there, which fixes the scale of T.
    """

    plant: Plant
    unit: np.ndarray  # (n,)
    rate: float
    inner: Plant

    def given(self, o: FunctionalObserver, row: np.ndarray, wrong: Perturbations) -> FunctionalObserver:
        """An observer of the inner plant as one of the plant that was given, in seconds; N and M are the same."""
        return replace(o, plant=self.plant, K=row, F=o.F * self.rate, T=o.T / self.unit, L=o.L * self.rate, poles=o.poles * self.rate,
                       wrong=wrong)

    def within(self, wrong: Perturbations) -> Perturbations:
        """Errors such that J of an inner observer is that of the given one: T Aᵢ and L Cᵢ have the same size."""
        return replace(wrong, A=wrong.A / self.unit[:, None], beta=wrong.beta * self.rate)

    def observer(self, row: np.ndarray, poles: tuple[complex, ...], wrong: Perturbations, norm: Any = 2) -> FunctionalObserver:
        """The observer of row · x with these poles, for the plant that was given."""
        found = functional_observer(self.inner, row * self.unit, len(poles), np.array(poles) / self.rate, wrong=self.within(wrong),
                                    norm=norm)
        return self.given(found, row, wrong)


def scaled(model: Model) -> Scaled:
    """The plant with units from its typical start and its typical rate."""
    plant = model.plant
    unit = 2.0 ** np.round(np.log2(np.maximum(np.abs(np.array(model.x0)), 1e-300)))
    rate = float(2.0 ** np.round(np.log2(typical_rate(plant))))
    return Scaled(plant, unit, rate, Plant(plant.A * unit / unit[:, None] / rate, plant.B / unit[:, None] / rate, plant.C * unit, plant.D))


@dataclass(frozen=True, eq=False)
class Here:
    """A plant, what may be wanted of it (name → input or state), and the poles to start from for every order offered."""

    model: Model
    wanted: tuple[tuple[str, Text], ...]
    starts: tuple[tuple[int, tuple[complex, ...]], ...]
    entries: Perturbations
    highest: int
    scaled: Scaled

    @property
    def plant(self) -> Plant:
        return self.model.plant


# --- does it fit? --------------------------------------------------------------------------------------------------
def fitted(model: Model) -> Here:
    """What the lesson needs of a plant. Raises KnobError, in one sentence, where it does not fit."""
    plant = model.plant
    if observability(plant).unobservable:
        raise KnobError(Text("The plant has modes that leave no trace in its outputs; this lesson is about observable plants.",
                             "该对象有在输出中不留痕迹的模态；本课只针对能观的对象。"))
    units = scaled(model)
    highest = plant.n - seen_by(units)
    if highest < 1:
        raise KnobError(Text("The outputs of this plant give its whole state at once, so u = −Kx needs no observer.",
                             "该对象的输出已直接给出全部状态，u = −Kx 不需要观测器。"))
    K = np.zeros((plant.m, plant.n)) if model.controller is None else model.controller.gain
    wanted = tuple((f"u{i + 1}", Text(f"input {name}: its row of K", f"输入 {name}：K 的对应行"))
                   for i, name in enumerate(plant.input_names) if np.any(K[i]))
    wanted += tuple((f"x{i + 1}", Text(f"state {name}", f"状态 {name}")) for i, name in enumerate(plant.state_names))
    row = row_of(plant, K, wanted[0][0])
    found = [(order, *starting_poles(model, units, row, order)) for order in range(1, highest + 1)]
    limit = max(WORST_CONDITION, min(condition for _, _, condition in found))
    starts = [(order, poles) for order, poles, condition in found if poles and condition <= limit]
    starts = starts[:FEW] + starts[FEW:][-1:]
    if not starts:
        raise KnobError(Text(f"No observer of order 1 to {highest} is within the reach of double precision for this plant: its "
                             "polynomials spread over too many powers of ten.",
                             f"对该对象，1 到 {highest} 阶的观测器都超出双精度的能力：其多项式系数相差的数量级太多。"))
    return Here(model, wanted, tuple(starts), every_entry(plant), highest, units)


def seen_by(here: Scaled) -> int:
    """How many directions of the state the outputs give at once."""
    values = np.linalg.svd(here.inner.C, compute_uv=False)
    return int(np.count_nonzero(values > 1e-10 * values[0]))


def row_of(plant: Plant, K: np.ndarray, wanted: str) -> np.ndarray:
    """The wanted row (1×n): of K, or of the unit matrix."""
    index = int(wanted[1:]) - 1
    return K[[index]] if wanted[0] == "u" else np.eye(plant.n)[[index]]


def starting_poles(model: Model, units: Scaled, row: np.ndarray, order: int) -> tuple[tuple[complex, ...], float]:
    """Poles of an observer of that order inside the board that keep [T; C] best conditioned, and its condition; (), ∞ if none serve."""
    window, nothing = model.observer_window, perturbations(model.plant)
    best, least = (), np.inf
    for poles in (_natural(model, order), _natural(model, order, 0.5),
                  tuple(complex(v) for v in np.linspace(0.3, 0.9, order) * window.re_low),
                  tuple(complex(v) for v in np.geomspace(0.05, 0.9, order)[::-1] * window.re_low)):
        if len(poles) != order or _near(poles) or max(p.real for p in poles) >= 0:
            continue
        try:
            poles = Poles("p", "", same(""), default=poles, re_low=window.re_low, re_high=window.re_high,
                          im_high=window.im_high).check(poles)
            found = units.observer(row, poles, nothing)
        except (EngineError, KnobError, np.linalg.LinAlgError):
            continue
        if met(found, 0.1) and found.condition < least:
            best, least = poles, found.condition
    return best, least


def _natural(model: Model, order: int, share: float = 1.0) -> tuple[complex, ...]:
    """The slowest of the poles that a full observer starts with, in whole pairs."""
    chosen: list[complex] = []
    window = model.observer_window
    known = model.observer_poles if model.observer is None else model.observer.moved
    for p in sorted((complex(p) for p in known if p.imag >= 0 and p.real >= window.re_low and p.imag <= window.im_high), key=abs):
        pair = [p * share] if p.imag == 0 else [p * share, p.conjugate() * share]
        if len(chosen) + len(pair) <= order:
            chosen += pair
    return tuple(chosen)


def _near(poles: tuple[complex, ...]) -> bool:
    p = np.array(poles)
    gaps = np.abs(p[:, None] - p[None, :]) + np.diag(np.full(p.size, np.inf))
    return bool(gaps.min() < NEAR * max(float(np.abs(p).max()), 1e-300))


def met(o: FunctionalObserver, share: float = 1.0) -> bool:
    """Both conditions hold to 1e-9, or to a share of it."""
    return o.dynamics_residual < share * MET and o.output_residual < share * MET


# --- knobs ---------------------------------------------------------------------------------------------------------
def own_knobs(here: Here) -> tuple[Knob, ...]:
    """What is wanted, the order and its poles, how wrong the model is, and what J and RLO are told."""
    model, orders = here.model, [order for order, _ in here.starts]
    c, o = model.controller_window, model.observer_window
    speed = -o.re_low
    return (
        Choice("wanted", "", Text("the observer is to give", "观测器给出"), default=here.wanted[0][0], options=here.wanted, group=WANTED,
               hint=Text("A row of K is fed back through the observer, all other inputs from the true state; a state is only watched.",
                         "K 的一行经观测器反馈，其余输入由真实状态反馈；状态只被观测，不参与反馈。")),
        Poles("controller_poles", "p", Text("Controller poles, which give K", "决定 K 的控制器极点"), "rad/s",
              default=model.controller_poles, re_low=c.re_low, re_high=c.re_high, im_high=c.im_high, role="plant", group=WANTED,
              hidden=not model.controller_poles, hint=Text("eig(A − BK): dragging them changes K.", "eig(A − BK)：拖动它们会改变 K。")),
        Choice("order", "q", Text("order of the observer", "观测器阶数"), default=str(orders[0]), group=WANTED, hidden=len(orders) == 1,
               options=tuple((str(q), same(str(q))) for q in orders),
               hint=Text("From the lowest order that these poles allow up to n less the rank of C.",
                         "从所给极点允许的最低阶数，直到 n 减去 C 的秩。")),
        *(Poles(f"poles_{q}", "s", Text("Observer poles", "观测器极点"), "rad/s", default=poles, re_low=o.re_low, re_high=o.re_high,
                im_high=o.im_high, role="estimate", when=("order", (str(q),)), group=WANTED,
                hint=Text("Drag them and watch J and the error.", "拖动它们，观察 J 与误差。")) for q, poles in here.starts),
        Number("delta_a", r"\delta_a", Text("error of every entry of A", "A 各元素的误差"), "%", low=0.0, high=50.0, default=5.0, step=0.5,
               group=ERRORS, hint=Text("Every entry of the true A is this much larger or smaller.", "真实 A 的每个元素都大或小这么多。")),
        Number("delta_c", r"\delta_c", Text("error of every entry of C", "C 各元素的误差"), "%", low=0.0, high=20.0, default=2.0, step=0.5,
               group=ERRORS, hint=Text("Every entry of the true C is this much larger or smaller.", "真实 C 的每个元素都大或小这么多。")),
        Number("signs", "", Text("signs of the errors", "误差的符号"), low=0, high=20, default=1, scale="integer", group=ERRORS,
               hint=Text("0: every entry is larger; 1 to 20: signs drawn at random.", "0：每个元素都偏大；1 至 20：符号随机抽取。")),
        Number("push", "v", Text("amplitude of v", "v 的幅值"), model.input_unit, low=0.0, high=5 * model.u_max, default=model.u_max,
               group=ERRORS, hint=Text("v = a sin ωt with three periods in the run.", "v = a sin ωt，运行中共三个周期。")),
        Choice("norm", "", Text("norm in J", "J 中的范数"), default="2", group=SEARCH,
               when=("order", tuple(str(q) for q in orders if q > 1)),
               options=tuple((name, same("∞" if name == "inf" else name)) for name in NORMS),
               hint=Text("Column sum, spectral or row sum norm; for order 1 all three agree.",
                         "列和范数、谱范数或行和范数；一阶时三者相同。")),
        *weight_knobs(),
        Number("region_low", "a", Text("region for RLO, left end", "RLO 区域左端"), "rad/s", low=-1.5 * speed, high=-0.5 * speed,
               default=-speed, group=SEARCH, hint=Text("RLO keeps every pole right of this.", "RLO 使所有极点都在此线右侧。")),
        Number("region_high", "b", Text("region for RLO, right end", "RLO 区域右端"), "rad/s", low=-0.45 * speed, high=-0.002 * speed,
               default=-0.02 * speed, group=SEARCH, hint=Text("RLO keeps every pole left of this.", "RLO 使所有极点都在此线左侧。")),
        Number("region_tall", "c", Text("region for RLO, largest |Im s|", "RLO 区域 |Im s| 的上限"), "rad/s", low=0.0, high=o.im_high,
               default=0.0, group=SEARCH,
               hint=Text("0: real poles only. Pairs take RLO longer.", "0：只取实极点。允许共轭对时 RLO 耗时更长。")),
    )


# --- the draft -----------------------------------------------------------------------------------------------------
def weighted(here: Here, design: Design) -> Perturbations:
    """Every entry of A and C wrong by itself, with the design's weights."""
    w = here.entries
    return replace(w, alpha=np.full(len(w.A), design["alpha"]), beta=np.full(len(w.C), design["beta"]),
                   gamma=np.full(len(w.C), design["gamma"]))


def errors(here: Here, design: Design) -> tuple[np.ndarray, np.ndarray]:
    """ΔA, ΔC of the true plant."""
    A, C = here.plant.A, here.plant.C
    rng = np.random.default_rng(int(design["signs"]))
    a, c = (rng.choice([-1.0, 1.0], M.shape) if design["signs"] else np.ones(M.shape) for M in (A, C))
    return design["delta_a"] / 100 * a * A, design["delta_c"] / 100 * c * C


def wanted_of(here: Here, design: Design) -> tuple[np.ndarray, np.ndarray]:
    """K (m×n) of the whole controller, and the wanted row (1×n)."""
    K = feedback(here.plant, design["controller_poles"], here.model)
    return K, row_of(here.plant, K, design["wanted"])


def observer_of(here: Here, design: Design) -> FunctionalObserver:
    """The observer of the design. Raises KnobError, in one sentence, where its poles give none."""
    order = int(design["order"])
    poles = design[f"poles_{order}"]
    if max(p.real for p in poles) >= -1e-6 * -here.model.observer_window.re_low:
        raise KnobError(Text("An observer pole is not in the left half plane, so its error would not decay; drag it left.",
                             "有观测器极点不在左半平面，误差不会衰减；请把它向左拖。"))
    if _near(poles):
        raise KnobError(Text("Two observer poles coincide; this form of the observer needs them apart, so move one.",
                             "有两个观测器极点重合；这种形式的观测器要求极点互异，请移开一个。"))
    row = wanted_of(here, design)[1]
    try:
        found = here.scaled.observer(row, poles, weighted(here, design), NORMS[design["norm"]])
    except (EngineError, np.linalg.LinAlgError) as problem:
        raise _none(order) from problem
    if not met(found):
        raise _none(order)
    return found


def _none(order: int) -> KnobError:
    return KnobError(Text(f"With these poles no observer of order {order} gives what is wanted to 1e-9; raise the order or move the poles.",
                          f"用这些极点，{order} 阶观测器无法以 1e-9 的精度给出所要的量；请提高阶数或移动极点。"))


@dataclass(frozen=True, eq=False)
class Loop:
    """The true plant with its observer, from v to the error: states (x, z), z in rows of T of unit length."""

    A: np.ndarray
    b: np.ndarray
    error: np.ndarray
    wanted: np.ndarray
    inputs: np.ndarray  # (m, n + q): u less v
    scale: np.ndarray


def loop_of(here: Here, design: Design, o: FunctionalObserver, dA: np.ndarray, dC: np.ndarray) -> Loop:
    """u_j = −(Nz + My) + v on the wanted input, u = −Kx from the true state on the others; for a state on all, v on the first."""
    plant, (K, row) = here.plant, wanted_of(here, design)
    n, fed = plant.n, design["wanted"][0] == "u"
    j = int(design["wanted"][1:]) - 1 if fed else 0
    A, C, size = plant.A + dA, plant.C + dC, _lengths(o.T * here.scaled.unit)
    T, L, N, F = o.T / size[:, None], o.L / size[:, None], o.N * size, o.F * size / size[:, None]
    estimate = np.hstack([o.M @ C, N])
    inputs = np.hstack([-K, np.zeros((plant.m, o.order))])
    if fed:
        inputs[j] = -estimate[0]
    whole = np.block([[A, np.zeros((n, o.order))], [L @ C, F]]) + np.vstack([plant.B, T @ plant.B]) @ inputs
    wanted = np.hstack([row, np.zeros((1, o.order))])
    return Loop(whole, np.concatenate([plant.B[:, j], T @ plant.B[:, j]]), wanted - estimate, wanted, inputs, size)


def _lengths(rows: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(rows, axis=1)
    return np.where(length > 0, length, 1.0)


def run_of(here: Here, design: Design, o: FunctionalObserver, dA: np.ndarray, dC: np.ndarray) -> Run:
    """From the model's x(0) and z(0) = 0 under v = a sin ωt: exact at the samples."""
    model, loop = here.model, loop_of(here, design, o, dA, dC)
    count, size = round(model.horizon / model.dt) + 1, len(loop.A)
    turn = 2 * np.pi * WAVES / model.horizon
    whole = np.zeros((size + 2, size + 2))
    whole[:size, :size], whole[:size, size] = loop.A, design["push"] * loop.b
    whole[size, size + 1], whole[size + 1, size] = turn, -turn
    states = np.zeros((count, size + 2))
    states[0, :here.plant.n], states[0, size + 1] = model.x0, 1.0
    with np.errstate(over="ignore", invalid="ignore"):
        step, done = expm(whole * model.dt), 1
        while done < count:  # twice as many samples each time
            more = min(done, count - done)
            states[done:done + more] = states[:more] @ step.T
            step, done = step @ step, done + more
        states = np.nan_to_num(states, nan=DIVERGED, posinf=DIVERGED, neginf=-DIVERGED)
        bound = DIVERGED * max(float(np.abs(states[0]).max()), 1.0)
        states = np.clip(states, -bound, bound)
    v, states = design["push"] * states[:, size], states[:, :size]
    j = int(design["wanted"][1:]) - 1 if design["wanted"][0] == "u" else 0
    u = states @ loop.inputs.T
    u[:, j] += v
    gain = _gain(here, loop)
    return Run(np.arange(count) * model.dt, states[:, :here.plant.n], states[:, here.plant.n:], u, v, states @ loop.error[0],
               states @ loop.wanted[0], *gain, np.linalg.eigvals(loop.A).astype(complex))


def _gain(here: Here, loop: Loop) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies in Hz, and |v → error|."""
    rate = 1.0 / here.model.horizon
    f = np.geomspace(0.2 * rate, 200 * rate, FREQUENCIES)
    s = 2j * np.pi * f
    try:
        solved = np.linalg.solve(s[:, None, None] * np.eye(len(loop.A)) - loop.A, loop.b[:, None] + 0j)[..., 0]
    except np.linalg.LinAlgError:
        return f, np.full(f.shape, DIVERGED)
    return f, np.nan_to_num(np.abs(solved @ loop.error[0]), nan=DIVERGED, posinf=DIVERGED)


def compute(here: Here, design: Design) -> Outcome:
    """The observer, its conditions and J, and one run each on the model and on the true plant. Raises KnobError, EngineError."""
    o = observer_of(here, design)
    dA, dC = errors(here, design)
    model, true = (run_of(here, design, o, *wrong) for wrong in ((0 * dA, 0 * dC), (dA, dC)))
    story = Story(o, model, true, design["wanted"][0] == "u", dict(here.wanted)[design["wanted"]], here.model.observer_window,
                  _unit(here, design))
    late = true.t >= 0.75 * true.t[-1]
    poles = np.array(design[f"poles_{o.order}"])
    metrics = {
        "J": o.J, "order": float(o.order), "dynamics_residual": o.dynamics_residual, "output_residual": o.output_residual,
        "condition": float(min(o.condition, 1e15)), "slowest_loop": float(true.poles.real.max()), "error_start": float(true.e[0]),
        "late_error": float(np.abs(true.e[late]).max()), "late_wanted": float(np.abs(true.wanted[late]).max()),
    }
    checks = (
        Check("dynamics", Text("T A − F T = L C", "T A − F T = L C"), o.dynamics_residual < MET, o.dynamics_residual),
        Check("output", Text("K = N T + M C", "K = N T + M C"), o.output_residual < MET, o.output_residual),
        Check("stable", Text("the loop with the true plant is stable", "真实对象的闭环稳定"), metrics["slowest_loop"] < 0,
              metrics["slowest_loop"]),
    )
    return Outcome(design, {"F": o.F, "T": o.T, "L": o.L, "N": o.N, "M": o.M, "K": o.K}, {"observer": poles, "loop": true.poles}, metrics,
                   checks, None, _boards(here, design, o.order), _stage(here, o, true, dC), _formulas(o), _live(metrics, poles),
                   story)


def _unit(here: Here, design: Design) -> str:
    names = here.plant.input_names if design["wanted"][0] == "u" else here.plant.state_names
    return here.plant.unit(names[int(design["wanted"][1:]) - 1])


def _boards(here: Here, design: Design, order: int) -> tuple[Board, Board]:
    model, c, o = here.model, here.model.controller_window, here.model.observer_window
    return (
        Board("controller", Text("controller poles  eig(A − BK)", "控制器极点  eig(A − BK)"), design["controller_poles"],
              "controller_poles" if model.controller_poles else None, bolts(model.controller, c), side="left", re_low=c.re_low,
              re_high=c.re_high, im_high=c.im_high),
        Board("observer", Text("observer poles  eig F", "观测器极点  eig F"), design[f"poles_{order}"], f"poles_{order}", role="estimate",
              side="right", re_low=o.re_low, re_high=o.re_high, im_high=o.im_high),
    )


def _stage(here: Here, o: FunctionalObserver, run: Run, dC: np.ndarray) -> Stage:
    """The ghost is the state that z and y give together, where there are enough of them."""
    plant, d = here.plant, here.scaled.unit
    ghost = None
    if o.order == here.highest and o.condition < WHOLE:
        rows = np.vstack([o.T / _lengths(o.T * d)[:, None], plant.C]) * d
        length = _lengths(rows)
        known = np.hstack([run.z, run.x @ (plant.C + dC).T]) / length
        ghost = np.linalg.lstsq(rows / length[:, None], known.T, rcond=1e-12)[0].T * d
    return Stage(here.model.body, run.t, run.x, ghost, run.u)


def _formulas(o: FunctionalObserver) -> tuple[Formula, ...]:
    return (
        Formula("law", r"\dot z = Fz + L(y - Du) + TBu, \quad Kx \approx Nz + M(y - Du)"),
        Formula("conditions", rf"TA - FT = LC, \quad K = NT + MC, \quad \mathrm{{rel.}}\; "
                              rf"{number(o.dynamics_residual)}, \; {number(o.output_residual)}"),
        Formula("J", rf"J = \textstyle\sum_i \alpha\|TA_i\| + \beta\|LC_i\| + \gamma\|MC_i\| = {number(o.J, 4)}"),
        *(Formula(name, gain_words(name, getattr(o, name))) for name in "FTLNMK"),
    )


def _live(m: dict[str, float], poles: np.ndarray) -> Text:
    start = Text(f"Order {m['order']:.0f}, poles {pole_words(list(poles)[:4])}: J = {m['J']:.3g}.",
                 f"{m['order']:.0f} 阶，极点 {pole_words(list(poles)[:4])}：J = {m['J']:.3g}。")
    if m["slowest_loop"] >= 0:
        end = Text(" With the true plant the loop is unstable.", " 对真实对象，闭环不稳定。")
    else:
        end = Text(f" At the end the estimate is off by up to {m['late_error']:.2g}, what is wanted being up to {m['late_wanted']:.2g}.",
                   f" 末段估计偏差最多 {m['late_error']:.2g}，而待估计的量最大为 {m['late_wanted']:.2g}。")
    return Text(start.en + end.en, start.zh + end.zh)


# --- the job -------------------------------------------------------------------------------------------------------
def depends(design: Design) -> tuple[Any, ...]:
    """What the search rests on: neither the order nor the poles nor the errors of the plant."""
    names = ("wanted", "controller_poles", "norm", "alpha", "beta", "gamma", "region_low", "region_high", "region_tall")
    return tuple(design[name] for name in names)


def search(here: Here, outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
    """Algorithm RLO for this plant; a better observer of the same order that is already chosen stays the result."""
    design, chosen = outcome.design, outcome.extra.observer
    units, row, result = here.scaled, wanted_of(here, design)[1], None
    region = Region(design["region_low"] / units.rate, design["region_high"] / units.rate, 0.0, design["region_tall"] / units.rate)
    try:
        for part, found in rlo_steps(units.inner, row * units.unit, units.within(weighted(here, design)), NORMS[design["norm"]], region,
                                     here.highest, worst_condition=WORST_CONDITION):
            result = found
            yield 0.99 * part, outcome
    except (EngineError, np.linalg.LinAlgError) as problem:
        raise KnobError(Text("Algorithm RLO finds no observer in this region whose [T; C] has a condition number below 10⁴; widen the "
                             "region, also to complex poles.",
                             "算法 RLO 在该区域内找不到 [T; C] 条件数小于 10⁴ 的观测器；请放宽区域，也可允许复极点。")) from problem
    assert result is not None
    found = units.given(result.observer, row, weighted(here, design))
    result = replace(result, observer=found)
    if not met(found):
        result = beside(here, design, row, result)
    same_order = chosen.order == result.observer.order and inside(chosen.poles, design)
    if same_order and chosen.condition <= WORST_CONDITION and result.value > chosen.J:
        result = replace(result, observer=chosen, value=chosen.J)
    yield 1.0, with_search(here, outcome, result, depends(design))


def beside(here: Here, design: Design, row: np.ndarray, result: RobustObserver) -> RobustObserver:
    """RLO may stop right on a mode of the plant, where J has a kink and precision is lost; then the best observer a hair away."""
    for share in NUDGES:
        for way in (1 + share, 1 - share):
            poles = result.observer.poles * way
            if not inside(poles, design):
                continue
            try:
                near = here.scaled.observer(row, tuple(poles), weighted(here, design), NORMS[design["norm"]])
            except (EngineError, np.linalg.LinAlgError):
                continue
            if met(near) and near.J - result.value < 10 * share * result.value:
                return replace(result, observer=near, value=near.J)
    return result


def with_search(here: Here, outcome: Outcome, result: RobustObserver, key: tuple[Any, ...]) -> Outcome:
    """The outcome with what RLO found, run under the same errors of the plant."""
    run = run_of(here, outcome.design, result.observer, *errors(here, outcome.design))
    more = {"J_rlo": float(result.value), "order_rlo": float(result.observer.order),
            "late_error_rlo": float(np.abs(run.e[run.t >= 0.75 * run.t[-1]]).max())}
    return replace(outcome, extra=replace(outcome.extra, found=result, found_run=run, key=key), metrics={**outcome.metrics, **more})


def carry(here: Here, before: Outcome, after: Outcome) -> Outcome:
    """What RLO found goes over to the next design as long as what it rests on is the same."""
    old = before.extra
    if old.found is None or after.extra.found is not None or old.key != depends(after.design):
        return after
    return with_search(here, after, old.found, old.key)


def adapted(model: Model) -> Lesson:
    """The lesson on a person's own plant, where an observer of a part of its state exists; the tasks stay with the paper."""
    here = fitted(model)
    return replace(LESSON, knobs=own_knobs(here), compute=partial(compute, here), figures=all_figures, tasks=(),
                   job=Job(Text("Run algorithm RLO", "运行算法 RLO"), partial(search, here)), carry=partial(carry, here))
