"""Compute a design of lesson 15: observers, loops, runs, worst cases.

House sign u = −K x̂ throughout; the source has u = +K x̂, so its K, N and M are minus ours, F, T and L the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.knobs import KnobError, Number
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Board, Check, Design, Outcome, Stage
from observer_lab.engine import Plant, functional_observer, simulate_functional
from observer_lab.engine.observers import (
    FunctionalObserver,
    FunctionalRun,
    Norm,
    Perturbations,
    RobustObserver,
    error_index,
    peak_gain,
    perturbed_loop,
    vertices,
)
from observer_lab.plants.bodies.body import Body
from observer_lab.plants.bodies.duan_body import rack_body
from observer_lab.plants.duan import EXAMPLE_1, EXAMPLE_2, Example, outer_input
from observer_lab.plants.two_carts import CARTS, directions
from observer_lab.text import Text, joined, text

from ..toolkit.boards import listed
from ..toolkit.latex import pole_words
from .formulas import formulas_of
from .knobs import ERRORS_GROUP, EXAMPLE_FOUR, EXAMPLE_ONE, EXAMPLE_THREE, EXAMPLE_TWO, IM_HIGH, KNOBS, NORMS, RE_HIGH, RE_LOW

HORIZON, DT = 6.0, 0.015
BEST_POLE = -5 / 3  # least J of example 1 with unit weights
FREQUENCIES = np.geomspace(0.02, 20.0, 120)  # Hz
V_AMPLITUDE, V_RATE_RAD_S = 4.0, 5.0  # amplitude and rad/s of the paper's v
DISPLAY_LIMIT = 1e3  # gains and signals beyond are drawn at the edge
SLOWEST_POLE_RAD_S = -0.01  # rad/s: an observer pole nearer to the imaginary axis is refused
MIN_POLE_GAP = 1e-3  # two real poles of example 2 must be farther apart than this


@dataclass(frozen=True, eq=False)
class Case:
    """One example with its body, and the knobs that hold its poles and the three model errors."""

    example: Example
    body: Body
    poles: str
    deltas: tuple[str, str, str]


ERROR_KNOBS = MappingProxyType({knob.name: knob for knob in KNOBS if isinstance(knob, Number) and knob.group == ERRORS_GROUP})


def _case(example: Example, poles: str, deltas: tuple[str, str, str], n: int, q: int, full: tuple[float, ...]) -> Case:
    return Case(example, rack_body(n, q, full, [ERROR_KNOBS[name].label for name in deltas]), poles, deltas)


EXAMPLE_CASES: MappingProxyType[str, Case] = MappingProxyType({
    EXAMPLE_ONE: _case(EXAMPLE_1, "pole", ("a1", "a2", "c"), 2, 1, (3.0, 3.0, 3.0, 20.0)),
    EXAMPLE_TWO: _case(EXAMPLE_2, "pair", ("b1", "b2", "d"), 3, 2, (0.6, 0.6, 0.6, 3.0, 3.0, 5.0)),
    EXAMPLE_THREE: _case(replace(EXAMPLE_1, z0=(-0.3, -0.3)), "pair", ("a1", "a2", "c"), 2, 2, (3.0, 3.0, 3.0, 3.0, 20.0)),
    EXAMPLE_FOUR: _case(CARTS, "pair", ("stiff", "damp", "tacho"), 4, 2, (0.5, 1.5, 0.5, 1.5, 2.0, 2.0, 20.0)),
})


def weighted(design: Design) -> Perturbations:
    """The directions of the model error with the design's weights: α₁ and α₂ of A, one β and one γ of C."""
    w = EXAMPLE_CASES[design["example"]].example.wrong
    return replace(w, alpha=design["alpha"] * np.array([1.0, design["second"]]), beta=np.full(len(w.C), design["beta"]),
                   gamma=np.full(len(w.C), design["gamma"]))


def deltas(design: Design) -> tuple[np.ndarray, np.ndarray]:
    """(δ of A, δ of C) that the plant really has."""
    a1, a2, c = (design[name] for name in EXAMPLE_CASES[design["example"]].deltas)
    return np.array([a1, a2]), np.array([c])


def errors(design: Design) -> tuple[np.ndarray, np.ndarray]:
    """ΔA, ΔC of the true plant."""
    w, (a, c) = EXAMPLE_CASES[design["example"]].example.wrong, deltas(design)
    return np.tensordot(a, w.A, 1), np.tensordot(c, w.C, 1)


def input_error(design: Design) -> np.ndarray:
    """ΔB = δ_b B of the true plant."""
    return design["input"] * EXAMPLE_CASES[design["example"]].example.plant.B


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


def shown(run: FunctionalRun) -> FunctionalRun:
    """The run over the whole horizon, held where it has left every scale."""
    count = round(HORIZON / DT) + 1
    if len(run.t) == count:
        return run
    index = np.minimum(np.arange(count), len(run.t) - 1)
    return replace(run, t=DT * np.arange(count), x=run.x[index], z=run.z[index], y=run.y[index], v=run.v[index],
                   u=run.u[index], e_u=run.e_u[index])


def gains_over_frequency(observer: FunctionalObserver, dB: np.ndarray,
                         pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, float]:
    """|v → e_u| of the loop for each (ΔA, ΔC), over FREQUENCIES (len(pairs), n_f), and the peak of all but the first.

    The first has ΔB as well.

    DISPLAY_LIMIT where a loop is unstable. The peak is exact for the pair that is highest on the grid.
    """
    loops = [perturbed_loop(observer, dA=dA, dB=dB if k == 0 else None, dC=dC) for k, (dA, dC) in enumerate(pairs)]
    A, B, C = (np.stack([getattr(loop, name) for loop in loops]) for name in "ABC")
    s = 2j * np.pi * np.append(FREQUENCIES, 1e-7)  # and all but a constant
    solved = np.linalg.solve(s[None, :, None, None] * np.eye(A.shape[1]) - A[:, None], B[:, None] + 0j)
    gain = np.abs((C[:, None] @ solved)[..., 0, 0])
    unstable = np.max(np.real(np.linalg.eigvals(A)), axis=1) >= 0
    gain[unstable] = DISPLAY_LIMIT
    k = 1 + int(np.argmax(gain[1:].max(axis=1)))
    peak = np.inf if unstable[1:].any() else peak_gain(A[k], B[k], C[k], np.zeros((1, 1)))[0]
    return np.minimum(gain[:, :-1], DISPLAY_LIMIT), float(min(peak, DISPLAY_LIMIT))


def steady_error(loop: Plant) -> float:
    """Amplitude of e_u once the start has died out, under v = `V_AMPLITUDE` sin(`V_RATE_RAD_S` t + φ): V_AMPLITUDE·|C (jω − A)⁻¹ B|."""
    if np.max(np.real(loop.poles)) >= 0:
        return np.inf
    return V_AMPLITUDE * float(abs((loop.C @ np.linalg.solve(1j * V_RATE_RAD_S * np.eye(len(loop.A)) - loop.A, loop.B + 0j))[0, 0]))


def vertices_of(design: Design) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """(ΔA, ΔC) at the eight sign patterns of the design's |δ|."""
    return vertices(EXAMPLE_CASES[design["example"]].example.wrong, *deltas(design))


LOOP_LOW, LOOP_HIGH, LOOP_IM = -32.0, 4.0, 8.0  # of the loop's
CONDITION_RTOL = 1e-9


@dataclass(frozen=True, eq=False)
class Search:
    """What RLO found so far: results by norm, and the worst |e_u/v| over poles s (example 2: s and s − 1)."""

    found: tuple[tuple[str, RobustObserver], ...] = ()
    s: np.ndarray = field(default_factory=lambda: np.zeros(0))
    worst: np.ndarray = field(default_factory=lambda: np.zeros(0))
    done: float = 0.0


@dataclass(frozen=True, eq=False)
class Story:
    """The observer, its run on the true plant and, when they are looked at, on the model, and `gains_over_frequency`.

    steady: amplitude at which e_u settles on the true plant under v, ∞ where its loop is unstable.
    """

    observer: FunctionalObserver
    alone: LazyValue[FunctionalRun]
    true: FunctionalRun
    gains: LazyValue[tuple[np.ndarray, float]]
    steady: float
    search: Search | None = None

    @property
    def model(self) -> FunctionalRun:
        """The run on the model."""
        return self.alone.value

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


def compute(design: Design) -> Outcome[Story]:
    """The observer in house sign, one run on the model and one on the true plant, the worst of eight vertices."""
    case = EXAMPLE_CASES[design["example"]]
    example, observer, (dA, dC), dB = case.example, observer_of(design), errors(design), input_error(design)
    z0 = start_of(design)
    model = LazyValue(lambda: simulate_functional(observer, outer_input, x0=example.x0, z0=z0, horizon=HORIZON, dt=DT))
    true = shown(simulate_functional(observer, outer_input, x0=example.x0, z0=z0, horizon=HORIZON, dt=DT, dA=dA, dB=dB, dC=dC))
    gains = LazyValue(lambda: gains_over_frequency(observer, dB, ((dA, dC), *vertices_of(design))))
    loop = perturbed_loop(observer, dA=dA, dB=dB, dC=dC)
    story = Story(observer, model, true, gains, steady_error(loop))
    late = true.t > 0.75 * HORIZON
    known = {"J": observer.J, "order": float(observer.order), "slowest_loop": float(np.max(np.real(loop.poles))),
             "error_start": float(true.e_u[0, 0]), "late_error": float(min(np.abs(true.e_u[late]).max(), DISPLAY_LIMIT))}
    metrics = LazyMap(lambda: {
        **known, "error_index": min(error_index(observer), 1e9), "dynamics_residual": observer.dynamics_residual,
        "output_residual": observer.output_residual, "worst_gain": story.peak,
        "largest_N": float(np.abs(observer.N).max()), "coordinate_gap": _coordinate_gap(design, story.model),
    }, known)
    o = observer
    return Outcome(design, {"F": o.F, "T": o.T, "L": o.L, "N": o.N, "M": o.M, "K": o.K},
                   {"observer": np.array(design[case.poles]), "loop": loop.poles}, metrics, LazySequence(lambda: _checks(metrics)), None,
                   _boards(design, case.poles, loop.poles), _stage(case, design, true), LazySequence(lambda: formulas_of(o, design)),
                   LazyValue(lambda: _live(design, metrics)), story)


def _checks(metrics: Mapping[str, float]) -> tuple[Check, Check]:
    kept = max(metrics["dynamics_residual"], metrics["output_residual"])
    return (
        Check("conditions", text("T A − F T = L C and K = N T + M C"), kept < CONDITION_RTOL, kept),
        Check("stable", text("the loop with the true plant is stable"), metrics["slowest_loop"] < 0, metrics["slowest_loop"]),
    )


def _coordinate_gap(design: Design, model: FunctionalRun) -> float:
    """How far e_u on the model is from that of W = I started at the published z(0)."""
    if design["example"] != EXAMPLE_TWO:
        return 0.0
    example = EXAMPLE_CASES[EXAMPLE_TWO].example
    plain = simulate_functional(observer_of(design, np.eye(2)), outer_input, x0=example.x0, z0=example.z0, horizon=HORIZON,
                                dt=DT)
    return float(np.abs(plain.e_u - model.e_u).max())


def _boards(design: Design, knob: str, loop: np.ndarray) -> tuple[Board, Board]:
    return (
        Board("loop", text("poles of the loop with the true plant"),
              listed(loop),
              role="plant", side="left", re_low=LOOP_LOW, re_high=LOOP_HIGH, im_high=LOOP_IM),
        Board("observer", text("observer poles  eig F"), design[knob], knob, role="estimate",
              side="right", re_low=RE_LOW, re_high=RE_HIGH, im_high=IM_HIGH),
    )


def _stage(case: Case, design: Design, run: FunctionalRun) -> Stage:
    given, wanted = run.u, run.u - run.e_u
    shares = np.tile([design[name] / ERROR_KNOBS[name].high for name in case.deltas], (len(run.t), 1))
    states = np.clip(np.hstack([run.x, run.z, shares]), -DISPLAY_LIMIT, DISPLAY_LIMIT)
    true, ghost = (np.hstack([states, np.clip(u, -DISPLAY_LIMIT, DISPLAY_LIMIT)]) for u in (wanted, given))
    return Stage(case.body, run.t, true, ghost, np.clip(given, -DISPLAY_LIMIT, DISPLAY_LIMIT))


def _live(design: Design, metrics: Mapping[str, float]) -> Text:
    poles = pole_words(design[EXAMPLE_CASES[design["example"]].poles])
    start = (text("Observer at {poles}: J = {j:.3g} for w = {w:g}.", poles=poles, j=metrics["J"], w=design["w12"])
             if design["example"] == EXAMPLE_TWO else text("Observer at {poles}: J = {j:.3g}.", poles=poles, j=metrics["J"]))
    end = claim(text("On the true plant û misses the wanted input by up to {late_error:.2g} at the end.",
                     late_error=metrics["late_error"]), metrics["slowest_loop"], below=0.0,
                otherwise=text("With the true plant the loop is unstable."))
    return joined(start, end)
