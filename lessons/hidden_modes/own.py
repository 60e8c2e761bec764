"""Fit lesson 6 to the user's own plant: its hidden modes, or the mode nearest to hidden."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, Figure, LineFigure, MatrixFigure, PlaneFigure, TableFigure
from observer_lab.course.knobs import Knob, Number
from observer_lab.course.lesson import Check, Design, Formula, Lesson, Outcome
from observer_lab.engine import controllability, kalman_decomposition, observability
from observer_lab.engine.design import in_natural_units
from observer_lab.engine.simulation import Run
from observer_lab.engine.structure import Mode
from observer_lab.engine.systems import sorted_poles
from observer_lab.plants import Model
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import Text, format_number, text

from ..toolkit.boards import pole_boards, stage
from ..toolkit.figures import TIME_TAB, input_figure
from ..toolkit.gains import feedback, injection
from ..toolkit.knobs import pole_knobs, run_knobs
from ..toolkit.latex import gain_words, pole_words
from .figures import blocks_of, cloud_figure, lights_of, margins_of, measured_figure, parts_figure
from .knobs import Case
from .study import checks_of, tried

RANDOM_GAINS, FEW_DRAWS = 50, 14  # random gains on a map, for few states and for many
MOST_ROWS = 12  # of the table of modes


@dataclass(frozen=True, eq=False)
class Setting:
    """The plant, what is known of it before any gain, and its weakest mode.

    `along` (n,): a motion of that mode; `rows` (1 or 2)×n: how much of it is in a state, zero for every other mode.
    """

    model: Model
    case: Case
    weakest: Mode
    along: np.ndarray
    rows: np.ndarray


def setting_of(model: Model) -> Setting:
    """Everything about the plant itself. Raises EngineError where it cannot be taken apart."""
    plant = model.plant
    even = in_natural_units(plant)
    case = Case("own", model.label, model, observability(even), controllability(even), kalman_decomposition(plant))
    weakest = min(case.seen.modes, key=lambda m: (m.visible, -m.pole.real if not m.visible else m.margin))
    values, right = np.linalg.eig(plant.A)
    at = int(np.argmin(np.abs(values - weakest.pole)))
    along = np.real(right[:, at])
    along = along if np.any(np.abs(along) > 1e-12) else np.imag(right[:, at])
    twins, left = np.linalg.eig(plant.A.T)
    w = left[:, int(np.argmin(np.abs(twins - weakest.pole)))]
    rows = np.vstack([np.real(w), np.imag(w)]) if abs(weakest.pole.imag) > 1e-12 * abs(weakest.pole) else np.real(w)[None]
    size = float(np.linalg.norm(rows @ along))
    if size < 1e-9 * float(np.linalg.norm(rows) * np.linalg.norm(along)):
        along = rows[0]  # a chain of equal poles: its end, whose part still obeys d(wᵀx)/dt = λ wᵀx
        size = float(np.linalg.norm(rows @ along))
    return Setting(model, case, weakest, along / np.abs(along).max() * max(np.abs(np.array(model.x0))), rows / size)


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """How much of the weakest mode is in the start, and the poles that can be moved."""
    return (
        Number("share", r"c_0", text("weakest mode in the start"), low=-2.0, high=2.0, default=1.0, step=0.05,
               hint=text("How much of the mode in the first line of Numbers is added to the start. The observer starts from 0.")),
        *(replace(knob, when=None) for knob in pole_knobs(model)),
        *run_knobs(model.horizon),
    )


def compute(here: Setting, design: Design) -> Outcome[Setting]:
    """Gains for the movable poles with the bolted ones left where they are, and one run."""
    model, plant, case = here.model, here.model.plant, here.case
    K, L = feedback(plant, design["controller_poles"], model), injection(plant, design["observer_poles"], model)
    start = np.array(model.x0)
    start = start - here.along * _amount(here, start[None])[0] + design["share"] * here.along
    control, observer = map(sorted_poles, (plant.A - plant.B @ K, plant.A - L @ plant.C))
    run, metrics = tried(case, design, (K, L), (control, observer), start.tolist())
    return Outcome(
        design, {"K": K, "L": L}, {"controller": control, "observer": observer}, metrics, checks_of(case, metrics), run,
        pole_boards(model, design, control, observer, plant.A - L @ plant.C), stage(model, run, design),
        (Formula("K", gain_words("K", K)), Formula("L", gain_words(r"L^{\mathsf T}", L.T))), _live(here), here)


def _amount(here: Setting, values: np.ndarray) -> np.ndarray:
    """How much of the weakest mode is in each row of a record (n_t, n); signed where the mode is real."""
    parts = values @ here.rows.T
    return parts[:, 0] * np.sign(float((here.rows @ here.along)[0])) / np.abs(here.rows @ here.along)[0] if parts.shape[1] == 1 else (
        np.linalg.norm(parts, axis=1) / float(np.linalg.norm(here.rows @ here.along)))


def _name(mode: Mode) -> str:
    return pole_words([complex(mode.pole.real, abs(mode.pole.imag))])


def _live(here: Setting) -> Text:
    case, name = here.case, _name(here.weakest)
    unseen, unmoved = (pole_words([p for p in poles if p.imag >= 0][:4]) for poles in (case.unseen, case.unmoved))
    if case.unseen and not case.seen.detectable:
        return text("Weakest mode {name}. Hidden from y: {unseen}, and not settling: no L makes the error decay.",
                    name=name, unseen=unseen)
    if case.unseen:
        return text("Weakest mode {name}. Hidden from y: {unseen}; it settles by itself.", name=name, unseen=unseen)
    if case.unmoved:
        return text("Weakest mode {name}. Out of reach of u: {unmoved}.", name=name, unmoved=unmoved)
    return text("There is no fixed mode. The mode nearest to hidden is {name}, by {distance:.2g}.",
                name=name, distance=here.weakest.distance)


def figures(here: Setting, outcome: Outcome[Case]) -> tuple[Figure, ...]:
    """What the sensor says and the weakest mode; parts of e and x; margins, lights, decomposition; every gain."""
    run, seed = outcome.run, int(outcome.design["seed"])
    assert run is not None
    return (_measured(here, run), _mode(here, run),
            _parts(here, "error_parts", "e", run, run.e), _parts(here, "state_parts", "x", run, run.x),
            input_figure(run, here.model), *_modes(here, outcome.checks), *_every(here, seed))


def _measured(here: Setting, run: Run) -> LineFigure:
    name = here.model.plant.output_names[0]
    return measured_figure(run, text("what sensor {name} says", name=signal_name(here.model.plant, name)),
                           f"[{here.model.plant.unit(name)}]",
                           text("At the end they differ by {y:.2g}.", y=abs(run.y[-1, 0] - run.yhat[-1, 0])))


def _mode(here: Setting, run: Run) -> LineFigure:
    true, guess = _amount(here, run.x), _amount(here, run.xhat)
    return LineFigure("centre", text("the weakest mode"), run.t,
                      (Curve(text("true"), true), Curve(text("estimate"), guess, "estimate", "dash")), "c(t)", tab=TIME_TAB,
                      caption=text("Mode {weakest}; at the end the estimate of its part is off by {true:.2g}.",
                                   weakest=_name(here.weakest), true=abs(true[-1] - guess[-1])))


def _parts(here: Setting, name: str, what: str, run: Run, values: np.ndarray) -> LineFigure:
    weak = np.abs(_amount(here, values)) * float(np.linalg.norm(here.along))
    rest = np.linalg.norm(values, axis=1)
    grown = weak[-1] / max(weak[0], 1e-300)
    said = (text("From start to end the weakest mode's part changes by a factor of {grown:.2g}.", grown=grown)
            if weak[0] > 1e-12 * rest[0] else text("The start holds nothing of the weakest mode."))
    return parts_figure(name, what, run, Curve(text("weakest mode"), weak, "error"), Curve(text("the whole"), rest, "second", "dash"), said)


def _modes(here: Setting, checks: Sequence[Check]) -> tuple[TableFigure, TableFigure, MatrixFigure]:
    table = margins_of(here.case)
    return replace(table, rows=table.rows[:MOST_ROWS]), lights_of(checks), blocks_of(here.case)


def _every(here: Setting, seed: int) -> tuple[PlaneFigure, PlaneFigure]:
    """Poles under random gains: what no gain moves stays under its bolt."""
    plant, model = here.model.plant, here.model
    rng, count = np.random.default_rng(seed), RANDOM_GAINS if plant.n <= 8 else FEW_DRAWS
    found = []
    for gain, base, bolts, window in (("L", model.observer, here.case.unseen, model.observer_window),
                                      ("K", model.controller, here.case.unmoved, model.controller_window)):
        assert base is not None
        draws = base.gain * np.exp(rng.normal(0.0, 1.0, (count, 1, 1))) * (1 + rng.normal(0.0, 0.5, (count, *base.gain.shape)))
        poles = np.linalg.eigvals(plant.A - (draws @ plant.C if gain == "L" else plant.B @ draws))
        size = round_up_nicely(max(-window.re_low, window.im_high))
        found.append(cloud_figure(poles, bolts, gain, (-size, 0.5 * size), size, lambda least, gain=gain: text(
            "{count} gains {letter} drawn around the start. The best has its rightmost pole at {least}.",
            count=count, letter=gain, least=format_number(least, ".3g")), 3 * size))
    return found[0], found[1]


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant; the tasks choose among the lesson's five plants and stay with them."""
    here = setting_of(model)
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, here), figures=partial(figures, here), tasks=())
