"""Describe the filter on its record as code, on the deck or on an own plant."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue
from observer_lab.engine.systems import root

from .filters import ADC, SENSOR_SIGMA, SINE_HZ, START_SIGMAS, drawn_jumps, truth, tuned
from .knobs import CARRIED, DT, MODEL, SAMPLE_COUNT, WHITE
from .own_study import OwnStudy
from .study import Study

NOT_IN_SCRIPT = "Means over many records, and the two updates in poor arithmetic"


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design on the deck that its script starts from and finds again."""
    d, m, study, kf = outcome.design, outcome.metrics, outcome.study, tuned()
    real = truth(int(d["seed"]), d["noise"] != WHITE, d["force"], d["kick"])
    a, each = ADC.relaxations
    return Code(
        ("kalman_deck", "kalman"),
        (
            GivenValue("A", kf.A, "the deck at its samples: x[k+1] = A x + B u + w, y = C x + v"),
            GivenValue("B", kf.B),
            GivenValue("C", kf.C),
            GivenValue("Q", kf.Q, "true covariance of w"),
            GivenValue("R", kf.R, "true covariance of a white v"),
            GivenValue("h", DT, "s"),
            GivenValue("count", SAMPLE_COUNT),
            GivenValue("force", d["force"], "N"),
            GivenValue("frequency", SINE_HZ, "Hz"),
            GivenValue("start_spread", START_SIGMAS, "standard deviations of the start"),
            GivenValue("sigma", SENSOR_SIGMA, "m/s, white part of a reading"),
            GivenValue("white", d["noise"] == WHITE),
            GivenValue("carried", d["noise"] == CARRIED, "the filter carries the converter's noise as states"),
            GivenValue("relax", a, "factors of the relaxations whose sum is the converter's 1/f noise"),
            GivenValue("relax_variance", each),
            GivenValue("q", d["q"], "assumed / true Q"),
            GivenValue("r", d["r"], "assumed / true R"),
            GivenValue("p0", d["p0"]),
            GivenValue("kick_at", round(d["kick"] / DT) if d["kick"] >= 0 else -1, "the sample at which x jumps, -1: never"),
            GivenValue("kick", MODEL.kick),
            GivenValue("skip", study.watcher.first, "samples that no test looks at"),
            GivenValue("seed", int(d["seed"])),
        ),
        (
            ShownValue("x", real.x),
            ShownValue("y", real.y),
            ShownValue("means", study.track.means),
            *_common(outcome),
            *(
                ShownValue(name, m[name])
                for name in ("nees_low", "nees_high", "nis_low", "nis_high", "bias_p", "failures", "S_over_R", "seen_over_R")
            ),
        ),
        NOT_IN_SCRIPT,
        (
            GivenValue("x_start", real.x[0] - (MODEL.kick if d["kick"] >= 0 and round(d["kick"] / DT) == 0 else 0.0)),
            GivenValue("w", drawn_jumps(int(d["seed"]))),
            GivenValue("v", real.y - real.x @ kf.C.T),
        ),
        DT,
    )


def own_code(outcome: Outcome[OwnStudy]) -> Code:
    """The same on a person's own plant."""
    d, m, found = outcome.design, outcome.metrics, outcome.study.found
    s = found.run.scenario
    for_w, for_v = np.random.default_rng(int(d["seed"])).spawn(2)
    at = round(s.impulses[0][0] / s.dt) if s.impulses else -1
    return Code(
        ("kalman_own", "kalman"),
        (
            GivenValue("A", s.plant.A, "the plant at its samples: x[k+1] = A x + B u + w, y = C x + D u + v"),
            GivenValue("B", s.plant.B),
            GivenValue("C", s.plant.C),
            GivenValue("D", s.plant.D),
            GivenValue("Q", found.truth.Q, "true covariance of w"),
            GivenValue("R", found.truth.R, "true covariance of v"),
            GivenValue("h", s.dt, "s"),
            GivenValue("count", len(found.run.t)),
            GivenValue("whole", s.n_t, "samples for which noise is drawn"),
            GivenValue("K", s.K, "a gain that holds the sampled plant; any would do, this is the page's"),
            GivenValue("x_start", s.x0, "drawn from 4 times the settled covariance, by one of its many square roots"),
            GivenValue("q", d["q"], "assumed / true Q"),
            GivenValue("r", d["r"], "assumed / true R"),
            GivenValue("kick_at", at, "the sample at which x jumps, -1: never"),
            GivenValue("kick", s.impulses[0][1] if s.impulses else np.zeros(s.plant.n)),
            GivenValue("skip", outcome.study.watcher.first, "samples that no test looks at"),
            GivenValue("seed", int(d["seed"])),
        ),
        (
            ShownValue("x", found.run.x),
            ShownValue("y", found.run.y),
            ShownValue("u", found.run.u_applied),
            ShownValue("means", found.track.means),
            *_common(outcome),
            ShownValue("nis_expected", m["nis_expected"]),
        ),
        NOT_IN_SCRIPT,
        (
            GivenValue("w", for_w.standard_normal((s.n_t, s.plant.n)) @ root(found.truth.Q).T),
            GivenValue("v", for_v.standard_normal((s.n_t, s.plant.p)) @ root(found.truth.R).T),
        ),
        s.dt,
    )


def _common(outcome: Outcome[Study] | Outcome[OwnStudy]) -> tuple[ShownValue, ...]:
    study, m = outcome.study, outcome.metrics
    return (ShownValue("last_gain", outcome.gains["M"]), ShownValue("M_final", outcome.gains["M_riccati"]),
            ShownValue("eigvals(Af - Af @ M_final @ Cf)", np.exp(outcome.poles["filter"] * study.watcher.filter.dt), poles=True),
            ShownValue("innovations", study.track.innovations), ShownValue("nis", study.nis), ShownValue("nees", study.nees),
            ShownValue("nis_mean", m["nis_mean"]), ShownValue("nees_mean", m["nees_mean"]), ShownValue("white_p", m["white_p"], 1.0),
            ShownValue("gain_gap", m["gain_gap"], 1.0))
