"""The observer of a combination of states as code: plant, model error and poles, for the paper's examples and for own plants."""

from __future__ import annotations

import numpy as np

from app.engine.observers import FunctionalObserver
from app.lesson.code import Code, Given, Shown
from app.lesson.lesson import Design, Outcome

from .knobs import THREE
from .own_loop import WAVES, lengths
from .own_loop import Story as OwnStory
from .own_plant import Scaled
from .study import CASES, DT, HORIZON, PUSH, TURN, Story, errors, input_error, start_of, turn, weighted

UNSAID = "Worst cases over the model errors, the error index, and what RLO finds"


def code(outcome: Outcome[Story]) -> Code:
    """The records of a design that its script starts from and finds again."""
    d, m, story = outcome.design, outcome.metrics, outcome.study
    case = CASES[d["example"]]
    example, o, (dA, dC) = case.example, story.observer, errors(d)
    return Code(("robust_paper", "robust"), (
        *_plant(o, dA, input_error(d), dC), Given("A_1", example.wrong.A[0], "what may be wrong in A"), Given("A_2", example.wrong.A[1]),
        Given("C_1", example.wrong.C[0], "and in C"), *_weights(d, outcome.poles["observer"], weighted(d).alpha),
        Given("W", turn(d), "coordinates of the observer"),
        Given("M_open", d["example"] == THREE, "whether the conditions leave M open"), Given("M_chosen", d["free"], "and what it is then"),
        Given("x_start", np.array(example.x0)), Given("z_start", start_of(d)), Given("h", DT, "s"),
        Given("count", round(HORIZON / DT) + 1), Given("push", -PUSH, "v = push sin(turn t + pi/2)"), Given("turn", TURN, "rad/s"),
    ), (*_found(outcome), Shown("x", story.true.x), Shown("z", story.true.z), Shown("u", story.true.u[:, 0]),
        Shown("e_u", story.true.e_u[:, 0]), *(Shown(name, m[name]) for name in ("error_start", "late_error"))), UNSAID)


def own_code(units: Scaled, outcome: Outcome[OwnStory], K: np.ndarray, dA: np.ndarray, dC: np.ndarray) -> Code:
    """The same on a person's own plant; K is the whole controller."""
    d, m, story = outcome.design, outcome.metrics, outcome.study
    o, true = story.observer, story.true
    horizon = float(true.t[-1])
    return Code(("robust_own", "robust"), (
        *_plant(o, dA, 0 * o.plant.B, dC), Given("D", np.asarray(o.plant.D)),
        Given("K_all", K, "the controller's gain, of the many with its poles the page's"),
        Given("L_free", np.linalg.solve(o.W, o.L), "for each pole a direction may be chosen: the page's choice, in rows of real poles and "
                                                   "of Re and Im of pairs"),
        Given("M_open", False), Given("M_chosen", 0.0), Given("units", units.unit, "typical sizes of the states"),
        Given("lengths", lengths(o.T * units.unit), "of the rows of T in them"),
        Given("wanted_input", story.fed, "whether an input is wanted, or a state"),
        Given("j", int(d["wanted"][1:]) - 1 if story.fed else 0, "the input that v is added to"),
        *_weights(d, outcome.poles["observer"], d["alpha"]), Given("x_start", true.x[0]), Given("h", horizon / (len(true.t) - 1), "s"),
        Given("count", len(true.t)), Given("push", d["push"], "v = push sin(turn t)"), Given("turn", 2 * np.pi * WAVES / horizon, "rad/s"),
    ), (*_found(outcome), Shown("x", true.x), Shown("z", true.z), Shown("u", true.u), Shown("e_u", true.e),
        Shown("error_start", m["error_start"], max(abs(m["error_start"]), float(np.abs(true.wanted).max()))),
        Shown("late_error", m["late_error"], max(m["late_error"], 1e-3 * float(np.abs(true.e).max()))),
        Shown("late_wanted", m["late_wanted"])), UNSAID)


def _plant(o: FunctionalObserver, dA: np.ndarray, dB: np.ndarray, dC: np.ndarray) -> tuple[Given, ...]:
    return (Given("A", o.plant.A, "the model"), Given("B", o.plant.B), Given("C", o.plant.C), Given("dA", dA, "the true plant has A + dA"),
            Given("dB", dB, "B + dB too"), Given("dC", dC, "and C + dC"), Given("K", o.K, "what is wanted: K x"))


def _weights(d: Design, poles: np.ndarray, alpha: np.ndarray | float) -> tuple[Given, ...]:
    heads = np.asarray([p for p in poles if p.imag >= 0])
    return (Given("pole_re", np.real(heads), "the observer's poles, of a pair the one with Im > 0"), Given("pole_im", np.imag(heads)),
            Given("alpha", alpha), Given("beta", d["beta"]), Given("gamma", d["gamma"]), Given("norm", str(d["norm"])))


def _found(outcome: Outcome[Story] | Outcome[OwnStory]) -> tuple[Shown, ...]:
    gains = outcome.gains
    natural = float(np.abs(gains["K"]).max() / np.abs(gains["T"]).max())  # of N, which is zero where y says what is wanted
    direct = float(np.abs(gains["K"]).max() / np.abs(outcome.study.observer.plant.C).max())  # of M, which may be zero too
    return (*(Shown(name, gains[name]) for name in "FTL"), Shown("M", gains["M"], max(direct, float(np.abs(gains["M"]).max()))),
            Shown("N", gains["N"], max(natural, float(np.abs(gains["N"]).max()))),
            Shown("J", outcome.metrics["J"]),
            Shown("eigvals(F)", outcome.poles["observer"], poles=True), Shown("eigvals(loop)", outcome.poles["loop"], poles=True),
            Shown("slowest_loop", outcome.metrics["slowest_loop"], float(np.abs(outcome.poles["loop"]).max())))
