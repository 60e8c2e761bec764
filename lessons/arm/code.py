"""Describe the arm's run as code: data sheet, gains, backlash, encoder, shown numbers."""

from __future__ import annotations

from math import radians

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue
from observer_lab.plants.arm import LOAD_INDEX, MODEL, MOTOR_DATA, PARAMETERS

from .knobs import JOINT
from .loop import READ, scenario_of
from .study import Study


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, run, p = outcome.design, outcome.metrics, outcome.run, PARAMETERS
    assert run is not None
    K, L, shown = outcome.gains["K"], outcome.gains["L"], outcome.study.played
    every = round(MODEL.dt / READ)
    kicks = scenario_of(d, K, L).impulses
    loaded = [ShownValue("by_poles", float(L[LOAD_INDEX, 0]), max(1.0, abs(float(L[LOAD_INDEX, 0]))))] if d["load_state"] else []
    cancelled = [ShownValue("-c", float(K[0, LOAD_INDEX]))] if d["load_state"] and d["cancel"] else []
    return Code(
        ("arm",),
        (
            GivenValue("R", MOTOR_DATA.resistance, "Ohm; maxon RE 40, order number 148867"),
            GivenValue("inductance", MOTOR_DATA.inductance, "H"),
            GivenValue("torque_constant", MOTOR_DATA.torque_constant, "N m/A"),
            GivenValue("rotor", MOTOR_DATA.rotor, "kg m^2"),
            GivenValue("ratio", p.ratio, "of the gear"),
            GivenValue("arm", p.arm, "kg m^2, chosen"),
            GivenValue("friction", p.friction, "N m s/rad, chosen"),
            GivenValue("K", K, "u = r - K xhat; its poles are asserted below"),
            GivenValue("L", L, "and those of the observer"),
            GivenValue("target", radians(d["target"]), "rad"),
            GivenValue("load", float(d["load"]), "N m from 1 s on"),
            GivenValue("u_max", float(d["u_max"]), "V"),
            GivenValue("gap", radians(d["gap"]), "rad from flank to flank"),
            GivenValue("at_joint", d["encoder"] == JOINT, "where the encoder sits: at the joint, or on the motor"),
            GivenValue("step", outcome.study.step, "rad of the joint for one count; 0: exact"),
            GivenValue("h", READ, "s between two looks at encoder and limits"),
            GivenValue("every", every, "looks from one shown instant to the next"),
            GivenValue("count", every * (len(run.t) - 1) + 1, "looks"),
            GivenValue("kicks", [(float(t), *np.asarray(jump).tolist()) for t, jump in kicks], "time in s, jump of (i, omega, theta, tau)"),
        ),
        (
            *loaded,
            *cancelled,
            ShownValue("eigvals(steered)", outcome.poles["controller"], poles=True),
            ShownValue("eigvals(A - L @ C)", outcome.poles["observer"], poles=True),
            ShownValue("x", run.x),
            ShownValue("xhat", run.xhat),
            ShownValue("u_asked", run.u_asked),
            ShownValue("u_applied", run.u_applied),
            ShownValue("y", run.y),
            ShownValue("motor", shown.motor),
            ShownValue("load_error", m["load_error"], max(1e-3, m["load_error"])),
            ShownValue("droop", m["droop"], 1.0),
            ShownValue("false_load", m["false_load"], max(1e-3, m["false_load"])),
            ShownValue("holding", m["holding"]),
        ),
        "Other figures of the run",
    )
