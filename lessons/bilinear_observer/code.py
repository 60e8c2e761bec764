"""The eight steps and the run of a bilinear functional observer as code."""

from __future__ import annotations

import numpy as np

from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Outcome
from app.plants.bilinear import PRINTED_FORM, PRINTED_L, X0

from .problems import COMPUTED, PAPER, PRINTED, PROBLEMS, ROUNDED, TYPED
from .study import DT, HOLD, HORIZON, KICK, Study, form_index, random_values

UNSAID = ("A*, B* and pi, which belong to one elimination among many and of which only the pole A* - B*pi counts, the settling time, "
          "and what the lines of the print in doubt lead to")
PRINTED_STEP_8 = np.concatenate([PRINTED_FORM.A.ravel(), PRINTED_FORM.Y.ravel(), PRINTED_FORM.B.ravel(), PRINTED_FORM.U.ravel(),
                                 PRINTED_FORM.G_y.ravel()])


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    problem, o, run = PROBLEMS[d["problem"]], study.observer, study.run
    paper = problem.id == PAPER
    gain = d["gain"] if paper else COMPUTED
    taken = o.case == 3 and o.pi is None
    given = PRINTED_L if gain == PRINTED else outcome.gains["L"] if taken else np.zeros((0, 0))
    hand = np.array(d["hand"]).reshape(-1, 2) if d["input"] == "hand" else np.zeros((0, 2))
    size = max(1.0, float(np.abs(run.g).max()))
    errors = float(np.abs(run.errors).max())
    shown = (Shown("L", outcome.gains["L"]), Shown("pole", m["pole"]), Shown("case_of_L", m["case"]), Shown("x", run.x), Shown("u", run.u),
             Shown("g", run.g), Shown("errors", run.errors, max(errors, size)), Shown("first_error", m["first_error"], size),
             Shown("late_error", m["late_error"], max(errors, size)), Shown("half_error", m["half_error"], max(errors, size)),
             Shown("late_g", m["late_g"]))
    return Code(("bilinear",), (
        Given("A", problem.plant.A, "dx/dt = A x + B u + u F x, y = C x"), Given("B", problem.plant.B), Given("F", problem.plant.F),
        Given("C", problem.plant.C), Given("K", problem.K, "wanted: g = K x"),
        Given("asked", float(o.asked[0].real), "1/s, the pole asked for"), Given("x0", np.array(X0)), Given("chi0", d["chi0"]),
        Given("tau", d["tau"], "s, of the differentiator"), Given("kind", d["input"]), Given("amplitude", d["amplitude"]),
        Given("omega", d["omega"], "rad/s"), Given("seed", int(d["seed"])), Given("hold", HOLD, "s for which a random input is held"),
        Given("drawn_at", hand[:, 0], "an input drawn by hand"), Given("drawn", hand[:, 1]), Given("horizon", HORIZON), Given("h", DT),
        Given("kick_at", int(d["kick"] / DT + 1e-9) if d["kick"] >= 0 else -1, "the grid point at which x jumps, -1: never"),
        Given("kick", np.array(KICK)), Given("form", form_index(d), "which of the three errors the numbers are of"),
        Given("L_given", given, "L where it is taken from the paper, or from a family in which no choice moves the pole"),
        Given("L4", d["l4"] if gain == TYPED else float("nan"), "the entry of L typed, if it is"),
        Given("printed_step", PRINTED_STEP_8 if gain == ROUNDED else np.zeros(0), "step 8 in printed decimals, if it runs"),
    ), shown, UNSAID, (Given("values", random_values(d)),) if d["input"] == "random" else ())
