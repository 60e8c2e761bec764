"""Draw the report's tuning rules: each with its evidence, and three of them beside what happens."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, Figure, PlaneFigure, Point, TableFigure, finite, over_frequency
from observer_lab.course.lazy import TabFigures, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import NO_WORDS, Text, format_number, joined, same, squared_unit, text, text_in

from ..toolkit.latex import tiny
from .cases import DOYLE, REPORT
from .knobs import CAUTION_RULE, NONE, PROCESS_RULE, RULES, SENSOR_RULE, SPLIT_RULE, UNITS_RULE, WRONG_RULES
from .study import Study
from .tuning import (
    INPUT_WEIGHTS,
    SENSOR_NOISES,
    STEP,
    Reached,
    channel_reductions,
    filter_by_sensor_noise,
    filter_step,
    motion_by_input_weight,
    reached,
    structure,
)

RULE_1_TAB, RULE_2_TAB, RULE_4_TAB = text("Rule 1"), text("Rule 2"), text("Rule 4")
ALL_OF_K, SPARSE_K = text("all of K"), text("K without cross gains")
HOLDS, REVERSED = text("holds"), text("the reverse happens")
KEPT_DB, SAME_DB = 3.0, 1.0  # a loss that still counts as kept; a difference that counts as none
AXIS = (1e-9, 1e12)  # the least and the largest value that is drawn
SAME_COST_PERCENT = 0.01
ROTATION = 1  # the channel in which the cross gains act
REPORT_TAB = text("Report")


def tuning_leaves(outcome: Outcome[Study]) -> Sequence[TabFigures]:
    """Figure and table of each rule; on a person's own plant, whose channels are not known, without rule 4."""
    case = outcome.study.case
    rules = (tab_figures(RULE_1_TAB, lambda: (_input_weights(outcome), _regulator_table(outcome))),
             tab_figures(RULE_2_TAB, lambda: (_sensor_noises(outcome), _filter_table(outcome))))
    crossing = {REPORT: lambda: (_cross_spectrum(outcome), _cross_table(outcome)), DOYLE: lambda: _one_input(outcome)}
    return (*rules, tab_figures(RULE_4_TAB, crossing[case.id])) if case.id in crossing else rules


def _number(value: float) -> str:
    return format_number(value, ".3g") if np.isfinite(value) else "—" if np.isnan(value) else "∞"


def _decades(x: Sequence[float], curves: Sequence[tuple[Text, np.ndarray, str]], now: float, labels: tuple[Text | str, Text | str],
                id: str, title: Text, caption: Text, tab: Text) -> PlaneFigure:
    """Curves over decades in both directions, with a mark on each where the knob stands now."""
    at = np.log10(np.asarray(x))
    lines = [(name, at[found], np.log10(np.clip(y[found], *AXIS)), role) for name, y, role in curves if (found := ~np.isnan(y)).any()]
    heights = np.concatenate([np.zeros(1), *(y for _, _, y, _ in lines)][bool(lines):])
    low, high = np.floor(heights.min() - 0.1), np.ceil(heights.max() + 0.1)
    here = float(np.clip(np.log10(max(now, AXIS[0])), at[0], at[-1]))
    marks = tuple(Point(here, float(np.interp(here, where, y)), role, "dot") for _, where, y, role in lines)
    return PlaneFigure(id, title, tuple(Curve(name, y, role, "solid", 2.2, where) for name, where, y, role in lines), marks, *labels,
                       (float(at[0]), float(at[-1])), (float(low), float(high)), tab=tab, caption=caption, powers="xy")


# --- rule 1 ----------------------------------------------------------------------------------------------------------
def _input_weights(outcome: Outcome[Study]) -> PlaneFigure:
    s = outcome.study
    known, estimated = motion_by_input_weight(s.case, s.setting)
    ratio = [y.max() / y.min() if np.isfinite(y).all() and y.min() > 0 else np.inf for y in (known, estimated)]
    said = (text("Over the knob α_R changes the motion by a factor of {known} with the state measured, of {estimated} with this filter.",
                 known=_number(ratio[0]), estimated=_number(ratio[1])) if np.isfinite(ratio).all() else
            text("At some α_R on this knob a loop is unstable or has no solution."))
    return _decades(INPUT_WEIGHTS, ((text("state measured (C = I)"), known, "plant"), (text("with this filter"), estimated, "estimate")),
                    s.setting.factors.alpha_r, (text("input weight α_R"), text("weighted motion")), "rule-1",
                    text("rule 1: tune the regulator as if the state were measured"), said, RULE_1_TAB)


def _regulator_table(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study
    case = s.case
    both = [reached(case, s.setting, measured) for measured in (True, False)]
    shares = [[""] * case.plant.m if r is None or not r.inputs.sum() > 0 else
              [f"{100 * part:.0f} %" for part in r.inputs / r.inputs.sum()] for r in both]

    def beside(name: Text, values: Sequence[str]) -> tuple[Text | str, ...]:
        return (name, *values)

    def height(r: Reached | None, i: int) -> str:
        if r is None:
            return "∞"
        return f"{_number(r.reductions[i])} dB" if r.reductions is not None else _number(case.scale * float(np.sqrt(r.channels[i])))

    rows = [beside(text("{name}: peak lowered by", name=name) if case.open_psd is not None else text("{name}: rms", name=name),
                   [height(r, i) for r in both]) for i, name in enumerate(case.names)]
    rows += [beside(text("input {name}: rms, share of the power", name=signal_name(case.plant, name)),
                    ["∞" if r is None else f"{_number(case.input_scale * float(np.sqrt(r.inputs[j])))}, {share[j]}"
                     for r, share in zip(both, shares, strict=True)]) for j, name in enumerate(case.plant.input_names)]
    known, estimated = both
    if known is None or estimated is None:
        said = text("With the true gain m one of these loops is unstable.")
    elif known.reductions is None or estimated.reductions is None:
        said = text("Rule 1 holds for the poles: those of the regulator stay poles of the loop.")
    else:
        lost = float(np.max(known.reductions - estimated.reductions))
        said = joined(text("Rule 1 holds for the poles: those of the regulator stay poles of the loop."),
                      claim(text("It does not hold for the reduction: the filter takes away up to {lost:.3g} dB.", lost=lost), lost,
                            above=KEPT_DB, otherwise=text("Here the filter takes away at most 3 dB.")))
    return TableFigure("rule-1-table", text("the regulator alone, and in the loop"),
                       (text("quantity"), text("state measured (C = I)"), text("with this filter")), tuple(rows),
                       said if s.setting.gain == 1 or known is None or estimated is None else
                       text("The true gain m is not 1, so the poles of the regulator are not those of the loop."), RULE_1_TAB)


# --- rule 2 ----------------------------------------------------------------------------------------------------------
def _sensor_noises(outcome: Outcome[Study]) -> PlaneFigure:
    s = outcome.study
    noise, speed = filter_by_sensor_noise(s.case, s.setting)
    f = s.setting.factors
    curves = tuple((name, y / _now(y, f.beta_r), role) for name, y, role in (
        (text("input from sensor noise"), noise, "error"), (text("speed of the filter (sum of its poles)"), speed, "estimate")))
    return _decades(SENSOR_NOISES, curves, f.beta_r, (text("assumed sensor noise β_R"), text("times the value now")), "rule-2",
                    text("rule 2: hold the regulator, tune the filter"),
                    text("β_R to the right has the effect of β_Q to the left: L depends on β_Q/β_R alone."), RULE_2_TAB)


def _now(y: np.ndarray, beta_r: float) -> float:
    """The value of a curve over β_R where the knob stands, between its points; nan where no point is known."""
    known = np.isfinite(y) & (y > 0)
    if not known.any():
        return float(np.nan)
    return float(10 ** np.interp(np.log10(beta_r), np.log10(SENSOR_NOISES)[known], np.log10(y[known])))


def _filter_table(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study
    sensors, process = filter_step(s.case, s.setting, 1.0, STEP), filter_step(s.case, s.setting, STEP, 1.0)

    def verdict(factor: float, rises: bool) -> Text:
        return same("—") if not np.isfinite(factor) or factor == 1 else HOLDS if (factor > 1) == rises else REVERSED

    rows = (
        (text("β_R ↑: the model is trusted more"), text("‖L‖ ×{factor}", factor=_number(sensors.gain)), verdict(sensors.gain, False)),
        (text("β_R ↑: noise is suppressed less"), text("input from sensor noise ×{factor}", factor=_number(sensors.noise)),
         verdict(sensors.noise, True)),
        (text("β_Q ↑: disturbances act more on the estimate"), text("‖L‖ ×{factor}", factor=_number(process.gain)),
         verdict(process.gain, True)),
        (text("β_Q ↑: the response is faster"), text("sum of the filter's poles ×{factor}", factor=_number(process.speed)),
         verdict(process.speed, True)),
    )
    both = filter_step(s.case, s.setting, STEP, STEP)
    said = text("Raised together, the two factors change ‖L‖ {factor} times.", factor=_number(both.gain))
    return TableFigure("rule-2-table", text("rule 2, each factor raised tenfold"),
                       (text("the report says"), text("this loop"), text("verdict")), rows,
                       claim(text("Raised together, the two factors leave L as it is: they are one knob."), abs(both.gain - 1), below=1e-5,
                             otherwise=said if np.isfinite(both.gain) else NO_WORDS), RULE_2_TAB)


# --- rule 4 ----------------------------------------------------------------------------------------------------------
def _cross_spectrum(outcome: Outcome[Study]) -> Figure:
    s = outcome.study
    case, square = s.case, s.case.scale**2
    both = structure(case, s.setting)
    curves = [Curve(text("no control"), square * s.disturbance * np.asarray(case.open_psd)[:, ROTATION], "muted", "dash", 1.8)]
    for name, z, role in ((ALL_OF_K, both.full, "plant"), (SPARSE_K, both.sparse, "second")):
        if z.stable:
            curves.append(Curve(name, finite(square * z.psd(case.frequency)[:, ROTATION], 1e30), role))
    top = max(float(c.y.max()) for c in curves)
    return over_frequency("rule-4", text("rule 4: {name} with a sparse K", name=case.names[ROTATION]), case.frequency, tuple(curves),
                          f"[{squared_unit(case.unit)}/Hz]",
                          text("Cross gains let one channel's states drive another channel's coils; the sparse K has none."), RULE_4_TAB,
                          (max(min(float(c.y.min()) for c in curves), 1e-14 * top), top))


def _cross_table(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study
    case = s.case
    both = structure(case, s.setting)
    drops = [channel_reductions(case, s.setting, z) for z in (both.full, both.sparse)]
    rows = (
        *((text("{name}: peak lowered by", name=name), *("∞" if d is None else f"{_number(d[i])} dB" for d in drops))
          for i, name in enumerate(case.names)),
        (text("couple (u₁ − u₂)/2: rms"), *(f"{_number(case.input_scale * c)} {case.input_unit}" for c in both.couple)),
        (text("from the cross gains alone"), f"{_number(case.input_scale * both.crossing)} {case.input_unit}", "0"),
        (same("J"), *(_number(c) for c in both.cost)),
    )
    return TableFigure("rule-4-table", text("all of K, and K without cross gains"),
                       (text("quantity"), ALL_OF_K, SPARSE_K), rows, _structure_words(both.cost, drops), RULE_4_TAB)


def _one_input(outcome: Outcome[Study]) -> tuple[Figure, Figure]:
    """The same two on a plant with one input, where nothing can be left out of K."""
    s = outcome.study
    case, z = s.case, s.loop
    curve = (Curve(ALL_OF_K, finite(z.psd(case.frequency)[:, ROTATION], 1e30), "plant") if z.stable else
             Curve(text_in("lqg", "none"), np.ones(len(case.frequency)), "muted"))
    said = text("Rule 4 has nothing to choose here: the plant has one input.")
    rows = ((text("inputs"), same("1")), (text("cross gains in K"), text_in("lqg", "none")))
    return (over_frequency("rule-4", text("rule 4: {name} with a sparse K", name=case.names[ROTATION]), case.frequency, (curve,),
                           f"[{squared_unit(case.unit)}/Hz]", said, RULE_4_TAB),
            TableFigure("rule-4-table", text("all of K, and K without cross gains"), (text("quantity"), ALL_OF_K), rows, said, RULE_4_TAB))


def _structure_words(cost: tuple[float, float], drops: Sequence[np.ndarray | None]) -> Text:
    full, sparse = drops
    if full is None or sparse is None:
        return text("With the true gain m one of these loops is unstable.")
    dearer, gained = 100 * (cost[1] / cost[0] - 1), float(sparse[ROTATION] - full[ROTATION])
    price = (text("Both K cost the same on average, within 0.01 %.") if abs(dearer) < SAME_COST_PERCENT else
             text("The sparse K costs {dearer} % more on average.", dearer=_number(dearer)) if dearer > 0 else
             text("The sparse K costs {dearer} % less, because the filter assumes another noise.", dearer=_number(-dearer)))
    lowered = claim(text("Here the cross gains lower the peak of the rotation by {gained:.3g} dB.", gained=-gained), gained,
                    below=-SAME_DB, otherwise=text("For the peak of the rotation the cross gains make no difference."))
    return joined(price, claim(
        text("Rule 4 holds: without the cross gains the peak of the rotation is {gained:.3g} dB lower.", gained=gained), gained,
        above=SAME_DB, otherwise=lowered))


def rules_figure(outcome: Outcome[Study]) -> TableFigure:
    """The rules one by one; the chosen one with its evidence."""
    study, chosen = outcome.study, outcome.design["rule"]
    m = {name: value if np.isfinite(value) else np.inf for name, value in study.answers.items()}
    evidence = {
        SPLIT_RULE: lambda: text("holds: the loop's poles are both sets, off by {union_error}",
                            union_error=tiny(m["union_error"])),
        SENSOR_RULE: lambda: text("slip: input from sensor noise ×{sensor_less:.3g} at β_R/10, ×{sensor_more:.3g} at "
                             "10 β_R",
                             sensor_less=m["sensor_less"], sensor_more=m["sensor_more"]),
        PROCESS_RULE: lambda: text("holds: at 10 β_Q the sum of the filter's poles ×{process_more:.3g}, input from "
                              "sensor noise ×{process_input:.3g}",
                              process_more=m["process_more"], process_input=m["process_input"]),
        CAUTION_RULE: lambda: text("holds: there is no guarantee; here min |1 + ℓ| = {nearest:.3g}", nearest=study.real.margins.nearest),
        UNITS_RULE: lambda: text("slip: R_v = σ_v² I gives 10⁻¹⁸; the figures use 10⁻⁹ and 10⁻⁶"),
    }
    rows = tuple((label, evidence[key]() if key == chosen else same("—")) for key, label in RULES if key != NONE)
    said = (text("Choose a line with the last knob.") if chosen == NONE else
            text("This line is wrong.") if chosen in WRONG_RULES else text("This line holds."))
    return TableFigure("rules", text("lines of the report, section 5.2"),
                       (text("line"), text("this loop says")), rows, said, REPORT_TAB)
