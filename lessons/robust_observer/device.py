"""Give the functional observer of lesson 15 to a device, with its feedback if it has one."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.devices import HELD_READINGS, DeviceDesign, DeviceError, linear_routine, sampled_observer
from observer_lab.engine.systems import discretise
from observer_lab.text import text

from .own_loop import Story as OwnStory
from .study import DT, Story

LOOP_LOST = text("Sampled every {ts:.3g} s the loop with the model is unstable: its largest pole has modulus {radius:.4g}. Choose a "
                 "shorter period.")
POLES_KEPT = text("Largest pole of the sampled loop with the model: modulus {radius:.4g}.")


def device(outcome: Outcome[Story], ts: float | None = None) -> DeviceDesign:
    """The observer on the page's run with the true plant. Raises DeviceError where the sampled loop is unstable."""
    story: Story | OwnStory = outcome.study
    o = story.observer
    plant = o.plant
    own = isinstance(story, OwnStory)
    step = float(story.true.t[1] - story.true.t[0]) if own else DT
    every = max(1, round((step if ts is None else ts) / step))
    period = every * step
    drives = not own and len(o.K) == plant.m
    D = np.asarray(plant.D)
    F, L, H = sampled_observer(o.F, (o.L, o.TB - o.L @ D), period)
    names = tuple(f"K x {k + 1}" for k in range(len(o.K)))
    matrices = {"F": F, "L": L, "H": H, "N": o.N, "M": o.M, **({"E": -o.M @ D} if np.any(D) and not drives else {})}
    held = discretise(plant, period)
    loss = ()
    if drives:
        K = np.hstack([o.M @ held.C, o.N])
        loop = np.block([[held.A, np.zeros((plant.n, o.order))], [L @ held.C, F]]) - np.vstack([held.B, H]) @ K
        radius = float(np.abs(np.linalg.eigvals(loop)).max())
        if radius >= 1:
            raise DeviceError(LOOP_LOST.format(ts=period, radius=radius))
        loss = (POLES_KEPT.format(radius=radius),)
    y, u, z, r = _record(story)
    routine = linear_routine("functional observer", period, matrices, z, (names, plant.input_names, plant.output_names),
                             HELD_READINGS.format(ts=period), drives=drives)
    return DeviceDesign(routine, y[::every], u[::every], r[::every] if drives else None, None, loss=loss)


def _record(story: Story | OwnStory) -> tuple[np.ndarray, ...]:
    """Readings, inputs, the observer's start and the command along the page's run."""
    if isinstance(story, OwnStory):
        run, plant = story.model, story.observer.plant
        return run.x @ plant.C.T + run.u @ np.asarray(plant.D).T, run.u, np.zeros(story.observer.order), np.zeros_like(run.u)
    return story.true.y, story.true.u, story.true.z[0], story.true.v
