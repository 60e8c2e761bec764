"""Compute a design of lesson 6: gains for the movable modes, and one run, whatever the plant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome
from observer_lab.engine import Scenario, observer_gain, place, simulate
from observer_lab.engine.simulation import Run
from observer_lab.text import Text, format_number, text

from ..toolkit.boards import stage
from ..toolkit.knobs import kicks
from ..toolkit.latex import gain_words, number, pole_words
from .knobs import FIRST_MODEL, PLANT_CASES, Case

Gains = tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]  # K and L, poles of controller and observer
START_OFFSET_M = 0.1  # m, by which each block starts off the centre, one to either side


def movable(case: Case) -> tuple[str, str]:
    """Names of the knobs that hold the poles which K and which L can move."""
    return ("controller_part" if case.unmoved else "controller_all",
            "observer_part" if case.unseen else "observer_all")


@dataclass(frozen=True, eq=False)
class Setting:
    """The plants of the lesson, or a person's own: the case of a design, K and L with the poles of both, x(0), what is told of a run."""

    case: Callable[[Design], Case]
    gains: Callable[[Case, Design], Gains]
    start: Callable[[Design], Sequence[float]]
    boards: Callable[[Case, Design, np.ndarray, np.ndarray, np.ndarray], tuple[Board, Board]]
    live: Callable[[Case, Run], Text]
    numbers: Callable[[Case, Run], dict[str, float]] = lambda *_: {}
    formulas: Callable[[Case], tuple[Formula, ...]] = lambda _: ()


def compute(here: Setting, design: Design) -> Outcome[Case]:
    """Gains for the movable poles with the bolted ones left where they are, and one run."""
    case = here.case(design)
    plant, model, ((K, L), (control, observer)) = case.model.plant, case.model, here.gains(case, design)
    run = simulate(Scenario(plant, K, L, x0=here.start(design), xhat0=model.guess, horizon=model.horizon, dt=model.dt,
                            impulses=kicks(design, model), seed=int(design["seed"])))
    e = np.linalg.norm(run.e, axis=1)
    metrics = {
        "error_rate": float(np.real(observer).max()), "state_rate": float(np.real(control).max()),
        "error_end": float(e[-1] / max(float(e[0]), 1e-300)), "weakest_seen": min(m.margin for m in case.seen.modes),
        "weakest_reached": min(m.margin for m in case.reached.modes), **here.numbers(case, run)}
    return Outcome(
        design, {"K": K, "L": L}, {"controller": control, "observer": observer}, metrics, checks_of(case, metrics), run,
        here.boards(case, design, control, observer, plant.A - L @ plant.C), stage(model, run, design),
        (*here.formulas(case), Formula("K", gain_words("K", K)), Formula("L", gain_words(r"L^{\mathsf T}", L.T))),
        here.live(case, run), case)


def checks_of(case: Case, metrics: dict[str, float]) -> tuple[Check, ...]:
    """Seen, reached, and whether what is neither settles; then what these gains make of it."""
    error, state = metrics["error_rate"], metrics["state_rate"]
    return (
        Check("observable", text("observable: every mode leaves a trace"), case.seen.observable,
              metrics["weakest_seen"], informative=True),
        Check("detectable", text("detectable: what leaves no trace settles"),
              case.seen.detectable, metrics["weakest_seen"], informative=True),
        Check("controllable", text("controllable: every mode is reached"),
              case.reached.controllable, metrics["weakest_reached"], informative=True),
        Check("stabilizable", text("stabilizable: what is out of reach settles"),
              case.reached.stabilizable, metrics["weakest_reached"], informative=True),
        Check("error", text("with this L the error decays"), error < 0, error, informative=True),
        Check("loop", text("with this K and L the plant settles"), max(error, state) < 0,
              max(error, state), informative=True),
    )


# --- the lesson's plants ---------------------------------------------------------------------------------------------
def _gains(case: Case, design: Design) -> Gains:
    plant, (left, right) = case.model.plant, movable(case)
    control = place(plant.A, plant.B, (*design[left], *case.unmoved))
    observer = observer_gain(plant.A, plant.C, (*design[right], *case.unseen))
    return (control.gain, observer.gain), (control.poles, observer.poles)


def _numbers(case: Case, run: Run) -> dict[str, float]:
    fixed = (*case.unseen, *case.unmoved)
    return {"state_end": float(np.linalg.norm(run.x[-1])), **({"hidden_rate": max(p.real for p in fixed)} if fixed else {})}


def _boards(case: Case, design: Design, _: np.ndarray, __: np.ndarray, error_matrix: np.ndarray) -> tuple[Board, Board]:
    left, right = movable(case)
    c, o = FIRST_MODEL.controller_window, FIRST_MODEL.observer_window
    return (
        Board("controller", text("controller poles  eig(A − BK)"), design[left], left,
              fixed=case.unmoved, role="plant", side="left", re_low=c.re_low, re_high=c.re_high, im_high=c.im_high),
        Board("observer", text("observer poles  eig(A − LC)"), design[right], right,
              fixed=case.unseen, role="estimate", side="right", re_low=o.re_low, re_high=o.re_high, im_high=o.im_high,
              landscape=error_matrix),
    )


def _formulas(case: Case) -> tuple[Formula, ...]:
    seen = min(case.seen.modes, key=lambda m: (m.margin > 1e-9, -m.pole.real, m.margin))
    reached = min(case.reached.modes, key=lambda m: (m.margin > 1e-9, -m.pole.real, m.margin))

    def rank(mode_pole: complex, stacked: str, distance: float) -> str:
        value = "0" if distance < 1e-12 else number(distance)
        pole = number(mode_pole.real) + (rf" {'+' if mode_pole.imag > 0 else '-'} {number(abs(mode_pole.imag))}j"
                                         if abs(mode_pole.imag) > 1e-9 else "")
        return rf"\lambda = {pole}: \quad \sigma_{{\min}} {stacked} = {value}"
    return (
        Formula("seen", rank(seen.pole, r"\begin{bmatrix} A-\lambda I \\ C \end{bmatrix}", seen.distance)),
        Formula("reached", rank(reached.pole, r"\begin{bmatrix} A-\lambda I & B \end{bmatrix}", reached.distance)),
    )


def carries(case: Case, run: Run) -> bool:
    """Whether the run holds the mode that cannot be moved: wᴴe, or wᴴx, at the start or after a kick, with w its left eigenvector.

    e and x along an unseen or unreached mode keep to it whatever the gains: wᴴ A = λ wᴴ with C v = 0 for e, wᴴ B = 0 for x.
    """
    s, plant = run.scenario, case.model.plant
    A = plant.A - s.L @ plant.C if case.unseen else plant.A
    values, left = np.linalg.eig(A.conj().T)
    along = left[:, [int(np.argmin(np.abs(values.conj() - pole))) for pole in case.unseen or case.unmoved]]
    moved = [run.e[0] if case.unseen else run.x[0], *(jump for _, jump in s.impulses)]
    return any(float(np.abs(along.conj().T @ v).max()) > 1e-9 * max(float(np.linalg.norm(v)), 1e-300) for v in moved)


def _live(case: Case, run: Run) -> Text:
    bolts = case.unseen or case.unmoved
    if not bolts:
        return text("There is no fixed mode: the magnets make the plant as unstable as before, yet every pole can be moved.")
    words, rate = pole_words(list(bolts)), format_number(max(p.real for p in bolts), ".3g")
    if not carries(case, run):
        return (text("The poles at {words} leave no trace in y, and no L moves them. This run starts without a part of e along them; "
                     "any such part would follow e^({rate} t).", words=words, rate=rate) if case.unseen else
                text("The poles at {words} are out of reach of u, and no K moves them. This run starts without a part of x along them; "
                     "any such part would follow e^({rate} t).", words=words, rate=rate))
    if case.unseen:
        return text("The poles at {words} leave no trace in y. Whatever L is, part of e follows e^({rate} t).",
                    words=words, rate=rate)
    return text("The poles at {words} are out of reach of u. Whatever K is, part of x follows e^({rate} t).",
                words=words, rate=rate)


def _start(design: Design) -> tuple[float, ...]:
    c = design["centre"]
    return c + START_OFFSET_M, c - START_OFFSET_M, 0.0, 0.0


CASES_SETTING = Setting(lambda design: PLANT_CASES[design["plant"]], _gains, _start, _boards, _live, _numbers, _formulas)
