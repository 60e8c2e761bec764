"""Build the loop of lesson 20: gains, run with an ideal gear or with backlash, rest position."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi, radians

import numpy as np

from observer_lab.course.lesson import Design
from observer_lab.engine import Scenario, observer_gain, place, simulate
from observer_lab.engine.simulation import Gear, Run, simulate_geared
from observer_lab.plants.arm import ANGLE_INDEX, LOAD_INDEX, MODEL, MOTOR_DATA, PARAMETERS, SPEED_INDEX

from ..toolkit.knobs import kicks
from .knobs import EXACT_ENCODER, JOINT

ARM_PLANT = MODEL.plant
A3, B3, C3 = ARM_PLANT.A[:LOAD_INDEX, :LOAD_INDEX], ARM_PLANT.B[:LOAD_INDEX], ARM_PLANT.C[:, :LOAD_INDEX]  # without the load
ENTRY = ARM_PLANT.A[:LOAD_INDEX, LOAD_INDEX:]  # how the load enters
WINDING = float(min(np.real(np.linalg.eigvals(A3))))  # 1/s; the pole that stays where the motor put it
LOAD_AT = 1.0  # s
READ = 0.002  # s between two readings of an encoder
RUN_SERIES = ("x", "xhat", "e", "u_asked", "u_applied", "y", "yhat", "w", "v")


@dataclass(frozen=True, eq=False)
class Played:
    """A run and, at its instants, the motor's angle as the joint sees it (rad) and the flank in contact.

    `linear`: nothing counts and nothing plays; the voltage may be clipped.
    """

    run: Run
    motor: np.ndarray
    contact: np.ndarray
    linear: bool


def gains(design: Design) -> tuple[np.ndarray, np.ndarray]:
    """K (1×4) and L (4×1): u = r − K x̂. Without a state for the load its entries are zero, and τ̂ stays 0."""
    K, L = np.zeros((1, 4)), np.zeros((4, 1))
    K[:, :LOAD_INDEX] = place(A3, B3, (WINDING, *design["controller_poles"])).gain
    if not design["load_state"]:
        L[:LOAD_INDEX] = observer_gain(A3, C3, (WINDING, *design["plain_poles"])).gain
        return K, L
    if design["cancel"]:
        K[0, LOAD_INDEX] = -(MOTOR_DATA.resistance + K[0, 0]) / PARAMETERS.torque
    return K, observer_gain(ARM_PLANT.A, ARM_PLANT.C, (WINDING, *design["observer_poles"])).gain


def scenario_of(design: Design, K: np.ndarray, L: np.ndarray, dt: float = MODEL.dt) -> Scenario:
    """The loop from rest to the target, the load as a jump of its state at 1 s."""
    jump = (LOAD_AT, (0.0, 0.0, 0.0, design["load"]))
    kicked = tuple((READ * round(t / READ), kick) for t, kick in kicks(design, MODEL))  # at a moment when the encoder is read
    return Scenario(ARM_PLANT, K, L, x0=MODEL.x0, xhat0=MODEL.guess, horizon=MODEL.horizon, dt=dt,
                    reference=[K[0, ANGLE_INDEX] * radians(design["target"])], u_min=-design["u_max"], u_max=design["u_max"],
                    impulses=(jump, *kicked))


def step_of(design: Design) -> float:
    """What one count is of the joint's angle, rad; 0 for an exact encoder."""
    if design["encoder"] == EXACT_ENCODER:
        return 0.0
    return 2 * pi / round(design["counts"]) / (1.0 if design["encoder"] == JOINT else PARAMETERS.ratio)


def gear_of(design: Design) -> Gear:
    """The gear with its play, and the encoder."""
    p = PARAMETERS
    return Gear(ANGLE_INDEX, SPEED_INDEX, p.reflected, p.arm, [0.0, -p.friction, 0.0, -1.0], gap=radians(design["gap"]),
                sensor="outer" if design["encoder"] == JOINT else "inner", step=step_of(design))


def played(design: Design, K: np.ndarray, L: np.ndarray) -> Played:
    """The run: exact where nothing plays, counts or clips, else with encoder and limits looked at every 2 ms; shown every 4 ms."""
    ideal = not design["gap"] and design["encoder"] == EXACT_ENCODER
    if ideal:
        free = simulate(replace(scenario_of(design, K, L), u_min=None, u_max=None))
        if np.abs(free.u_asked).max() <= design["u_max"]:
            run = replace(free, scenario=scenario_of(design, K, L))
            return Played(run, run.x[:, ANGLE_INDEX], np.ones(len(run.t)), True)
    fine, every = simulate_geared(scenario_of(design, K, L, READ), gear_of(design)), round(MODEL.dt / READ)
    scenario, shown = scenario_of(design, K, L), {name: getattr(fine.run, name)[::every] for name in RUN_SERIES}
    run = replace(fine.run, scenario=scenario, t=scenario.t[:len(shown["x"])], **shown)
    return Played(run, fine.inner[::every], fine.contact[::every], ideal)


def resting(design: Design, K: np.ndarray, L: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """x (4,) and x̂ (4,) where the linear loop comes to rest under the load, None where it is unstable.

    0 = A x + B (r − K x̂) and 0 = A x̂ + B (r − K x̂) + L C (x − x̂), x the three states of motor and arm with τ given.
    """
    kept = [0, 1, 2, 3] if design["load_state"] else [0, 1, 2]
    believed = ARM_PLANT.A - ARM_PLANT.B @ K - L @ ARM_PLANT.C
    M = np.block([[A3, -(B3 @ K)[:, kept]], [(L @ C3)[kept], believed[np.ix_(kept, kept)]]])
    if float(np.max(np.real(np.linalg.eigvals(M)))) >= 0:
        return None
    asked = K[0, ANGLE_INDEX] * radians(design["target"])
    push = np.concatenate([ENTRY[:, 0] * design["load"] + B3[:, 0] * asked, ARM_PLANT.B[kept, 0] * asked])
    found = np.linalg.solve(M, -push)
    xhat = np.zeros(4)
    xhat[kept] = found[LOAD_INDEX:]
    return np.append(found[:LOAD_INDEX], design["load"]), xhat
