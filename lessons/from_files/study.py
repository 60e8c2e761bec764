"""Compute a design of a lesson that is written as files: gains, one run, and its metrics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Board, Design, Formula, Outcome
from observer_lab.engine import Plant, Scenario, simulate
from observer_lab.engine.simulation import Run
from observer_lab.plants.model import Window
from observer_lab.text import Text, text

from ..toolkit.boards import listed, stage
from ..toolkit.figures import error_with_jumps, settle_time
from ..toolkit.latex import gain_words
from .python_plant import LoopGiven, simulate_loop
from .setup import Setup

TAIL_SHARE = 10  # the last tenth of a run
METRICS: Mapping[str, Text] = MappingProxyType({
    "settled": text("the time until the error stays below 2 % of its peak (s)"),
    "final_error": text("the largest error in the last tenth of the run"),
    "largest_error": text("the largest error of the run"),
    "rms_error": text("the root mean square error"),
    "largest_estimate": text("the largest entry of the estimate"),
    "largest_input": text("the largest input"),
    "largest_gain": text("the largest entry of L"),
    "slowest_observer": text("the rightmost observer pole (1/s)"),
    "slowest_controller": text("the rightmost controller pole (1/s)"),
})


@dataclass(frozen=True, eq=False)
class Study:
    """The run that the figures draw; of a nonlinear plant its scenario is that of the linearisation."""

    run: Run


def compute(setup: Setup, design: Design) -> Outcome[Study]:
    """Gains on the believed plant, one run on the true one. Raises LessonFileError or EngineError."""
    values = setup.parameters.values(design)
    believed = setup.belief(values)
    truth = setup.source.plant(values)
    model = truth if believed == values else setup.source.plant(believed)
    K, L = setup.K(design, model, believed), setup.L(design, model, believed)
    run = _run(setup, design, truth, model, K, L)
    if setup.source.python is not None:
        run = nonlinear_run(setup, design, run)
    poles = {"observer": np.sort_complex(np.linalg.eigvals(model.A - L @ model.C))}
    poles |= {"controller": np.sort_complex(np.linalg.eigvals(model.A - model.B @ K))} if np.any(K) else {}
    formulas = (Formula("L", gain_words("L", L)), *([Formula("K", gain_words("K", K))] if np.any(K) else []))
    metrics = _metrics(run, L, poles)
    return Outcome(design, {"K": K, "L": L}, poles, metrics, (), run if setup.source.python is None else None,
                   _boards(setup, poles, model.A - L @ model.C), replace(stage(setup.source.model, run, design), picture=setup.picture),
                   formulas, _live(metrics, setup.horizon),
                   Study(run))


def _run(setup: Setup, design: Design, truth: Plant, model: Plant, K: np.ndarray, L: np.ndarray) -> Run:
    values = setup.parameters.values(design)
    limit, noise, push = setup.number("limit", values), setup.number("noise", values), setup.number("disturbance", values)
    step = truth.dt or setup.step
    return simulate(Scenario(
        truth, K, L, model=model, x0=setup.vector("start", values, truth.n), xhat0=setup.vector("guess", values, truth.n),
        horizon=setup.horizon, dt=step, reference=setup.vector("input", values, truth.m) if truth.m else None,
        u_min=-limit, u_max=limit, V=noise**2 * (1.0 if truth.dt else step) if noise else None, W=push if push else None,
        impulses=((_on_grid(design["kick"], step), setup.vector("kick", values, truth.n)),) if design["kick"] >= 0 else (),
        seed=int(design["seed"])))


def _on_grid(time: float, step: float) -> float:
    return float(step * np.ceil(time / step - 1e-9))


def nonlinear_run(setup: Setup, design: Design, linear: Run) -> Run:
    """The run of the equations themselves, with gains, grid, seed and noise of the linear one."""
    s, values, python = linear.scenario, setup.parameters.values(design), setup.source.python
    assert python is not None
    believed = setup.belief(values)
    noise = (0.0 if s.V is None else setup.number("noise", values)) * np.random.default_rng(s.seed).standard_normal((s.n_t, s.plant.p))
    kick = (design["kick"], setup.vector("kick", values, s.plant.n))
    found = simulate_loop(python, values, believed, LoopGiven(s.K, s.L, s.x0, s.xhat0, setup.vector("input", values, s.plant.m),
                                                              setup.number("limit", values), noise, kick, s.dt))
    count = len(found.t)
    return Run(s, found.t, found.x, found.xhat, found.x - found.xhat, found.u, found.u, found.y, found.yhat, np.zeros((count, 0)),
               noise[:count], None if count == s.n_t else float(found.t[-1]), False)


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """The numbers for a derivation's places: the believed A, B, C, the gains, knobs that are numbers, and the metrics."""
    scenario = outcome.study.run.scenario
    model = scenario.plant if scenario.model is None else scenario.model
    knobs = {name: float(value) for name, value in outcome.design.values if isinstance(value, (int, float))}
    return {**knobs, **outcome.metrics, "A": model.A, "B": model.B, "C": model.C, **outcome.gains}


def _metrics(run: Run, L: np.ndarray, poles: Mapping[str, np.ndarray]) -> dict[str, float]:
    size = np.linalg.norm(run.e, axis=1)
    settled = settle_time(*error_with_jumps(run))
    return {
        "settled": np.inf if settled is None else settled, "final_error": float(size[-max(len(size) // TAIL_SHARE, 1):].max()),
        "largest_error": float(size.max()), "rms_error": float(np.sqrt(np.mean(size**2))),
        "largest_estimate": float(np.abs(run.xhat).max()), "largest_input": float(np.abs(run.u_asked).max(initial=0.0)),
        "largest_gain": float(np.abs(L).max()), "slowest_observer": float(poles["observer"].real.max()),
        **({"slowest_controller": float(poles["controller"].real.max())} if "controller" in poles else {}),
    }


def _live(metrics: Mapping[str, float], horizon: float) -> Text:
    if not np.isfinite(metrics["settled"]):
        return text("The error does not settle within the {horizon:g} s of this run.", horizon=horizon)
    return text("The error stays below 2 % of its peak from {settled:.3g} s to the end of this run.", settled=metrics["settled"])


def _boards(setup: Setup, poles: Mapping[str, np.ndarray], error: np.ndarray) -> tuple[Board, ...]:
    """A board for each set of poles that a knob holds."""
    boards = []
    windows = {k.name: Window(k.re_low, k.re_high, k.im_high) for k in setup.parameters.knobs if k.name in setup.parameters.pole_knobs}
    for id, knob, role, side, title in (
            ("controller", setup.controller_knob, "plant", "left", text("controller poles  eig(A − BK)")),
            ("observer", setup.observer_knob, "estimate", "right", text("observer poles  eig(A − LC)"))):
        if knob and id in poles:
            w = windows[knob]
            boards.append(Board(id, title, listed(poles[id]), knob, role=role, side=side, re_low=w.re_low, re_high=w.re_high,
                                im_high=w.im_high, disc=bool(setup.source.model.plant.dt), landscape=error if id == "observer" else None))
    return tuple(boards)
