"""Compute a design of lesson 16: eight steps, and the run of three observer forms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Board, Check, Design, Outcome, Stage
from observer_lab.engine import BilinearPlant
from observer_lab.engine.observers import BilinearObserver
from observer_lab.plants.bilinear import BILINEAR_PLANT, PRINTED_FORM, PRINTED_L, X0
from observer_lab.plants.bodies.front_bars import share_of_decades
from observer_lab.plants.model import Window
from observer_lab.text import Text, format_number, same, text

from ..toolkit.boards import listed
from ..toolkit.figures import settle_time
from .formulas import formulas_of
from .input_signals import FILTERED_DERIVATIVE, HORIZON, form_index, joined, promised, signal
from .paper_example import pole_of, words
from .problems import (
    AS_PRINTED,
    COMPUTED_GAIN,
    HIGH,
    LAG_ERROR,
    LOW,
    PAPER_PROBLEM,
    PROBLEMS,
    ROUNDED_GAIN,
    Problem,
    lag_body,
    nearest_gain,
    piped_body,
    unknown_terms,
)
from .run_record import Record, Row, Setting, end_to_end, run_of

DT = 0.005
LAW_TOLERANCE = 1e-6  # of its own law, over its peak: an error this near follows it
LARGEST = 1e15  # number that is told of an own plant
GAIN_STEP = 6  # of the eight: it gives π, and so L
STATE_JUMP = (0.0, 0.0, 0.0, 0.0, 2.0, 0.0)


@dataclass(frozen=True, eq=False)
class Study:
    """What a design is about, and its run."""

    setting: Setting
    run: Record

    @property
    def observer(self) -> BilinearObserver:
        """The eight steps."""
        return self.setting.solved


FORM_NAMES = (text("without ẏ"), text("with the true ẏ"), text("with a differentiator"))
OBSERVER_WINDOW, PLANT_WINDOW = Window(-62.0, 18.0, 19.0), Window(-30.0, 10.0, 12.0)
PLANT_POLES = np.sort_complex(np.linalg.eigvals(BILINEAR_PLANT.A))
PLANT_POLES.setflags(write=False)
WINDOWS = MappingProxyType({"functional": (-10.0, 30.0), "error": (1e-6, 10.0), "input": (-1.0, 1.0), "fed": (-200.0, 200.0)})


def compute(setting_of: Callable[[Design], Setting], design: Design) -> Outcome[Study]:
    """The eight steps for what is wanted, L with the poles asked for, and one run of all three forms under the chosen input."""
    s = setting_of(design)
    study = Study(s, run_of(s, design))
    metrics = LazyMap(lambda: _metrics(design, study))
    return Outcome(design, {"L": s.L}, {"observer": s.poles, "plant": s.plant_poles}, metrics,
                   LazySequence(lambda: _checks(s, metrics)), None, s.boards, s.stage(study.run), LazySequence(s.formulas),
                   LazyValue(lambda: s.live(metrics)), study)


def _metrics(design: Design, study: Study) -> dict[str, float]:
    """Row by row, the worst row of each moment."""
    s, run, o, index = study.setting, study.run, study.observer, form_index(design)
    size, count = s.size(run), len(run.t)
    worst = np.max(np.abs(run.errors[:, index]) / size, axis=1)
    settled = settle_time(run.t, worst)
    found = {"case": float(o.case), "defect": o.defect_size, "late_error": float(np.max(worst[-max(count // 10, 1):])),
             "half_error": float(np.max(worst[count // 2:])), "settled_after": float("inf") if settled is None else settled,
             **s.told(run, worst)}
    if design["noise"]:
        late, running = run.heard[count // 2:, index] / size, s.plain if index == 0 else s.exact
        says = promised(joined(running, running, design["tau"]), s.deviations, s.dt).reshape(3, -1)[index]
        found |= {"noise_rms": float(np.max(np.sqrt(np.mean(late ** 2, axis=0)))),
                  "noise_promised": float(min(np.max(says / size), LARGEST))}
    return {name: float(np.clip(value, -LARGEST, LARGEST)) for name, value in found.items()} if s.own else found


def _checks(s: Setting, metrics: Mapping[str, float]) -> tuple[Check, ...]:
    o, gap, slowest = s.solved, metrics["law_gap"], float(np.max(np.real(s.poles)))
    names = ((text("(A*, B*) controllable: any poles"), text("the poles in use are on the left"), text("ε follows its poles under this u"))
             if s.own else
             (text("(A*, B*) controllable: any pole"), text("the pole in use is on the left"), text("ε follows its pole under this u")))
    return (
        Check("case1", text("case 1: (21) fails, no L"), o.case == 1, o.defect_size, informative=True),
        Check("case2", text("case 2: one L only"), o.case == 2, float(o.canonical_Q.rank), informative=True),
        Check("case3", text("case 3: a family of L"), o.case == 3, float(len(o.canonical_Q.zero_left)), informative=True),
        Check("controllable", names[0], *s.controllable),
        Check("stable", names[1], slowest < 0, slowest),
        Check("law", names[2], gap <= LAW_TOLERANCE, gap),
        *promises(o),
    )


def counts(o: BilinearObserver) -> tuple[int, int]:
    """(k + 2) m + r and (k + 1) n, of one input 3m + r and 2n: L has as many entries as equations where the first reaches the second."""
    k = o.plant.inputs
    return (k + 2) * o.plant.m + o.order, (k + 1) * o.plant.n


def bound(plant: BilinearPlant) -> str:
    """How the two counts are to lie, in letters."""
    return f"{plant.inputs + 2}m + r ≥ {plant.inputs + 1}n"


def promises(o: BilinearObserver) -> tuple[Check, Check, Check]:
    """What sizes and a pair of matrices promise before anything is solved."""
    (known, needed), n, m, q = counts(o), o.plant.n, o.plant.m, o.order
    return (
        Check("fewer", text("r < n − m: fewer states than Luenberger's reduced observer"), q < n - m, float(n - m - q), informative=True),
        Check("advised", text("{bound}: (21) holds in general", bound=bound(o.plant)), o.advised, float(known - needed), informative=True),
        Check("pair", text("(V₂AT₂, V₁AT₂) observable: any pole, if (21) asked nothing of L"), o.observable, float(o.order)),
    )


def boards_of(plant: tuple[tuple[complex, ...], Window], window: Window, title: Text, poles: tuple[complex, ...], knob: str | None,
              fixed: tuple[complex, ...], also: tuple[tuple[str, str], ...] = ()) -> tuple[Board, Board]:
    """The plant's poles, and those of the observer, which can be dragged where a knob holds them."""
    (own, left), right = plant, window
    return (
        Board("plant", text("the plant's poles at u = 0  eig(A)"), own, side="left", re_low=left.re_low, re_high=left.re_high,
              im_high=left.im_high),
        Board("observer", title, poles, knob, fixed=fixed, role="estimate", side="right", re_low=right.re_low, re_high=right.re_high,
              im_high=right.im_high, also=also))


# --- the paper's problems --------------------------------------------------------------------------------------------
def paper_setting(design: Design) -> Setting:
    """The problem and the pole of a design, with the numbers of ours or of the paper."""
    problem, index = PROBLEMS[design["problem"]], form_index(design)
    paper = problem.id == PAPER_PROBLEM
    o = problem.observer(design["pole"][0].real) if paper else problem.solved
    L = _gain(design, o)
    exact, plain = o.forms(L)
    if paper and design["gain"] == ROUNDED_GAIN:
        plain = PRINTED_FORM
    pole = PRINTED_FORM.A.item() if plain is PRINTED_FORM and index == 0 else pole_of(o, L)
    plant = problem.plant
    return Setting(
        False, o, L, exact, plain, np.array([complex(pole)]), PLANT_POLES, plant, np.ones(plant.n), np.array(X0),
        np.array([design["chi0"]]), np.array(STATE_JUMP), HORIZON, DT, signal(design), np.full(plant.m, design["noise"]),
        (Row(same("g"), same("ĝ"), same("|ε|"), text("e^({pole}t)", pole=words(np.array([pole]), 2))),), ((same("u"), ""),),
        (("u",), tuple(f"y{k + 1}" for k in range(plant.m))), WINDOWS, _boards(design, o, pole),
        (bool(o.controllable), float(np.max(np.abs(o.B_star), initial=0.0))),
        lambda calm: end_to_end([p.error[0, index] * np.exp(pole * p.t) for p in calm])[:, None],
        partial(_told, o, pole, index), partial(_told_of_error, design), partial(_stage, problem, design, L),
        lambda: formulas_of(o, L, plain, int(design["step"])), partial(_live, design, o))


def _gain(design: Design, observer: BilinearObserver) -> np.ndarray:
    """L (1×m) of the run: computed, of the paper, with L₄ typed, or of least squares where none meets (20)."""
    if observer.L is None:
        return nearest_gain(observer)
    if design["problem"] != PAPER_PROBLEM or design["gain"] in (COMPUTED_GAIN, ROUNDED_GAIN):
        return observer.L
    if design["gain"] == AS_PRINTED:
        return PRINTED_L
    typed = observer.L.copy()
    typed[0, 3] = design["l4"]
    return typed


def _told(o: BilinearObserver, pole: float, index: int, run: Record, worst: np.ndarray) -> dict[str, float]:
    scale, n = max(float(np.max(np.abs(run.law))), 1e-3), len(run.t)
    found = {"pole": pole, "law_gap": float(np.max(np.abs(run.errors[:, index] - run.law))) / scale,
             "first_error": float(run.errors[0, index, 0]), "plain_half": float(np.max(np.abs(run.errors[n // 2:, 0]))),
             "late_g": float(np.max(np.abs(run.g[-max(n // 10, 1):])))}
    if o.pi is not None:
        found |= {"A*": o.A_star.item(), "B*": o.B_star.item(), "pi": o.pi.item()}
    return found


def _told_of_error(design: Design, m: Mapping[str, float]) -> Text:
    pole = words(np.array([m["pole"]]), 2)
    if design["kick"] >= 0 and m["law_gap"] < LAW_TOLERANCE:
        return text("The kick moves |ε|; before it and after it |ε| follows e^({pole}t).", pole=pole)
    return claim(text("|ε| follows e^({pole}t) to within {law_gap:.0e} of its peak, whatever u does.", pole=pole, law_gap=m["law_gap"]),
                 m["law_gap"], below=LAW_TOLERANCE, otherwise=text(
                     "|ε| leaves the line e^({pole}t): in the last tenth of the run it is up to {late_error:.2g}.",
                     pole=pole, late_error=m["late_error"]))


def _boards(design: Design, o: BilinearObserver, pole: float) -> tuple[Board, Board]:
    paper, seen = design["problem"] == PAPER_PROBLEM, (complex(pole),)
    title = text("observer pole  A* − B*π") if o.case == 3 else text("observer pole  (V₂ − LV₁)AT₂")
    return boards_of((listed(PLANT_POLES), PLANT_WINDOW), OBSERVER_WINDOW, title, seen if paper else (), "pole" if paper else None,
                     () if paper or o.case == 1 else seen, (("gain", COMPUTED_GAIN),) if paper else ())


def _stage(problem: Problem, design: Design, L: np.ndarray, run: Record) -> Stage:
    """Gauges behind bars; with pipes for the unknown terms from the step on that gives L, or with that of a differentiator's lag."""
    index = form_index(design)
    bars = share_of_decades(np.column_stack([run.g, run.errors[:, index]]), LOW, HIGH)
    body, pipes = problem.body, np.zeros((len(run.t), 0))
    if design["form"] == FILTERED_DERIVATIVE:
        bars, body = np.abs(run.errors[:, index]) / LAG_ERROR, lag_body(problem.id)
        pipes = np.column_stack([run.missed, np.abs(run.fed[:, 0] - run.fed[:, 1])])
    elif design["step"] >= GAIN_STEP:
        alone, left = unknown_terms(problem.solved, L)
        body, pipes = piped_body(problem.id), np.tile(left / alone.max(), (len(run.t), 1))
    true, ghost = (np.column_stack([run.x, g, pipes, bars]) for g in (run.g, run.estimates[:, index]))
    return Stage(body, run.t, true, ghost, run.u[:, None])


def _live(design: Design, o: BilinearObserver, m: Mapping[str, float]) -> Text:
    pole, late = words(np.array([m["pole"]]), 2), format_number(m["late_error"], ".1e")
    if o.case == 1 and design["noise"]:
        return text("Case 1: no L frees ε from u and x. With the nearest one ε is {late} when the run ends, the sensors' noise included.",
                    late=late)
    if o.case == 1:
        return text("Case 1: no L frees ε from u and x. The nearest one leaves ε at {late} when the run ends.",
                    late=late)
    if m["pole"] == 0:
        return text("The observer's pole is at 0: ε does not decay; at the end it is {late}.", late=late)
    if m["pole"] >= 0:
        return text("The observer's pole is {pole}: ε grows and reaches {late}.", pole=pole, late=late)
    if design["noise"]:
        return claim(text("The sensors' noise moves ĝ by {rms:.2g} (rms, second half of the run); at rest and u = 0 its law says "
                          "{promised:.2g}.", rms=m["noise_rms"], promised=m["noise_promised"]), m["noise_rms"], above=0.0)
    if design["kick"] >= 0 and m["law_gap"] < LAW_TOLERANCE:
        return text("Case {case}: one state estimates g. The kick moves ε, and before and after it ε follows e^({pole}t).", case=o.case,
                    pole=pole)
    return claim(text("Case {case}: one state estimates g, and ε decays as e^({pole}t) under this u.", case=o.case, pole=pole),
                 m["law_gap"], below=1e-6, otherwise=text(
                     "The pole is {pole}, but something still drives ε: it ends at {late}.", pole=pole, late=late))
