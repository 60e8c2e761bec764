"""Compute a design of lesson 2: one run with the chosen force and one without."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome
from observer_lab.engine import Plant, Scenario, observer_gain, simulate
from observer_lab.engine.simulation import Run
from observer_lab.engine.systems import sorted_poles
from observer_lab.plants import Model
from observer_lab.text import Text, format_number, same, text

from ..toolkit.boards import bolts, listed, stage
from ..toolkit.figures import error_with_jumps, settle_time
from ..toolkit.knobs import kicks
from ..toolkit.latex import gain_words, matrix
from .knobs import ACCELEROMETER, AS_PRINTED, BY_NUMBERS, BY_POLES, DT, FORGOTTEN, HORIZON, MODEL, POSITION
from .notes_page import PLANT, PRINTED_GAIN, poles_of, printed_model

FORCE_HOLD_STEPS = 20  # steps for which a random force is held
ERROR_ROUNDING = 1e-9  # an error moved by less than this share of the largest state is moved by rounding alone, in whatever units
PRINTED_MODEL = printed_model()
ACCELERATION = replace(PLANT, C=PLANT.A[1:], D=PLANT.B[1:], output_names=("acceleration",),
                       units=(*((name, unit) for name, unit in PLANT.units if name != "position"), ("acceleration", "m/s²")))
PLANTS = MappingProxyType({POSITION: PLANT, ACCELEROMETER: ACCELERATION, FORGOTTEN: ACCELERATION})
BELIEFS = MappingProxyType({**PLANTS, FORGOTTEN: replace(ACCELERATION, D=np.zeros((1, 1)))})


@dataclass(frozen=True, eq=False)
class Setting:
    """The plant of the lesson with its sensor, what is believed of it and the gain in a design, the first guess, how long it runs.

    `notes`: whether the page of the notes is about this plant. `whose`: what the left board is called.
    """

    model: Model
    plant: Callable[[Design], Plant]
    horizon: float
    dt: float
    belief: Callable[[Design], Plant]
    gain: Callable[[Design], np.ndarray]
    guess: Callable[[Design], tuple[float, ...]]
    parts: tuple[tuple[Text, str], ...]  # names of the first two errors, and the unit
    whose: Text
    notes: bool = False


@dataclass(frozen=True, eq=False)
class Study:
    """The same run without any input, and the matrix that drives the error; the plant as it is measured, and as it is believed.

    `unstruck` is the run without its kick and pull, None where it has neither.
    """

    quiet: Run
    error: np.ndarray
    plant: Plant
    belief: Plant
    unstruck: Run | None = None

    @property
    def forgets(self) -> bool:
        """Whether the observer leaves out how the input acts on the reading."""
        return not np.array_equal(self.plant.D, self.belief.D)


def force(design: Design, horizon: float = HORIZON, dt: float = DT) -> np.ndarray:
    """The force over the run (n_t,) in N, held between grid points."""
    t = dt * np.arange(round(horizon / dt) + 1)
    kind, size = design["input"], design["amplitude"]
    if kind == "step":
        return np.full(len(t), size)
    if kind == "sine":
        return size * np.sin(2 * np.pi * design["frequency"] * t)
    if kind == "square":
        return np.where((t * design["frequency"]) % 1.0 < 0.5, size, -size)
    if kind == "random":
        rng = np.random.default_rng(int(design["seed"]))
        return np.repeat(rng.uniform(-size, size, len(t) // FORCE_HOLD_STEPS + 1), FORCE_HOLD_STEPS)[:len(t)]
    if kind == "hand" and design["hand"]:
        times, values = np.array(design["hand"]).T
        return np.concatenate([[0.0], values])[np.searchsorted(times, t + 1e-9 * dt, side="right")]
    return np.zeros(len(t))


def gain(design: Design) -> np.ndarray:
    """L (2×1): from the poles, typed, or as the notes print it."""
    if design["method"] == AS_PRINTED:
        return PRINTED_GAIN
    if design["method"] == BY_NUMBERS:
        return np.array([[design["l1"]], [design["l2"]]])
    return observer_gain(PLANT.A, PLANTS[design["sensor"]].C, design["observer_poles"]).gain


def _sensor(design: Design) -> str:
    """What is measured: the page of the notes is about the position."""
    return POSITION if design["method"] == AS_PRINTED else design["sensor"]


BLOCK_SETTING = Setting(
    MODEL, lambda design: PLANTS[_sensor(design)], HORIZON, DT,
    lambda design: PRINTED_MODEL if design["method"] == AS_PRINTED else BELIEFS[_sensor(design)], gain,
    lambda design: (design["guess_q"], design["guess_v"]), ((same("e₁"), "m"), (same("e₂"), "m/s")),
    text("the block's own poles  eig(A)"), notes=True)


def compute(here: Setting, design: Design) -> Outcome[Study]:
    """One run with the chosen force and one without any, from the same start and with the same kick."""
    model, plant = here.model, here.plant(design)
    L, belief = here.gain(design), here.belief(design)
    error = belief.A - L @ belief.C
    push = np.zeros((round(here.horizon / here.dt) + 1, plant.m))
    push[:, 0] = force(design, here.horizon, here.dt)
    steered = Scenario(plant, None, L, model=belief, x0=model.x0, xhat0=here.guess(design),
                       horizon=here.horizon, dt=here.dt, reference=push, impulses=kicks(design, model, (here.dt, here.horizon)))
    run, quiet = simulate(steered), simulate(replace(steered, reference=None))
    poles = poles_of(error) if plant.n == 2 else sorted_poles(error)
    metrics = _metrics(run, quiet) | {"slowest_observer": float(np.max(np.real(poles)))}
    checks = (
        Check("independent", text("the error does not depend on the input"),
              left_alone(metrics) and (metrics["state_moved"] > 0 or belief is plant), metrics["error_moved"]),
        Check("observer", text("the error decays by itself"), metrics["slowest_observer"] < 0,
              metrics["slowest_observer"]),
    )
    return Outcome(design, {"L": L}, {"observer": poles, "plant": plant.poles}, metrics, checks, run,
                   _boards(here, design, poles, error), stage(model, run, design), _formulas(design, plant, belief, L),
                   _live(metrics, bool(kicks(design, model))),
                   Study(quiet, error, plant, belief, simulate(replace(steered, impulses=())) if steered.impulses else None))


def _metrics(run: Run, quiet: Run) -> dict[str, float]:
    count = min(len(run.t), len(quiet.t))
    size = np.linalg.norm(run.e, axis=1)
    settled = settle_time(*error_with_jumps(run))
    return {
        "error_moved": float(np.max(np.abs(run.e[:count] - quiet.e[:count]))),
        "state_moved": float(np.max(np.abs(run.x[:count] - quiet.x[:count]))) if np.any(run.u_applied) else 0.0,
        "largest": float(max(np.max(np.abs(run.x)), np.max(np.abs(run.xhat)))),
        "final_error": float(np.max(size[-max(len(size) // 10, 1):])), "largest_error": float(np.max(size)),
        "settled_after": np.inf if settled is None else settled, "final_e1": float(run.e[-1, 0])}


def _boards(here: Setting, design: Design, poles: np.ndarray, error: np.ndarray) -> tuple[Board, Board]:
    window, own = here.model.observer_window, here.model.plant.poles
    shown = design["observer_poles"] if design["method"] == BY_POLES else listed(poles)
    return (
        Board("plant", here.whose, listed(own), side="left", re_low=window.re_low, re_high=window.re_high,
              im_high=window.im_high),
        Board("observer", text("observer poles  eig(A − LC)"), shown, "observer_poles",
              bolts(here.model.observer, window), role="estimate", side="right", re_low=window.re_low, re_high=window.re_high,
              im_high=window.im_high, also=(("method", BY_POLES),), landscape=error),
    )


def _formulas(design: Design, plant: Plant, belief: Plant, L: np.ndarray) -> tuple[Formula, ...]:
    gain_now, error = Formula("L", gain_words("L", L)), belief.A - L @ belief.C
    if design["method"] != AS_PRINTED:
        forgets = not np.array_equal(plant.D, belief.D)
        through = (Formula("through", gain_words("LD", L @ plant.D)) if forgets else
                   Formula("through", gain_words("B - LD", plant.B - L @ plant.D)),) if np.any(plant.D) else ()
        law = r"\dot e = (A - LC)\,e - LD\,u" if forgets else r"\dot e = (A - LC)\,e"
        return (Formula("law", law), gain_now, Formula("error", gain_words("A - LC", error)), *through)
    leak = plant.A - L @ plant.C - error
    return (Formula("law", r"\dot e = M e + (A - LC - M)\,x"), gain_now, Formula("error", rf"M = {matrix(error)}"),
            Formula("leak", rf"A - LC - M = {matrix(leak)}"))


def _live(m: dict[str, float], kicked: bool) -> Text:
    if m["state_moved"] == 0 and kicked:
        return text("No input acts; only the kick or pull moves plant and error.")
    if m["state_moved"] == 0:
        return text("No input acts: plant and error evolve freely.")
    moved = format_number(m["state_moved"], ".2g")
    driven = text("The input moves the state by up to {moved} and the error by up to {error_moved:.2g}: the "
                  "input drives the error.",
                  moved=moved, error_moved=m["error_moved"])
    alone = (text("The input moves the state by up to {moved} and the error by {error_moved:.0e}, which is rounding.",
                  moved=moved, error_moved=m["error_moved"]) if m["slowest_observer"] < 0 else
             text("An observer pole is not in the left half plane. The input does not drive the error: the {error_moved:.0e} between both "
                  "runs is rounding that grows.", error_moved=m["error_moved"]))
    return claim(driven, m["error_moved"], above=ERROR_ROUNDING * m["largest"], otherwise=alone)


def left_alone(m: Mapping[str, float]) -> bool:
    """Whether the force moves the error by rounding alone."""
    return m["error_moved"] <= ERROR_ROUNDING * m["largest"]
