"""Draw the figures of lesson 18 from an outcome."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import Curve, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine.network import mean_lower_limit
from observer_lab.text import NO_WORDS, Text, format_number, same, superscript, text, text_in

from ..toolkit.figures import TIME_TAB
from .cases import CASE_KINDS, RUN_SAMPLES
from .gaps import GAP_TAB, gaps
from .job import RUN_COUNT
from .study import (
    AUTONOMOUS_TOLERANCE,
    DISPLAY_LIMIT,
    INPUT_LOSSES,
    LOSSES,
    OVER,
    ZERO_INPUT,
    Study,
    bounds_over_loss,
    growth_now,
    input_growth,
    key,
    loop_radius,
)

MEAN_TAB, WALL_TAB, INPUT_TAB = text("Covariance"), text("Separation"), text("Lost inputs")
JUST = 1e-3  # of a period: how long before a sample its upper corner is drawn
CIRCLE_ANGLES_RAD = np.linspace(0, 2 * np.pi, 73)
FIRST_SAMPLES = 40  # that one can tell apart
NEVER = text_in("network", "none")


def figures(outcome: Outcome[Study]) -> FigureSet:
    """Time, covariance, gaps, separation, lost inputs: at most three in a tab."""
    return FigureSet(tab_figures(TIME_TAB, lambda: (_state(outcome), _input(outcome), _ages(outcome))),
                 tab_figures(MEAN_TAB, lambda: (_teeth(outcome), _means(outcome), _limits(outcome))),
                 tab_figures(GAP_TAB, lambda: (gaps(outcome), _first(outcome))),
                 tab_figures(WALL_TAB, lambda: (_error(outcome), _spectrum(outcome), _blocks(outcome))),
                 tab_figures(INPUT_TAB, lambda: (_growth(outcome),)))


def times(outcome: Outcome[Study]) -> np.ndarray:
    """Two moments a sample: at it, and just before the next."""
    h = outcome.study.watched.sampled.plant.dt
    return np.column_stack([np.arange(RUN_SAMPLES), np.arange(1, RUN_SAMPLES + 1) - JUST]).ravel() * h


def _steps(values: np.ndarray) -> np.ndarray:
    """Held from sample to sample."""
    return np.repeat(values, 2)


def _lines(values: np.ndarray) -> np.ndarray:
    """Straight from sample to sample."""
    return np.column_stack([values, np.append(values[1:], values[-1])]).ravel()


# --- time ------------------------------------------------------------------------------------------------------------
def _state(outcome: Outcome[Study]) -> LineFigure:
    s, signal = outcome.study, CASE_KINDS[outcome.design["case"]].watched
    true, guess = signal.of(s.x), signal.of(s.xhat)
    low, high = float(min(true.min(), guess.min(), 0.0)), float(max(true.max(), guess.max(), 0.0))
    comb = _steps(np.where(s.heard, low, low - 0.12 * (high - low)))
    lost = int(np.sum(~s.heard))
    return LineFigure("state", signal.name, times(outcome),
                      (Curve(text("true"), _lines(true)), Curve(text("estimate"), _lines(guess), "estimate", "dash"),
                       Curve(text("steps down: no packet arrives"), comb, "disturbance", width=1.2)),
                      f"[{signal.unit}]" if signal.unit else "x₁", tab=TIME_TAB,
                      caption=text("{lost} of {samples} samples brought no measurement; the longest gap lasted "
                                   "{heard}.",
                                   lost=lost, samples=RUN_SAMPLES, heard=longest(s.heard)))


def longest(heard: np.ndarray) -> int:
    """The longest run of samples without a packet."""
    gap = most = 0
    for there in heard.tolist():
        gap = 0 if there else gap + 1
        most = max(most, gap)
    return most


def _input(outcome: Outcome[Study]) -> LineFigure:
    s, d, unit = outcome.study, outcome.design, CASE_KINDS[outcome.design["case"]].input_unit
    lost = int(np.sum(s.run.draw.acted < 0))
    how = text("zero stands in") if d["lost"] == ZERO_INPUT else text("the last one is held")
    return LineFigure("input", text("input asked for and applied"), times(outcome),
                      (Curve(text("asked"), _steps(s.asked[:, 0]), "second", "dash", 1.6),
                       Curve(text("applied"), _steps(s.applied[:, 0]), "force")), f"u [{unit}]" if unit else "u",
                      tab=TIME_TAB, caption=_fate(lost, how, int(d["delay"])))


def _fate(lost: int, how: Text, late: int) -> Text:
    """What became of the inputs."""
    when = text("arrive {late} samples late", late=late) if late else text("arrive at once")
    if lost == 1:
        return text("One input is lost, {how}; the others {when}.", how=how, when=when)
    if lost:
        return text("{lost} inputs lost, {how}; the others {when}.", lost=lost, how=how, when=when)
    return text("No input is lost; all {when}.", when=when)


def _ages(outcome: Outcome[Study]) -> LineFigure:
    sensor, actuator = outcome.study.ages
    return LineFigure("age", text("age of the newest packet"), times(outcome),
                      (Curve(text("measurement"), _steps(sensor).astype(float), "estimate"),
                       Curve(text("input"), _steps(actuator).astype(float), "force", "dash", 1.6)),
                      "k − k₀", tab=TIME_TAB, window=(0.0, 4.0),
                      caption=text("In samples. Oldest measurement in use: {sensor}; oldest input: {actuator}.",
                                   sensor=int(sensor.max()), actuator=int(actuator.max())))


# --- covariance --------------------------------------------------------------------------------------------------------
def _teeth(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    curves = [Curve(text("this run"), s.teeth.ravel(), "plant")]
    if s.trials is not None and len(s.trials.mean):
        curves.append(Curve(text("mean of {runs}", runs=RUN_COUNT), _bound(s.trials.mean), "estimate"))
    curves += [Curve(text("mean, at least"), _bound(s.lower), "reference", "dot", 1.6),
               Curve(text("mean, at most"), _bound(s.upper), "reference", "dash", 1.6)]
    peak = float(s.teeth.max())
    low, high = _big(s.lower[-1]), _big(s.upper[-1])
    mean = (text("lies between {low} and {high}", low=low, high=high) if s.upper[-1] < DISPLAY_LIMIT else
            text("is at least {low}", low=low))
    words = text("Variance that the filter computes, over that without loss. This run rises to {peak}; after {samples} samples "
                 "the mean {mean}.",
                 peak=_big(peak), samples=RUN_SAMPLES, mean=mean)
    return LineFigure("teeth", text("how unsure the filter is"), times(outcome), tuple(curves), "σ²/σ₀²",
                      log_y=True, window=(0.5, 10.0), tab=MEAN_TAB, caption=words)


def _first(outcome: Outcome[Study]) -> LineFigure:
    """The variance over the first samples, packet by packet, and which packets are lost."""
    s, shown = outcome.study, 2 * FIRST_SAMPLES
    grows, lost = s.teeth.ravel()[:shown], int(np.sum(~s.heard[:FIRST_SAMPLES]))
    floor = 0.8 * float(grows.min())
    comb = _steps(np.where(s.heard, floor, 0.7 * floor))[:shown]
    return LineFigure("first", text("how unsure the filter is: the first packets"), times(outcome)[:shown],
                      (Curve(text("variance"), grows), Curve(text("steps down: no packet arrives"), comb, "disturbance")),
                      "σ²/σ₀²", log_y=True, window=(0.2, 10.0), tab=GAP_TAB,
                      caption=text("Packets that did not arrive: {lost} of {samples}. Each of them raises the variance; the next "
                                   "one that arrives lowers it.", lost=lost, samples=FIRST_SAMPLES))


def _bound(values: np.ndarray) -> np.ndarray:
    """A sequence before the packets of samples 0 … N, drawn straight."""
    return np.column_stack([values[:-1], values[1:]]).ravel()


def _big(value: float) -> str:
    """A ratio in few letters."""
    if value >= DISPLAY_LIMIT:
        return "10⁹"
    if value < 1e4:
        return format_number(value, ".3g")
    mantissa, power = f"{value:.1e}".split("e")
    return f"{mantissa}·10{superscript(int(power))}"


def _log(values: np.ndarray) -> np.ndarray:
    return np.log10(np.maximum(values, 1e-3))


def _means(outcome: Outcome[Study]) -> PlaneFigure:
    s, d = outcome.study, outcome.design
    edge = s.watched.sampled.edge
    lower, upper = bounds_over_loss(key(d))
    top = float(np.clip(np.ceil(np.log10(upper[-2])), 1.0, 6.0))
    curves = [Curve(text("mean, at least"), _log(lower), "reference", "dot", 1.6, LOSSES),
              Curve(text("mean, at most"), _log(upper), "reference", "dash", 1.6, LOSSES)]
    if edge.lost < 1:
        curves.append(Curve(same("1/max|λ|²"), np.array([-1.0, top + 1]), "error", "solid", 2.0, np.full(2, edge.lost)))
    if not edge.exact:
        curves.append(Curve(same("1/∏|λ|²"), np.array([-1.0, top + 1]), "disturbance", "solid", 2.0, np.full(2, edge.safe)))
    points = [Point(d["loss"], float(np.clip(_log(s.teeth[:, 1]).mean(), -0.3, top)), "plant", "circle")]
    if s.trials is not None:
        points += [Point(float(p), float(min(_log(np.array(v)), top)), role, mark)  # type: ignore[arg-type]
                   for values, role, mark in ((s.trials.means, "estimate", "cross"), (s.trials.medians, "plant", "dot"))
                   for p, v in zip(OVER, values, strict=False)]
    words = (text("After {samples} samples. Crosses: mean of {runs} runs; dots: their median. At high loss "
                  "the crosses can miss the rare runs that carry the mean. Circle: this run.",
                  samples=RUN_SAMPLES, runs=RUN_COUNT)
             if s.trials is not None else
             text("After {samples} samples. Circle: this run. Press “Average {runs} runs” for means and "
                  "medians.",
                  samples=RUN_SAMPLES, runs=RUN_COUNT))
    return PlaneFigure("means", text("mean variance over the share lost"), tuple(curves), tuple(points),
                       "p", "σ²/σ₀²", (0.0, 1.0), (-0.3, top), caption=words, tab=MEAN_TAB, powers="y")


def _limits(outcome: Outcome[Study]) -> TableFigure:
    s, d = outcome.study, outcome.design
    plant = s.watched.sampled
    edge, p = plant.edge, d["loss"]
    least = (format_number(s.watched.ratio(mean_lower_limit(plant.plant.A, plant.Q, p)), ".4g") if p * plant.radius**2 < 1 else NEVER)
    rows: tuple[tuple[Text | str, ...], ...] = (
        (same("max|λ|"), f"{plant.radius:.4f}"),
        (text("diverges above 1/max|λ|²"), f"{100 * edge.lost:.2f} %" if edge.lost < 1 else NEVER),
        (text("the upper bound has a limit below"), f"{100 * edge.safe:.2f} %"),
        (text("lost now"), f"{100 * p:.1f} %"),
        (text("loss · max|λ|², growth per sample"), f"{p * plant.radius**2:.4f}"),
        (text("least limit of the mean, σ²/σ₀²"), least),
    )
    said = (text("The mean that the filter expects grows without end.") if not edge.bounded(p) else
            text("The mean that the filter expects stays bounded.") if p < edge.safe else
            text("The mean that the filter expects stays bounded, though the upper bound does not: the modes differ in modulus "
                 "(Mo and Sinopoli)."))
    return TableFigure("limits", text("tolerable losses"), (text("quantity"), text("value")), rows,
                       caption=said, tab=MEAN_TAB)


# --- separation --------------------------------------------------------------------------------------------------------
def _error(outcome: Outcome[Study]) -> LineFigure:
    s, meter = outcome.study, outcome.study.meter
    held = meter < AUTONOMOUS_TOLERANCE
    words = (text("Separation meter: 0. The error is what noise and packets make of it, whatever the controller "
                  "does.") if held else
             text("Separation meter: {meter}. State or inputs now drive the error of the estimate.",
                  meter=_big(meter)))
    return LineFigure("error", text("estimation error, in σ₀"), times(outcome),
                      (Curve(text("error"), _lines(s.size), "error"),
                       Curve(text("of an observer that gets the applied input"), _lines(s.promised), "reference", "dash", 1.6)),
                      "‖e‖/σ₀", log_y=True, window=(0.1, 10.0), caption=words, tab=WALL_TAB)


def _largest_first(pole: complex) -> tuple[float, float]:
    return -abs(pole), -pole.imag


def _spectrum(outcome: Outcome[Study]) -> PlaneFigure:
    groups = (("controller", "plant", "cross", text("controller")), ("observer", "estimate", "cross", text("observer")),
              ("loop", "reference", "circle", text("loop")))
    radius = loop_radius(outcome.study)
    reach = float(np.clip(1.15 * radius, 1.25, 4.5))
    points = tuple(Point(float(p.real), float(p.imag), role, mark, said if k == 0 else NO_WORDS)  # type: ignore[arg-type]
                   for name, role, mark, said in groups for k, p in enumerate(sorted(outcome.poles[name], key=_largest_first)))
    words = text("Delay alone, no loss. Crosses: controller and observer as designed. Circles: the loop; the "
                 "largest has modulus {radius:.3f}.",
                 radius=radius)
    return PlaneFigure(
        "spectrum",
        text("poles in the z-plane"),
        (Curve(same("|z| = 1"), np.sin(CIRCLE_ANGLES_RAD), "muted", "dash", 1.4, np.cos(CIRCLE_ANGLES_RAD)),),
        points,
        "Re z",
        "Im z",
        (-reach, reach),
        (-reach, reach),
        equal=True,
        caption=words,
        tab=WALL_TAB,
    )


def _blocks(outcome: Outcome[Study]) -> MatrixFigure:
    s, d = outcome.study, outcome.design
    plant = s.watched.sampled.plant
    n, m, delay = plant.n, plant.m, int(d["delay"])
    names = (*(f"x{i + 1}" for i in range(n)), *(f"u{'' if m == 1 else j + 1}−{i + 1}" for i in range(delay) for j in range(m)),
             *(f"e{i + 1}" for i in range(n)))
    N = n + delay * m
    scale = np.concatenate([1 / np.sqrt(s.watched.weights), np.ones(delay * m), 1 / np.sqrt(s.watched.weights)])
    shown = s.loop / scale[:, None] * scale[None, :] if n > 1 else s.loop
    corner = float(np.abs(shown[N:, :N]).max())
    words = (text("Delay alone. The lower left block is zero: state and inputs do not drive the error.")
             if corner == 0 and s.meter < AUTONOMOUS_TOLERANCE else
             text("Delay alone leaves the lower left block at zero; what the meter reads comes from packets lost or out of order.")
             if corner == 0 else
             text("The lower left block is not zero: the observer gets another input than the plant, and the difference drives the error."))
    return MatrixFigure("blocks", text("the loop in (x, inputs under way, e)"), shown, names, names,
                        (N,), words, WALL_TAB)


# --- lost inputs -------------------------------------------------------------------------------------------------------
def _growth(outcome: Outcome[Study]) -> PlaneFigure:
    d = outcome.design
    name, a, stretch, _ = key(d)
    held, zeroed = input_growth(name, a, stretch)
    hold_now, zero_now = growth_now(name, a, stretch, d["loss_u"])
    now = zero_now if d["lost"] == ZERO_INPUT else hold_now
    top = float(np.clip(np.ceil(2 * max(held.max(), zeroed.max())) / 2, 1.5, 5.0))
    better = (text("with nothing lost there is no difference") if hold_now == zero_now else
              text("holding is the better stand-in there") if hold_now < zero_now else
              text("zero is the better stand-in there"))
    words = text("Growth of E‖x‖² per sample under u = −Kx without delay; below 1 it decays. At {loss_u:.0f} % lost: "
                 "{now:.3f}; {better}.",
                 loss_u=100 * d["loss_u"], now=now, better=better)
    return PlaneFigure("growth", text("inputs lost: hold or zero"),
                       (Curve(text("hold the last input"), held, "force", x=INPUT_LOSSES),
                        Curve(text("zero"), zeroed, "disturbance", "dash", x=INPUT_LOSSES),
                        Curve(text_in("network", "limit"), np.ones(2), "reference", "dot", 1.4, np.array([0.0, 1.0]))),
                       (Point(d["loss_u"], now, "plant", "circle"),), "pᵤ", "E‖x⁺‖² / E‖x‖²", (0.0, 1.0), (0.0, top),
                       caption=words, tab=INPUT_TAB)
