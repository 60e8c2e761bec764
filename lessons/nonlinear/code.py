"""A few runs of a nonlinear plant under three filters as code."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from app.engine.systems import root
from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Design, Outcome
from app.plants import cart_pendulum, falling_body, nonlinear_platform, platform

from .cases import FALL, LENGTH, PENDULUM, PLATFORM, SINE, case_of, starts
from .runs import FEW, FILTERS, Study

UNSAID = "The bound that no filter beats, and what the lines of the report in doubt lead to"
PARTS = MappingProxyType({PLATFORM: "nonlinear_deck", PENDULUM: "nonlinear_pole", FALL: "nonlinear_fall"})


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, s = outcome.design, outcome.metrics, outcome.study
    case = s.case
    at = round(d["kick"] / case.step) if d["kick"] >= 0 else -1
    kept = [name for name in FILTERS if not s.lost[name]]
    gone = [name.upper() for name in FILTERS if s.lost[name]]
    shown = [Shown("x", s.x), *((Shown("u", s.u),) if s.u.shape[1] else ()),
             *(Shown(f"{what}['{name}']", getattr(s, what)[name]) for name in kept for what in ("means", "sigmas", "nees", "nis", "rms")),
             *(Shown(f"len(lost['{name}'])", s.lost[name]) for name in FILTERS), Shown("len(fallen)", s.fallen)]
    if not gone:
        shown += [Shown(f"apart['{name}']", m[f"apart_{name}"], max(1.0, m[f"apart_{name}"])) for name in FILTERS[1:]]
    return Code((PARTS[case.id], "nonlinear"), (
        *_laws(d), Given("h", case.step, "s, between two samples"), Given("parts", case.parts, "steps of Runge and Kutta in it"),
        Given("count", len(s.t)), Given("runs", FEW), Given("Q", d["wind"] * case.Q, "covariance of w"),
        Given("R", d["sensor"]**2 * case.R, "covariance of v"), Given("start", case.guess, "what the filters begin with"),
        Given("P_start", np.diag((d["size"] * case.spread)**2)), Given("start_spread", d["size"] * case.spread, "of the true starts"),
        Given("steered_by", d["filter"] if case.id == PENDULUM or (case.id == PLATFORM and d["steer"]) else "",
              "the filter that u = -K xhat uses"),
        Given("u_max", case.u_max), Given("alpha", d["alpha"], "of the sigma points"), Given("beta", d["beta"]), Given("kappa", d["kappa"]),
        Given("redraw", bool(d["redraw"]), "sigma points are drawn anew for the measurement"),
        Given("kick_at", at if at < len(s.t) else -1, "the sample at which x jumps, -1: never"), Given("kick", case.kick),
        Given("watched", np.array([signal.weights for signal in case.watched]), "signals whose errors are averaged"),
        Given("seed", int(d["seed"])),
    ), tuple(shown), UNSAID + (f", and the {', '.join(gone)}, which loses runs where rounding decides" if gone else ""),
                _drawn(d, len(s.t)))


def _drawn(d: Design, count: int) -> tuple[Given, ...]:
    """True starts (n, runs), and the noise of each sample: of its p or n entries one after the other, all runs of each."""
    case, rng = case_of(d["case"]), np.random.default_rng([int(d["seed"]), 14])
    begun = starts(case, d["size"], FEW, rng)
    to_v, to_w = root(d["sensor"]**2 * case.R), root(d["wind"] * case.Q)
    noise = [(to_v @ rng.standard_normal((len(to_v), FEW)), to_w @ rng.standard_normal((len(to_w), FEW))) for _ in range(count)]
    return (Given("starts", begun, "true states, a run a column"), Given("noise_v", np.array([v.ravel() for v, _ in noise])),
            Given("noise_w", np.array([w.ravel() for _, w in noise])))


def _laws(d: Design) -> tuple[Given, ...]:
    """What the equations of the case are made of."""
    if d["case"] == FALL:
        k = falling_body.PARAMETERS
        return (Given("density", k.density, "1/m: how fast the air thins with height"), Given("side", k.side, "m, the radar beside"),
                Given("height", k.height, "m, and above"), Given("drag", falling_body.START[2], "1/m, true drag coefficient"))
    if d["case"] == PENDULUM:
        p = cart_pendulum.Parameters()
        return (Given("cart", p.cart, "kg"), Given("ball", p.ball, "kg"), Given("length", p.length, "m"),
                Given("friction", p.friction, "N s/m"), Given("pivot", p.pivot, "N m s"), Given("g", p.g, "m/s^2"))
    A, B, C, enter = nonlinear_platform.linear_parts(platform.Parameters())
    k = platform.Parameters()
    return (Given("A", A, "the deck at rest"), Given("B", B), Given("C", C), Given("enter", enter, "how spring forces enter the states"),
            Given("stiffness", (k.kz, k.kz, k.kx), "N/m, of the three springs"),
            Given("stretch", [[0, 1, -k.a, 0, 0, 0], [0, 1, k.a, 0, 0, 0], [1, 0, k.h, 0, 0, 0]], "of the springs, of x"),
            Given("gap", [[0, 1, -k.b, 0, 0, 0], [0, 1, k.b, 0, 0, 0], [1, 0, k.h, 0, 0, 0]], "of the coils"),
            Given("hardening", d["hardening"]), Given("weakening", d["weakening"]), Given("length", LENGTH, "m"),
            Given("force", d["force"], "N"), Given("frequency", SINE, "Hz"))
