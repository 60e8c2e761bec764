"""The loop over packets as code: the sampled plant, its weights and noise, the two links, and what the page shows."""

from __future__ import annotations

from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Outcome

from .cases import KINDS
from .study import AHEAD, ASKED, Study


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    s, scenario, run = study.watched.sampled, study.run.scenario, study.run
    return Code(("network",), (
        Given("A", s.plant.A, "the plant at its samples: x[k+1] = A x + B u + w, y = C x + v"), Given("B", s.plant.B),
        Given("C", s.plant.C), Given("h", s.plant.dt, "s, sampling period"),
        Given("Q", s.Q, "covariance of w over a sample"), Given("R", study.watched.R, "covariance of v"),
        Given("state_weight", s.state), Given("input_weight", s.force), Given("x0", KINDS[d["case"]].x0),
        Given("steps", scenario.steps), Given("jumps", scenario.jumps, "of x between samples, unknown to the observer"),
        Given("loss", d["loss"], "share of the measurements that is lost"), Given("loss_u", d["loss_u"], "share of the inputs"),
        Given("jitter", int(d["jitter"]), "a measurement comes 0 ... jitter samples late"),
        Given("delay", int(d["delay"]), "samples that every input comes late"),
        Given("stamped", scenario.order == "stamped", "late measurements are put in their place, or taken for fresh"),
        Given("held", scenario.on_loss == "hold", "for a lost input the last one is held, or zero applied"),
        Given("told_asked", d["told"] == ASKED, "the observer counts with the input asked for, or the one applied"),
        Given("ahead", int(d["delay"]) if d["told"] == AHEAD else 0, "samples that the controller predicts"),
        Given("seed", int(d["seed"])),
    ), (
        Shown("K", outcome.gains["K"]), Shown("L", outcome.gains["L"]), Shown("M", outcome.gains["M"]),
        Shown("eigvals(A - B @ K)", outcome.poles["controller"], poles=True),
        Shown("eigvals(A - L @ C)", outcome.poles["observer"], poles=True), Shown("eigvals(loop)", outcome.poles["loop"], poles=True),
        Shown("x", run.x), Shown("xhat", run.xhat), Shown("u_asked", run.u_asked), Shown("u_applied", run.u_applied), Shown("y", run.y),
        Shown("lower", study.lower), Shown("upper", study.upper), Shown("peak", m["peak"]), Shown("critical", m["critical"]),
        Shown("radius", m["radius"]), Shown("growth", m["growth"]), Shown("loop_radius", m["loop_radius"]),
        Shown("separation_meter", m["separation_meter"], max(1.0, m["separation_meter"])),
        Shown("lost_measurements", m["lost_measurements"]), Shown("lost_inputs", m["lost_inputs"]),
    ), "Means over many runs, growth over all losses and the safe share of several sensors", (
        Given("e0", run.draw.e0), Given("w", run.draw.w), Given("v", run.draw.v), Given("sensed", run.draw.sensed, "samples of arrival"),
        Given("acted", run.draw.acted)), s.plant.dt)
