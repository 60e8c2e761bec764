"""Turn a run into a device: its routine, what a test feeds it, what the page shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..engine import Belief
from ..engine.filters import LinearFilter
from ..engine.simulation import Run
from ..text import Text, text
from .device import Device
from .kalman import kalman_routine
from .observer import observer_routine
from .routine import Routine
from .sampling import SampledDesign, sample_design

__all__ = ["DeviceDesign", "design_of_filter", "design_of_run"]

POLES = text("Poles of observer and feedback before: {before}; after: {after} (1/s).")
MARGIN = text("Disk margin before: {before:.3g}; after: {after:.3g}.")
METER = text("Separation meter of the sampled run: {meter:.2g}.")


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
        """The watched tables after each sample, as the plain Python form gives them."""
        return Device(self.routine, single=single).run(self.y, self.u, self.r, self.routine.watched)

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
