"""The geared arm as code: the sheet, the gains, the gear with its play, the encoder, and what the page shows."""

from __future__ import annotations

from math import radians

import numpy as np

from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Outcome
from app.plants.arm import LOAD, MODEL, PARAMETERS, SHEET

from .knobs import JOINT
from .study import Study
from .system import READ, scenario_of


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, run, p = outcome.design, outcome.metrics, outcome.run, PARAMETERS
    assert run is not None
    K, L, shown = outcome.gains["K"], outcome.gains["L"], outcome.study.played
    every = round(MODEL.dt / READ)
    kicks = scenario_of(d, K, L).impulses
    loaded = [Shown("by_poles", float(L[LOAD, 0]), max(1.0, abs(float(L[LOAD, 0]))))] if d["load_state"] else []
    cancelled = [Shown("-c", float(K[0, LOAD]))] if d["load_state"] and d["cancel"] else []
    return Code(("arm",), (
        Given("R", SHEET.resistance, "Ohm; maxon RE 40, order number 148867"), Given("inductance", SHEET.inductance, "H"),
        Given("torque_constant", SHEET.torque_constant, "N m/A"), Given("rotor", SHEET.rotor, "kg m^2"),
        Given("ratio", p.ratio, "of the gear"), Given("arm", p.arm, "kg m^2, chosen"), Given("friction", p.friction, "N m s/rad, chosen"),
        Given("K", K, "u = r - K xhat; its poles are asserted below"), Given("L", L, "and those of the observer"),
        Given("target", radians(d["target"]), "rad"), Given("load", float(d["load"]), "N m from 1 s on"),
        Given("u_max", float(d["u_max"]), "V"), Given("gap", radians(d["gap"]), "rad from flank to flank"),
        Given("at_joint", d["encoder"] == JOINT, "where the encoder sits: at the joint, or on the motor"),
        Given("step", outcome.study.step, "rad of the joint for one count; 0: exact"),
        Given("h", READ, "s between two looks at encoder and limits"), Given("every", every, "looks from one shown instant to the next"),
        Given("count", every * (len(run.t) - 1) + 1, "looks"),
        Given("kicks", [(float(t), *np.asarray(jump).tolist()) for t, jump in kicks], "time in s, jump of (i, omega, theta, tau)"),
    ), (
        *loaded, *cancelled,
        Shown("eigvals(steered)", outcome.poles["controller"], poles=True),
        Shown("eigvals(A - L @ C)", outcome.poles["observer"], poles=True),
        Shown("x", run.x), Shown("xhat", run.xhat), Shown("u_asked", run.u_asked), Shown("u_applied", run.u_applied), Shown("y", run.y),
        Shown("motor", shown.motor), Shown("load_error", m["load_error"], max(1e-3, m["load_error"])),
        Shown("droop", m["droop"], 1.0), Shown("false_load", m["false_load"], max(1e-3, m["false_load"])), Shown("holding", m["holding"]),
    ), "Other figures of the run")
