"""Define the knobs of lesson 19: gains, limit, noise, tolerance, in the plant's measures."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Knob, Number, Switch
from observer_lab.plants import Model
from observer_lab.text import text

from ..toolkit.knobs import method_knobs, pole_knobs, pull_knobs, run_knobs

COMMANDED, APPLIED = "commanded", "applied"


def knobs(model: Model) -> tuple[Knob, ...]:
    """Gains, limit, noise and tolerance, in the plant's own measures."""
    return (
        *method_knobs(),
        *pole_knobs(model),
        Switch("limited", "", text("limit the inputs"),
               hint=text("Clip every input at the limit below.")),
        Number("u_max", r"u_{\max}", text("limit"), model.input_unit, low=0.02 * model.u_max, high=20 * model.u_max,
               default=model.u_max, scale="log", when=("limited", (True,)),
               hint=text("The largest input that is given, either way.")),
        Choice("fed", "", text("input of the observer"), default=COMMANDED,
               options=((COMMANDED, text("the commanded input")), (APPLIED, text(
                   "the applied input"))),
               when=("limited", (True,)),
               hint=text("The commanded input, or the applied input.")),
        Switch("noisy", "", text("noise in the run"), hint=text(
            "Draw both noises in the run that is shown.")),
        Number("sensor", r"\sigma", text("sensor noise, share of the outputs"), low=1e-3,
               high=1.0, default=0.01, scale="log",
               hint=text("Beside a process noise of a tenth of the natural input.")),
        Number("belief", r"b", text("assumed / true process noise"),
               low=1e-3, high=1e3, default=1.0, scale="log",
               hint=text("The process noise that the Kalman filter of the tab Noise assumes; below 1 it trusts its model too much.")),
        Number("tolerance", r"\tau", text("tolerance of the rank"), low=1e-16, high=1.0, default=1e-12, scale="log",
               hint=text("Singular values at or below τ times the largest count as zero.")),
        Switch("columns", "", text("singular values on the stage"),
               hint=text("Those of the observability matrix as columns in place of the tubes, with the tolerance as a plate.")),
        *run_knobs(model.horizon),
        *pull_knobs(model),
    )
