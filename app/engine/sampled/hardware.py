"""Define the hardware between controller and plant: coils, drivers, sensors, computer."""

from __future__ import annotations

import numpy as np

from ..systems.errors import EngineError
from ..systems.gates.argument_checks import count, instance, number, passed, takes
from ..systems.plant import Plant
from ..systems.records import record

__all__ = ["Hardware", "coil_driver"]


@record(eq=True)
class Hardware:
    """The switches of real life; the default is ideal.

    limit: most that a coil gives, either way (N). bandwidth Hz and order (1 or 2; the second order with ζ = 1/√2) of
    the coil driver, which follows the clipped command with gain 1. walk: bias of each sensor as a random walk, units
    per √s; ramp: as a straight line, units per s. step: size of one bit of the converter (0: none). delay: seconds from
    reading a sensor to giving the command, whole samples and a fraction. Raises EngineError for sizes without sense.
    """

    limit: float = np.inf
    bandwidth: float = np.inf
    order: int = 1
    walk: float = 0.0
    ramp: float = 0.0
    step: float = 0.0
    delay: float = 0.0

    def __post_init__(self) -> None:
        size = number(infinite=True)
        passed(self, limit=size, bandwidth=size, order=size, walk=size, ramp=size, step=size, delay=size)
        if not self.limit > 0 or not self.bandwidth > 0:
            raise EngineError("A coil needs a limit above 0 N and its driver a bandwidth above 0 Hz.")
        if self.order not in (1, 2):
            raise EngineError("A driver is of order 1 or 2.")
        if not all(np.isfinite(size) and size >= 0 for size in (self.walk, self.step, self.delay)):
            raise EngineError("Random walk, converter step and delay must be finite and not negative.")
        if not np.isfinite(self.ramp):
            raise EngineError("The slope of the bias must be finite.")

    @property
    def linear(self) -> bool:
        """Whether nothing clips and nothing rounds."""
        return bool(np.isinf(self.limit) and self.step == 0)


@takes(hardware=instance(Hardware), coils=count(1, 1000))
def coil_driver(hardware: Hardware, coils: int) -> Plant | None:
    """The driver of every coil, command to force, as one continuous plant; None where its bandwidth is infinite.

    Order 1: ω/(s + ω). Order 2: ω²/(s² + √2 ω s + ω²), which is −3 dB at the same ω = 2π·bandwidth.
    """
    if np.isinf(hardware.bandwidth):
        return None
    omega, eye = 2 * np.pi * hardware.bandwidth, np.eye(coils)
    if hardware.order == 1:
        return Plant(-omega * eye, omega * eye, eye)
    zero = np.zeros((coils, coils))
    A = np.block([[zero, omega * eye], [-omega * eye, -np.sqrt(2) * omega * eye]])  # (force, its rate / ω)
    return Plant(A, np.vstack([zero, omega * eye]), np.hstack([eye, zero]))
