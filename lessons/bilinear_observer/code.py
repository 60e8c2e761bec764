"""Describe the eight design steps and the run of a bilinear functional observer as code."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Design, Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue
from observer_lab.engine.observers import BilinearObserver
from observer_lab.plants.bilinear import PRINTED_FORM, PRINTED_L, X0

from .input_signals import RANDOM_HOLDS, columns, form_index, noise_values, number_of, random_values
from .problems import AS_PRINTED, COMPUTED_GAIN, PAPER_PROBLEM, ROUNDED_GAIN, TYPED_GAIN
from .run_record import Setting
from .study import Study

NOT_IN_SCRIPT = (
    "A*, B* and pi: they depend on the elimination, the pole A* - B*pi does not. The settling time, "
    "the results of the doubtful printed lines, and the noise's share of the errors"
)
PRINTED_STEP_8 = np.concatenate([PRINTED_FORM.A.ravel(), PRINTED_FORM.Y.ravel(), PRINTED_FORM.B.ravel(), PRINTED_FORM.U.ravel(),
                                 PRINTED_FORM.G_y.ravel()])


def code(outcome: Outcome[Study]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, study = outcome.design, outcome.metrics, outcome.study
    o, run = study.observer, study.run
    gain = d["gain"] if d["problem"] == PAPER_PROBLEM else COMPUTED_GAIN
    taken = o.case == 3 and o.pi is None
    given = PRINTED_L if gain == AS_PRINTED else outcome.gains["L"] if taken else np.zeros((0, 0))
    size = max(1.0, float(np.abs(run.g).max()))
    errors = float(np.abs(run.errors).max())
    shown = (ShownValue("L", outcome.gains["L"]), ShownValue("pole", m["pole"]), ShownValue("case_of_L", m["case"]), ShownValue("x", run.x),
             ShownValue("u", columns(run.u)), ShownValue("g", run.g), ShownValue("errors", run.errors[:, :, 0], max(errors, size)),
             ShownValue("first_error", m["first_error"], size),
             ShownValue("late_error", m["late_error"], max(errors, size)), ShownValue("half_error", m["half_error"], max(errors, size)),
             ShownValue("late_g", m["late_g"]))
    return Code(
        ("bilinear", "bilinear_run"),
        (
            *_plant(o),
            GivenValue("asked", float(o.asked[0].real), "1/s, the pole asked for"),
            GivenValue("x0", np.array(X0)),
            GivenValue("chi0", np.array([d["chi0"]])),
            *_course(d, study.setting, d["noise"]),
            GivenValue("L_given", given, "L where it is taken from the paper, or from a family in which no choice moves the pole"),
            GivenValue("L4", d["l4"] if gain == TYPED_GAIN else float("nan"), "the entry of L typed, if it is"),
            GivenValue("printed_step", PRINTED_STEP_8 if gain == ROUNDED_GAIN else np.zeros(0), "step 8 in printed decimals, if it runs"),
        ),
        shown,
        NOT_IN_SCRIPT,
        drawn_of(d, study.setting),
    )


def _plant(o: BilinearObserver) -> tuple[GivenValue, ...]:
    return (
        GivenValue("A", o.plant.A, "dx/dt = A x + B u + u F x, y = C x"),
        GivenValue("B", o.plant.B),
        GivenValue("F", o.plant.F, "of several inputs F1, F2, ... side by side" if o.plant.inputs > 1 else ""),
        GivenValue("C", o.plant.C),
        GivenValue("K", o.K, "wanted: g = K x"),
    )


def _course(d: Design, s: Setting, noise: np.ndarray | float) -> tuple[GivenValue, ...]:
    """What the run goes by: sizes, noise, inputs, grid, kick."""
    hand = np.array(d["hand"]).reshape(-1, 2) if d["input"] == "hand" else np.zeros((0, 2))
    return (
        GivenValue("units", s.scale, "typical sizes of the states, in which the run is computed"),
        GivenValue("relative", s.own, "whether late_error and half_error are divided by the largest g"),
        GivenValue("noise", noise, "standard deviation of each sensor's noise"),
        GivenValue("tau", d["tau"], "s, of the differentiator"),
        GivenValue("kind", d["input"]),
        GivenValue("amplitude", d["amplitude"]),
        GivenValue("omega", d["omega"], "rad/s"),
        GivenValue("seed", int(d["seed"])),
        *_more(d, s.plant.inputs),
        GivenValue("hold", s.horizon / RANDOM_HOLDS, "s for which a random input is held"),
        GivenValue("drawn_at", hand[:, 0], "an input drawn by hand"),
        GivenValue("drawn", hand[:, 1]),
        GivenValue("horizon", s.horizon),
        GivenValue("h", s.dt),
        GivenValue("kick_at", int(d["kick"] / s.dt + 1e-9) if d["kick"] >= 0 else -1, "the grid point at which x jumps, -1: never"),
        GivenValue("kick", s.jump * s.scale),
        GivenValue("form", form_index(d), "which of the three errors the numbers are of"),
    )


def _more(d: Design, inputs: int) -> tuple[GivenValue, ...]:
    """What drives the inputs after the first."""
    numbers = range(2, inputs + 1)
    hands = [(j, *pair) for j in numbers if d[f"input{j}"] == "hand" for pair in d[f"hand{j}"]]
    return (GivenValue("more_kinds", " ".join(d[f"input{j}"] for j in numbers), "what drives the inputs after the first, if there are any"),
            GivenValue("more_amplitudes", np.array([d[f"amplitude{j}"] for j in numbers])),
            GivenValue("more_omegas", np.array([d[f"omega{j}"] for j in numbers])),
            GivenValue("more_seeds", np.array([d[f"seed{j}"] for j in numbers])),
            GivenValue("more_drawn", np.array(hands).reshape(-1, 3), "what a hand drew of them: which input, s, value"))


def drawn_of(d: Design, s: Setting) -> tuple[GivenValue, ...]:
    """What Python draws from the seed."""
    held, inputs = [GivenValue("values", random_values(d))] if d["input"] == "random" else [], s.plant.inputs
    if any(d[f"input{number_of(j)}"] == "random" for j in range(1, inputs)):
        held.append(GivenValue("more_values", np.column_stack([random_values(d, j) for j in range(1, inputs)])))
    if d["noise"]:
        held.append(GivenValue("draws", noise_values(d, round(s.horizon / s.dt) + 1, s.plant.m)))
    return tuple(held)


def own_code(outcome: Outcome[Study]) -> Code:
    """The same on a person's own plant: coordinates and L as the page chose them, everything else found again."""
    d, m, s, run = outcome.design, outcome.metrics, outcome.study.setting, outcome.study.run
    o, index = s.solved, form_index(d)
    size = max(float(np.abs(run.g).max()), float(np.abs(run.estimates[:, index]).max()))
    share = size / min(float(np.abs(g).max()) or 1.0 for g in run.g.T)
    return Code(
        ("bilinear_own", "bilinear_run"),
        (
            *_plant(o),
            GivenValue("T1", o.T[0], "x = T1 y + T2 mu + T3 eta, of many such coordinates the page's"),
            GivenValue("T2", o.T[1]),
            GivenValue("T3", o.T[2]),
            GivenValue("L", s.L, "of all that keep eta and u out, if any do, the page's with its poles"),
            GivenValue("x0", s.x0 * s.scale),
            *_course(d, s, s.deviations),
        ),
        (
            ShownValue("eigvals(A_w)", s.poles, poles=True),
            ShownValue("Y_chi", s.plain.Y),
            ShownValue("U_chi", s.plain.U, _natural(s.plain.U, s.plain.Y)),
            ShownValue("B_chi", s.plain.B, _natural(s.plain.B, s.plain.Y)),
            ShownValue("Gy_chi", s.plain.G_y),
            ShownValue("x", run.x),
            ShownValue("u", columns(run.u)),
            ShownValue("g", run.g),
            ShownValue("errors", run.errors.reshape(len(run.t), -1), max(float(np.abs(run.errors).max()), size)),
            *(ShownValue(name, m[name], max(m[name], share)) for name in ("late_error", "half_error")),
        ),
        "The eight steps in between, the settling time, and how much of the errors is noise",
        drawn_of(d, s),
    )


def _natural(M: np.ndarray, beside: np.ndarray) -> float:
    return max(float(np.abs(M).max()), 1e-3 * float(np.abs(beside).max()), 1e-300)
