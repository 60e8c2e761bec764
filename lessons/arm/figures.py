"""Draw the figures of lesson 20: load, angle, speed, error, input, backlash, data sheet."""

from __future__ import annotations

from dataclasses import replace
from math import degrees
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.diagram import DiagramFigure
from observer_lab.course.figures.records import Curve, Figure, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lesson import Outcome
from observer_lab.plants.arm import ANGLE_INDEX, CURRENT_INDEX, LOAD_INDEX, MODEL, MOTOR_DATA, SPEED_INDEX
from observer_lab.text import NO_WORDS, Text, format_number, joined, text

from ..toolkit.diagram import Limit, loop
from ..toolkit.figures import ERROR_TAB, TIME_TAB, error_figure, input_figure, within
from ..toolkit.knobs import untouched
from .knobs import EXACT_ENCODER, JOINT
from .loop import ARM_PLANT, LOAD_AT
from .study import NOT_DECAYING, RESTED, SOLID, Study, last, sheet_rows

GEAR_TAB, NUMBERS_TAB = text("Gear"), text("Numbers")
TRUE, ESTIMATE = text("true"), text("estimate")
BEYOND = MappingProxyType({"angle": 360.0, "load": 20.0, "speed": 60.0, "current": 160.0, "input": 48.0, "gear": 6.0})  # drawn at the edge


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Three tabs of curves, one of numbers, and the loop."""
    run = outcome.run
    assert run is not None
    limit = outcome.design["u_max"]
    voltage = replace(input_figure(run, MODEL, limit), title=text("voltage, asked and applied"), window=(-5.0, 10.0))
    error = replace(error_figure(run, outcome.study.promised), caption=_error_words(outcome))
    lines = (_angle(outcome), _load(outcome), _speed(outcome), voltage, _current(outcome), _gear(outcome))
    angle, load, speed, voltage, current, gear = (within(figure, BEYOND[figure.id]) for figure in lines)
    return (load, angle, speed, error, voltage, current, gear, _loop(outcome), _speeds(outcome), _sheet(), _rest(outcome),
            _diagram(outcome), _model(outcome))


def _model(outcome: Outcome[Study]) -> MatrixFigure:
    """The matrix A that the observer has: what each state's rate depends on; that of the load on nothing."""
    names, whole = ("i", "ω", "θ", "τ"), bool(outcome.design["load_state"])
    kept = slice(None) if whole else slice(LOAD_INDEX)
    said = text("The entry in a row says how a rate depends on a state. The last row is zero: the model has no law for the load.")
    without = text("The entry in a row says how a rate depends on a state. This observer has no row for the load.")
    return MatrixFigure("model", text("matrix A of the observer's model"), ARM_PLANT.A[kept, kept],
                        tuple(f"d{name}/dt" for name in names[kept]), names[kept], lit=(LOAD_INDEX,) if whole else (),
                        caption=said if whole else without, tab=NUMBERS_TAB)


def _diagram(outcome: Outcome[Study]) -> DiagramFigure:
    run = outcome.run
    assert run is not None
    limit = Limit(run.u_asked, True) if run.saturated else None
    return loop(ARM_PLANT, run, outcome.gains["L"], outcome.gains["K"], limit=limit, reference=True,
                law="" if outcome.study.played.linear else r"\dot x = f(x, u),\quad y = h(x)")


def _pair(outcome: Outcome[Study], place: int, scale: float = 1.0) -> tuple[Curve, Curve]:
    run = outcome.run
    assert run is not None
    return Curve(TRUE, scale * run.x[:, place]), Curve(ESTIMATE, scale * run.xhat[:, place], "estimate", "dash")


def _angle(outcome: Outcome[Study]) -> LineFigure:
    run, design, m = outcome.run, outcome.design, outcome.metrics
    assert run is not None
    target = Curve(text("target"), np.full(len(run.t), design["target"]), "reference", "dot", 1.4)
    droop = text("At the end the arm is {droop:.3g}° below its target.", droop=m["droop"])
    above = text("At the end the arm is {droop:.3g}° above its target.", droop=-m["droop"])
    on = text("At the end the arm stands on its target.")
    words = claim(on, abs(m["droop"]), below=0.05, otherwise=claim(droop, m["droop"], above=0.0, otherwise=above))
    return LineFigure("angle", MODEL.watched[0].name, run.t, (*_pair(outcome, ANGLE_INDEX, degrees(1.0)), target), "θ [°]", tab=TIME_TAB,
                      caption=words, window=(0.0, 80.0))


def _load(outcome: Outcome[Study]) -> LineFigure:
    run, m, design = outcome.run, outcome.metrics, outcome.design
    assert run is not None
    off = text("In the last tenth of the run the estimate is off by up to {off:.2g} N m.", off=m["load_error"])
    none = text("This observer has no state for the load: its estimate stays at zero.")
    words = off if design["load_state"] else none
    return LineFigure("load", MODEL.watched[2].name, run.t, _pair(outcome, LOAD_INDEX), "τ [N m]", tab=TIME_TAB, caption=joined(
        words, _false_words(outcome)), window=(-0.2, 2.0))


def _false_words(outcome: Outcome[Study]) -> Text:
    m = outcome.metrics
    return claim(text("Before the load came it was up to {false:.2g} N m.", false=m["false_load"]), m["false_load"],
                 above=1e-3)


def _speed(outcome: Outcome[Study]) -> LineFigure:
    run, m = outcome.run, outcome.metrics
    assert run is not None
    return LineFigure("speed", MODEL.watched[1].name, run.t, _pair(outcome, SPEED_INDEX), "ω [rad/s]", tab=TIME_TAB, caption=text(
        "No sensor of speed: the estimate is off by {speed:.2g} rad/s at most.", speed=m["speed_error"]), window=(-2.0, 6.0))


def _current(outcome: Outcome[Study]) -> LineFigure:
    run, m = outcome.run, outcome.metrics
    assert run is not None
    rated = Curve(text("rated"), np.full(len(run.t), MOTOR_DATA.nominal_current), "reference", "dot", 1.4)
    return LineFigure(
        "current",
        MODEL.watched[3].name,
        run.t,
        (*_pair(outcome, CURRENT_INDEX), rated),
        "i [A]",
        tab=ERROR_TAB,
        caption=text(
            "No sensor of current: off by {current:.2g} A at most. The winding is rated for {rated:g} A in continuous use.",
            current=m["current_error"],
            rated=MOTOR_DATA.nominal_current,
        ),
        window=(-10.0, 30.0),
    )


def _error_words(outcome: Outcome[Study]) -> Text:
    m = outcome.metrics
    kept = text("The error follows ė = (A − LC)e: the load enters it once, at {at:g} s, and it decays from there.", at=LOAD_AT)
    stays = text("The load enters the error at {at:g} s and stays there: nothing in this observer takes it in.", at=LOAD_AT)
    leaves = text("The error departs from ė = (A − LC)e by {share:.2g} of its size: counts and play are no part of A − LC.",
                  share=m["separation_meter"])
    grows = text("A pole is not in the left half plane: the error grows.")
    if m["slowest_observer"] > NOT_DECAYING:
        return grows
    if m["separation_meter"] < SOLID and not outcome.design["load"]:
        return text("The error follows ė = (A − LC)e; no load enters it.")
    if m["separation_meter"] < SOLID and outcome.design["load_state"] and not untouched(outcome.design):
        return text("The error follows ė = (A − LC)e; the load at {at:g} s and each kick or pull add to it.", at=LOAD_AT)
    said = kept if outcome.design["load_state"] else stays
    return claim(said, m["separation_meter"], below=SOLID, otherwise=leaves)


def _gear(outcome: Outcome[Study]) -> LineFigure:
    """Arm against motor within the play, and the arm against what is believed of it."""
    run, shown, design = outcome.run, outcome.study.played, outcome.design
    assert run is not None
    half = design["gap"] / 2
    edges = tuple(Curve(text("flanks"), np.full(len(run.t), sign * half), "reference", "dot", 1.4) for sign in (1, -1))
    apart = Curve(text("arm less motor"), np.degrees(run.x[:, ANGLE_INDEX] - shown.motor))
    belief = Curve(text("arm less estimate"), np.degrees(run.e[:, ANGLE_INDEX]), "error", "dash")
    return LineFigure("gear", text("what the gear hides"), run.t, (apart, belief, *edges), "Δθ [°]", tab=GEAR_TAB,
                      caption=_gear_words(outcome), window=(-1.0, 1.0))


def _gear_words(outcome: Outcome[Study]) -> Text:
    design, m, run = outcome.design, outcome.metrics, outcome.run
    assert run is not None
    if not design["gap"]:
        return text("This gear has no play: arm and motor are one body.")
    rests = float(np.max(np.abs(last(outcome.study.played.contact) - outcome.study.played.contact[-1])))
    on = text("At the end the arm rests on one flank, {apart:.3g}° from the motor.",
              apart=abs(degrees(float(run.x[-1, ANGLE_INDEX] - outcome.study.played.motor[-1]))))
    flank = claim(on, rests, below=0.5, otherwise=text("In the last tenth of the run the contact still changes."))
    unseen = text("The encoder at the joint measures the arm itself.") if design["encoder"] == JOINT else text(
        "The encoder on the motor does not measure it, however fast the observer.")
    changed = text("Changes of contact: {count}.", count=int(m["changes"]))
    return joined(flank if outcome.study.played.contact[-1] else NO_WORDS, changed, unseen)


def _loop(outcome: Outcome[Study]) -> PlaneFigure:
    """The arm less the motor over the motor's angle: a line without play, a loop of its width with it."""
    run, motor, half = outcome.run, np.degrees(outcome.study.played.motor), outcome.design["gap"] / 2
    assert run is not None
    apart = np.degrees(run.x[:, ANGLE_INDEX]) - motor
    low, high = min(0.0, float(motor.min())), max(80.0, float(motor.max()))
    high, low = min(high, BEYOND["angle"]), max(low, -BEYOND["angle"])
    seen = Curve(text("arm less motor"), np.clip(apart, -BEYOND["gear"], BEYOND["gear"]), x=np.clip(motor, low, high))
    wide = max(1.0, 1.2 * half)
    words = text("The arm stays within {gap:.3g}° of play: where the motor brakes, the arm may go on by itself until the other flank "
                 "meets it.", gap=2 * half)
    return PlaneFigure("loop", text("arm less motor, over the motor's angle"), (seen,), (), text("motor, at the joint [°]"), "Δθ [°]",
                       (1.05 * low - 1.0, 1.05 * high), (-wide, wide), tab=GEAR_TAB,
                       caption=words if half else text("Without play this is a line."))


def _speeds(outcome: Outcome[Study]) -> PlaneFigure:
    """What a faster observer buys, and what it pays: each dot is one speed."""
    tried = tuple(each for each in outcome.study.tried if each.found is not None)
    x = np.array([each.found for each in tried], dtype=float)
    false, stray = (np.minimum([getattr(each, name) for each in tried], BEYOND["load"]) for name in ("false", "stray"))
    curves = (Curve(text("largest estimate before it came"), false, "error", x=x),
              Curve(text("strays at the end"), stray, "disturbance", "dash", x=x))
    points = tuple(Point(float(a), float(b), role, "dot") for a, y, role in ((x, false, "error"), (x, stray, "disturbance"))
                   for a, b in zip(x, y, strict=True))
    top = max(0.1, 1.1 * float(np.max([*false, *stray], initial=0.0)))
    return PlaneFigure("speeds", text("slower and faster observers"), curves if len(tried) else (), points if len(tried) else (),
                       text("the load is found after [s]"), "[N m]", (0.0, max(1.0, 1.05 * float(np.max(x, initial=0.0)))), (0.0, top),
                       tab=GEAR_TAB, caption=_speed_words(outcome))


def _speed_words(outcome: Outcome[Study]) -> Text:
    tried = outcome.study.tried
    if not tried:
        return text("Not computed for this design yet: press the button under the knobs.")
    lost = sum(each.found is None for each in tried)
    slow, fast = tried[0], tried[-1]
    said = text("From {slow:.2g} to {fast:.2g} times the speed: without a load the estimate is up to {least:.2g} N m, then {most:.2g} N m.",
                slow=slow.speed, fast=fast.speed, least=slow.false, most=fast.false)
    missed = text("{lost} of {count} never find the load to 5 %.", lost=lost, count=len(tried))
    ideal = text("Gear and encoder are ideal: without a load the estimate is zero, at any speed.")
    return joined(claim(said, fast.false, above=1e-6, otherwise=ideal), missed if lost else NO_WORDS)


def _sheet() -> TableFigure:
    rows = tuple((name, _amount(printed, unit), _amount(computed, unit), f"{100 * (computed / printed - 1):+.2f} %".replace("-", "−"))
                 for name, printed, computed, unit in sheet_rows())
    heads = text("quantity"), text("on the sheet"), text("from R and k"), text("apart")
    return TableFigure("sheet", text("the motor's data sheet"), heads, rows, tab=NUMBERS_TAB, caption=text(
        "maxon RE 40, order number 148867: R = 0.299 Ω, L = 0.082 mH, k = 30.2 mN m/A, rotor 142 g cm². The arm is chosen."))


def _amount(value: float, unit: str) -> str:
    return f"{value:.0f} {unit}" if value >= 200 else f"{value:.4g} {unit}"


def _rest(outcome: Outcome[Study]) -> TableFigure:
    run, rest, design = outcome.run, outcome.study.rest, outcome.design
    assert run is not None
    x, xhat = (np.mean(last(values), axis=0) for values in (run.x, run.xhat))

    def row(name: Text, places: tuple[float, float], unit: str, scale: float = 1.0) -> tuple[Text | str, ...]:
        return (name, *("—" if np.isnan(v) else f"{format_number(scale * v, '.4g')} {unit}" for v in places))
    promised = [(np.nan,) * 4] * 2 if rest is None else rest
    rows = (
        row(text("angle, true"), (promised[0][ANGLE_INDEX], x[ANGLE_INDEX]), "°", degrees(1.0)),
        row(text("angle, estimate"), (promised[1][ANGLE_INDEX], xhat[ANGLE_INDEX]), "°", degrees(1.0)),
        row(text("load, estimate"), (promised[1][LOAD_INDEX], xhat[LOAD_INDEX]), "N m"),
        row(text("current, true"), (promised[0][CURRENT_INDEX], x[CURRENT_INDEX]), "A"),
    )
    if rest is None:
        said = text("This loop comes to no rest.")
    elif not outcome.study.played.linear or design["encoder"] != EXACT_ENCODER:
        said = (
            text("On the left an ideal gear and an exact encoder. On the right this run, whose gear has play and whose encoder counts.")
            if design["gap"] and design["encoder"] != EXACT_ENCODER
            else text("On the left an ideal gear. On the right this run, whose gear has play.")
            if design["gap"]
            else text("On the left an exact encoder. On the right this run, whose encoder counts.")
            if design["encoder"] != EXACT_ENCODER
            else text("On the left a voltage without limit. On the right this run, whose voltage is limited.")
        )
    else:
        gap = max(abs(degrees(rest[0][ANGLE_INDEX] - x[ANGLE_INDEX])), abs(rest[1][LOAD_INDEX] - xhat[LOAD_INDEX]))
        said = claim(text("The run ends where the equations of rest say."), gap, below=RESTED,
                     otherwise=text("The run has not come to rest yet, or its voltage is at its limit."))
    return TableFigure("rest", text("at rest under the load"), (text("quantity"), text("linear loop"), text("end of this run")), rows,
                       tab=NUMBERS_TAB, caption=said)
