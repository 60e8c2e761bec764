"""The filter on its record as code: the sampled plant and what the filter believes, on the deck or on a person's own plant."""

from __future__ import annotations

import numpy as np

from app.engine.systems import root
from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Outcome

from .filters import ADC, SIGMA, SINE, SPREAD, drawn_jumps, truth, tuned
from .knobs import CARRIED, COUNT, DT, MODEL, WHITE
from .own_study import SKIP as OWN_SKIP
from .own_study import Study as OwnStudy
from .study import SKIP, Study

UNSAID = "Means over many records, and the two updates in poor arithmetic"


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design on the deck that its script starts from and finds again."""
    d, m, study, kf = outcome.design, outcome.metrics, outcome.study, tuned()
    real = truth(int(d["seed"]), d["noise"] != WHITE, d["force"], d["kick"])
    a, each = ADC.relaxations
    return Code(("kalman_deck", "kalman"), (
        Given("A", kf.A, "the deck at its samples: x[k+1] = A x + B u + w, y = C x + v"), Given("B", kf.B), Given("C", kf.C),
        Given("Q", kf.Q, "true covariance of w"), Given("R", kf.R, "true covariance of a white v"), Given("h", DT, "s"),
        Given("count", COUNT), Given("force", d["force"], "N"), Given("frequency", SINE, "Hz"),
        Given("start_spread", SPREAD, "standard deviations of the start"), Given("sigma", SIGMA, "m/s, white part of a reading"),
        Given("white", d["noise"] == WHITE), Given("carried", d["noise"] == CARRIED, "the filter carries the converter's noise as states"),
        Given("relax", a, "factors of the relaxations whose sum is the converter's 1/f noise"), Given("relax_variance", each),
        Given("q", d["q"], "believed / true Q"), Given("r", d["r"], "believed / true R"), Given("p0", d["p0"]),
        Given("kick_at", round(d["kick"] / DT) if d["kick"] >= 0 else -1, "the sample at which x jumps, -1: never"),
        Given("kick", MODEL.kick), Given("skip", SKIP, "samples that no test looks at"), Given("seed", int(d["seed"])),
    ), (
        Shown("x", real.x), Shown("y", real.y), Shown("means", study.track.means), *_common(outcome),
        *(Shown(name, m[name]) for name in (
            "nees_low", "nees_high", "nis_low", "nis_high", "bias_p", "failures", "S_over_R", "seen_over_R")),
    ), UNSAID, (Given("x_start", real.x[0] - (MODEL.kick if d["kick"] >= 0 and round(d["kick"] / DT) == 0 else 0.0)),
                Given("w", drawn_jumps(int(d["seed"]))), Given("v", real.y - real.x @ kf.C.T)), DT)


def own_code(outcome: Outcome[OwnStudy]) -> Code:
    """The same on a person's own plant."""
    d, m, found = outcome.design, outcome.metrics, outcome.study.found
    s = found.run.scenario
    for_w, for_v = np.random.default_rng(int(d["seed"])).spawn(2)
    at = round(s.impulses[0][0] / s.dt) if s.impulses else -1
    return Code(("kalman_own", "kalman"), (
        Given("A", s.plant.A, "the plant at its samples: x[k+1] = A x + B u + w, y = C x + D u + v"), Given("B", s.plant.B),
        Given("C", s.plant.C), Given("D", s.plant.D), Given("Q", found.truth.Q, "true covariance of w"),
        Given("R", found.truth.R, "true covariance of v"), Given("h", s.dt, "s"), Given("count", len(found.run.t)),
        Given("whole", s.n_t, "samples for which noise is drawn"),
        Given("K", s.K, "a gain that holds the sampled plant; any would do, this is the page's"),
        Given("x_start", s.x0, "drawn from 4 times the settled covariance, by one of its many square roots"),
        Given("q", d["q"], "believed / true Q"), Given("r", d["r"], "believed / true R"),
        Given("kick_at", at, "the sample at which x jumps, -1: never"),
        Given("kick", s.impulses[0][1] if s.impulses else np.zeros(s.plant.n)),
        Given("skip", OWN_SKIP, "samples that no test looks at"), Given("seed", int(d["seed"])),
    ), (
        Shown("x", found.run.x), Shown("y", found.run.y), Shown("u", found.run.u_applied), Shown("means", found.track.means),
        *_common(outcome), Shown("nis_expected", m["nis_expected"]),
    ), UNSAID, (Given("w", for_w.standard_normal((s.n_t, s.plant.n)) @ root(found.truth.Q).T),
                Given("v", for_v.standard_normal((s.n_t, s.plant.p)) @ root(found.truth.R).T)), s.dt)


def _common(outcome: Outcome[Study] | Outcome[OwnStudy]) -> tuple[Shown, ...]:
    study, m = outcome.study, outcome.metrics
    track = study.found.track if isinstance(study, OwnStudy) else study.track
    h = study.found.run.scenario.dt if isinstance(study, OwnStudy) else DT
    return (Shown("last_gain", outcome.gains["M"]), Shown("M_final", outcome.gains["M_riccati"]),
            Shown("eigvals(Af - Af @ M_final @ Cf)", np.exp(outcome.poles["filter"] * h), poles=True),
            Shown("innovations", track.innovations), Shown("nis", study.nis), Shown("nees", study.nees),
            Shown("nis_mean", m["nis_mean"]), Shown("nees_mean", m["nees_mean"]), Shown("white_p", m["white_p"], 1.0),
            Shown("gain_gap", m["gain_gap"], 1.0))
