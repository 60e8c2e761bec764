"""Give the extended Kalman filter of lesson 14 to a device: cart-pendulum and falling body."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.devices import DeviceDesign, DeviceError, Equations, extended_routine
from observer_lab.engine import Belief
from observer_lab.plants import cart_pendulum
from observer_lab.plants.bodies import falling_body
from observer_lab.text import text

from .cases import EKF, FALL_CASE, PLATFORM, Case, plant_of
from .runs import Study, filters_of

OTHER_CASE = text("The deck's filter is not written for a device yet; choose the cart-pendulum or the falling body.")
OWN_PERIOD = text("This filter runs every {dt:.6g} s; leave the period out.")
PENDULUM = (
    ("sine", "lab_sin(theta)"), ("cosine", "lab_cos(theta)"), ("fall", "g * sine - pivot / (ball * length) * omega"),
    ("push", "force - friction * speed + ball * length * sine * omega * omega"), ("moves", "speed * 1.0"), ("turns", "omega * 1.0"),
    ("faster", "(push - ball * cosine * fall) / (cart + ball * sine * sine)"), ("swings", "(fall - cosine * faster) / length"))
FALL = (("sinks", "-speed"), ("slower", "-(lab_exp(-density * altitude) * speed * speed * beta)"), ("same", "0.0 * beta"))


def equations(case: Case) -> Equations:
    """The description from which f, h and their slopes follow."""
    if case.id == FALL_CASE:
        return Equations(("altitude", "speed", "beta"), (), FALL, ("sinks", "slower", "same"),
                         (("distance", "sqrt(side * side + (altitude - height) * (altitude - height))"),), ("distance",),
                         asdict(falling_body.PARAMETERS))
    return Equations(("cart_position", "theta", "speed", "omega"), ("force",), PENDULUM, ("moves", "turns", "faster", "swings"),
                     (("position", "cart_position * 1.0"),), ("position",), asdict(cart_pendulum.Parameters()))


def device(outcome: Outcome[Study], ts: float | None = None) -> DeviceDesign:
    """The filter on the readings of the page's first run, without noise. Raises DeviceError."""
    study, d = outcome.study, outcome.design
    case = study.case
    if case.id == PLATFORM:
        raise DeviceError(OTHER_CASE)
    if ts is not None and abs(ts - case.step) > 1e-9 * case.step:
        raise DeviceError(OWN_PERIOD.format(dt=case.step))
    plant = plant_of(case.id, d["hardening"], d["weakening"])
    ekf = filters_of(case, plant, d)[EKF]
    start = Belief(case.guess, np.diag((d["size"] * case.spread) ** 2))
    e = equations(case)
    routine = extended_routine(e, ekf.Q, ekf.R, (start.mean, start.covariance), case.step, case.parts, e.outputs)
    y, u = plant.output(study.x.T, study.u.T).T, study.u if plant.m else np.zeros((len(study.x), 1))
    page = ekf.run(start, y, u if plant.m else None).means
    return DeviceDesign(routine, y, u, None, page)
