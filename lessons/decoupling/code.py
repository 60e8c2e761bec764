"""Three channels, a mixing, their loop and its run as code."""

from __future__ import annotations

import numpy as np

from app.engine import Plant
from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Outcome
from app.plants import platform
from app.plants import platform_siso as siso
from app.plants.platform_channels import HORIZONTAL, T_u, T_y
from app.plants.platform_lqg import coils

from .loops import BAND, DT, FALLING, GROUND, KICK, PLATFORM, SAMPLES, SLOWEST, lower_of, platform_of
from .study import Study

UNSAID = "The least J by search, the rightmost pole with pitch open, and the residual of the placement"
WILD = 0.1  # m or m/s: a run on this quiet ground that gets there magnifies rounding as much
METRICS = ("vertical", "rotation", "horizontal")
NOTHING = Plant(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.zeros((1, 1)))


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, s = outcome.design, outcome.metrics, outcome.study
    lower = lower_of(d)
    plant, built = coils(platform_of(lower)), s.controllers
    given: list[Given] = []
    for name, controller in (("v", built.vertical), ("t", built.rotation), ("h", built.horizontal)):
        c = NOTHING if controller is None else controller
        given += [Given(f"A_{name}", c.A, {"v": "C_v, the vertical controller (a loop that is open has none)", "t": "C_theta, of pitch",
                                           "h": "C_h, the horizontal one"}[name]),
                  Given(f"B_{name}", c.B), Given(f"C_{name}", c.C), Given(f"D_{name}", np.asarray(c.D))]
    numerator, denominator = siso.rigid_polynomials(HORIZONTAL, s.mixed.S, platform.Parameters(lower=lower))
    shown = [Shown("S", outcome.gains["S"]), Shown("eigvals(loop)", outcome.poles["loop"], poles=True), Shown("J", m["J"]),
             Shown("J_plain", m["J_plain"]), Shown("rightmost", m["rightmost"], max(1e-3, abs(m["rightmost"]))),
             Shown("bare", s.spectra.bare), Shown("density", s.spectra.closed), Shown("forces", s.spectra.forces),
             Shown("suppression", [m[name] for name in METRICS], 1.0), Shown("ground", s.shaken.ground), Shown("x_bare", s.shaken.bare)]
    calm = m["rightmost"] < 0 and float(np.abs(s.shaken.x).max()) < WILD
    if calm:
        shown += [Shown("x", s.shaken.x), Shown("u", s.shaken.u)]
    if len(outcome.poles["zeros of P_h"]):
        shown.append(Shown("np.roots(numerator)", outcome.poles["zeros of P_h"], poles=True))
    if built.placed is not None:
        shown += [Shown("E", built.placed.E), Shown("F", built.placed.F)]
    return Code(("decoupling",), (
        Given("A", plant.A, "the platform"), Given("B", plant.B, "its coils"), Given("C", plant.C), Given("G", GROUND, "its ground"),
        Given("B_nominal", coils(PLATFORM).B, "of the platform without control, whose coil stands in the spring's line"),
        Given("T_y", T_y[:3], "readings to vertical, rotation, horizontal"), Given("T_u", T_u, "common, differential, horizontal to coils"),
        Given("a", m["a"], "the mixing S = [1 b; a 1] between the last two"), Given("b", m["b"]),
        Given("band", (d["f_low"], d["f_high"]), "Hz, of J"), Given("samples", SAMPLES), *given,
        Given("numerator", numerator, "of P_h on a rigid deck, highest power first"), Given("denominator", denominator),
        Given("asked", np.real(np.poly([*d["control_poles"], *d["observer_poles"]])) if built.placed else np.zeros(0),
              "Phi, if C_h is placed by poles"),
        Given("falling", d["ground"] == FALLING, "the ground falls as 1/f^2, or is white"),
        Given("sensor", d["noise"], "m/s/sqrt(Hz), of each sensor"), Given("frequency", s.spectra.f, "Hz"),
        Given("peaks", BAND, "Hz between which peaks are looked for"), Given("slowest", SLOWEST, "1/s: poles nearer to zero are drift"),
        Given("h", DT, "s"), Given("count", len(s.shaken.t)), Given("seed", int(d["seed"])),
        Given("kick_at", round(d["kick"] / DT) if d["kick"] >= 0 else -1, "the grid point at which x jumps, -1: never"),
        Given("kick", KICK)), tuple(shown), UNSAID + ("" if calm else ", and the run with control, which magnifies rounding"),
                (Given("ground", s.shaken.ground),))
