"""Compute a design of lesson 15: observers, loops, runs, worst cases.

House sign u = −K x̂ throughout; the source has u = +K x̂, so its K, N and M are minus ours, F, T and L the same.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.knobs import KnobError, Number
from observer_lab.course.lazy import LazyValue
from observer_lab.course.lesson import Board, Check, Design, Stage
from observer_lab.engine import functional_observer
from observer_lab.engine.observers import (
    FunctionalObserver,
    Norm,
    Perturbations,
    RobustObserver,
    criterion,
    error_index,
    peak_gain,
    vertices,
)
from observer_lab.plants import Window
from observer_lab.plants.bodies.body import Body
from observer_lab.plants.bodies.cause_rows import CauseRows
from observer_lab.plants.bodies.duan_body import rack_body
from observer_lab.plants.duan import EXAMPLE_1, EXAMPLE_2, Example
from observer_lab.plants.two_carts import CARTS, directions
from observer_lab.text import Text, joined, text

from ..toolkit.boards import listed
from ..toolkit.latex import pole_words
from .formulas import formulas_of
from .knobs import ERRORS_GROUP, EXAMPLE_FOUR, EXAMPLE_ONE, EXAMPLE_THREE, EXAMPLE_TWO, IM_HIGH, KNOBS, NORMS, RE_HIGH, RE_LOW, ROWS_AND_J
from .loop import CONDITION_RTOL, Drive, Errors, Loop, Run, Setting, amplitudes, loop_of, run_of, weighed
from .loop import Story as PlainStory
from .parts import Cause, error_parts

HORIZON, DT = 6.0, 0.015
BEST_POLE = -5 / 3  # least J of example 1 with unit weights
FREQUENCIES = np.geomspace(0.02, 20.0, 120)  # Hz
V_AMPLITUDE, V_RATE_RAD_S = 4.0, 5.0  # amplitude and rad/s of the paper's v
RUNAWAY = 1e12  # a state beyond ends what a run tells
DISPLAY_LIMIT = 1e3  # gains and signals beyond are drawn at the edge
SLOWEST_POLE_RAD_S = -0.01  # rad/s: an observer pole nearer to the imaginary axis is refused
LADDER_POLES = (-4.0, -2.5, -6.0, -7.5)  # rad/s, of the orders that the board does not show
MIN_POLE_GAP = 1e-3  # two real poles of example 2 must be farther apart than this


@dataclass(frozen=True, eq=False)
class Case:
    """One example with its body, and the knobs that hold its poles and the three model errors.

    `full`: the error that a bar on the stage draws at full length. `bodies` are those without and with a row for the error of the input,
    for each of these without and with the slabs of J.
    """

    example: Example
    bodies: tuple[tuple[Body, Body], tuple[Body, Body]]
    poles: str
    deltas: tuple[str, str, str]
    full: float


ADDED = text("added to û − u")
ERROR_KNOBS = MappingProxyType({knob.name: knob for knob in KNOBS if isinstance(knob, Number) and knob.group == ERRORS_GROUP})


def _case(example: Example, poles: str, deltas: tuple[str, str, str], q: int, full: tuple[float, ...], bar: float, most: float,
          axis: Text = ADDED, called: Mapping[str, Text] = MappingProxyType({})) -> Case:
    def rows(*names: str) -> CauseRows:
        return CauseRows(text("first error"), [called.get(name, ERROR_KNOBS[name].label) for name in names], text("sum: error of û"),
                         (f"≤ −{bar:g}", "0", f"≥ {bar:g}"), axis)

    first, second = ((rack_body(example.plant.n, q, full, rows(*names)), rack_body(example.plant.n, q, full, rows(*names), most))
                     for names in (deltas, (*deltas, "input")))
    return Case(example, (first, second), poles, deltas, bar)


EXAMPLE_CASES: MappingProxyType[str, Case] = MappingProxyType({
    EXAMPLE_ONE: _case(EXAMPLE_1, "pole", ("a1", "a2", "c"), 1, (3.0, 3.0, 3.0, 3.0), 3.0, 360.0),
    EXAMPLE_TWO: _case(EXAMPLE_2, "pair", ("b1", "b2", "d"), 2, (0.6, 0.6, 0.6, 3.0, 3.0, 5.0), 0.02, 100.0),
    EXAMPLE_THREE: _case(replace(EXAMPLE_1, z0=(-0.3, -0.3)), "pair", ("a1", "a2", "c"), 2, (3.0, 3.0, 3.0, 3.0, 3.0), 3.0, 30.0),
    EXAMPLE_FOUR: _case(CARTS, "pair", ("stiff", "damp", "tacho"), 2, (0.5, 1.5, 0.5, 1.5, 2.0, 2.0, 3.0), 0.5, 8.0,
                        text("added to û − u, in N"),
                        MappingProxyType({"stiff": text("δ of the spring"), "damp": text("δ of the damping")})),
})


def weighted(design: Design) -> Perturbations:
    """The directions of the model error with the design's weights: α₁ and α₂ of A, one β and one γ of C."""
    wrong = weighed(EXAMPLE_CASES[design["example"]].example.wrong, design)
    return replace(wrong, alpha=wrong.alpha * np.array([1.0, design["second"]]))


def deltas(design: Design) -> tuple[np.ndarray, np.ndarray]:
    """(δ of A, δ of C) that the plant really has."""
    a1, a2, c = (design[name] for name in EXAMPLE_CASES[design["example"]].deltas)
    return np.array([a1, a2]), np.array([c])


def errors(design: Design) -> Errors:
    """ΔA, ΔB = δ_b B and ΔC of the true plant."""
    example, (a, c) = EXAMPLE_CASES[design["example"]].example, deltas(design)
    return np.tensordot(a, example.wrong.A, 1), design["input"] * example.plant.B, np.tensordot(c, example.wrong.C, 1)


def causes(design: Design) -> tuple[Cause, ...]:
    """The errors of the model one by one, that of the input last and only where there is one."""
    example, (a, c) = EXAMPLE_CASES[design["example"]].example, deltas(design)
    known = (*(Cause(A=d * way) for d, way in zip(a, example.wrong.A, strict=True)),
             *(Cause(C=d * way) for d, way in zip(c, example.wrong.C, strict=True)))
    return (*known, Cause(B=design["input"] * example.plant.B)) if design["input"] else known


def index_parts(design: Design, o: FunctionalObserver) -> np.ndarray:
    """The three parts of J (3,): what of it is due to T, to L and to M."""
    return np.array([criterion(*(kept if k == part else 0 * kept for k, kept in enumerate((o.T, o.L, o.M))), o.wrong, norm=norm_of(design))
                     for part in range(3)])


def turn(design: Design) -> np.ndarray:
    """W: [1 w; 0 1] for the second example, I for the others."""
    return (
        np.array([[1.0, design["w12"]], [0.0, 1.0]])
        if design["example"] == EXAMPLE_TWO
        else np.eye(len(design[EXAMPLE_CASES[design["example"]].poles]))
    )


def norm_of(design: Design) -> Norm:
    """The norm of J; in the first example all three are the same number."""
    return NORMS[design["norm"]]


def observer_of(design: Design, W: np.ndarray | None = None) -> FunctionalObserver:
    """The observer of the design, in other coordinates W if given. Raises KnobError for poles that give none."""
    case = EXAMPLE_CASES[design["example"]]
    poles = design[case.poles]
    if max(p.real for p in poles) > SLOWEST_POLE_RAD_S:
        raise KnobError(text("An observer pole is not in the left half plane (Re s ≤ −0.01), so its error would "
                             "not decay; drag it left."))
    if len(poles) == 2 and abs(poles[0] - poles[1]) < MIN_POLE_GAP:
        raise KnobError(text("The two poles coincide, so [T; C] is singular and K cannot be reached; move them "
                             "apart.") if design["example"] == EXAMPLE_TWO else
                        text("The two poles coincide, and with them both rows of T, so the second state adds nothing; move them apart."))
    found = partial(functional_observer, case.example.plant, case.example.K, len(poles), poles=poles,
                    W=turn(design) if W is None else W, wrong=weighted(design), norm=norm_of(design))
    if design["example"] == EXAMPLE_FOUR:
        return found(directions=directions(poles))
    if design["example"] != EXAMPLE_THREE:
        return found()
    plain, moved = (float(found(free=[[step]]).M[0, 0]) for step in (0.0, 1.0))  # M follows the engine's free number in a line
    return replace(found(free=[[(design["free"] - plain) / (moved - plain)]]), M=np.array([[float(design["free"])]]))


def start_of(design: Design) -> np.ndarray:
    """z(0): as published, or carried along into the coordinates W."""
    z0 = np.array(EXAMPLE_CASES[design["example"]].example.z0)
    return turn(design) @ z0 if design["example"] == EXAMPLE_TWO and design["carried"] else z0


def gains_over_frequency(loops: Sequence[Loop]) -> tuple[np.ndarray, float]:
    """|v → e_u| of each loop over FREQUENCIES (len(loops), n_f), and the peak of all but the first.

    DISPLAY_LIMIT where a loop is unstable. The peak is exact for the loop that is highest on the grid.
    """
    gain = amplitudes(loops, np.append(FREQUENCIES, 1e-7))  # and all but a constant
    unstable = np.array([np.max(np.real(np.linalg.eigvals(loop.A))) >= 0 for loop in loops])
    gain[unstable] = DISPLAY_LIMIT
    high = loops[1 + int(np.argmax(gain[1:].max(axis=1)))]
    peak = np.inf if unstable[1:].any() else peak_gain(high.A, high.b[:, None], high.error, np.zeros((1, 1)))[0]
    return np.minimum(gain[:, :-1], DISPLAY_LIMIT), float(min(peak, DISPLAY_LIMIT))


def vertices_of(design: Design) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """(ΔA, ΔC) at the eight sign patterns of the design's |δ|."""
    return vertices(EXAMPLE_CASES[design["example"]].example.wrong, *deltas(design))


LOOP_LOW, LOOP_HIGH, LOOP_IM = -32.0, 4.0, 8.0  # of the loop's


@dataclass(frozen=True, eq=False)
class Search:
    """What RLO found so far: results by norm, and the worst |e_u/v| over poles s (example 2: s and s − 1)."""

    found: tuple[tuple[str, RobustObserver], ...] = ()
    s: np.ndarray = field(default_factory=lambda: np.zeros(0))
    worst: np.ndarray = field(default_factory=lambda: np.zeros(0))
    done: float = 0.0


@dataclass(frozen=True, eq=False)
class Story(PlainStory):
    """With `gains_over_frequency` of the true loop and of the eight vertices, and what RLO found."""

    gains: LazyValue[tuple[np.ndarray, float]]
    search: Search | None = None

    @property
    def now(self) -> np.ndarray:
        """|v → e_u| (n_f,) with these errors."""
        return self.gains.value[0][0]

    @property
    def worst(self) -> np.ndarray:
        """The same at the worst vertex, by frequency."""
        return self.gains.value[0][1:].max(axis=0)

    @property
    def peak(self) -> float:
        """The largest of that."""
        return self.gains.value[1]


def _story(design: Design, plain: PlainStory) -> Story:
    o, exact = plain.observer, 0 * plain.observer.plant.B
    return Story(o, plain.alone, plain.true, LazyValue(lambda: gains_over_frequency(
        (plain.true.loop, *(loop_of(PAPER, design, o, (dA, exact, dC)) for dA, dC in vertices_of(design))))))


def _told(design: Design, story: Story) -> dict[str, float]:
    o = story.observer
    return {"error_index": min(error_index(o), 1e9), "worst_gain": story.peak, "largest_N": float(np.abs(o.N).max()),
            "coordinate_gap": _coordinate_gap(design, story.model)}


def _conditions(metrics: Mapping[str, float]) -> tuple[Check]:
    kept = max(metrics["dynamics_residual"], metrics["output_residual"])
    return (Check("conditions", text("T A − F T = L C and K = N T + M C"), kept < CONDITION_RTOL, kept),)


def _coordinate_gap(design: Design, model: Run) -> float:
    """How far e_u on the model is from that of W = I started at the published z(0)."""
    if design["example"] != EXAMPLE_TWO:
        return 0.0
    plain = run_of(PAPER, design.with_values(carried=False), observer_of(design, np.eye(2)))
    return float(np.abs(plain.e - model.e).max())


def _loop_board(design: Design, loop: np.ndarray) -> Board:
    return Board("loop", text("poles of the loop with the true plant"), listed(loop), role="plant", side="left", re_low=LOOP_LOW,
                 re_high=LOOP_HIGH, im_high=LOOP_IM)


def _stage(design: Design, story: Story) -> Stage:
    case, run, named = EXAMPLE_CASES[design["example"]], story.true, causes(design)
    given, wanted = run.u, run.u - run.e[:, None]
    knobs = (*case.deltas, "input")[:len(named)]
    shares = np.tile([design[name] / ERROR_KNOBS[name].high for name in knobs], (len(run.t), 1))
    parts = np.clip(np.nan_to_num(np.column_stack([error_parts(run, story.observer, named), run.e]) / case.full), -1.0, 1.0)
    index = np.tile(index_parts(design, story.observer), (len(run.t), 1))
    states = np.hstack([np.clip(np.hstack([run.x, run.z]), -DISPLAY_LIMIT, DISPLAY_LIMIT), shares, parts, index])
    true, ghost = (np.hstack([states, np.clip(u, -DISPLAY_LIMIT, DISPLAY_LIMIT)]) for u in (wanted, given))
    body = case.bodies[bool(design["input"])][design["shown"] == ROWS_AND_J]
    return Stage(body, run.t, true, ghost, np.clip(given, -DISPLAY_LIMIT, DISPLAY_LIMIT))


def _live(design: Design, metrics: Mapping[str, float]) -> Text:
    poles = pole_words(design[EXAMPLE_CASES[design["example"]].poles])
    start = (text("Observer at {poles}: J = {j:.3g} for w = {w:g}.", poles=poles, j=metrics["J"], w=design["w12"])
             if design["example"] == EXAMPLE_TWO else text("Observer at {poles}: J = {j:.3g}.", poles=poles, j=metrics["J"]))
    end = claim(text("On the true plant û misses the wanted input by up to {late_error:.2g} at the end.",
                     late_error=metrics["late_error"]), metrics["slowest_loop"], below=0.0,
                otherwise=text("With the true plant the loop is unstable."))
    return joined(start, end)


def _bounded(states: np.ndarray) -> np.ndarray:
    """The states as they are, held where one of them has left every scale."""
    lost = ~(np.abs(states).max(axis=1) < RUNAWAY)
    return states[np.minimum(np.arange(len(states)), int(np.argmax(lost)) - 1)] if lost.any() else states


def _rows(design: Design) -> tuple[np.ndarray, np.ndarray]:
    K = EXAMPLE_CASES[design["example"]].example.K
    return K, K


def _orders(design: Design) -> Iterator[Sequence[complex]]:
    case = EXAMPLE_CASES[design["example"]]
    poles = design[case.poles]
    return (poles if order == len(poles) else LADDER_POLES[:order] for order in range(case.example.plant.n + 1))


PAPER = Setting(
    HORIZON, DT, 0.75 * HORIZON + DT / 2, DISPLAY_LIMIT, Window(RE_LOW, RE_HIGH, IM_HIGH), _rows,
    lambda design: (EXAMPLE_CASES[design["example"]].example.plant, _rows(design)[0], 1.0), _orders, observer_of, errors,
    lambda design: Drive(-V_AMPLITUDE, V_RATE_RAD_S, np.pi / 2),
    lambda design: (EXAMPLE_CASES[design["example"]].example.x0, start_of(design)), _bounded,
    lambda design: EXAMPLE_CASES[design["example"]].poles, _story, _told, _conditions, _loop_board, _stage, formulas_of, _live)
