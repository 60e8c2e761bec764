"""Draw the figures of lesson 10: spectra, cost, robustness, recovery, one run."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.diagram import DIAGRAM
from observer_lab.course.figures.records import Curve, LineFigure, PlaneFigure, Point, TableFigure, finite, over_frequency
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine.feedback import ChannelMargins
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import Text, format_number, same, squared_unit, text, text_in

from ..toolkit.figures import TIME_TAB, axis_name, within
from .loop_figures import CLOSEST_TAB, RECOVERY_TAB, UNIT_CIRCLE, both_halves, closest_figure, loop_of, rings_figure
from .robustness import Robustness
from .robustness import within as gain_within
from .study import Study, sensor_share
from .tuning_figures import REPORT_TAB, rules_figure, tuning_leaves

SPECTRUM_TAB, COST_TAB = text("Spectrum"), text("Input and cost")
ROBUST_TAB = text("Robustness")
TOO_MUCH = 1e30  # a density beyond this is drawn at it
NO_CONTROL, CLOSED = text("no control"), text("closed, predicted")
ANY = text("any")
ROLES = ("force", "disturbance", "second")


def figures(outcome: Outcome[Study]) -> FigureSet:
    """Everything on the right of the stage."""
    return FigureSet(
        tab_figures(SPECTRUM_TAB, lambda: _spectra(outcome)),
        tab_figures(COST_TAB, lambda: (_input(outcome), _cost(outcome))),
        tab_figures(ROBUST_TAB, lambda: (_nyquist(outcome), _return(outcome))),
        tab_figures(ROBUST_TAB, lambda: (_margins(outcome),), "late"),
        tab_figures(CLOSEST_TAB, lambda: (closest_figure(outcome),)),
        tab_figures(RECOVERY_TAB, lambda: (rings_figure(outcome), _loop_gain(outcome))),
        tab_figures(RECOVERY_TAB, lambda: (_price(outcome),), "late"),
        tab_figures(TIME_TAB, lambda: _run(outcome)),
        tab_figures(DIAGRAM, lambda: (loop_of(outcome),)),
        tab_figures(REPORT_TAB, lambda: (rules_figure(outcome),)),
        *tuning_leaves(outcome),
    )


def words(value: float, digits: int = 3) -> str:
    """A number for a table: ∞, a true minus sign, powers of ten where they help."""
    if not np.isfinite(value):
        return "∞"
    return format_number(value, f".{digits}g")


def level(power: float) -> str:
    """Decibels of a power ratio with a true minus sign."""
    return f"{power:.1f}".replace("-", "−")


def density(unit: str) -> str:
    """The axis of a density of a signal in this unit."""
    return f"[{squared_unit(unit)}/Hz]"


def _phase(m: ChannelMargins) -> Text | str:
    """The phase margin in degrees; any phase will do where |ℓ| = 1 nowhere."""
    return ANY if np.isnan(m.phase_frequency) and m.phase > 3 else f"{np.degrees(m.phase):.3g}°"


# --- spectra ---------------------------------------------------------------------------------------------------------
def _spectra(outcome: Outcome[Study]) -> tuple[LineFigure, ...]:
    s = outcome.study
    case, square = s.case, s.case.scale**2
    figures = []
    for i, name in enumerate(case.names):
        curves = []
        if case.open_psd is not None:
            curves.append(Curve(NO_CONTROL, square * s.disturbance * case.open_psd[:, i], "muted", "dash", 1.8))
        if s.trials is not None:
            curves.append(Curve(text("{count} runs", count=s.trials.count),
                                finite(square * s.trials.density[:, i], TOO_MUCH), "disturbance", "solid", 4.0))
            curves.append(Curve(text("predicted for this computer"),
                                finite(square * s.trials.predicted[:, i], TOO_MUCH), "reference", "dot", 1.6))
        if s.density is not None:
            curves.append(Curve(CLOSED, finite(square * s.density[:, i], TOO_MUCH), "plant"))
        figures.append(over_frequency(
            f"spectrum{i}", name, case.frequency, tuple(curves) or (Curve(text_in("lqg", "none"), np.ones(len(case.frequency)), "muted"),),
            density(case.unit), _spectrum_words(outcome, i), SPECTRUM_TAB, _deep(curves)))
    return tuple(figures)


def _deep(curves: list[Curve]) -> tuple[float, float] | None:
    """The range of all curves, at most twelve decades: a quiet channel is worth seeing too."""
    if not curves:
        return None
    top = max(float(c.y.max()) for c in curves)
    return max(min(float(c.y.min()) for c in curves), 1e-12 * top), top


def _spectrum_words(outcome: Outcome[Study], i: int) -> Text:
    s = outcome.study
    if s.density is None or s.variance is None:
        return text("The loop is unstable: it has no stationary spectrum.")
    if s.trials is not None:
        t = s.trials
        within = f"{100 * t.inside[i]:.0f} %"
        return text("Runs over prediction: {ratio:.2f} on average; {within} of the points lie within their 95 % "
                    "band.",
                    ratio=t.ratio[i], within=within)
    if s.suppression is None:
        rms = float(np.sqrt(s.variance[i])) * s.case.scale
        return text("Without control nothing is stationary; with it the rms is {rms:.3g}.", rms=rms)
    drop, low = s.suppression[i], s.low[i]
    under = (text("amplified {low} dB", low=level(-low)) if low < -0.1 else
             text("lowered {low} dB", low=level(low)) if low > 0.1 else text("nothing gained"))
    if drop < 0:
        return text("Peak raised by {drop} dB; at {low:.2g} Hz {under}.", drop=level(-drop), low=s.case.low, under=under)
    return text("Peak lowered by {drop} dB; at {low:.2g} Hz {under}.",
                drop=level(drop), low=s.case.low, under=under)


# --- input and cost --------------------------------------------------------------------------------------------------
def _input(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    case, square = s.case, s.case.input_scale**2
    names = [signal_name(case.plant, name) for name in case.plant.input_names]
    curves: list[Curve] = []
    if s.asked is not None:
        ground, sensors = s.asked
        for j in range(min(len(names), 3)):
            curves.append(Curve(names[j], finite(square * (ground + sensors)[:, j], TOO_MUCH), ROLES[j],
                                "dash" if j == 1 else "solid"))
        curves.append(Curve(text("{names}, sensors' part", names=names[-1]),
                            finite(square * sensors[:, -1], TOO_MUCH), "estimate", "dot", 1.6))
        part = sensor_share(s.cost)[1]
        share = 100 * part if np.isfinite(part) else 0.0
        said = text("The sensors' noise causes {share:.3g} % of the input's power.", share=share)
    else:
        curves.append(Curve(text_in("lqg", "none"), np.ones(len(case.frequency)), "muted"))
        said = text("The loop is unstable: the input has no spectrum.")
    return over_frequency("input", text("inputs"), case.frequency, tuple(curves), density(case.input_unit), said, COST_TAB,
                           _deep(curves))


def _cost(outcome: Outcome[Study]) -> TableFigure:
    c, wrong = outcome.study.cost, outcome.study.setting.gain != 1.0
    unknown = c.total - c.known
    rows = (
        (text("x known: tr(S G W Gᵀ)"), words(c.known)),
        (text("+ x only estimated, and m not 1") if wrong else text("+ x only estimated"), words(unknown)),
        (text("= this loop"), words(c.total, 4)),
        (text("of it E xᵀQx, E uᵀRu"), f"{words(c.state)}, {words(c.input)}"),
        (text("least for this noise"), words(c.least, 4)),
        (text("without control"), words(c.idle)),
    )
    if not np.isfinite(c.total):
        said = text("An unstable loop costs without bound.")
    else:
        more = c.total / c.least if c.least > 0 else 1.0 if c.total == 0 else np.inf
        said = claim(text("No other controller is cheaper on average under this noise."), more, below=1 + 1e-6,
                     otherwise=text(
            "{total} times the least: the inputs' gain, or the noise, is not what the model says.", total=words(more)) if wrong else text(
            "{total} times the least: the filter assumes another noise.", total=words(more)))
    return TableFigure("cost", text("average of xᵀQx + uᵀRu"), (text("part"), same("J")), rows,
                       said, COST_TAB)


# --- robustness ------------------------------------------------------------------------------------------------------
def _nyquist(outcome: Outcome[Study]) -> PlaneFigure:
    s = outcome.study
    ideal, real = both_halves(s.ideal.curve), both_halves(s.real.curve)
    low, high = gain_within(s.real.margins.gain)
    gap = s.real.curve[int(np.argmin(np.abs(1 + s.real.curve)))] + 1
    gap = gap / max(abs(gap), 1e-300) * s.real.margins.nearest
    return PlaneFigure(
        "nyquist", text("Nyquist, cut at one input"),
        (UNIT_CIRCLE, Curve(same("LQR"), ideal[1], "plant", "dash", 2.0, ideal[0]),
         Curve(same("LQG"), real[1], "estimate", "solid", 2.4, real[0]),
         Curve(text("distance to −1: {near}", near=words(s.real.margins.nearest)), np.array([0.0, gap.imag]), "error", "solid", 4.0,
               np.array([-1.0, gap.real - 1]))),
        (Point(-1.0, 0.0, "reference", "cross"),), "Re ℓ", "Im ℓ", (-2.0, 1.0), (-1.1, 1.1), equal=True, tab=ROBUST_TAB,
        caption=text("LQG stays stable while the input's gain is between {low} and {high} times the model's.",
                     low=words(low, 10), high=words(high, 10)))


def _return(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    f, least = s.case.wide, words(s.real.margins.nearest)
    curves = [Curve(same("LQR |1 + ℓ|"), np.clip(np.abs(1 + s.ideal.gain), 1e-6, 1e6), "plant", "dash"),
              Curve(same("LQG |1 + ℓ|"), np.clip(np.abs(1 + s.real.gain), 1e-6, 1e6), "estimate")]
    said = text("LQR never falls below 1; LQG comes down to {least}.", least=least)
    if s.case.plant.m > 1:
        curves.append(Curve(text("LQG, all inputs: σ_min(I + L)"),
                            np.clip(s.real.together, 1e-6, 1e6), "error", "dot", 1.6))
        together = words(s.real.nearest)
        said = text("LQR never falls below 1; LQG comes down to {least}, with all inputs at once to {together}.",
                    least=least, together=together)
    curves.append(Curve(same("1"), np.ones(len(f)), "reference", "dot", 1.2))
    return over_frequency("return", text("return difference"), f, tuple(curves), "|1 + ℓ|", said, ROBUST_TAB,
                           window=(0.1, 100.0))


def _margins(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study

    def column(r: Robustness) -> tuple[Text | str, ...]:
        m = r.margins
        low, high = m.gain
        return (f"{words(low, 4)} … {words(high, 6)}", _phase(m), ANY if np.isinf(m.delay) else f"{words(m.delay)} s",
                words(m.disk.alpha), words(m.nearest), f"{words(r.alpha)}, {words(r.nearest)}")

    names = (text("gain"), text("phase"), text("delay"), text("disk α"), same("min |1 + ℓ|"),
             text("all inputs: α, σ_min"))
    rows = tuple((name, a, b) for name, a, b in zip(names, column(s.ideal), column(s.real), strict=True))
    real = s.real.margins
    thin, hasty = real.gain[1] < 1.1 or real.gain[0] > 0.9 or real.phase < 0.1, real.delay < 1e-3
    best = s.cost.total <= s.cost.least * (1 + 1e-6)
    said = (text("A little error of gain, phase or timing breaks this loop, which is not even optimal for this "
                 "noise.") if thin and not best else
            text("Optimal, yet a little error of gain, phase or timing breaks it.") if thin else
            text("In gain and phase this loop has margins, but it is so fast that a delay of {delay:.2g} s breaks it.",
                 delay=real.delay) if hasty else
            text("This loop has margins, but optimality guarantees none of them.") if best else
            text("This loop has margins; for this noise it is not the optimal one."))
    return TableFigure("margins", text("margins"), (text("margin"), same("LQR"), same("LQG")), rows, said,
                       ROBUST_TAB)


# --- recovery --------------------------------------------------------------------------------------------------------
def _loop_gain(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    curves = [Curve(same("LQR |ℓ|"), np.clip(np.abs(s.ideal.gain), 1e-12, 1e12), "plant", "dash"),
              Curve(text("plain LQG |ℓ|"), np.clip(np.abs(s.plain.gain), 1e-12, 1e12), "muted", "dot", 1.6),
              Curve(text("this LQG |ℓ|"), np.clip(np.abs(s.real.gain), 1e-12, 1e12), "estimate")]
    gap = float(np.max(np.abs(1 / (1 + s.real.gain) - 1 / (1 + s.ideal.gain))))
    return over_frequency("loop-gain", text("loop gain, cut at one input"), s.case.wide,
                           tuple(curves), "|ℓ|",
                           text("Largest difference of the sensitivities of LQG and LQR: {gap}.", gap=words(gap)), RECOVERY_TAB,
                           window=(1e-3, 1e2))


def _price(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study
    unit = f" [{s.case.input_unit}]" if s.case.input_unit else ""
    noise = [s.case.input_scale * float(np.linalg.norm(c.sensors)) for c in (s.plain_cost, s.cost)]
    rows = (
        (text("gain may grow to"), words(s.plain.margins.gain[1], 6), words(s.real.margins.gain[1], 6)),
        (text("gain may fall to"), words(s.plain.margins.gain[0], 4), words(s.real.margins.gain[0], 4)),
        (text("phase margin"), _phase(s.plain.margins), _phase(s.real.margins)),
        (same("min |1 + ℓ|"), words(s.plain.margins.nearest), words(s.real.margins.nearest)),
        (text("input from sensor noise{unit}", unit=unit),
         words(noise[0]), words(noise[1])),
        (same("J"), words(s.plain_cost.total, 4), words(s.cost.total, 4)),
    )
    said = (text("Recovery is off: move ρ.") if outcome.design["recovery"] == 0 else
            claim(_bought(s, noise[1] / max(noise[0], 1e-300)), s.cost.total / s.plain_cost.total, above=1.0,
                  otherwise=text("Here the loop with recovery costs no more than the plain one.")))
    return TableFigure("price", text("what recovery gives and takes"),
                       (same(""), text("plain LQG"), text("now")), rows, said, RECOVERY_TAB)


def _bought(s: Study, noise: float) -> Text:
    """What the higher cost of recovery has bought: an approach to −1 that is farther, or none."""
    if s.real.margins.nearest <= s.plain.margins.nearest:
        return text("Recovery costs more here and brings the loop no farther from −1 at this input.")
    return claim(text("Margins are bought with noise in the input and a higher cost."), noise, above=1.0,
                 otherwise=text("Margins are bought with a higher cost."))


# --- one run ---------------------------------------------------------------------------------------------------------
def _run(outcome: Outcome[Study]) -> tuple[LineFigure, ...]:
    s = outcome.study
    run, model = s.trace, s.case.model
    figures = []
    for i, signal in enumerate(model.watched[:2]):
        edge = 40 * max(float(np.max(np.abs(signal.of(np.array([model.x0, model.guess]))))), 1e-9)
        true, guess = signal.of(run.x), signal.of(run.xhat)
        late = float(np.abs(true[-max(len(true) // 10, 1):]).max())
        figures.append(within(LineFigure(
            f"state{i}", signal.name, run.t,
            (Curve(text("true"), true), Curve(text("estimate"), guess, "estimate", "dash")),
            axis_name(signal), tab=TIME_TAB,
            caption=text("In the last tenth of the run at most {late:.2g} {unit}.", late=late, unit=signal.unit) if signal.unit else
            text("In the last tenth of the run at most {late:.2g}.", late=late)), edge))
    size = run.error(s.case)
    start = max(float(size[0]), 1e-12)
    half = np.flatnonzero(size > 0.1 * start)
    said = (text("Still above a tenth of its first size at the end.")
            if len(half) and half[-1] == len(run.t) - 1 else
            text("Last above a tenth of its first size at {t:.2f} s.", t=run.t[half[-1]] if len(half) else 0.0))
    figures.append(LineFigure(
        "error", text("estimation error over its first size"), run.t,
        (Curve(same("‖e‖ / ‖e(0)‖"), np.clip(size / start, 1e-9, 1e6), "error"),), "‖e‖ / ‖e(0)‖", log_y=True,
        tab=TIME_TAB, window=(1e-3, 1.0),
        caption=said))
    return tuple(figures)
