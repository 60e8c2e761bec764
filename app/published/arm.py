"""Compare the arm's motor data sheet with the equations of the arm."""

from __future__ import annotations

import numpy as np

from ..plants.arm import CURRENT_INDEX, LOAD_INDEX, MOTOR_DATA, SPEED_INDEX, Parameters, plant
from .record import Published

SOURCE = "maxon RE 40, 148867"
NOTE = "the equations of the arm with neither gear nor arm; the sheet's digits bear no more"
RPM = 30 / np.pi


def turning(load: float) -> float:
    """The speed, rad/s, at which the motor alone turns at nominal voltage under a load in N m."""
    motor = plant(Parameters(ratio=1.0, arm=0.0, friction=0.0))
    A, B = motor.A[:LOAD_INDEX - 1, :LOAD_INDEX - 1], motor.B[:LOAD_INDEX - 1, 0]
    return float(np.linalg.solve(A, -B * MOTOR_DATA.voltage - motor.A[:LOAD_INDEX - 1, LOAD_INDEX] * load)[SPEED_INDEX])


def standing() -> float:
    """The current, A, of the motor held at nominal voltage."""
    motor = plant(Parameters(ratio=1.0, arm=0.0, friction=0.0))
    return float(-motor.B[CURRENT_INDEX, 0] * MOTOR_DATA.voltage / motor.A[CURRENT_INDEX, CURRENT_INDEX])


RECORDS = (
    Published(
        SOURCE,
        "no-load speed at 24 V, rpm",
        "7580",
        lambda: turning(MOTOR_DATA.torque_constant * MOTOR_DATA.no_load_current) * RPM,
        relative=2e-3,
        note=NOTE,
    ),
    Published(SOURCE, "stall current at 24 V, A", "80.2", standing, relative=2e-3, note=NOTE),
    Published(
        SOURCE, "stall torque at 24 V, mN m", "2420", lambda: 1000 * MOTOR_DATA.torque_constant * standing(), relative=3e-3, note=NOTE
    ),
    Published(SOURCE, "speed constant, rpm/V", "317", lambda: turning(0.0) / MOTOR_DATA.voltage * RPM, relative=3e-3, note=NOTE),
)
