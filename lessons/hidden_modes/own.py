"""Fit lesson 6 to the user's own plant: its hidden modes, or the mode nearest to hidden."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, LineFigure, PlaneFigure
from observer_lab.course.knobs import Knob, Number
from observer_lab.course.lesson import Design, Lesson
from observer_lab.engine import controllability, kalman_decomposition, observability
from observer_lab.engine.design import in_natural_units
from observer_lab.engine.simulation import Run
from observer_lab.engine.structure import Mode
from observer_lab.engine.systems import sorted_poles
from observer_lab.plants import Model
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import Text, format_number, text

from ..toolkit.boards import pole_boards
from ..toolkit.figures import TIME_TAB
from ..toolkit.gains import gains
from ..toolkit.knobs import pole_knobs, run_knobs
from ..toolkit.latex import pole_words
from .figures import cloud_figure, figures, measured_figure, mode_name, parts_figure
from .knobs import Case
from .study import Gains, Setting, compute

RANDOM_GAINS, FEW_DRAWS = 50, 14  # random gains on a map, for few states and for many


@dataclass(frozen=True, eq=False)
class Weakest:
    """The mode of a plant that is hidden, or nearest to it: a motion of it (n,), and rows (1 or 2)×n, zero for every other mode."""

    mode: Mode
    along: np.ndarray
    rows: np.ndarray

    def amount(self, values: np.ndarray) -> np.ndarray:
        """How much of it is in each row of a record (n_t, n); signed where it is real."""
        parts, size = values @ self.rows.T, self.rows @ self.along
        return parts[:, 0] / size[0] if len(size) == 1 else np.linalg.norm(parts, axis=1) / float(np.linalg.norm(size))


def weakest_of(case: Case) -> Weakest:
    """The unseen mode that grows fastest, else the one least seen."""
    A, mode = case.model.plant.A, min(case.seen.modes, key=lambda m: (m.visible, -m.pole.real if not m.visible else m.margin))
    (values, right), (twins, left) = np.linalg.eig(A), np.linalg.eig(A.T)
    v = right[:, int(np.argmin(np.abs(values - mode.pole)))]
    along = np.real(v) if np.any(np.abs(np.real(v)) > 1e-12) else np.imag(v)
    w = left[:, int(np.argmin(np.abs(twins - mode.pole)))]
    rows = np.vstack([np.real(w), np.imag(w)]) if abs(mode.pole.imag) > 1e-12 * abs(mode.pole) else np.real(w)[None]
    size = float(np.linalg.norm(rows @ along))
    if size < 1e-9 * float(np.linalg.norm(rows) * np.linalg.norm(along)):
        along = rows[0]  # a chain of equal poles: its end, whose part still obeys d(wᵀx)/dt = λ wᵀx
        size = float(np.linalg.norm(rows @ along))
    return Weakest(mode, along / np.abs(along).max() * max(np.abs(np.array(case.model.x0))), rows / size)


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """How much of the weakest mode is in the start, and the poles that can be moved."""
    return (
        Number("share", r"c_0", text("weakest mode in the start"), low=-2.0, high=2.0, default=1.0, step=0.05,
               hint=text("How much of the mode in the first line of Numbers is added to the start. The observer starts from 0.")),
        *(replace(knob, when=None) for knob in pole_knobs(model)),
        *run_knobs(model.horizon),
    )


def own_setting(case: Case, weakest: Weakest) -> Setting:
    """A person's own plant: the part of its weakest mode in the usual start is given by hand."""
    model, plant, usual = case.model, case.model.plant, np.array(case.model.x0)

    def placed(_: Case, design: Design) -> Gains:
        K, L = gains(design, plant, model)
        return (K, L), (sorted_poles(plant.A - plant.B @ K), sorted_poles(plant.A - L @ plant.C))

    def start(design: Design) -> Sequence[float]:
        return (usual - weakest.along * weakest.amount(usual[None])[0] + design["share"] * weakest.along).tolist()
    return Setting(lambda _: case, placed, start, lambda _, *shown: pole_boards(model, *shown), lambda *_: _live(case, weakest.mode))


def _live(case: Case, weakest: Mode) -> Text:
    name = mode_name(weakest)
    unseen, unmoved = (pole_words([p for p in poles if p.imag >= 0][:4]) for poles in (case.unseen, case.unmoved))
    if case.unseen and not case.seen.detectable:
        return text("Weakest mode {name}. Hidden from y: {unseen}, and not settling: no L makes the error decay.",
                    name=name, unseen=unseen)
    if case.unseen:
        return text("Weakest mode {name}. Hidden from y: {unseen}; it settles by itself.", name=name, unseen=unseen)
    if case.unmoved:
        return text("Weakest mode {name}. Out of reach of u: {unmoved}.", name=name, unmoved=unmoved)
    return text("There is no fixed mode. The mode nearest to hidden is {name}, by {distance:.2g}.",
                name=name, distance=weakest.distance)


def _lines(weakest: Weakest, case: Case, run: Run) -> tuple[LineFigure, ...]:
    """What the sensor says and the weakest mode; parts of e and x."""
    plant, true, guess = case.model.plant, weakest.amount(run.x), weakest.amount(run.xhat)
    sensor, length = plant.output_names[0], float(np.linalg.norm(weakest.along))

    def parts(name: str, what: str, values: np.ndarray) -> LineFigure:
        weak, rest = np.abs(weakest.amount(values)) * length, np.linalg.norm(values, axis=1)
        said = (text("From start to end the weakest mode's part changes by a factor of {grown:.2g}.", grown=weak[-1] / max(weak[0], 1e-300))
                if weak[0] > 1e-12 * rest[0] else text("The start holds nothing of the weakest mode."))
        return parts_figure(name, what, run, Curve(text("weakest mode"), weak, "error"), Curve(text("the whole"), rest, "second", "dash"),
                            said)
    return (
        measured_figure(run, text("what sensor {name} says", name=signal_name(plant, sensor)), f"[{plant.unit(sensor)}]",
                        text("At the end they differ by {y:.2g}.", y=abs(run.y[-1, 0] - run.yhat[-1, 0]))),
        LineFigure("centre", text("the weakest mode"), run.t,
                   (Curve(text("true"), true), Curve(text("estimate"), guess, "estimate", "dash")), "c(t)", tab=TIME_TAB,
                   caption=text("Mode {weakest}; at the end the estimate of its part is off by {true:.2g}.",
                                weakest=mode_name(weakest.mode), true=abs(true[-1] - guess[-1]))),
        parts("error_parts", "e", run.e), parts("state_parts", "x", run.x))


def _clouds(case: Case, seed: int) -> tuple[PlaneFigure, ...]:
    """Poles under gains that are drawn around those of the start."""
    model, plant, rng, found = case.model, case.model.plant, np.random.default_rng(seed), []
    count = RANDOM_GAINS if plant.n <= 8 else FEW_DRAWS
    for gain, base, bolts, window in (("L", model.observer, case.unseen, model.observer_window),
                                      ("K", model.controller, case.unmoved, model.controller_window)):
        assert base is not None
        draws = base.gain * np.exp(rng.normal(0.0, 1.0, (count, 1, 1))) * (1 + rng.normal(0.0, 0.5, (count, *base.gain.shape)))
        poles = np.linalg.eigvals(plant.A - (draws @ plant.C if gain == "L" else plant.B @ draws))
        size = round_up_nicely(max(-window.re_low, window.im_high))
        found.append(cloud_figure(poles, bolts, gain, (-size, 0.5 * size), size, lambda least, gain=gain: text(
            "{count} gains {letter} drawn around the start. The best has its rightmost pole at {least}.",
            count=count, letter=gain, least=format_number(least, ".3g")), 3 * size))
    return tuple(found)


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant; the tasks choose among the lesson's five plants and stay with them."""
    even = in_natural_units(model.plant)
    case = Case("own", model.label, model, observability(even), controllability(even), kalman_decomposition(model.plant))
    weakest = weakest_of(case)
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, own_setting(case, weakest)),
                   figures=partial(figures, partial(_lines, weakest), _clouds), tasks=())
