"""The eight steps and the run of a bilinear functional observer as code."""

from __future__ import annotations

import numpy as np

from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Design, Outcome
from app.plants.bilinear import PRINTED_FORM, PRINTED_L, X0

from .drive import HELD, HORIZON, columns, form_index, noise_values, number_of, random_values
from .own_run import deviations
from .own_words import Story
from .problems import COMPUTED, PAPER, PRINTED, PROBLEMS, ROUNDED, TYPED
from .study import DT, KICK, Study

UNSAID = ("A*, B* and pi, which belong to one elimination among many and of which only the pole A* - B*pi counts, the settling time, "
          "what the lines of the print in doubt lead to, and how much of the errors is noise")
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
    shown = (Shown("L", outcome.gains["L"]), Shown("pole", m["pole"]), Shown("case_of_L", m["case"]), Shown("x", run.x),
             Shown("u", columns(run.u)), Shown("g", run.g[:, None]), Shown("errors", run.errors, max(errors, size)),
             Shown("first_error", m["first_error"], size),
             Shown("late_error", m["late_error"], max(errors, size)), Shown("half_error", m["half_error"], max(errors, size)),
             Shown("late_g", m["late_g"]))
    return Code(("bilinear", "bilinear_run"), (
        Given("A", problem.plant.A, "dx/dt = A x + B u + u F x, y = C x"), Given("B", problem.plant.B), Given("F", problem.plant.F),
        Given("C", problem.plant.C), Given("K", problem.K, "wanted: g = K x"),
        Given("asked", float(o.asked[0].real), "1/s, the pole asked for"), Given("x0", np.array(X0)), Given("chi0", np.array([d["chi0"]])),
        *_sizes(np.ones(problem.plant.n), False), Given("noise", d["noise"], "standard deviation of each sensor's noise"),
        Given("tau", d["tau"], "s, of the differentiator"), Given("kind", d["input"]), Given("amplitude", d["amplitude"]),
        Given("omega", d["omega"], "rad/s"), Given("seed", int(d["seed"])), *_more(d, 1),
        Given("hold", HORIZON / HELD, "s for which a random input is held"),
        Given("drawn_at", hand[:, 0], "an input drawn by hand"), Given("drawn", hand[:, 1]), Given("horizon", HORIZON), Given("h", DT),
        Given("kick_at", int(d["kick"] / DT + 1e-9) if d["kick"] >= 0 else -1, "the grid point at which x jumps, -1: never"),
        Given("kick", np.array(KICK)), Given("form", form_index(d), "which of the three errors the numbers are of"),
        Given("L_given", given, "L where it is taken from the paper, or from a family in which no choice moves the pole"),
        Given("L4", d["l4"] if gain == TYPED else float("nan"), "the entry of L typed, if it is"),
        Given("printed_step", PRINTED_STEP_8 if gain == ROUNDED else np.zeros(0), "step 8 in printed decimals, if it runs"),
    ), shown, UNSAID, drawn_of(d, round(HORIZON / DT) + 1, problem.plant.m))


def _sizes(units: np.ndarray, relative: bool) -> tuple[Given, Given]:
    return (Given("units", units, "typical sizes of the states, in which the run is computed"),
            Given("relative", relative, "whether late_error and half_error are told over the largest g"))


def _more(d: Design, inputs: int) -> tuple[Given, ...]:
    """What drives the inputs after the first."""
    numbers = range(2, inputs + 1)
    hands = [(j, *pair) for j in numbers if d[f"input{j}"] == "hand" for pair in d[f"hand{j}"]]
    return (Given("more_kinds", " ".join(d[f"input{j}"] for j in numbers), "what drives the inputs after the first, if there are any"),
            Given("more_amplitudes", np.array([d[f"amplitude{j}"] for j in numbers])),
            Given("more_omegas", np.array([d[f"omega{j}"] for j in numbers])),
            Given("more_seeds", np.array([d[f"seed{j}"] for j in numbers])),
            Given("more_drawn", np.array(hands).reshape(-1, 3), "what a hand drew of them: which input, s, value"))


def drawn_of(d: Design, count: int, outputs: int, inputs: int = 1) -> tuple[Given, ...]:
    """What Python draws from the seed."""
    held = [Given("values", random_values(d))] if d["input"] == "random" else []
    if any(d[f"input{number_of(j)}"] == "random" for j in range(1, inputs)):
        held.append(Given("more_values", np.column_stack([random_values(d, j) for j in range(1, inputs)])))
    return (*held, Given("draws", noise_values(d, count, outputs))) if d["noise"] else tuple(held)


def own_code(outcome: Outcome[Story]) -> Code:
    """The same on a person's own plant: coordinates and L as the page chose them, everything else found again."""
    d, m, s = outcome.design, outcome.metrics, outcome.study
    here, o, run = s.here, s.wanted.solved, s.run
    r, index, count = len(s.wanted.K), form_index(d), len(run.t)
    hand = np.array(d["hand"]).reshape(-1, 2) if d["input"] == "hand" else np.zeros((0, 2))
    size = max(float(np.abs(run.g).max()), float(np.abs(run.estimates[:, index]).max()))
    share = size / min(float(np.abs(g).max()) or 1.0 for g in run.g.T)
    return Code(("bilinear_own", "bilinear_run"), (
        Given("A", o.plant.A, "dx/dt = A x + B u + u F x, y = C x"), Given("B", o.plant.B),
        Given("F", o.plant.F, "of several inputs F1, F2, ... side by side" if o.plant.inputs > 1 else ""), Given("C", o.plant.C),
        Given("K", o.K, "wanted: g = K x"), Given("T1", o.T[0], "x = T1 y + T2 mu + T3 eta, of many such coordinates the page's"),
        Given("T2", o.T[1]), Given("T3", o.T[2]), Given("L", s.L, "of all that keep eta and u out, if any do, the page's with its poles"),
        Given("x0", np.array(here.model.x0)), *_sizes(here.scale, True),
        Given("noise", deviations(here, d), "standard deviation of each sensor's noise"),
        Given("tau", d["tau"], "s, of the differentiator"), Given("kind", d["input"]), Given("amplitude", d["amplitude"]),
        Given("omega", d["omega"], "rad/s"), Given("seed", int(d["seed"])), *_more(d, o.plant.inputs),
        Given("hold", here.horizon / HELD, "s for which a random input is held"),
        Given("drawn_at", hand[:, 0], "an input drawn by hand"), Given("drawn", hand[:, 1]), Given("horizon", here.horizon),
        Given("h", here.dt), Given("kick_at", int(d["kick"] / here.dt + 1e-9) if d["kick"] >= 0 else -1,
                                   "the grid point at which x jumps, -1: never"),
        Given("kick", np.array(here.model.kick)), Given("form", index, "which of the three errors the numbers are of"),
    ), (Shown("eigvals(A_w)", s.poles, poles=True), Shown("Y_chi", s.plain.Y), Shown("U_chi", s.plain.U, _natural(s.plain.U, s.plain.Y)),
        Shown("B_chi", s.plain.B, _natural(s.plain.B, s.plain.Y)), Shown("Gy_chi", s.plain.G_y), Shown("x", run.x),
        Shown("u", columns(run.u)), Shown("g", run.g),
        Shown("errors", run.errors.reshape(count, 3 * r), max(float(np.abs(run.errors).max()), size)),
        *(Shown(name, m[name], max(m[name], share)) for name in ("late_error", "half_error")),
    ), "The eight steps in between, the settling time, and how much of the errors is noise",
        drawn_of(d, round(here.horizon / here.dt) + 1, o.plant.m, o.plant.inputs))


def _natural(M: np.ndarray, beside: np.ndarray) -> float:
    return max(float(np.abs(M).max()), 1e-3 * float(np.abs(beside).max()), 1e-300)
