"""Sample a continuous observer and its feedback by one rule, and measure what that costs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..engine import EngineError, Plant, closed_loop, compensator, loop_margins, simulate
from ..engine.simulation import Run, Scenario, emulated_gain, separation_meter
from ..engine.systems import discretise
from ..text import SaidError, Text, text

__all__ = ["DeviceError", "SampledDesign", "sample_design"]

HELD = text("The model is sampled exactly, with its input held for {ts:.3g} s. The observer gain is the integral of exp((A − L C) s) L "
            "over one period, and K stays as it is.")
AS_GIVEN = text("The design is sampled already, every {ts:.3g} s; nothing is changed.")
TRUE_STATE = text("This design feeds back the true state, which no device measures; switch to feedback of the estimate.")
NOT_WHOLE = text("The period must be a whole number of steps of {dt:.6g} s; choose {near:.6g} s instead of {ts:.6g} s.")
SAMPLED_ALREADY = text("This design is sampled every {dt:.6g} s already; leave the period out.")
TOO_LONG = text("A period of {ts:.3g} s leaves fewer than two samples of the run of {horizon:.3g} s; choose a shorter one.")
UNSTABLE = text("Sampled every {ts:.3g} s the loop is unstable: its largest pole has modulus {radius:.4g}. Choose a shorter period.")
NO_OBSERVER = text("This design has no observer gain and no feedback, so there is nothing for a device to compute.")


class DeviceError(SaidError):
    """A design that no device can run; `text` says why in every language."""


@dataclass(frozen=True, eq=False)
class SampledDesign:
    """A scenario whose observer runs once every period, its sampled model and gain, its run, and what the sampling cost.

    Poles before and after are those of A − B K and A − L C in 1/s, after as log(z)/T. A margin is the disk margin of the loop, None where
    nothing is fed back. `meter` is the separation meter of the sampled run.
    """

    scenario: Scenario
    model: Plant
    L: np.ndarray
    run: Run
    drives: bool
    rule: Text
    before: np.ndarray
    after: np.ndarray
    margins: tuple[float, float] | None
    meter: float | None

    @property
    def period(self) -> float:
        """Seconds from one step to the next."""
        return self.scenario.dt


def sample_design(s: Scenario, ts: float | None = None) -> SampledDesign:
    """The scenario with a sampled observer, every `ts` seconds (None: every step of its grid). Raises DeviceError where that breaks it."""
    drives = bool(np.any(s.K))
    if s.state_feedback and drives:
        raise DeviceError(TRUE_STATE)
    if not drives and not np.any(s.L):
        raise DeviceError(NO_OBSERVER)
    if s.discrete and ts is not None and abs(ts - s.dt) > 1e-9 * s.dt:
        raise DeviceError(SAMPLED_ALREADY.format(dt=s.dt))
    if s.plant.dt:
        return _measured(s, drives, AS_GIVEN.format(ts=s.dt))
    every = 1 if ts is None else round(ts / s.dt)
    if every < 1 or (ts is not None and abs(ts - every * s.dt) > 1e-6 * ts):
        raise DeviceError(NOT_WHOLE.format(dt=s.dt, near=max(every, 1) * s.dt, ts=ts))
    if every > s.n_t - 2:
        raise DeviceError(TOO_LONG.format(ts=ts, horizon=s.horizon))
    T = every * s.dt
    reference = None if s.reference is None else s.reference[::every]
    impulses = tuple((T * round(time / T), jump) for time, jump in s.impulses)
    held = replace(s, dt=T, sampled=True, reference=reference, impulses=impulses, horizon=T * ((s.n_t - 1) // every),
                   delay=T * round(s.delay / T))
    return _measured(held, drives, HELD.format(ts=T))


def _measured(s: Scenario, drives: bool, rule: Text) -> SampledDesign:
    """What the sampling cost. Raises DeviceError where a stable design becomes unstable."""
    T, kept = s.dt, bool(s.plant.dt)
    plant, model = (each if kept else discretise(each, T) for each in (s.plant, s.model))
    L = s.L if kept else emulated_gain(s.model, s.L, T)
    loop = closed_loop(plant, s.K, L, model=model).poles if drives else np.linalg.eigvals(model.A - L @ model.C)
    radius = float(np.abs(loop).max(initial=0.0))
    designed = closed_loop(s.plant, s.K, s.L, model=s.model).poles if drives else np.linalg.eigvals(s.model.A - s.L @ s.model.C)
    if not kept and np.all(designed.real < 0) and radius >= 1:
        raise DeviceError(UNSTABLE.format(ts=T, radius=radius))
    margins = (_margin(s.plant, s.model, s.K, s.L), _margin(plant, model, s.K, L)) if drives else None
    run = simulate(s)
    meter = separation_meter(run) if s.model.n == s.plant.n else None
    return SampledDesign(s, model, L, run, drives, rule, _rates(s.model, s.K, s.L, T), _rates(model, s.K, L, T), margins, meter)


def _rates(model: Plant, K: np.ndarray, L: np.ndarray, T: float) -> np.ndarray:
    parts = [model.A - L @ model.C, *([model.A - model.B @ K] if np.any(K) else [])]
    poles = np.concatenate([np.sort_complex(np.linalg.eigvals(part)) for part in parts]).astype(complex)
    return np.log(np.where(np.abs(poles) > 1e-300, poles, 1e-300)) / T if model.dt else poles


def _margin(plant: Plant, model: Plant, K: np.ndarray, L: np.ndarray) -> float:
    try:
        return float(loop_margins(plant, compensator(model, K, L)).input_disk.alpha)
    except EngineError:
        return 0.0
