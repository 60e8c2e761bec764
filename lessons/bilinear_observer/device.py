"""Give the bilinear observer that needs no derivative of y to a device."""

from __future__ import annotations

from observer_lab.course.lesson import Outcome
from observer_lab.devices import HELD_READINGS, DeviceDesign, linear_routine, sampled_observer

from .input_signals import columns
from .study import Study


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The observer on the page's run. Raises DeviceError where its error does not decay."""
    s, design, run = outcome.study.setting, outcome.design, outcome.study.run
    form, C, count = s.plain, s.solved.plant.C, len(run.t)
    noise = s.noise(design, count) if design["noise"] else 0.0
    step = float(run.t[1] - run.t[0])
    every = 1 if ts is None else max(1, round(ts / step))
    F, L, H, U = sampled_observer(form.A, (form.Y, form.B, form.U), every * step)
    wanted = tuple(f"g{k + 1}" for k in range(len(form.G_z)))
    routine = linear_routine("bilinear functional observer", every * step, {"F": F, "L": L, "H": H, "N": form.G_z, "M": form.G_y, "U": U},
                             s.chi0, (wanted, *s.signals), HELD_READINGS.format(ts=every * step))
    page = run.estimates[::every, 0].reshape(-1, len(wanted))
    return DeviceDesign(routine, (run.x @ C.T + noise)[::every], columns(run.u)[::every], None, page)
