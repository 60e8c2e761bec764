"""The optimal loop as code: plant, weights and noise of a case with their factors, and what the page shows of the loop."""

from __future__ import annotations

import numpy as np

from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Outcome

from .knobs import RECURSIVE
from .loops import first_belief, setting_of
from .study import Study

FOUND = ("J", "J_known", "J_least", "J_open", "sensor_input", "sensor_share", "gain_low", "gain_high", "phase_deg", "delay", "disk",
         "nearest", "nearest_lqr")
MOST = 6.0  # decades of recovery beyond which the loop's Lyapunov equation leaves no six digits to agree in
NOISY = ("J", "sensor_input", "sensor_share")


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    case, z = study.case, study.trace
    setting = setting_of(case, d)
    f, plant = setting.factors, case.plant
    fine = d["recovery"] <= MOST
    left_out = () if fine else NOISY
    shown = [*(Shown(name, outcome.poles[of], poles=True) for name, of in (
                 ("eigvals(A - B @ K)", "regulator"), ("eigvals(A - L @ C)", "filter"), ("eigvals(loop)", "loop"))),
             *(Shown(name, m[name]) for name in FOUND if name in m and name not in left_out),
             Shown("x", z.x), Shown("xhat", z.xhat), Shown("u", z.u)]
    if study.density is not None and study.variance is not None and fine:
        shown += [Shown("density", study.density), Shown("variance", study.variance)]
        if study.suppression is not None:
            shown += [Shown("suppression", study.suppression, 1.0), Shown("low", study.low, 1.0)]
    return Code(("lqg",), (
        Given("A", plant.A), Given("B", plant.B), Given("C", plant.C), Given("D", np.asarray(plant.D)),
        Given("G", case.G, "the way of the disturbance w into x"),
        Given("Q", f.alpha_q * case.Q, "weight of x"), Given("R", f.alpha_r * case.R, "weight of u"),
        Given("W", case.true_disturbance(f) * case.W, "true intensity of w"), Given("V", f.sensor * case.V, "true intensity of v"),
        Given("W_told", f.beta_q * case.W, "what the filter is told of w"), Given("V_told", f.beta_r * case.V, "and of v"),
        Given("K_page", outcome.gains["K"], "the gains of the page, which are computed again below"), Given("L_page", outcome.gains["L"]),
        Given("recovery", d["recovery"], "decades of fictitious noise on the inputs"),
        Given("gain", d["gain"], "true gain of the inputs, times what the model says"),
        Given("cut", min(int(dict(d.values).get("cut", "1")), plant.m) - 1, "the input at which the loop is cut for its margins"),
        Given("watched", case.rows, "rows of the channels whose spectra are drawn"),
        Given("frequency", case.frequency, "Hz"), Given("band", case.band, "Hz in which peaks are looked for"), Given("low_at", case.low),
        Given("x_start", np.asarray(case.model.x0)), Given("xhat_start", np.asarray(case.model.guess)), Given("h", case.dt, "s"),
        Given("count", len(z.t)), Given("recursive", d["filter"] == RECURSIVE, "a computer's filter step by step, or the steady gain"),
        Given("P_start", first_belief(case), "covariance with which the recursive filter begins"),
        Given("kick_at", round(d["kick"] / case.dt) if d["kick"] >= 0 else -1, "the grid point at which x jumps, -1: never"),
        Given("kick", np.asarray(case.model.kick)),
    ), tuple(shown), "Margins of all inputs at once, and what the lines of the report in doubt ask for" + (
        "" if fine else ", and spectra and variances of the loop, which rounding decides at so high a recovery"))
