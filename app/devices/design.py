"""Turn a run or a controller into a device: its routine, what a test feeds it, what the page shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..engine import Belief, Plant
from ..engine.filters import LinearFilter
from ..engine.sampled import sampled_controller
from ..engine.simulation import Run
from ..engine.systems import discretise
from ..text import Text, text
from . import kalman, observer
from .kalman import kalman_routine
from .linear import linear_routine
from .observer import observer_routine
from .routine import Device, Routine
from .sampling import DeviceError, SampledDesign, sample_design

__all__ = ["DeviceDesign", "design_of_controller", "design_of_filter", "design_of_run", "watching"]

POLES = text("Poles of observer and feedback before: {before}; after: {after} (1/s).")
MARGIN = text("Disk margin before: {before:.3g}; after: {after:.3g}.")
METER = text("Separation meter of the sampled run: {meter:.2g}.")
TUSTIN = text("The controller is sampled by Tustin's rule every {ts:.3g} s: s = 2 (z − 1) / (T (z + 1)).")
HELD_INPUTS = text("The controller is sampled exactly, with its readings held for {ts:.3g} s; a pole beyond 2/T would ring under "
                   "Tustin's rule.")
RUNS_ALREADY = text("The controller runs every {ts:.3g} s as it is.")
OTHER_PERIOD = text("This controller runs every {dt:.6g} s already; leave the period out.")
LOOP_UNSTABLE = text("Sampled every {ts:.3g} s the loop is unstable: its largest pole has modulus {radius:.6g}. Choose a shorter period, "
                     "or another controller.")
LOOP_POLES = text("The largest pole of the sampled loop has modulus {radius:.6g}.")
ROUNDED_AWAY = text("On this plant rounding makes a variance negative, so a device cannot compute this filter. Write states and outputs in "
                    "other units, so that their numbers are of similar size.")
NO_CONTROLLER = text("This controller does nothing, so there is nothing for a device to compute.")
NOTHING_TO_WATCH = text("This design is a controller without an estimate of the plant's state, so there is nothing to compare "
                        "with a plant.")


@dataclass(frozen=True, eq=False)
class DeviceDesign:
    """A routine with the run that its test replays: readings y, inputs u and commands r, one row a sample.

    `page` is what the page shows of the table `shown` at these samples, NaN where it shows nothing; `loss` says what the sampling cost.
    """

    routine: Routine
    y: np.ndarray
    u: np.ndarray
    r: np.ndarray | None = None
    page: np.ndarray | None = None  # columns of `shown`
    shown: str = "xhat"
    loss: tuple[Text, ...] = field(default=())

    def expected(self, *, single: bool = False) -> dict[str, np.ndarray]:
        """The watched tables after each sample, as the plain Python form gives them. Raises DeviceError where rounding stops it."""
        try:
            return Device(self.routine, single=single).run(self.y, self.u, self.r, self.routine.watched)
        except (ArithmeticError, ValueError) as problem:  # the root of a variance that rounding has made negative, or a division by it
            raise DeviceError(ROUNDED_AWAY) from problem

    def gap(self) -> float | None:
        """The largest difference from the page's estimate over the run, as a share of its largest entry; None where the page has none."""
        if self.page is None:
            return None
        found = self.expected()[self.shown][:, :self.page.shape[1]]
        return float(np.nanmax(np.abs(found - self.page)) / max(float(np.nanmax(np.abs(self.page))), 1e-300))


def design_of_run(run: Run, ts: float | None = None) -> DeviceDesign:
    """The device of a page's run. Raises DeviceError where no device can compute it."""
    found = sample_design(run.scenario, ts)
    s, held = found.scenario, found.run
    routine = observer_routine(
        found.model, s.K if found.drives else None, found.L, s.xhat0, found.rule, limits=(s.u_min, s.u_max) if s.limited else None,
        applied=s.fed == "applied", r=None if s.reference is None else s.reference[0])
    told = np.clip(held.u_asked, s.u_min, s.u_max) if s.fed == "applied" else held.u_asked
    commands = s.reference[:len(held.t)] if found.drives and s.reference is not None else None
    return DeviceDesign(routine, held.y, told, commands, held.xhat, loss=tuple(losses(found)))


def design_of_filter(kf: LinearFilter, start: Belief, record: tuple[np.ndarray, np.ndarray],
                     names: tuple[Sequence[str], Sequence[str], Sequence[str]], page: np.ndarray | None, *, gate: float | None = None,
                     ) -> DeviceDesign:
    """The device of a recursive Kalman filter from its belief before the first row of the record (y, u); `names` of x, u and y."""
    y, u = record
    B, D = kf.B, np.asarray(kf.D)
    if not B.shape[1]:  # C has no empty arrays
        B, D, u, names = np.zeros((kf.n, 1)), np.zeros((len(kf.C), 1)), np.zeros((len(y), 1)), (names[0], ("unused",), names[2])
    routine = kalman_routine(kf.A, B, kf.C, kf.Q, kf.R, (start.mean, start.covariance), kf.dt, names, D=D, gate=gate)
    return DeviceDesign(routine, y, u, None, page)


def losses(found: SampledDesign) -> list[Text]:
    """What the sampling cost, a sentence for each measure."""
    said = [POLES.format(before=_listed(found.before), after=_listed(found.after))]
    if found.margins is not None:
        said.append(MARGIN.format(before=found.margins[0], after=found.margins[1]))
    if found.meter is not None:
        said.append(METER.format(meter=found.meter))
    return said


def _listed(poles: np.ndarray) -> str:
    return ", ".join(f"{p.real:.4g}{p.imag:+.4g}j" if abs(p.imag) > 1e-12 * abs(p) else f"{p.real:.4g}" for p in poles)


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


def watching(routine: Routine) -> Routine:
    """The same observer, its feedback left out: u is given. Raises DeviceError for a controller without an estimate."""
    if not routine.drives:
        return routine
    if "xnext" not in routine.lengths:
        raise DeviceError(NOTHING_TO_WATCH)
    source = routine.source.replace("asked[j]", "u[j]")
    for part in (observer.FEEDBACK, observer.CLIP, kalman.FEEDBACK, kalman.CLIP):
        source = source.replace(part.strip() + "\n", "")
    dropped = {"K", "u_min", "u_max"}
    return replace(routine, source=source, drives=False, constants=tuple(each for each in routine.constants if each.name not in dropped),
                   states=tuple(each for each in routine.states if each.name != "r"),
                   scratch={name: size for name, size in routine.scratch.items() if name != "asked"},
                   watched=tuple(name for name in routine.watched if name != "u"))
