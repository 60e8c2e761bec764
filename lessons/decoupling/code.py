"""Describe the three channels, the mixing, the loop and the run as code."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue
from observer_lab.engine import Plant
from observer_lab.plants.platform import model
from observer_lab.plants.platform import siso_loops as siso
from observer_lab.plants.platform.channels import HORIZONTAL, T_u, T_y
from observer_lab.plants.platform.lqg_weights import coils

from .loops import (
    AXIS_POLE_RAD_S,
    BAND_HZ,
    DT,
    FALLING,
    GROUND_MATRIX,
    INDEX_FREQUENCIES,
    PLATFORM_PLANT,
    STATE_JUMP,
    lower_of,
    platform_of,
)
from .sensors import knee_of, reading, sensors_of
from .study import Study

NOT_IN_SCRIPT = "The least J by search, the rightmost pole with pitch open, and the residual of the placement"
WILD = 0.1  # m or m/s: a run on this quiet ground that gets there magnifies rounding as much
METRICS = ("vertical", "rotation", "horizontal")
NO_PLANT = Plant(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.zeros((1, 1)))


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, s = outcome.design, outcome.metrics, outcome.study
    lower = lower_of(d)
    plant, built = coils(platform_of(lower)), s.controllers
    sensors = reading(sensors_of(d))
    given: list[GivenValue] = []
    for name, controller in (("v", built.vertical), ("t", built.rotation), ("h", built.horizontal)):
        c = NO_PLANT if controller is None else controller
        given += [
            GivenValue(
                f"A_{name}",
                c.A,
                {
                    "v": "C_v, the vertical controller (a loop that is open has none)",
                    "t": "C_theta, of pitch",
                    "h": "C_h, the horizontal one",
                }[name],
            ),
            GivenValue(f"B_{name}", c.B),
            GivenValue(f"C_{name}", c.C),
            GivenValue(f"D_{name}", np.asarray(c.D)),
        ]
    numerator, denominator = siso.rigid_polynomials(HORIZONTAL, s.mixed.S, model.Parameters(lower=lower))
    shown = [
        ShownValue("S", outcome.gains["S"]),
        ShownValue("eigvals(loop)", outcome.poles["loop"], poles=True),
        ShownValue("J", m["J"]),
        ShownValue("J_plain", m["J_plain"]),
        ShownValue("rightmost", m["rightmost"], max(1e-3, abs(m["rightmost"]))),
        ShownValue("bare", s.spectra.bare),
        ShownValue("density", s.spectra.closed),
        ShownValue("forces", s.spectra.forces),
        ShownValue("suppression", [m[name] for name in METRICS], 1.0),
        ShownValue("ground", s.shaken.ground),
        ShownValue("x_bare", s.shaken.bare),
    ]
    calm = m["rightmost"] < 0 and float(np.abs(s.shaken.x).max()) < WILD
    if calm:
        shown += [ShownValue("x", s.shaken.x), ShownValue("u", s.shaken.u)]
    if len(outcome.poles["zeros of P_h"]):
        shown.append(ShownValue("np.roots(numerator)", outcome.poles["zeros of P_h"], poles=True))
    if built.placed is not None:
        shown += [ShownValue("E", built.placed.E), ShownValue("F", built.placed.F)]
    return Code(
        ("decoupling",),
        (
            GivenValue("A", plant.A, "the platform"),
            GivenValue("B", plant.B, "its coils"),
            GivenValue("C", plant.C),
            GivenValue("G", GROUND_MATRIX, "its ground"),
            GivenValue("B_nominal", coils(PLATFORM_PLANT).B, "of the platform without control, whose coil stands in the spring's line"),
            GivenValue("T_y", T_y[:3], "readings to vertical, rotation, horizontal"),
            GivenValue("T_u", T_u, "common, differential, horizontal to coils"),
            GivenValue("a", m["a"], "the mixing S = [1 b; a 1] between the last two"),
            GivenValue("b", m["b"]),
            GivenValue("band", (d["f_low"], d["f_high"]), "Hz, of J"),
            GivenValue("samples", INDEX_FREQUENCIES),
            *given,
            GivenValue("A_s", sensors.A, "from the true channels to what the sensors read"),
            GivenValue("B_s", sensors.B),
            GivenValue("C_s", sensors.C),
            GivenValue("D_s", np.asarray(sensors.D)),
            GivenValue("numerator", numerator, "of P_h on a rigid deck, highest power first"),
            GivenValue("denominator", denominator),
            GivenValue(
                "asked",
                np.real(np.poly([*d["control_poles"], *d["observer_poles"]])) if built.placed else np.zeros(0),
                "Phi, if C_h is placed by poles",
            ),
            GivenValue("falling", d["ground"] == FALLING, "the ground falls as 1/f^2, or is white"),
            GivenValue("sensor", d["noise"], "m/s/sqrt(Hz), of each sensor"),
            GivenValue("knee", knee_of(d), "Hz: its density rises as 1 + knee/f"),
            GivenValue("frequency", s.spectra.f, "Hz"),
            GivenValue("peaks", BAND_HZ, "Hz between which peaks are looked for"),
            GivenValue("slowest", AXIS_POLE_RAD_S, "1/s: poles nearer to zero are drift"),
            GivenValue("h", DT, "s"),
            GivenValue("count", len(s.shaken.t)),
            GivenValue("seed", int(d["seed"])),
            GivenValue("kick_at", round(d["kick"] / DT) if d["kick"] >= 0 else -1, "the grid point at which x jumps, -1: never"),
            GivenValue("kick", STATE_JUMP),
        ),
        tuple(shown),
        NOT_IN_SCRIPT + ("" if calm else ", and the run with control, which magnifies rounding"),
        (GivenValue("ground", s.shaken.ground),),
    )
