"""Describe the functional observer as code: plant, model error, poles."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Design, Outcome
from observer_lab.course.script_record import Code, GivenValue, ShownValue
from observer_lab.engine.observers import FunctionalObserver

from .knobs import EXAMPLE_FOUR, EXAMPLE_THREE
from .loop import S
from .own_plant import Here, lengths
from .study import DT, EXAMPLE_CASES, HORIZON, V_AMPLITUDE, V_RATE_RAD_S, Story, errors, start_of, turn, weighted

NOT_IN_SCRIPT = "Worst cases over the model errors, the error index, and what RLO finds"


def code(outcome: Outcome[Story]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, story = outcome.design, outcome.metrics, outcome.study
    case = EXAMPLE_CASES[d["example"]]
    example, o = case.example, story.observer
    return Code(
        ("robust_two_outputs" if d["example"] == EXAMPLE_FOUR else "robust_paper", "robust"),
        (
            *_plant(o, *errors(d)),
            GivenValue("A_1", example.wrong.A[0], "what may be wrong in A"),
            GivenValue("A_2", example.wrong.A[1]),
            GivenValue("C_1", example.wrong.C[0], "and in C"),
            *_weights(d, outcome.poles["observer"], weighted(d).alpha),
            *((_given_rows(o),) if d["example"] == EXAMPLE_FOUR else ()),
            GivenValue("W", turn(d), "coordinates of the observer"),
            GivenValue("M_open", d["example"] == EXAMPLE_THREE, "whether the conditions leave M open"),
            GivenValue("M_chosen", d["free"], "and what it is then"),
            GivenValue("x_start", np.array(example.x0)),
            GivenValue("z_start", start_of(d)),
            GivenValue("h", DT, "s"),
            GivenValue("count", round(HORIZON / DT) + 1),
            GivenValue("push", -V_AMPLITUDE, "v = push sin(turn t + pi/2)"),
            GivenValue("turn", V_RATE_RAD_S, "rad/s"),
        ),
        (
            *_found(outcome),
            ShownValue("x", story.true.x),
            ShownValue("z", story.true.z),
            ShownValue("u", story.true.u[:, 0]),
            ShownValue("e_u", story.true.e),
            *(ShownValue(name, m[name]) for name in ("error_start", "late_error")),
        ),
        NOT_IN_SCRIPT,
    )


def own_code(here: Here, outcome: Outcome[S]) -> Code:
    """The same on a person's own plant."""
    d, m, story = outcome.design, outcome.metrics, outcome.study
    o, true, drive = story.observer, story.true, story.true.loop.drive
    return Code(
        ("robust_own", "robust"),
        (
            *_plant(o, *here.errors(d)),
            GivenValue("D", np.asarray(o.plant.D)),
            GivenValue("K_all", here.rows(d)[0], "the controller's gain, of the many with its poles the page's"),
            _given_rows(o),
            GivenValue("M_open", False),
            GivenValue("M_chosen", 0.0),
            GivenValue("units", here.scaled.unit, "typical sizes of the states"),
            GivenValue("lengths", lengths(o.T * here.scaled.unit), "of the rows of T in them"),
            GivenValue("wanted_input", drive.fed, "whether an input is wanted, or a state"),
            GivenValue("j", drive.on, "the input that v is added to"),
            *_weights(d, outcome.poles["observer"], d["alpha"]),
            GivenValue("x_start", true.x[0]),
            GivenValue("h", float(true.t[-1]) / (len(true.t) - 1), "s"),
            GivenValue("count", len(true.t)),
            GivenValue("push", drive.amplitude, "v = push sin(turn t)"),
            GivenValue("turn", drive.rate, "rad/s"),
        ),
        (
            *_found(outcome),
            ShownValue("x", true.x),
            ShownValue("z", true.z),
            ShownValue("u", true.u),
            ShownValue("e_u", true.e),
            ShownValue("error_start", m["error_start"], max(abs(m["error_start"]), float(np.abs(true.wanted).max()))),
            ShownValue("late_error", m["late_error"], max(m["late_error"], 1e-3 * float(np.abs(true.e).max()))),
            ShownValue("late_wanted", m["late_wanted"]),
        ),
        NOT_IN_SCRIPT,
    )


def _plant(o: FunctionalObserver, dA: np.ndarray, dB: np.ndarray, dC: np.ndarray) -> tuple[GivenValue, ...]:
    return (
        GivenValue("A", o.plant.A, "the model"),
        GivenValue("B", o.plant.B),
        GivenValue("C", o.plant.C),
        GivenValue("dA", dA, "the true plant has A + dA"),
        GivenValue("dB", dB, "B + dB too"),
        GivenValue("dC", dC, "and C + dC"),
        GivenValue("K", o.K, "what is wanted: K x"),
    )


def _given_rows(o: FunctionalObserver) -> GivenValue:
    return GivenValue("L_free", np.linalg.solve(o.W, o.L),
                      "for each pole a direction may be chosen: the page's choice, in rows of real poles and of Re and Im of pairs")


def _weights(d: Design, poles: np.ndarray, alpha: np.ndarray | float) -> tuple[GivenValue, ...]:
    heads = np.asarray([p for p in poles if p.imag >= 0])
    return (
        GivenValue("pole_re", np.real(heads), "the observer's poles, of a pair the one with Im > 0"),
        GivenValue("pole_im", np.imag(heads)),
        GivenValue("alpha", alpha),
        GivenValue("beta", d["beta"]),
        GivenValue("gamma", d["gamma"]),
        GivenValue("norm", str(d["norm"])),
    )


def _found(outcome: Outcome[S]) -> tuple[ShownValue, ...]:
    gains = outcome.gains
    natural = float(np.abs(gains["K"]).max() / np.abs(gains["T"]).max())  # of N, which is zero where y says what is wanted
    direct = float(np.abs(gains["K"]).max() / np.abs(outcome.study.observer.plant.C).max())  # of M, which may be zero too
    return (*(ShownValue(name, gains[name]) for name in "FTL"), ShownValue("M", gains["M"], max(direct, float(np.abs(gains["M"]).max()))),
            ShownValue("N", gains["N"], max(natural, float(np.abs(gains["N"]).max()))),
            ShownValue("J", outcome.metrics["J"]),
            ShownValue("eigvals(F)", outcome.poles["observer"], poles=True), ShownValue("eigvals(loop)", outcome.poles["loop"], poles=True),
            ShownValue("slowest_loop", outcome.metrics["slowest_loop"], float(np.abs(outcome.poles["loop"]).max())))
