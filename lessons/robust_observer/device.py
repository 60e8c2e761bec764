"""Give the functional observer of lesson 15 to a device, with its feedback if it has one."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.devices import HELD_READINGS, DeviceDesign, DeviceError, linear_routine, sampled_observer
from observer_lab.engine.systems import discretise
from observer_lab.text import text

from .loop import Story
from .own_job import Story as OwnStory

LOOP_LOST = text("Sampled every {ts:.3g} s the loop with the model is unstable: its largest pole has modulus {radius:.4g}. Choose a "
                 "shorter period.")
POLES_KEPT = text("Largest pole of the sampled loop with the model: modulus {radius:.4g}.")


def device(outcome: Outcome[Story], ts: float | None = None) -> DeviceDesign:
    """The observer on the page's run with the true plant. Raises DeviceError where the sampled loop is unstable."""
    story, o = outcome.study, outcome.study.observer
    plant = o.plant
    drives = not isinstance(story, OwnStory)
    run = story.true if drives else story.model
    step = float(run.t[1])
    every = max(1, round((step if ts is None else ts) / step))
    period = every * step
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
    routine = linear_routine("functional observer", period, matrices, run.z[0], (names, plant.input_names, plant.output_names),
                             HELD_READINGS.format(ts=period), drives=drives)
    return DeviceDesign(routine, run.y[::every], run.u[::every], run.v[::every, None] if drives else None, None, loss=loss)
