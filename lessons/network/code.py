"""Describe the loop over packets as code: plant, weights, noise, links, shown numbers."""

from __future__ import annotations

from observer_lab.course.lesson import Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue

from .cases import CASE_KINDS
from .study import TOLD_AHEAD, TOLD_COMMANDED, Study


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    s, scenario, run = study.watched.sampled, study.run.scenario, study.run
    return Code(
        ("network",),
        (
            GivenValue("A", s.plant.A, "the plant at its samples: x[k+1] = A x + B u + w, y = C x + v"),
            GivenValue("B", s.plant.B),
            GivenValue("C", s.plant.C),
            GivenValue("h", s.plant.dt, "s, sampling period"),
            GivenValue("Q", s.Q, "covariance of w over a sample"),
            GivenValue("R", study.watched.R, "covariance of v"),
            GivenValue("state_weight", s.state),
            GivenValue("input_weight", s.force),
            GivenValue("x0", CASE_KINDS[d["case"]].x0),
            GivenValue("steps", scenario.steps),
            GivenValue("jumps", scenario.jumps, "of x between samples, unknown to the observer"),
            GivenValue("loss", d["loss"], "share of the measurements that is lost"),
            GivenValue("loss_u", d["loss_u"], "share of the inputs"),
            GivenValue("jitter", int(d["jitter"]), "a measurement comes 0 ... jitter samples late"),
            GivenValue("delay", int(d["delay"]), "samples that every input comes late"),
            GivenValue("stamped", scenario.order == "stamped", "late measurements are put in their place, or taken for fresh"),
            GivenValue("held", scenario.on_loss == "hold", "for a lost input the last one is held, or zero applied"),
            GivenValue("told_asked", d["told"] == TOLD_COMMANDED, "the observer counts with the input asked for, or the one applied"),
            GivenValue("ahead", int(d["delay"]) if d["told"] == TOLD_AHEAD else 0, "samples that the controller predicts"),
            GivenValue("seed", int(d["seed"])),
        ),
        (
            ShownValue("K", outcome.gains["K"]),
            ShownValue("L", outcome.gains["L"]),
            ShownValue("M", outcome.gains["M"]),
            ShownValue("eigvals(A - B @ K)", outcome.poles["controller"], poles=True),
            ShownValue("eigvals(A - L @ C)", outcome.poles["observer"], poles=True),
            ShownValue("eigvals(loop)", outcome.poles["loop"], poles=True),
            ShownValue("x", run.x),
            ShownValue("xhat", run.xhat),
            ShownValue("u_asked", run.u_asked),
            ShownValue("u_applied", run.u_applied),
            ShownValue("y", run.y),
            ShownValue("lower", study.lower),
            ShownValue("upper", study.upper),
            ShownValue("peak", m["peak"]),
            ShownValue("critical", m["critical"]),
            ShownValue("radius", m["radius"]),
            ShownValue("growth", m["growth"]),
            ShownValue("loop_radius", m["loop_radius"]),
            ShownValue("separation_meter", m["separation_meter"], max(1.0, m["separation_meter"])),
            ShownValue("lost_measurements", m["lost_measurements"]),
            ShownValue("lost_inputs", m["lost_inputs"]),
        ),
        "Means over many runs, growth over all losses and the safe share of several sensors",
        (
            GivenValue("e0", run.draw.e0),
            GivenValue("w", run.draw.w),
            GivenValue("v", run.draw.v),
            GivenValue("sensed", run.draw.sensed, "samples of arrival"),
            GivenValue("acted", run.draw.acted),
        ),
        s.plant.dt,
    )
