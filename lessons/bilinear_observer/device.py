"""Give the bilinear observer that needs no derivative of y to a device."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.devices import HELD_READINGS, DeviceDesign, linear_routine, sampled_observer
from observer_lab.engine.observers import BilinearForm
from observer_lab.plants.bilinear import PRINTED_FORM

from .input_signals import columns, noise_values
from .own_run import deviations
from .own_summary import Story
from .problems import PAPER_PROBLEM, PROBLEMS, ROUNDED_GAIN
from .study import Study


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The observer on the page's run. Raises DeviceError where its error does not decay."""
    found: Study | Story = outcome.study
    design, run = outcome.design, found.run
    count = len(run.t)
    if isinstance(found, Story):
        form, C, start = found.plain, found.here.model.plant.C, np.zeros(len(found.plain.A))
        noise = deviations(found.here, design) * noise_values(design, count, len(C)) if design["noise"] else 0.0
        names = found.here.model.plant.input_names, found.here.model.plant.output_names
    else:
        problem = PROBLEMS[design["problem"]]
        form, C, start = _form(outcome, problem.id == PAPER_PROBLEM), problem.plant.C, np.array([design["chi0"]])
        noise = design["noise"] * noise_values(design, count, len(C)) if design["noise"] else 0.0
        names = ("u",), tuple(f"y{k + 1}" for k in range(len(C)))
    step = float(run.t[1] - run.t[0])
    every = 1 if ts is None else max(1, round(ts / step))
    F, L, H, U = sampled_observer(form.A, (form.Y, form.B, form.U), every * step)
    wanted = tuple(f"g{k + 1}" for k in range(len(form.G_z)))
    routine = linear_routine("bilinear functional observer", every * step, {"F": F, "L": L, "H": H, "N": form.G_z, "M": form.G_y, "U": U},
                             start, (wanted, *names), HELD_READINGS.format(ts=every * step))
    page = run.estimates[::every, 0].reshape(-1, len(wanted))
    return DeviceDesign(routine, (run.x @ C.T + noise)[::every], columns(run.u)[::every], None, page)


def _form(outcome: Outcome[Study], paper: bool) -> BilinearForm:
    """The form without ẏ that the page runs."""
    if paper and outcome.design["gain"] == ROUNDED_GAIN:
        return PRINTED_FORM
    return outcome.study.observer.forms(outcome.gains["L"])[1]
