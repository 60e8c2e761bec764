"""Compute a design of lesson 10: gains, spectra, costs, robustness, one run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from observer_lab.colours import COLOURS
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome, Stage
from observer_lab.engine import closed_loop
from observer_lab.engine.design import Optimal
from observer_lab.engine.feedback import NoisyLoop
from observer_lab.plants.bodies.body import Body, Box, Part, Pose
from observer_lab.plants.bodies.front_bars import BEGIN, FIRST_Y, FLOOR, LONG, THICK, Bar, share_of_decades, with_bars
from observer_lab.plants.bodies.gain_lanes import with_gain_lanes
from observer_lab.plants.doyle import gains as gains_of_paper
from observer_lab.plants.model import Window
from observer_lab.text import Text, same, text

from ..toolkit.latex import number
from .cases import DOYLE, REPORT, REPORT_FACTORS, Case
from .knobs import PROCESS_RULE, RECURSIVE, SENSOR_RULE, SPLIT_RULE, STATE
from .loops import Cost, Setting, Trace, cost, estimator, gains, loop, sensor_input, setting_of, trace
from .robustness import Robustness, ideal, real, within

DECK_BACK = 1.05  # stage units that the deck stands behind the bar
FAR_GAIN = 1e3  # times the model's gain: a loop that tolerates more tolerates all that is drawn


@dataclass(frozen=True, eq=False)
class Trials:
    """What `count` runs showed: densities (n_f, k) at the case's frequencies, those predicted for this computer, and
    the χ² band (95 %) of their ratio at one frequency, and per channel the mean of that ratio and the share within."""

    count: int
    density: np.ndarray
    predicted: np.ndarray
    band: tuple[float, float]
    ratio: np.ndarray
    inside: np.ndarray


@dataclass(frozen=True, eq=False)
class Study:
    """All that a design leads to, found when it is looked at; None where the loop (or, for the gains in decibels, the plant) is
    unstable. `disturbance` is the true factor of W, `cut` the input at which robustness is asked for, `rule` the line in doubt."""

    case: Case
    setting: Setting
    cut: int
    disturbance: float
    rule: str
    trace: Trace
    trials: Trials | None = None

    @property
    def loop(self) -> NoisyLoop:
        """The loop of the true plant under the true noise."""
        return loop(self.case, self.setting)

    @cached_property
    def parts(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Densities (n_f, k + m) of the channels and the inputs by cause: ground, sensors."""
        z = self.loop
        return z.parts(self.case.frequency, np.vstack([z.outputs(), z.inputs()])) if z.stable else None

    @cached_property
    def density(self) -> np.ndarray | None:
        """Of the channels (n_f, k)."""
        return None if self.parts is None else (self.parts[0] + self.parts[1])[:, :len(self.case.names)]

    @property
    def asked(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Of the inputs, by cause."""
        k = len(self.case.names)
        return None if self.parts is None else (self.parts[0][:, k:], self.parts[1][:, k:])

    @cached_property
    def variance(self) -> np.ndarray | None:
        """Of the channels (k,)."""
        return self.loop.variance() if self.loop.stable else None

    @cached_property
    def gained(self) -> tuple[np.ndarray | None, np.ndarray]:
        """Decibels gained at the peak, and at the case's low frequency (k,)."""
        none = np.zeros(len(self.case.names))
        return (None, none) if self.density is None else peak_reductions(self.case, self.disturbance, self.density)

    @property
    def suppression(self) -> np.ndarray | None:
        """At the peak."""
        return self.gained[0]

    @property
    def low(self) -> np.ndarray:
        """At the low frequency."""
        return self.gained[1]

    @cached_property
    def answers(self) -> dict[str, float]:
        """What this loop says of the line in doubt."""
        return _answers(self)

    @cached_property
    def cost(self) -> Cost:
        """What this loop costs."""
        return cost(self.case, self.setting)

    @cached_property
    def plain_cost(self) -> Cost:
        """What it would without recovery."""
        return cost(self.case, self.setting.plain())

    @cached_property
    def ideal(self) -> Robustness:
        """Of the regulator that knows the state."""
        f = self.setting.factors
        return ideal(self.case, f.alpha_q, f.alpha_r, self.cut)

    @cached_property
    def real(self) -> Robustness:
        """Of this loop, the model being right."""
        return real(self.case, self.setting.factors, self.setting.recovery, self.cut)

    @cached_property
    def plain(self) -> Robustness:
        """The same without recovery."""
        return real(self.case, self.setting.factors, 0.0, self.cut)


# --- the draft -------------------------------------------------------------------------------------------------------
def compute_for(cases: tuple[Case, ...], design: Design) -> Outcome[Study]:
    """Gains, loop, spectra, costs, robustness and one run of a design on one of these cases."""
    values = dict(design.values)
    case = next(c for c in cases if c.id == values.get("case", cases[0].id))
    setting = setting_of(case, design)
    f, cut = setting.factors, min(int(values.get("cut", "1")), case.plant.m) - 1
    reg, est = gains(case, setting)
    study = Study(case, setting, cut, case.true_disturbance(f), design["rule"],
                  trace(case, setting, design["kick"], design["filter"] == RECURSIVE))
    metrics, poles = LazyMap(lambda: _metrics(study, reg, est)), {"regulator": reg.poles, "filter": est.poles}
    return Outcome(design, {"K": reg.gain, "L": est.gain}, LazyMap(lambda: {**poles, "loop": study.loop.poles}, poles), metrics,
                   LazySequence(lambda: _checks(study, metrics)), None, _boards(case, reg, est),
                   _stage(study, values.get("lane") == STATE, bool(values.get("noise_bar"))),
                   LazySequence(lambda: _formulas(study, setting)), LazyValue(lambda: _live(study)), study)


NOISE_DECADES = -1, 1  # of the bar of the input that sensor noise causes, over that at the default settings


@lru_cache(maxsize=8)
def body_of(case: Case, known: bool) -> Body:
    """The case's body behind the lanes of gains that LQG, or the loop with the state `known`, and LQR tolerate."""
    near = text("with the state known") if known else text("LQG tolerates")
    return with_gain_lanes(case.model.body, case.plant.n, (near, text("LQR tolerates")), pale=not known)


@lru_cache(maxsize=2)
def noise_body(case: Case) -> Body:
    """The case's body behind the bar of the input that sensor noise causes, and the pale one of the default settings."""
    start, long = -NOISE_DECADES[0] / (NOISE_DECADES[1] - NOISE_DECADES[0]), 2.4 * THICK
    barred = with_bars(case.model.body, case.plant.n, (Bar(text("input from noise"), COLOURS["force"]),),
                       ((same("0.1"), 0.0), (text("1: default settings"), start)), DECK_BACK, decades=NOISE_DECADES)
    pale = Pose((BEGIN + LONG * start / 2, FIRST_Y, FLOOR + THICK))
    return replace(barred, parts=(*barred.parts, Part("default input", Box((LONG * start, long, long)), COLOURS["muted"], opacity=0.35)),
                   pose=lambda x, gain: {**barred.pose(x, gain), "default input": pale})


def _stage(s: Study, known: bool, noise_bar: bool) -> Stage:
    run = s.trace
    if s.case.id == REPORT and not noise_bar:
        return Stage(s.case.model.body, run.t, run.x, run.xhat, run.u)
    if s.case.id == REPORT:
        now = sensor_input(s.case, s.setting) / sensor_input(s.case, Setting(REPORT_FACTORS, 0.0, 1.0))
        body, more = noise_body(s.case), share_of_decades(np.array([now]), *NOISE_DECADES)
    else:
        limits = (*(s.ideal if known else s.real).margins.gain, *s.ideal.margins.gain, s.setting.gain)
        body, more = body_of(s.case, known), np.clip(limits, 0.0, FAR_GAIN)
    tail = np.tile(more, (len(run.t), 1))
    return Stage(body, run.t, np.hstack([run.x, tail]), np.hstack([run.xhat, tail]), run.u)


def peak_reductions(case: Case, true: float, density: np.ndarray) -> tuple[np.ndarray | None, np.ndarray]:
    """Decibels that the highest peak in the band, and the density at the low frequency, have come down."""
    if case.open_psd is None:
        return None, np.zeros(density.shape[1])
    f, opened = case.frequency, np.maximum(true * case.open_psd, 1e-300)
    band = (f >= case.band[0]) & (f <= case.band[1])
    at = int(np.argmin(np.abs(f - case.low)))
    floor = np.maximum(density, 1e-300)
    return (10 * np.log10(opened[band].max(axis=0) / floor[band].max(axis=0)), 10 * np.log10(opened[at] / floor[at]))


def sensor_share(c: Cost) -> tuple[float, float]:
    """The power of what the sensors' noise makes the inputs do, and its share of all."""
    power, noise = float(np.sum(np.square(c.ground))) + float(np.sum(np.square(c.sensors))), float(np.sum(np.square(c.sensors)))
    return noise, noise / power if 0 < power < np.inf else np.inf


def _metrics(s: Study, reg: Optimal, est: Optimal) -> dict[str, float]:
    c, m, (noise, share), inner = s.cost, s.real.margins, sensor_share(s.cost), within(s.real.margins.gain)
    out = {
        "stable": float(s.density is not None), "J": c.total, "J_known": c.known, "J_least": c.least, "J_open": c.idle,
        "sensor_input": float(np.sqrt(noise)), "sensor_share": share,
        "gain_low": m.gain[0], "gain_high": m.gain[1], "stable_from": inner[0], "stable_to": inner[1],
        "phase_deg": float(np.degrees(m.phase)), "delay": m.delay,
        "disk": m.disk.alpha, "nearest": m.nearest, "nearest_lqr": s.ideal.margins.nearest,
        "all_inputs_alpha": s.real.alpha, "all_inputs_nearest": s.real.nearest,
        "riccati_residual": max(reg.residual, est.residual),
    }
    out |= {f"suppression_{i}": float(v) for i, v in enumerate(s.suppression if s.suppression is not None else ())}
    out |= {f"low_{i}": float(v) for i, v in enumerate(s.low)} | s.answers
    return {name: float(value) for name, value in out.items() if np.isfinite(value)}


def _answers(s: Study) -> dict[str, float]:
    case, f, rule, (reg, est) = s.case, s.setting.factors, s.rule, gains(s.case, s.setting)
    base = float(np.sqrt(sensor_share(s.cost)[0])) if rule in (SENSOR_RULE, PROCESS_RULE) else 0.0
    if rule == SPLIT_RULE:
        return {"union_error": closed_loop(case.plant, reg.gain, est.gain).union_error}
    if rule == SENSOR_RULE:
        others = {name: replace(s.setting, factors=replace(f, beta_r=f.beta_r * factor))
                  for name, factor in (("sensor_less", 0.1), ("sensor_more", 10.0))}
        return {name: sensor_input(case, other) / base if base > 0 else np.inf for name, other in others.items()}
    if rule == PROCESS_RULE:
        more = estimator(case, f.beta_q * 10.0, f.beta_r, s.setting.recovery)
        told = replace(s.setting, factors=replace(f, beta_q=f.beta_q * 10.0))
        return {"process_more": float(np.sum(more.poles.real) / np.sum(est.poles.real)),
                "process_input": sensor_input(case, told) / base if base > 0 else np.inf}
    return {}


def _checks(s: Study, m: Mapping[str, float]) -> tuple[Check, ...]:
    disk = s.real.margins.disk.alpha
    return (
        Check("stable", text("stable with the true gain m"), s.density is not None, m["stable"]),
        Check("optimal", text("no controller is cheaper under this noise"),
              s.cost.total <= s.cost.least * (1 + 1e-6), s.cost.total / max(s.cost.least, 1e-300), informative=True),
        Check("kalman", text("LQR keeps |1 + ℓ| ≥ 1"), m["nearest_lqr"] > 1 - 1e-6, m["nearest_lqr"]),
        Check("margins", text("LQG has a disk margin of at least 0.5"), disk >= 0.5, disk),
    )


def _inside(poles: np.ndarray, window: Window) -> tuple[complex, ...]:
    """The poles that a board has room for; those of sensors and fast gains lie far outside."""
    return tuple(complex(p) for p in poles if window.re_low <= p.real <= window.re_high and abs(p.imag) <= window.im_high)


def _boards(case: Case, reg: Optimal, est: Optimal) -> tuple[Board, Board]:
    c, o = case.model.controller_window, case.model.observer_window
    return (
        Board("regulator", text("regulator poles  eig(A − BK)"), _inside(reg.poles, c), side="left",
              re_low=c.re_low, re_high=c.re_high, im_high=c.im_high),
        Board("filter", text("filter poles  eig(A − LC)"), _inside(est.poles, o), role="estimate", side="right",
              re_low=o.re_low, re_high=o.re_high, im_high=o.im_high),
    )


def _formulas(s: Study, setting: Setting) -> tuple[Formula, ...]:
    f, c = setting.factors, s.cost
    rest = r"\hat x \neq x" if setting.gain == 1.0 else r"\hat x \neq x,\ m \neq 1"
    split = (Formula("split", rf"J = \underbrace{{{number(c.known)}}}_{{\mathrm{{tr}}\,S G W G^{{\mathsf T}}}}"
                     rf" + \underbrace{{{number(c.total - c.known)}}}_{{{rest}}}")
             if np.isfinite(c.total) else Formula("split", r"J = \infty"))
    law = Formula("law", r"u = -K\hat x,\quad K = R^{-1}B^{\mathsf T}S,\quad L = P C^{\mathsf T}V^{-1}")
    if s.case.id != DOYLE:
        ratios = number(f.alpha_q / f.alpha_r), number(f.beta_r / f.beta_q)
        return law, split, Formula("ratio", rf"\alpha_Q/\alpha_R = {ratios[0]},\quad \beta_R/\beta_Q = {ratios[1]}")
    top, d = gains_of_paper(f.alpha_q, f.beta_q)
    return (
        law,
        Formula("fd", rf"f = 2 + \sqrt{{4 + q}} = {number(top)},\quad d = 2 + \sqrt{{4 + \sigma}} = {number(d)}"),
        Formula("edge", rf"m < 1 + \frac{{1}}{{d f}} = {1 + 1 / (d * top):.6g}", text("for plain LQG, ρ = 0")),
        split,
    )


def _live(s: Study) -> Text:
    gain = within(s.real.margins.gain)
    if s.density is None:
        return text("Unstable: this loop tolerates {gain:.10g} … {gain2:.10g} times the gain of one input.",
                    gain=gain[0], gain2=gain[1])
    if s.suppression is None:
        return text("Stable up to a gain of {gain:.10g}; nearest approach to −1: {nearest:.3g}.",
                    gain=gain[1], nearest=s.real.margins.nearest)
    changes = [round(float(v), 1) for v in -s.suppression]
    named = ", ".join(f"{change:+.1f}" if change else "0.0" for change in changes).replace("-", "−")
    delay = s.real.margins.delay
    late = (text("{delay:.3g} s of delay", delay=delay) if np.isfinite(delay) else text(
        "any delay"))
    if s.setting.gain != 1:  # the margins are those of the loop that was designed
        return text("Peaks beside no control: {named} dB; with the gain of the model this input tolerates {late}.", named=named, late=late)
    return text("Peaks beside no control: {named} dB; this input tolerates {late}.", named=named, late=late)
