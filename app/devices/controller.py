"""Turn a controller from y to u into a device, in a loop with its plant from a given start."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..engine import Plant
from ..engine.sampled import sampled_controller
from ..engine.systems import discretise
from ..text import text
from .design import DeviceDesign
from .linear import linear_routine
from .sampling import DeviceError

__all__ = ["design_of_controller"]

TUSTIN = text("The controller is sampled by Tustin's rule every {ts:.3g} s: s = 2 (z − 1) / (T (z + 1)).")
HELD_INPUTS = text("The controller is sampled exactly, with its readings held for {ts:.3g} s; a pole beyond 2/T would ring under "
                   "Tustin's rule.")
RUNS_ALREADY = text("The controller runs every {ts:.3g} s as it is.")
OTHER_PERIOD = text("This controller runs every {dt:.6g} s already; leave the period out.")
LOOP_UNSTABLE = text("Sampled every {ts:.3g} s the loop is unstable: its largest pole has modulus {radius:.6g}. Choose a shorter period, "
                     "or another controller.")
LOOP_POLES = text("The largest pole of the sampled loop has modulus {radius:.6g}.")
NO_CONTROLLER = text("This controller does nothing, so there is nothing for a device to compute.")


def design_of_controller(controller: Plant, plant: Plant, x0: Sequence[float] | np.ndarray, ts: float, steps: int, *,
                         edge: float = 1.0) -> DeviceDesign:
    """The device of u = K(s) y, sign included, every `ts` seconds. Its test replays the plant's readings from x0 in the sampled loop.

    Raises DeviceError where the loop has a pole outside the unit circle times `edge`.
    """
    if controller.dt and abs(ts - controller.dt) > 1e-9 * ts:
        raise DeviceError(OTHER_PERIOD.format(dt=controller.dt))
    if not controller.n and not np.any(np.asarray(controller.D)):
        raise DeviceError(NO_CONTROLLER)
    fast = not controller.dt and bool(np.any(np.abs(controller.poles) > 2 / ts))
    law, real = sampled_controller(controller, ts, method="hold" if fast else "tustin").last, plant if plant.dt else discretise(plant, ts)
    D = np.asarray(law.D)
    loop = np.block([[real.A + real.B @ D @ real.C, real.B @ law.C], [law.B @ real.C, law.A]])
    radius = float(np.abs(np.linalg.eigvals(loop)).max())
    if radius > edge:
        raise DeviceError(LOOP_UNSTABLE.format(ts=ts, radius=radius))
    state, y = np.concatenate([np.asarray(x0, dtype=float), np.zeros(law.n)]), np.empty((steps, real.p))
    for k in range(steps):
        y[k] = real.C @ state[:real.n]
        state = loop @ state
    m = real.m
    routine = linear_routine(
        "controller", ts, {"F": law.A, "L": law.B, "H": np.zeros((law.n, m)), "N": -law.C, "M": -D}, np.zeros(law.n),
        (tuple(f"-{name}" for name in plant.input_names), plant.input_names, plant.output_names),
        (RUNS_ALREADY if controller.dt else HELD_INPUTS if fast else TUSTIN).format(ts=ts), drives=True)
    return DeviceDesign(routine, y, np.zeros((steps, m)), None, None, loss=(LOOP_POLES.format(radius=radius),))
