"""Run a design of a lesson file on many seeds, beside the covariance that its observer predicts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.linalg import expm

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Design, Outcome
from observer_lab.course.many_seeds import SeedErrors, SeedTrial
from observer_lab.course.reading.toml_table import Table
from observer_lab.engine import Plant, Scenario, simulate
from observer_lab.engine.systems import step_covariance
from observer_lab.text import Text, same, text

from .setup import Setup
from .study import Study, nonlinear_run

BATCH_RUNS, POINTS = 5, 100  # runs between two results, points of a course at most
LEAST_CORRELATION = 1e-10  # least eigenvalue of the correlations of a covariance that has an inverse
NO_NOISE = text("This design has no noise, so that all runs are the same; set noise or disturbance above 0.")
SINGULAR = text("The noise does not reach every state, so that P has no inverse.")


def read_seeds(top: Table, setup: Setup) -> SeedTrial | None:
    """The runs of many seeds, of a lesson with noise and two states or more; `cloud` names the two that are drawn.

    Raises LessonFileError.
    """
    plant = setup.source.model.plant
    noisy = any(key in top.table("run").data for key in ("noise", "disturbance"))
    if "cloud" in top.data and not (noisy and plant.n > 1):
        raise top.refuse("cloud", text("cloud needs a plant with two states and noise or disturbance in [run]."))
    if not noisy or plant.n < 2:
        return None
    names = top.names("cloud", plant.state_names) or plant.state_names[:2]
    if len(set(names)) != 2 or len(names) != 2:
        raise top.refuse("cloud", text("cloud must name two states."))
    return partial(run_seeds, setup, tuple(plant.state_names.index(name) for name in names))


def run_seeds(setup: Setup, shown: tuple[int, ...], outcome: Outcome[Study],
              seeds: np.ndarray) -> Iterator[tuple[float, SeedErrors | None]]:
    """The error at the end about its course without noise, and P(t) of the observer from P(0) = 0. Raises KnobError."""
    scenario, values = outcome.study.run.scenario, setup.parameters.values(outcome.design)
    model = scenario.plant if scenario.model is None else scenario.model
    if scenario.V is None and (scenario.W is None or setup.source.python is not None):
        raise KnobError(NO_NOISE)
    P = predicted(setup, scenario, model, setup.belief(values))
    _check_regular(P[-1])
    quiet, n = _errors(setup, outcome.design, replace(scenario, W=None, V=None)), scenario.plant.n
    if len(quiet) < scenario.n_t:
        raise KnobError(text("This run is lost before its end; choose gentler gains."))
    rows, stride = np.eye(n)[list(shown)], -(-scenario.n_t // POINTS)
    times = scenario.dt * np.arange(scenario.n_t)[::stride]
    errors, paths = np.full((len(seeds), n), np.nan), np.full((len(seeds), len(times)), np.nan)
    sigmas = np.sqrt(np.maximum(P[::stride, shown[0], shown[0]], 0.0))
    names = _names(scenario.plant, shown)
    for k, seed in enumerate(seeds, start=1):
        e = _errors(setup, outcome.design, replace(scenario, seed=int(seed)))
        if len(e) == scenario.n_t:
            errors[k - 1], paths[k - 1] = e[-1] - quiet[-1], (e - quiet)[::stride, shown[0]]
        if k % BATCH_RUNS == 0 or k == len(seeds):
            yield k / len(seeds), SeedErrors(float(scenario.dt * (scenario.n_t - 1)), errors[:k].copy(), P[-1], rows, names, times,
                                             paths[:k].copy(), sigmas)


def predicted(setup: Setup, scenario: Scenario, model: Plant, believed: Mapping[str, float]) -> np.ndarray:
    """P (n_t, n, n) at each sample, as the observer predicts it by its model and its gain L.

    P⁺ = Φ P Φᵀ + Q + Γ V_d Γᵀ, where Φ = e^{Fh}, F = A − LC, Γ = ∫₀ʰ e^{Fs} ds L and Q = ∫₀ʰ e^{Fs} BWBᵀ e^{Fᵀs} ds: v is held over a step.
    A plant in discrete time has Φ = F, Γ = L and Q = BWBᵀ. W and V are those of `[observer]` where it states them, else those of the run.
    """
    L, h = np.asarray(scenario.L), scenario.dt
    W, V = _intensities(setup, scenario, model, believed)
    F, push, held = model.A - L @ model.C, model.B @ W @ model.B.T, V if model.dt else V / h
    if model.dt:
        Phi, Gamma, Q = F, L, push
    else:
        n = model.n
        both: np.ndarray = expm(np.block([[F, L], [np.zeros((model.p, n + model.p))]]) * h)
        Phi, Gamma, Q = both[:n, :n], both[:n, n:], step_covariance(F, push, h)
    Q = Q + Gamma @ held @ Gamma.T
    P = np.zeros((scenario.n_t, model.n, model.n))
    for k in range(1, scenario.n_t):
        P[k] = Phi @ P[k - 1] @ Phi.T + Q
    return P


def _intensities(setup: Setup, scenario: Scenario, model: Plant, believed: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """W (m×m) and V (p×p) that the observer assumes."""
    if setup.assumed is not None:
        return setup.assumed(model, believed)
    W = np.zeros((model.m, model.m)) if scenario.W is None or setup.source.python is not None else np.asarray(scenario.W)
    return W, np.zeros((model.p, model.p)) if scenario.V is None else np.asarray(scenario.V)


def _errors(setup: Setup, design: Design, scenario: Scenario) -> np.ndarray:
    linear = simulate(scenario)
    return linear.e if setup.source.python is None else nonlinear_run(setup, design, linear).e


def _check_regular(P: np.ndarray) -> None:
    spread = np.sqrt(np.maximum(np.diag(P), 0.0))
    if not spread.all() or not np.isfinite(P).all() or np.linalg.eigvalsh(P / np.outer(spread, spread))[0] < LEAST_CORRELATION:
        raise KnobError(SINGULAR)


def _names(plant: Plant, shown: tuple[int, ...]) -> tuple[Text, Text]:
    first, second = (plant.state_names[k] for k in shown)
    return _name(first, plant.unit(first)), _name(second, plant.unit(second))


def _name(state: str, unit: str) -> Text:
    return text("error of {name}", name=same(f"{state} [{unit}]" if unit else state))
