"""Describe a few runs of a nonlinear plant under three filters as code."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.lesson import Design, Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue
from observer_lab.engine.systems import root
from observer_lab.plants import cart_pendulum
from observer_lab.plants.bodies import falling_body
from observer_lab.plants.platform import model, nonlinear

from .cases import FALL_CASE, LENGTH, PENDULUM_CASE, PLATFORM, SINE_HZ, case_of, starts
from .runs import DRAFT_RUNS, FILTERS, Study

NOT_IN_SCRIPT = "The bound that no filter beats, and what the lines of the report in doubt lead to"
CODE_TEMPLATES = MappingProxyType({PLATFORM: "nonlinear_deck", PENDULUM_CASE: "nonlinear_pole", FALL_CASE: "nonlinear_fall"})


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, s = outcome.design, outcome.metrics, outcome.study
    case = s.case
    at = round(d["kick"] / case.step) if d["kick"] >= 0 else -1
    kept = [name for name in FILTERS if not s.lost[name]]
    gone = [name.upper() for name in FILTERS if s.lost[name]]
    shown = [
        ShownValue("x", s.x),
        *((ShownValue("u", s.u),) if s.u.shape[1] else ()),
        *(ShownValue(f"{what}['{name}']", getattr(s, what)[name]) for name in kept for what in ("means", "sigmas", "nees", "nis", "rms")),
        *(ShownValue(f"len(lost['{name}'])", s.lost[name]) for name in FILTERS),
        ShownValue("len(fallen)", s.fallen),
    ]
    if not gone:
        shown += [ShownValue(f"apart['{name}']", m[f"apart_{name}"], max(1.0, m[f"apart_{name}"])) for name in FILTERS[1:]]
    return Code(
        (CODE_TEMPLATES[case.id], "nonlinear"),
        (
            *_laws(d),
            GivenValue("h", case.step, "s, between two samples"),
            GivenValue("parts", case.parts, "steps of Runge and Kutta in it"),
            GivenValue("count", len(s.t)),
            GivenValue("runs", DRAFT_RUNS),
            GivenValue("Q", d["wind"] * case.Q, "covariance of w"),
            GivenValue("R", d["sensor"] ** 2 * case.R, "covariance of v"),
            GivenValue("start", case.guess, "what the filters begin with"),
            GivenValue("P_start", np.diag((d["size"] * case.spread) ** 2)),
            GivenValue("start_spread", d["size"] * case.spread, "of the true starts"),
            GivenValue(
                "steered_by",
                d["filter"] if case.id == PENDULUM_CASE or (case.id == PLATFORM and d["steer"]) else "",
                "the filter that u = -K xhat uses",
            ),
            GivenValue("u_max", case.u_max),
            GivenValue("alpha", d["alpha"], "of the sigma points"),
            GivenValue("beta", d["beta"]),
            GivenValue("kappa", d["kappa"]),
            GivenValue("redraw", bool(d["redraw"]), "sigma points are drawn again for the measurement"),
            GivenValue("kick_at", at if at < len(s.t) else -1, "the sample at which x jumps, -1: never"),
            GivenValue("kick", case.kick),
            GivenValue("watched", np.array([signal.weights for signal in case.watched]), "signals whose errors are averaged"),
            GivenValue("seed", int(d["seed"])),
        ),
        tuple(shown),
        NOT_IN_SCRIPT + (f", and the {', '.join(gone)}, which loses runs where rounding decides" if gone else ""),
        _drawn(d, len(s.t)),
    )


def _drawn(d: Design, count: int) -> tuple[GivenValue, ...]:
    """True starts (n, runs), and the noise of each sample: of its p or n entries one after the other, all runs of each."""
    case, rng = case_of(d["case"]), np.random.default_rng([int(d["seed"]), 14])
    begun = starts(case, d["size"], DRAFT_RUNS, rng)
    to_v, to_w = root(d["sensor"]**2 * case.R), root(d["wind"] * case.Q)
    noise = [
        (to_v @ rng.standard_normal((len(to_v), DRAFT_RUNS)), to_w @ rng.standard_normal((len(to_w), DRAFT_RUNS))) for _ in range(count)
    ]
    return (GivenValue("starts", begun, "true states, a run a column"), GivenValue("noise_v", np.array([v.ravel() for v, _ in noise])),
            GivenValue("noise_w", np.array([w.ravel() for _, w in noise])))


def _laws(d: Design) -> tuple[GivenValue, ...]:
    """What the equations of the case are made of."""
    if d["case"] == FALL_CASE:
        k = falling_body.PARAMETERS
        return (
            GivenValue("density", k.density, "1/m: how fast the air thins with height"),
            GivenValue("side", k.side, "m, the radar beside"),
            GivenValue("height", k.height, "m, and above"),
            GivenValue("drag", falling_body.TRUE_START[2], "1/m, true drag coefficient"),
        )
    if d["case"] == PENDULUM_CASE:
        p = cart_pendulum.Parameters()
        return (GivenValue("cart", p.cart, "kg"), GivenValue("ball", p.ball, "kg"), GivenValue("length", p.length, "m"),
                GivenValue("friction", p.friction, "N s/m"), GivenValue("pivot", p.pivot, "N m s"), GivenValue("g", p.g, "m/s^2"))
    A, B, C, enter = nonlinear.linear_parts(model.Parameters())
    k = model.Parameters()
    return (
        GivenValue("A", A, "the deck at rest"),
        GivenValue("B", B),
        GivenValue("C", C),
        GivenValue("enter", enter, "how spring forces enter the states"),
        GivenValue("stiffness", (k.kz, k.kz, k.kx), "N/m, of the three springs"),
        GivenValue("stretch", [[0, 1, -k.a, 0, 0, 0], [0, 1, k.a, 0, 0, 0], [1, 0, k.h, 0, 0, 0]], "of the springs, of x"),
        GivenValue("gap", [[0, 1, -k.b, 0, 0, 0], [0, 1, k.b, 0, 0, 0], [1, 0, k.h, 0, 0, 0]], "of the coils"),
        GivenValue("hardening", d["hardening"]),
        GivenValue("weakening", d["weakening"]),
        GivenValue("length", LENGTH, "m"),
        GivenValue("force", d["force"], "N"),
        GivenValue("frequency", SINE_HZ, "Hz"),
    )
