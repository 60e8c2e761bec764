"""Describe the LQG loop as code: plant, weights, noise, factors, shown numbers."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue

from .knobs import RECURSIVE
from .loops import first_belief, setting_of
from .study import Study

SHOWN_METRICS = ("J", "J_known", "J_least", "J_open", "sensor_input", "sensor_share", "gain_low", "gain_high", "phase_deg", "delay", "disk",
         "nearest", "nearest_lqr")
MAX_RECOVERY_DECADES = 6.0  # decades of recovery beyond which rounding leaves no six digits to agree in
ROUNDED_METRICS = ("J", "sensor_input", "sensor_share", "gain_low", "gain_high", "phase_deg", "delay")  # beyond it


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    case, z = study.case, study.trace
    setting = setting_of(case, d)
    f, plant = setting.factors, case.plant
    fine = d["recovery"] <= MAX_RECOVERY_DECADES
    left_out = () if fine else ROUNDED_METRICS
    shown = [*(ShownValue(name, outcome.poles[of], poles=True) for name, of in (
                 ("eigvals(A - B @ K)", "regulator"), ("eigvals(A - L @ C)", "filter"), ("eigvals(loop)", "loop"))),
             *(ShownValue(name, m[name]) for name in SHOWN_METRICS if name in m and name not in left_out),
             ShownValue("x", z.x), ShownValue("xhat", z.xhat), ShownValue("u", z.u)]
    if study.density is not None and study.variance is not None and fine:
        shown += [ShownValue("density", study.density), ShownValue("variance", study.variance)]
        if study.suppression is not None:
            shown += [ShownValue("suppression", study.suppression, 1.0), ShownValue("low", study.low, 1.0)]
    return Code(
        ("lqg",),
        (
            GivenValue("A", plant.A),
            GivenValue("B", plant.B),
            GivenValue("C", plant.C),
            GivenValue("D", np.asarray(plant.D)),
            GivenValue("G", case.G, "the way of the disturbance w into x"),
            GivenValue("Q", f.alpha_q * case.Q, "weight of x"),
            GivenValue("R", f.alpha_r * case.R, "weight of u"),
            GivenValue("W", case.true_disturbance(f) * case.W, "true intensity of w"),
            GivenValue("V", f.sensor * case.V, "true intensity of v"),
            GivenValue("W_told", f.beta_q * case.W, "the W that the filter uses"),
            GivenValue("V_told", f.beta_r * case.V, "and of v"),
            GivenValue("K_page", outcome.gains["K"], "the gains of the page, which are computed again below"),
            GivenValue("L_page", outcome.gains["L"]),
            GivenValue("recovery", d["recovery"], "decades of fictitious noise on the inputs"),
            GivenValue("gain", d["gain"], "true gain of the inputs, times what the model says"),
            GivenValue("cut", min(int(dict(d.values).get("cut", "1")), plant.m) - 1, "the input at which the loop is cut for its margins"),
            GivenValue("watched", case.rows, "rows of the channels whose spectra are drawn"),
            GivenValue("frequency", case.frequency, "Hz"),
            GivenValue("band", case.band, "Hz in which peaks are looked for"),
            GivenValue("low_at", case.low),
            GivenValue("x_start", np.asarray(case.model.x0)),
            GivenValue("xhat_start", np.asarray(case.model.guess)),
            GivenValue("h", case.dt, "s"),
            GivenValue("count", len(z.t)),
            GivenValue("recursive", d["filter"] == RECURSIVE, "a computer's filter step by step, or the steady gain"),
            GivenValue("P_start", first_belief(case), "covariance with which the recursive filter begins"),
            GivenValue("kick_at", round(d["kick"] / case.dt) if d["kick"] >= 0 else -1, "the grid point at which x jumps, -1: never"),
            GivenValue("kick", np.asarray(case.model.kick)),
        ),
        tuple(shown),
        "Margins of all inputs at once, and what the lines of the report in doubt ask for"
        + ("" if fine else ", and spectra, variances and crossings of the loop, which rounding decides at so high a recovery"),
    )
