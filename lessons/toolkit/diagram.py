"""Draw the loop of a lesson as a block diagram: plant, observer, K and L with the signals of the run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol  # a knob takes values of several kinds: `Any`

import numpy as np

from observer_lab.course.figures.diagram import Block, DiagramFigure, Wire
from observer_lab.engine import Plant
from observer_lab.text import Text, text

from .latex import gain_words

PLANT_LAW, OBSERVER_LAW = r"\dot x = Ax + Bu,\quad y = Cx", r"\dot{\hat x} = A\hat x + Bu + %s\,(y - C\hat x)"
SAMPLED_PLANT, SAMPLED_OBSERVER = r"x_{k+1} = Ax_k + Bu_k,\quad y_k = Cx_k", r"\hat x_k = \hat x_k^- + %s\,(y_k - C\hat x_k^-)"
FED_BACK, FED_REFERENCE = r"u = -K\hat x,\quad ", r"u = r - K\hat x,\quad "
MOST_ENTRIES_IN_DIAGRAM, TALLEST_COLUMN = 8, 2  # of a gain below a diagram
SUM, LIMIT_BOX = (330.0, 150.0), (72.0, 36.0, 36.0, 28.0)


class Signals(Protocol):
    """What flows in a loop of N samples: t (N,), u as it is applied (N, m), y and ŷ (N, p), x̂ (N, n)."""

    @property
    def t(self) -> np.ndarray: ...
    @property
    def u_applied(self) -> np.ndarray: ...
    @property
    def y(self) -> np.ndarray: ...
    @property
    def yhat(self) -> np.ndarray: ...
    @property
    def xhat(self) -> np.ndarray: ...


@dataclass(frozen=True)
class Press:
    """A block that can be pressed, the knobs that this sets, and what it does in words."""

    block: str
    knobs: Mapping[str, Any]
    words: Text


class LoopSignals(NamedTuple):
    """The signals of a loop whose run is no `Run`."""

    t: np.ndarray
    u_applied: np.ndarray
    y: np.ndarray
    yhat: np.ndarray
    xhat: np.ndarray


@dataclass(frozen=True, eq=False)
class Limit:
    """A limit between controller and plant: the input that is asked for (N, m), and whether the observer gets what is applied."""

    asked: np.ndarray
    applied: bool


def loop(plant: Plant, run: Signals, L: np.ndarray, K: np.ndarray | None = None, press: Press | None = None,
         limit: Limit | None = None, gain: str = "L", sampled: bool = False, model: Plant | None = None,
         reference: bool = False, law: str = "") -> DiagramFigure:
    """The loop of a run with observer gain L (n, p) and, where the estimate is fed back, controller gain K (m, n).

    `gain` is the symbol of L; a continuous plant may be run in a `sampled` loop. `model` is the plant
    that the observer copies, where that is another one. With a `reference` r the controller gives u = r − K x̂. A plant
    that is not linear has a `law` of its own.
    """
    unit, sampled, count = dict(plant.units or ()), sampled or bool(plant.dt), len(run.t)
    of_input, of_output = (unit.get(names[0], "") if names else "" for names in (plant.input_names, plant.output_names))
    opened, innovation = not np.any(L), run.y - run.yhat
    blocks = [
        Block("plant", (130.0, 30.0, 100.0, 40.0), text("plant"),
              law or _with_input(SAMPLED_PLANT if sampled else PLANT_LAW, plant.D, sampled)),
        Block("observer", (130.0, 130.0, 100.0, 44.0), text("observer"),
              _with_input((SAMPLED_OBSERVER if sampled else OBSERVER_LAW) % gain, (model or plant).D, sampled)),
        Block("L", (262.0, 134.0, 30.0, 32.0), gain, _gain_words(gain, L), off=opened),
        *(() if K is None else (Block("K", (10.0, 100.0, 40.0, 32.0), "−K",
                                      (FED_REFERENCE if reference else FED_BACK) + _gain_words("K", K)),)),
        *(() if limit is None else (Block("limit", LIMIT_BOX, text("limit"), r"|u| \le u_{\max}"),)),
    ]
    if press is not None:
        blocks = [replace(block, press=press.knobs, pressed=press.words) if block.id == press.block else block for block in blocks]
    start = ((10.0, 50.0),) if K is None else ((30.0, 100.0), (30.0, 50.0))
    back = ((130.0, 162.0), (20.0, 162.0)) if K is None else ((130.0, 162.0), (30.0, 162.0), (30.0, 132.0))
    wires = (
        *_inputs(run, start, limit, of_input),
        Wire("y", (((230.0, 50.0), (330.0, 50.0), (330.0, 141.0)),), (238.0, 40.0), run.y, of_output, "plant"),
        Wire("ŷ", (((200.0, 174.0), (200.0, 204.0), (330.0, 204.0), (330.0, 159.0)),), (206.0, 222.0), run.yhat, of_output, "estimate"),
        Wire("y − ŷ", (((321.0, 150.0), (292.0, 150.0)), *(() if opened else (((262.0, 150.0), (230.0, 150.0)),))), (206.0, 124.0),
             innovation, of_output, "error"),
        Wire("x̂", (back,), (38.0, 182.0), run.xhat[:count], "", "estimate"),
    )
    return DiagramFigure("diagram", text("the loop, with its signals now"), run.t, tuple(blocks), wires, (SUM,),
                         (("+", (343.0, 139.0)), ("−", (343.0, 170.0))),
                         text("The thicker a line, the larger its signal now. A number in brackets says how many signals share the line."))


def _gain_words(symbol: str, M: np.ndarray) -> str:
    """A gain as LaTeX in one line or two: a tall column transposed, the size of a matrix with many entries."""
    if M.size > MOST_ENTRIES_IN_DIAGRAM:
        return rf"{symbol}\quad ({M.shape[0]}\times {M.shape[1]})"
    return gain_words(rf"{symbol}^{{\mathsf T}}", M.T) if M.shape[1] == 1 and len(M) > TALLEST_COLUMN else gain_words(symbol, M)


def _with_input(law: str, D: np.ndarray, sampled: bool) -> str:
    """A law of the plant or the observer in which the input acts on the reading as well, where D is not zero."""
    if not np.any(D):
        return law
    return law.replace(r"C\hat x_k^-", r"C\hat x_k^- - Du_k").replace("= Cx_k", "= Cx_k + Du_k") if sampled else (
        law.replace(r"C\hat x)", r"C\hat x - Du)").replace("= Cx", "= Cx + Du"))


def _inputs(run: Signals, start: tuple[tuple[float, float], ...], limit: Limit | None, unit: str) -> tuple[Wire, ...]:
    """The wires of the input: to the plant and, from before or behind a limit, to the observer."""
    def branch(x: float) -> tuple[tuple[float, float], ...]:
        return (x, 50.0), (x, 142.0), (130.0, 142.0)

    to_plant, applied = (130.0, 50.0), run.u_applied[:len(run.t)]
    if limit is None:
        return (Wire("u", ((*start, to_plant), branch(90.0)), (8.0, 40.0), applied, unit, "force"),)
    before, behind = ((*start, (72.0, 50.0)),), (((108.0, 50.0), to_plant),)
    if limit.applied:
        behind = (*behind, branch(118.0))
    else:
        before = (*before, branch(60.0))
    return (Wire("u", before, (8.0, 22.0), limit.asked[:len(run.t)], unit, "force"),
            Wire("sat u", behind, (112.0, 22.0), applied, unit, "force"))
