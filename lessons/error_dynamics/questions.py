"""Draw the questions of lesson 2: what makes the error decay, a force, a worse start, a wrong model."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_over_time
from observer_lab.engine.simulation import Run
from observer_lab.text import Text, same, text

from ..toolkit.questions import driven, size

BETTER = 0.3  # of the copy's error, in the option that says that the observer knows the input better
SLOWER = 0.5  # pace of the error in the option that says that the force slows it down
UNSTABLE = 1.65  # 1/s by which all poles lie farther right, in the option that says unstable: then at +0.15
SHARE_S = 6.0  # s of the error over its peak
FASTER = 2.0  # by how much a moving block would shorten the transient, in the option that says so


def _drawn(t: np.ndarray, known: tuple[Curve, ...], options: tuple[np.ndarray, ...], run: Curve) -> DrawnQuestion:
    return question_over_time(text("size of the error e"), t, known, options, run, "‖e‖", log_y=True, span=(-4.0, 1.0))


def _curve(run: Run, name: Text, role: str = "error") -> Curve:
    return Curve(name, size(run.e), role)


def _now(run: Run) -> Curve:
    return _curve(run, text("now"), "muted")


def recall(asked: Asked) -> DrawnQuestion:
    """The error of an observer beside a copy's: smaller at the same pace, faster by the feedback, or the same."""
    run, study = asked.entry.run, asked.entry.study
    t, e0 = run.t, run.e[0]
    copy = size(driven(run.scenario.plant.A, e0, t))
    return _drawn(t, (Curve(text("the copy"), copy, "second", "dot"),), (BETTER * copy, size(driven(study.error, e0, t)), copy),
                  _curve(run, text("the observer")))


def predict(asked: Asked) -> DrawnQuestion:
    """The error under a sine force: driven by it, as without it, or shorter."""
    quiet, run = asked.entry.run, asked.after.run
    A, B = asked.entry.study.error, run.scenario.plant.B
    pushed = driven(A, quiet.e[0], quiet.t, run.u_applied @ B.T)
    shorter = size(driven(FASTER * A, quiet.e[0], quiet.t))
    return _drawn(quiet.t, (_now(quiet),), (size(pushed), size(quiet.e), shorter), _curve(run, text("with the force")))


def surprise(asked: Asked) -> DrawnQuestion:
    """The error over its own peak, from twice the start: half as fast, later by a fixed time, or the same curve as before."""
    before, after = asked.entry.run, asked.after.run
    seen = before.t <= SHARE_S
    t, error = before.t[seen], before.e
    slower = size(driven(0.5 * asked.entry.study.error, error[0], before.t))
    later = np.interp(np.maximum(before.t - np.log(2) / 1.5, 0.0), before.t, size(error))

    def share(errors: np.ndarray) -> np.ndarray:
        return (errors / errors.max())[seen]
    known = Curve(text("now"), share(size(error)), "muted"), Curve(same("2 %"), np.full(len(t), 0.02), "reference", "dot", 1.4)
    return question_over_time(text("size of the error over its peak"), t, known, (share(slower), share(later), share(size(error))),
                              Curve(text("from twice the start"), share(size(after.e)), "error"), "", log_y=True, span=(-3.0, 0.5))


def printed(asked: Asked) -> DrawnQuestion:
    """The error of a copy of another block under a constant force: as before, slower, or at rest away from zero."""
    before, after = asked.entry.run, asked.after.run
    t, start, error = after.t, before.e[0], asked.after.study.error
    block, belief = after.scenario.plant, after.scenario.model or after.scenario.plant
    push = block.B @ after.u_applied[-1]
    rest = np.linalg.solve(block.A, -push)
    offset = np.linalg.solve(error, (belief.A - block.A) @ rest)
    return _drawn(t, (_now(before),), (size(driven(asked.entry.study.error, start, t)), size(driven(SLOWER * error, start, t)),
                          size(offset + driven(error, start - offset, t))), _curve(after, text("with the printed pair")))


def direct(asked: Asked) -> DrawnQuestion:
    """The error of the position without D u in ŷ: as with it, to the rest that −L D u gives, or along a pole on the right."""
    before, after, study = asked.entry.run, asked.after.run, asked.entry.study
    t, e0, F = before.t, before.e[0], study.error
    leak = -after.u_applied @ (asked.after.gains["L"] @ study.plant.D).T
    curves = tuple(driven(*given)[:, 0] for given in ((F, e0, t), (F, e0, t, leak), (F + UNSTABLE * np.eye(len(F)), e0, t, leak)))
    return question_over_time(text("error of the position"), t, (Curve(text("with D u"), before.e[:, 0], "muted"),), curves,
                              Curve(text("without D u"), after.e[:, 0], "error"), "e₁ [m]", span=(-1.0, 3.0))


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise, "printed": printed, "direct": direct})
