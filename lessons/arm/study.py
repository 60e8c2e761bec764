"""Compute a design of lesson 20: run, quality of the load estimate, rest position."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import degrees, inf, radians

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome, Stage
from observer_lab.engine import autonomous_error
from observer_lab.engine.simulation import Run, separation_meter
from observer_lab.plants.arm import ANGLE_INDEX, CURRENT_INDEX, LOAD_INDEX, MODEL, MOTOR_DATA, PARAMETERS, SPEED_INDEX
from observer_lab.text import Text, joined, text

from ..toolkit.boards import stage
from ..toolkit.latex import gain_words
from .body import BODY
from .knobs import EXACT_ENCODER
from .loop import ARM_PLANT, LOAD_AT, Played, gains, played, resting, step_of

FOUND_SHARE = 0.05  # of the load: an estimate this near has found it
RESTED = 0.02  # N m and degrees: a run that ends this near to its rest has come there
SOLID = 1e-9
NOT_DECAYING = 1e-6  # of a real part: beyond it an error grows


@dataclass(frozen=True)
class Tried:
    """An observer `speed` times as fast: when it found the load (s; None: not), what it claimed before and by how much it strays, N m."""

    speed: float
    found: float | None
    false: float
    stray: float


@dataclass(frozen=True, eq=False)
class Study:
    """The run with the motor's angle, what ė = (A − LC) e promises (n_t, 4), and where the linear loop comes to rest.

    `tried`: other speeds of the observer, once the job has run.
    """

    played: Played
    promised: np.ndarray
    rest: tuple[np.ndarray, np.ndarray] | None
    step: float
    tried: tuple[Tried, ...] = ()


def compute(design: Design) -> Outcome[Study]:
    """Gains, one run, and what it says about the load."""
    K, L = gains(design)
    shown = played(design, K, L)
    run, rest = shown.run, resting(design, K, L)
    error = ARM_PLANT.A - L @ ARM_PLANT.C
    poles = {
        "controller": np.linalg.eigvals(ARM_PLANT.A[:LOAD_INDEX, :LOAD_INDEX] - ARM_PLANT.B[:LOAD_INDEX] @ K[:, :LOAD_INDEX]),
        "observer": np.linalg.eigvals(error),
    }
    metrics = _metrics(design, shown, poles) | {"separation_meter": separation_meter(run)}
    ideal = shown.linear and not run.saturated
    checks = (
        Check("found", text("the load is found without bias"),
              bool(design["load_state"]) and metrics["slowest_observer"] < 0 and shown.linear, metrics["load_error"]),
        Check("arrives", text("the arm comes to rest on its target"),
              rest is not None and ideal and abs(float(rest[0][ANGLE_INDEX]) - radians(design["target"])) < SOLID, metrics["angle_error"]),
        Check("autonomous", text("the error dynamics are autonomous, ė = (A − LC)e"), metrics["separation_meter"] < SOLID,
              metrics["separation_meter"]),
    )
    study = Study(shown, autonomous_error(run), rest, step_of(design))
    return Outcome(design, {"K": K, "L": L}, poles, metrics, checks, run, _boards(design, error), _stage(design, shown),
                   _formulas(design, K, L), _live(design, metrics, run), study)


def _stage(design: Design, shown: Played) -> Stage:
    """The arm between the flanks of its gear and beside its target, with the voltage applied and the voltage asked for."""
    run, plain = shown.run, stage(MODEL, shown.run, design)
    half, target = (np.full(len(run.t), radians(value)) for value in (design["gap"] / 2, design["target"]))
    gear = np.column_stack([shown.motor - run.x[:, ANGLE_INDEX], half, target, run.u_applied[:, 0]])
    return replace(plain, body=BODY, x=np.hstack([run.x, gear]), xhat=None if plain.xhat is None else np.hstack([plain.xhat, gear]),
                   u=np.hstack([run.u_applied, run.u_asked]), plain=plain)


def _boards(design: Design, error: np.ndarray) -> tuple[Board, Board]:
    c, o = MODEL.controller_window, MODEL.observer_window
    knob = "observer_poles" if design["load_state"] else "plain_poles"
    return (
        Board("controller", text("controller poles  eig(A − BK)"), design["controller_poles"], "controller_poles", role="plant",
              side="left", re_low=c.re_low, re_high=c.re_high, im_high=c.im_high),
        Board("observer", text("observer poles  eig(A − LC)"), design[knob], knob, () if design["load_state"] else (0j,),
              role="estimate", side="right", re_low=o.re_low, re_high=o.re_high, im_high=o.im_high, landscape=error),
    )


def last(values: np.ndarray) -> np.ndarray:
    """The last tenth of a run."""
    return values[-max(len(values) // 10, 1):]


def found_after(run: Run) -> float | None:
    """How long after it came the load is found for good, in s; None if it is not, or if there is none."""
    late = run.t >= LOAD_AT - 1e-9
    size = float(abs(run.x[-1, LOAD_INDEX]))
    away = np.flatnonzero(np.abs(run.e[late, LOAD_INDEX]) > FOUND_SHARE * size)
    if not late.any() or not size or (len(away) and away[-1] == late.sum() - 1):
        return None
    return float(run.t[late][away[-1] + 1] - LOAD_AT) if len(away) else 0.0


def measured(speed: float, run: Run) -> Tried:
    """What a run with an observer of some speed came to."""
    return Tried(speed, found_after(run), float(np.max(np.abs(run.e[run.t < LOAD_AT - 1e-9, LOAD_INDEX]))),
                 float(np.max(np.abs(last(run.e[:, LOAD_INDEX])))))


def _metrics(design: Design, shown: Played, poles: Mapping[str, np.ndarray]) -> dict[str, float]:
    run, found = shown.run, found_after(shown.run)
    early, e = run.t < LOAD_AT - 1e-9, run.e
    return {
        "load_error": float(np.max(np.abs(last(e[:, LOAD_INDEX])))), "load_belief": float(np.mean(last(run.xhat[:, LOAD_INDEX]))),
        "holding": MOTOR_DATA.resistance * abs(design["load"]) / PARAMETERS.torque,
        "found_after": inf if found is None else found,
        "false_load": float(np.max(np.abs(e[early, LOAD_INDEX]))),
        "angle_error": float(np.max(np.abs(last(np.degrees(run.x[:, ANGLE_INDEX])) - design["target"]))),
        "droop": design["target"] - degrees(float(np.mean(last(run.x[:, ANGLE_INDEX])))),
        "angle_belief": float(np.max(np.abs(last(np.degrees(e[:, ANGLE_INDEX]))))),
        "speed_error": float(np.max(np.abs(e[:, SPEED_INDEX]))), "current_error": float(np.max(np.abs(e[:, CURRENT_INDEX]))),
        "largest_current": float(np.max(np.abs(run.x[:, CURRENT_INDEX]))), "largest_input": float(np.max(np.abs(run.u_asked))),
        "clipped_for": MODEL.dt * float(np.sum(np.abs(run.u_asked[:, 0]) > design["u_max"] * (1 + 1e-9))),
        "apart": float(np.max(np.abs(np.degrees(shown.motor - run.x[:, ANGLE_INDEX])))),
        "changes": float(np.sum(np.diff(shown.contact) != 0)),
        "slowest_observer": float(np.max(np.real(poles["observer"]))), "slowest_controller": float(np.max(np.real(poles["controller"]))),
        "whole": float(run.diverged_at is None),
    }


def _formulas(design: Design, K: np.ndarray, L: np.ndarray) -> tuple[Formula, ...]:
    law = r"\dot e = (A_a - L C_a)\,e" if design["load_state"] else r"\dot e = (A - L C)\,e + E\,\tau"
    return (Formula("error", law), Formula("K", gain_words("K", K)), Formula("L", gain_words(r"L^{\mathsf T}", L.T)))


def _live(design: Design, m: Mapping[str, float], run: Run) -> Text:
    if not m["whole"]:
        return text("This loop is lost after {end:.2f} s.", end=run.diverged_at or 0.0)
    load = _load_words(design, m)
    rests = text("In the last tenth of the run the arm is up to {angle:.2g}° from its target.", angle=m["angle_error"])
    hidden = text("The arm stands up to {apart:.2g}° off the motor, and the encoder on the motor does not measure it.", apart=m["apart"])
    seen = design["gap"] > 0 and design["encoder"] in (EXACT_ENCODER, "motor")
    if m["slowest_controller"] >= 0:
        return joined(text("A controller pole is not in the left half plane: the loop is unstable."), load, rests)
    if m["slowest_observer"] > NOT_DECAYING:
        return joined(text("An observer pole is not in the left half plane: the error does not decay."), load, rests)
    return joined(load, rests, claim(hidden, m["apart"], above=0.0)) if seen else joined(load, rests)


def _load_words(design: Design, m: Mapping[str, float]) -> Text:
    if not design["load_state"]:
        return text("This observer has no state for the load: its estimate is 0 N m, the load is {load:.3g} N m.", load=design["load"])
    if not design["load"]:
        return text("There is no load; the estimate strays by up to {stray:.2g} N m in the last tenth of the run.", stray=m["load_error"])
    missing = text("The load is not found to 5 % within this run.")
    return claim(text("The load is found to 5 % after {found:.3f} s.", found=m["found_after"]), m["found_after"],
                 below=MODEL.horizon, otherwise=missing)


def sheet_rows() -> tuple[tuple[Text, float, float, str], ...]:
    """What the sheet prints beside what follows from its R, k and no-load current: name, printed, computed, unit."""
    m, rpm = MOTOR_DATA, 30 / np.pi
    stall = m.voltage / m.resistance
    return (
        (text("no-load speed"), m.no_load_speed * rpm,
         (m.voltage - m.resistance * m.no_load_current) / m.torque_constant * rpm, "rpm"),
        (text("stall current"), m.stall_current, stall, "A"),
        (text("stall torque"), 1000 * m.stall_torque, 1000 * m.torque_constant * stall, "mN m"),
        (text("speed constant"), m.speed_constant * rpm, rpm / m.torque_constant, "rpm/V"),
    )
