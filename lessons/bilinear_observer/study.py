"""Compute a design of lesson 16: eight steps, and the run of three observer forms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Board, Check, Design, Outcome, Stage
from observer_lab.engine import BilinearPlant
from observer_lab.engine.observers import BilinearForm, BilinearObserver
from observer_lab.plants.bilinear import BILINEAR_PLANT, PRINTED_FORM, PRINTED_L, X0
from observer_lab.plants.bodies.body import Body
from observer_lab.plants.bodies.front_bars import share_of_decades
from observer_lab.plants.model import Window
from observer_lab.text import Text, format_number, text

from ..toolkit.boards import listed
from ..toolkit.figures import settle_time
from .formulas import formulas_of
from .input_signals import HORIZON, form_index, joined, noise_values, promised, signal
from .paper_example import pole_of, words
from .problems import AS_PRINTED, COMPUTED_GAIN, HIGH, LOW, PAPER_PROBLEM, PROBLEMS, ROUNDED_GAIN, nearest_gain
from .run_record import Record, Setting, end_to_end, fed_of, kicked_at, whole

DT = 0.005
LAW_TOLERANCE = 1e-6  # of its own law, over its peak: an error this near follows it
STATE_JUMP = (0.0, 0.0, 0.0, 0.0, 2.0, 0.0)


@dataclass(frozen=True, eq=False)
class Study:
    """The eight steps for the problem and the pole, and the run: of its numbers g there is one, without an axis of its own."""

    observer: BilinearObserver
    run: Record


def watch(plant: BilinearPlant, K: np.ndarray, plain: BilinearForm, exact: BilinearForm, design: Design, pole: float) -> Record:
    """Run all forms from χ(0), μ̂(0) = χ(0) + L y(0); the law is that of the pole."""
    tau, last = design["tau"], round(HORIZON / DT)
    x0, start = np.array(X0), (exact.R @ plant.C @ X0).item()
    z0 = np.array([design["chi0"], design["chi0"] + start, design["chi0"] + start, start])
    setting = Setting(plant, joined(plain, exact, tau), np.repeat(K, 3, axis=0), signal(design), x0, z0, np.array(STATE_JUMP),
                      kicked_at(design["kick"], DT, last), last, DT)
    still = setting.pieces(None)
    pieces = setting.pieces(design["noise"] * noise_values(design, last + 1, plant.m)) if design["noise"] else still
    errors, calm = whole("error", pieces), whole("error", still)
    count, chosen = min(len(errors), len(calm)), form_index(design)
    law = end_to_end([p.error[0, chosen] * np.exp(pole * p.t) for p in still])
    fed = fed_of(plant, exact.R[0], pieces, 3, tau)
    x, u, g, estimates = (whole(name, pieces)[:count] for name in ("x", "u", "g", "estimate"))
    return Record(DT * np.arange(count), u, x, g[:, 0], estimates, errors[:count], errors[:count] - calm[:count], law[:count], fed[:count])


FORM_NAMES = (text("without ẏ"), text("with the true ẏ"), text("with a differentiator"))
OBSERVER_WINDOW, PLANT_WINDOW = Window(-62.0, 18.0, 19.0), Window(-30.0, 10.0, 12.0)
PLANT_POLES = np.sort_complex(np.linalg.eigvals(BILINEAR_PLANT.A))
PLANT_POLES.setflags(write=False)


def compute(design: Design) -> Outcome[Study]:
    """The eight steps for the problem and the pole, and one run of all three forms under the chosen input."""
    problem = PROBLEMS[design["problem"]]
    paper = problem.id == PAPER_PROBLEM
    observer = problem.observer(design["pole"][0].real) if paper else problem.solved
    L = _gain(design, observer)
    exact, plain = observer.forms(L)
    if paper and design["gain"] == ROUNDED_GAIN:
        plain = PRINTED_FORM
    running = plain if form_index(design) == 0 else exact
    pole = PRINTED_FORM.A.item() if running is PRINTED_FORM else pole_of(observer, L)
    run = watch(problem.plant, problem.K, plain, exact, design, pole)
    metrics = LazyMap(lambda: _metrics(design, observer, run, pole) | (
        _noise(design, run, joined(running, running, design["tau"]), problem.plant.m) if design["noise"] else {}))
    return Outcome(design, {"L": L}, {"observer": np.array([complex(pole)]), "plant": PLANT_POLES}, metrics,
                   LazySequence(lambda: _checks(observer, metrics)), None, _boards(design, observer, pole),
                   _stage(problem.body, design, run), LazySequence(lambda: formulas_of(observer, L, plain, int(design["step"]))),
                   LazyValue(lambda: _live(design, observer, metrics)), Study(observer, run))


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


def _metrics(design: Design, observer: BilinearObserver, run: Record, pole: float) -> dict[str, float]:
    size = np.abs(run.errors[:, form_index(design)])
    scale = max(float(np.max(np.abs(run.law))), 1e-3)
    n, settled = len(run.t), settle_time(run.t, size)
    found = {"pole": pole, "case": float(observer.case), "defect": observer.defect_size,
             "law_gap": float(np.max(np.abs(run.errors[:, form_index(design)] - run.law))) / scale,
             "first_error": float(run.errors[0, form_index(design)]),
             "late_error": float(np.max(size[-max(n // 10, 1):])), "half_error": float(np.max(size[n // 2:])),
             "plain_half": float(np.max(np.abs(run.errors[n // 2:, 0]))),
             "late_g": float(np.max(np.abs(run.g[-max(n // 10, 1):]))),
             "settled_after": float("inf") if settled is None else settled}
    if observer.pi is not None:
        found |= {"A*": observer.A_star.item(), "B*": observer.B_star.item(), "pi": observer.pi.item()}
    return found


def _noise(design: Design, run: Record, form: BilinearForm, outputs: int) -> dict[str, float]:
    """The rms of what noise adds to the estimate in the second half of the run, and what its law promises at u = 0."""
    index, late = form_index(design), run.heard[len(run.t) // 2:]
    says = promised(form, np.full(outputs, design["noise"]), DT)
    return {"noise_rms": float(np.sqrt(np.mean(late[:, index] ** 2))), "noise_promised": float(min(says[index], 1e15))}


def _checks(o: BilinearObserver, metrics: Mapping[str, float]) -> tuple[Check, ...]:
    gap = metrics["law_gap"]
    return (
        Check("case1", text("case 1: (21) fails, no L"), o.case == 1, o.defect_size, informative=True),
        Check("case2", text("case 2: one L only"), o.case == 2, float(o.canonical_Q.rank), informative=True),
        Check("case3", text("case 3: a family of L"), o.case == 3, float(len(o.canonical_Q.zero_left)), informative=True),
        Check("controllable", text("(A*, B*) controllable: any pole"), bool(o.controllable),
              float(np.max(np.abs(o.B_star), initial=0.0))),
        Check("stable", text("the pole in use is on the left"), metrics["pole"] < 0, metrics["pole"]),
        Check("law", text("ε follows its pole under this u"), gap <= 1e-6, gap),
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


def _boards(design: Design, o: BilinearObserver, pole: float) -> tuple[Board, Board]:
    paper = design["problem"] == PAPER_PROBLEM
    seen = listed(np.array([complex(pole)]))
    title = (text("observer pole  A* − B*π") if o.case == 3
             else text("observer pole  (V₂ − LV₁)AT₂"))
    return (
        Board("plant", text("the plant's poles at u = 0  eig(A)"), listed(PLANT_POLES),
              side="left", re_low=PLANT_WINDOW.re_low, re_high=PLANT_WINDOW.re_high, im_high=PLANT_WINDOW.im_high),
        Board("observer", title, seen if paper else (), "pole" if paper else None, fixed=() if paper or o.case == 1 else seen,
              role="estimate", side="right", re_low=OBSERVER_WINDOW.re_low, re_high=OBSERVER_WINDOW.re_high,
              im_high=OBSERVER_WINDOW.im_high,
              also=(("gain", COMPUTED_GAIN),) if paper else ()),
    )


def _stage(body: Body, design: Design, run: Record) -> Stage:
    chosen = form_index(design)
    bars = share_of_decades(np.column_stack([run.u, run.g, run.errors[:, chosen]]), LOW, HIGH)
    true, ghost = (np.column_stack([run.x, g, bars]) for g in (run.g, run.estimates[:, chosen]))
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
