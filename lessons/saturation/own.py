"""Fit lesson 7 to the user's own plant: recovery map over x(0) and e(0) under a limit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, cast

import numpy as np

from observer_lab.course.figures.records import Curve, Figure, MapFigure
from observer_lab.course.knobs import Choice, Knob, KnobError, Number
from observer_lab.course.lesson import Design, Formula, Job, Lesson, Outcome
from observer_lab.engine import Plant, Scenario, autonomous_error, simulate
from observer_lab.engine.simulation import Run
from observer_lab.plants import Model
from observer_lab.text import NO_WORDS, Text, joined, text

from ..toolkit.boards import pole_boards, stage
from ..toolkit.figures import error_figure, input_figure, state_figures, within
from ..toolkit.gains import feedback, injection
from ..toolkit.knobs import kicks, pole_knobs, run_knobs
from ..toolkit.latex import gain_words
from .derive import derived_own
from .ending import Ending, ending_of, map_span
from .figures import CATEGORIES
from .job import survey
from .knobs import APPLIED, COMMANDED
from .study import NOT_COMPUTED, amount, checks_of, depends, limited, poles_of

START_GRID = np.linspace(-3.0, 3.0, 25)  # starts and errors, in units of the plant's own start
LAW_RTOL = 1e-8  # of the error's peak: how well ė = (A − LC)e must hold to count as exact
RECOVERED_SIZE, LOST_SIZE = 0.1, 100.0  # of the start's size: come home below the one at the end, lost beyond the other
PASS_STRIDE = 4  # every so many rows of errors are one pass
MAP_RUN_STEPS = 200  # of a run on the map


@dataclass(frozen=True, eq=False)
class OwnStudy:
    """What a design leads to beside its run; `known`: states had x been known; `values`: the map, once it is there."""

    known: Run
    end: Ending
    values: np.ndarray | None = None


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """The lesson's knobs in the plant's own measures."""
    return (
        Choice("fed", "", text("input of the observer"), default=COMMANDED,
               options=((COMMANDED, text("the commanded input")), (APPLIED, text("the applied input"))),
               hint=text("The commanded input, or the applied input.")),
        Number("u_max", r"u_{\max}", text("limit of every input"), model.input_unit, low=0.02 * model.u_max,
               high=20 * model.u_max, default=model.u_max, scale="log",
               hint=text("The largest input that is given, either way.")),
        Number("start", r"x(0)", text("start, times its usual size"), low=-3.0, high=3.0, default=1.0, step=0.05,
               hint=text("How far off rest the plant starts.")),
        Number("error0", r"e(0)", text("error of its estimate, likewise"), low=-3.0, high=3.0,
               default=1.0, step=0.05,
               hint=text("The observer starts from the true start minus this share of it.")),
        *(replace(knob, when=None) for knob in pole_knobs(model)),
        *run_knobs(model.horizon),
    )


def scenario_of(model: Model, design: Design, K: np.ndarray, L: np.ndarray) -> Scenario:
    """The clipped loop from the design's own start."""
    x0 = design["start"] * np.array(model.x0)
    return Scenario(model.plant, K, L, x0=x0, xhat0=x0 - design["error0"] * np.array(model.x0), horizon=model.horizon, dt=model.dt,
                    u_min=-design["u_max"], u_max=design["u_max"], fed=cast(Literal["applied", "commanded"], design["fed"]),
                    impulses=kicks(design, model), seed=int(design["seed"]))


def _scale(model: Model) -> np.ndarray:
    return np.array([abs(v) or 1.0 for v in model.x0])


def compute(model: Model, design: Design) -> Outcome[OwnStudy]:
    """One clipped run, the same start with a known state, and what the error was promised."""
    plant = model.plant
    K, L = feedback(plant, design["controller_poles"], model), injection(plant, design["observer_poles"], model)
    scenario = scenario_of(model, design, K, L)
    run, ideal = simulate(scenario), simulate(replace(scenario, state_feedback=True))
    if min(len(run.t), len(ideal.t)) < 2:
        raise KnobError(text("Under this limit the plant grows without bound at once; raise it."))
    poles, end = poles_of(plant, K, L, design["fed"]), ending_of(run)
    metrics = limited(run, design["u_max"], poles, end, ending_of(ideal))
    checks = checks_of(metrics, LAW_RTOL, text("the compensator is stable while the input is clipped"), metrics["comes_home"])
    formulas = (Formula("error", r"\dot e = (A-LC)\,e" if design["fed"] == APPLIED else
                        r"\dot e = (A-LC)\,e + B\,(\mathrm{sat}\,u - u)"),
                Formula("K", gain_words("K", K)), Formula("L", gain_words(r"L^{\mathsf T}", L.T)))
    return Outcome(design, {"K": K, "L": L}, poles, metrics, checks, run,
                   pole_boards(model, design, poles["controller"], poles["observer"], plant.A - L @ plant.C),
                   stage(model, run, design), formulas,
                   _live(metrics, end), OwnStudy(ideal, end))


def _live(m: Mapping[str, float], end: Ending) -> Text:
    first = text("The loop is unstable.") if end.unstable else NO_WORDS
    how = (text("This start recovers.") if end.home else text("This start does not recover.") if end.decided else
           text("Whether this start recovers is not decided within {long:.3g} s.", long=end.until))
    clipped = m["clipped_for"]
    limit = text("An input is clipped for {clipped:.3g} s.", clipped=clipped) if clipped > 0 else text("No input is ever clipped.")
    wall = (text("The error obeys A − LC all the same.") if m["separation_meter"] < LAW_RTOL and clipped > 0 else
            text("So the error obeys A − LC, whichever input the observer gets.") if m["separation_meter"] < LAW_RTOL else
            text("Separation meter {separation_meter}.", separation_meter=amount(m["separation_meter"])))
    return joined(first, how, limit, wall)


def figures(model: Model, outcome: Outcome[OwnStudy]) -> tuple[Figure, ...]:
    """Two signals, error and input, and the map of starts."""
    run, story, limit = outcome.run, outcome.study, outcome.design["u_max"]
    assert run is not None
    first, *rest = state_figures(model, run, 2)
    count = min(len(run.t), len(story.known.t))
    known = Curve(text("had x been known"), model.watched[0].of(story.known.x[:count]), "reference", "dot", 1.6)
    first = replace(first, x=run.t[:count], curves=(*(replace(c, y=c.y[:count]) for c in first.curves), known))
    lines = (first, *rest, error_figure(run, autonomous_error(run)), within(input_figure(run, model, limit), 8 * limit * model.input_scale))
    return (*lines, _map(outcome))


# --- the map -------------------------------------------------------------------------------------------------------------
def _map(outcome: Outcome[OwnStudy]) -> MapFigure:
    story, design = outcome.study, outcome.design
    values = np.full((len(START_GRID), len(START_GRID)), NOT_COMPUTED) if story.values is None else story.values
    done = float(np.mean(values != NOT_COMPUTED))
    said = (text("Not computed for this design yet: press the button under the knobs.") if done == 0 else
            text("{values:.1f} % of the starts computed so far recover. The circle runs now; click another start.",
                 values=100 * np.mean(values == 0) / done))
    assert outcome.run is not None
    if done:
        scenario, plant = outcome.run.scenario, outcome.run.scenario.plant
        said = joined(said, text("Each start is run for {span:.3g} s.", span=map_span(
            scenario.horizon, plant.A, plant.B, plant.C, scenario.K, scenario.L)))
    return MapFigure("starts", text("starts that recover"), START_GRID, START_GRID, values, CATEGORIES[:2], "x(0)", "e(0)",
                     (design["start"], design["error0"]), said, text("Map"))


def turned(model: Model, scenario: Scenario) -> Scenario:
    """The loop in coordinates whose first is how much of the usual start is in a state, all in typical sizes."""
    plant, s = model.plant, _scale(model)
    along = np.array(model.x0) / s
    Q = np.linalg.qr(np.column_stack([along, np.eye(plant.n)]))[0]
    Q = Q * np.sign(float(Q[:, 0] @ along))
    T = s[:, None] * Q * float(np.linalg.norm(along))
    inverse = np.linalg.inv(T)
    new = Plant(inverse @ plant.A @ T, inverse @ plant.B, plant.C @ T, plant.D)
    rest, span = np.zeros(plant.n), map_span(model.horizon, plant.A, plant.B, plant.C, scenario.K, scenario.L)
    return replace(scenario, plant=new, model=None, K=scenario.K @ T, L=inverse @ scenario.L, x0=rest, xhat0=rest, impulses=(),
                   horizon=span, dt=model.horizon / MAP_RUN_STEPS)


def find_starts(model: Model, outcome: Outcome[OwnStudy]) -> Iterator[tuple[float, np.ndarray | None]]:
    """The job: which starts come home, some rows of errors at a time; the loop is odd, so half of them are mirrored."""
    worst = max(float(np.real(outcome.poles[name]).max()) for name in ("controller", "observer"))
    if worst >= 0:
        raise KnobError(text("A pole is not in the left half plane, so no start recovers; drag it to the left if it can be moved."))
    scenario = turned(model, scenario_of(model, outcome.design, outcome.gains["K"], outcome.gains["L"]))
    blank, everywhere, up = np.full((len(START_GRID), len(START_GRID)), NOT_COMPUTED), np.arange(len(START_GRID)), START_GRID >= 0
    passes = [(everywhere, np.flatnonzero(up)[k::PASS_STRIDE]) for k in range(PASS_STRIDE)]
    for fraction, values in survey(scenario, 0, START_GRID, blank, passes, RECOVERED_SIZE, LOST_SIZE):
        yield fraction, None if values is blank else values


def with_map(outcome: Outcome[OwnStudy], values: np.ndarray) -> Outcome[OwnStudy]:
    """The outcome with the map in it."""
    return replace(outcome, study=replace(outcome.study, values=values))


def pick(outcome: Outcome[OwnStudy], x: float, y: float) -> Mapping[str, float]:
    """A click on the map: the start of the nearest cell, without a kick."""
    if not (np.isfinite(x) and np.isfinite(y)):
        raise KnobError(text("That click is not on the map."))
    cell = {name: float(START_GRID[int(np.argmin(np.abs(START_GRID - value)))]) for name, value in (("start", x), ("error0", y))}
    return {**cell, "kick": -1.0}


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, which fits whatever it is; the tasks speak of the pole and stay with it."""
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, model), figures=partial(figures, model), tasks=(),
                   job=Job(text("Map the starts that recover"), partial(find_starts, model), depends, with_map, figure="starts",
                           follows=True),
                   pick=pick, derived=partial(derived_own, model))
