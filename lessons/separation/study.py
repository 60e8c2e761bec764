"""Compute a design of lesson 4: gains on the assumed plant, loop and run on the true one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.optimize import linear_sum_assignment

from observer_lab.course.figures.claims import claim
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome, Stage
from observer_lab.engine import Plant, Scenario, closed_loop, simulate
from observer_lab.engine.feedback import ClosedLoop
from observer_lab.engine.simulation import Run, separation_meter
from observer_lab.plants import Model
from observer_lab.plants.platform import model as platform
from observer_lab.text import NO_WORDS, Text, joined, text

from ..toolkit.boards import pole_boards
from ..toolkit.gains import gains
from ..toolkit.knobs import held, kicks
from ..toolkit.latex import gain_words, tiny
from ..toolkit.loop_rates import loop_rate
from .command import Driven, Target, driven
from .height_gauge import gauge_record, with_height_gauge
from .knobs import MODEL


@dataclass(frozen=True, eq=False)
class Setting:
    """The plant of the lesson: what really moves and what is believed of it, in a design; noise of a design; what follows the command.

    `ground`, `heard`: column and row of the frequency figure, with its title, axis and frequencies in Hz.
    """

    model: Model
    truth: Callable[[Design], Plant]
    belief: Callable[[Design], Plant]
    delay: Callable[[Design], float]
    noise: Callable[[Design], np.ndarray | float | None]
    ground: np.ndarray
    heard: np.ndarray
    heading: tuple[Text, Text | str]
    frequencies: np.ndarray
    target: Target
    gauge: bool = False  # whether a gauge of the signal that follows stands on the stage


@lru_cache(maxsize=64)
def believed(error_percent: float) -> Plant:
    """The deck as the designer believes it: every spring stiffer by the error."""
    p, factor = platform.Parameters(), 1 + error_percent / 100
    return platform.deck(replace(p, kz=p.kz * factor, kx=p.kx * factor))


DECK_SETTING = Setting(
    MODEL, lambda design: MODEL.plant, lambda design: believed(design["stiffness_error"]),
    lambda design: MODEL.dt * round(design["delay"] / 1000 / MODEL.dt),
    lambda design: None if design["noise"] == 0 else (design["noise"] / 1000) ** 2 * MODEL.dt,
    platform.deck_disturbance()[:, :1], MODEL.plant.C[:1],
    (text("from ground height to velocity VL"), "|VL/zg| [1/s]"), np.geomspace(0.1, 30.0, 300),
    Target("z [mm]", "mm", 1e3, lambda plant: (np.eye(6)[[1, 0, 2], :plant.n], np.zeros((3, plant.m))),
           lambda design: design["command"] / 1000), gauge=True)
LEAST_SHIFT = 0.01  # of the largest pole: from where on the loop's poles are seen to be others than those of the boards
UNION_RTOL = 1e-9  # union of spectra: agreement asked of them
DECAYED_SHARE = 0.5  # of a run's largest state: a run that is smaller in its last tenth dies down


@dataclass(frozen=True, eq=False)
class Study:
    """The loop without delay and clipping, and what of the two it leaves out: the delay in s, whether an input was clipped.

    `driven`: what ran, with integral action one state larger; `runs`: it without and with integral action, and
    why there is none with it, if so; `boards`: the loop of the two boards alone.
    """

    loop: ClosedLoop
    delay: float
    clipped: bool
    driven: Driven
    boards: ClosedLoop
    runs: LazyValue[tuple[Run, Run, Text]]

    @property
    def whole(self) -> bool:
        """Whether the loop's matrix is all there is: nothing late, nothing clipped."""
        return self.delay == 0 and not self.clipped

    def left_out(self) -> Text:
        """What boards, matrix and curves know nothing of; no words if there is nothing."""
        late = text("Boards, matrix and curves leave the delay of {delay:.3g} s out.", delay=self.delay)
        cut = text("Boards, matrix and curves leave the clipping out.")
        return joined(late if self.delay else NO_WORDS, cut if self.clipped else NO_WORDS)


def compute(here: Setting, design: Design) -> Outcome[Study]:
    """Gains on the believed plant, the loop on the true one with 2n poles (or 2n + 2 with integral action), one run."""
    truth, belief = here.truth(design), here.belief(design)
    K, L = gains(design, belief, here.model)
    boards = closed_loop(truth, K, L, model=belief)

    def drive(integral: bool) -> Driven:
        return driven(here.model, here.target, here.target.value(design), (truth, belief), (K, L), integral)
    drove = drive(design["integral"])
    loop = closed_loop(drove.truth, drove.K, drove.L, model=drove.belief) if drove.integral else boards
    scenario = _scenario(here, design, drove)
    run, m = simulate(scenario), drove.m

    def both() -> tuple[Run, Run, Text]:
        rival = drive(not design["integral"])
        other = simulate(_scenario(here, design, rival))
        return (other, run, drove.refused) if design["integral"] else (run, other, rival.refused)
    study = Study(loop, here.delay(design), design["limited"] and bool(np.any(np.abs(run.u_asked[:, :m]) > design["u_max"] * (1 + 1e-9))),
                  drove, boards, LazyValue(both))
    slow, fast = float(max(boards.controller_poles.real)), float(max(boards.observer_poles.real))
    metrics = LazyMap(lambda: {
        "union_error": loop.union_error, "separation_meter": separation_meter(run), "slowest_controller": slow,
        "slowest_observer": fast, "largest_input": float(np.max(np.abs(run.u_asked[:, :m]))),
        "slowest_loop": loop_rate(run), "dies_down": float(_dies_down(run)),
        "at_the_end": float(here.target.along(run, truth)[-1]),
    })
    same_union = loop.union_error <= UNION_RTOL or loop.polynomial_error <= UNION_RTOL
    checks = (
        Check("union", text("the 2n poles are the union of both sets"), same_union and study.whole, loop.union_error),
        Check("compensator", text("the compensator itself is stable"), loop.compensator_stable,
              float(max(loop.compensator_poles.real))),
    )
    return Outcome(
        design, {"K": drove.K, "L": drove.L},
        {"controller": loop.controller_poles, "observer": loop.observer_poles, "loop": loop.poles,
         "compensator": loop.compensator_poles},
        metrics, checks, run,
        with_loop_poles(pole_boards(here.model, design, boards.controller_poles, boards.observer_poles, belief.A - L @ belief.C),
                        boards.poles if study.whole else np.zeros(0)),
        _stage(here, study, design, run, truth),
        LazySequence(lambda: _formulas(K, L, believed_right(truth, belief), drove)),
        LazyValue(lambda: _live(study, metrics["separation_meter"], metrics["slowest_loop"])), study)


def with_loop_poles(boards: Sequence[Board], loop: np.ndarray) -> tuple[Board, ...]:
    """The boards with the loop's poles (2n,), each on the board and in the place of its nearest; none where they are the boards' own."""
    wanted = np.array([pole for board in boards for pole in board.poles])
    if len(wanted) != len(loop):
        return tuple(boards)
    _, order = linear_sum_assignment(np.abs(wanted[:, None] - loop))
    found = loop[order]
    if np.abs(found - wanted).max() <= LEAST_SHIFT * np.abs(wanted).max():
        return tuple(boards)
    ends = np.cumsum([len(board.poles) for board in boards])
    return tuple(replace(board, loop=tuple(map(complex, each))) for board, each in zip(boards, np.split(found, ends[:-1]), strict=True))


def _stage(here: Setting, study: Study, design: Design, run: Run, truth: Plant) -> Stage:
    """The plant with its estimate and, where it follows a command, a gauge with the run without integral action beside."""
    n, m, r = truth.n, study.driven.m, here.target.value(design) * here.target.scale
    body, x, xhat = here.model.body, run.x[:, :n], run.xhat[:, :n]
    if here.gauge and r:
        compared = study.driven.integral
        record = gauge_record(here.target.along(run, truth), r, here.target.along(study.runs.value[0], truth) if compared else None)
        body, x, xhat = with_height_gauge(body, n, r > 0, compared), np.hstack([x, record]), np.hstack([xhat, record])
    return Stage(body, run.t, x, xhat, run.u_applied[:, :m], held=held(design, here.model))


def _scenario(here: Setting, design: Design, drove: Driven) -> Scenario:
    """The run of what is driven, with the limits and the noise of a design; neither of them touches the way of r to the integrator."""
    model, more = drove.model, drove.truth.m - drove.m
    limit = np.append(np.full(drove.m, design["u_max"] if design["limited"] else np.inf), np.full(more, np.inf))
    V = here.noise(design)
    if V is not None and more:
        p = drove.truth.p - 2
        V = np.pad(V * np.eye(p) if np.ndim(V) == 0 else np.asarray(V), (0, 2))
    return Scenario(
        drove.truth, drove.K, drove.L, model=drove.belief, x0=model.x0, xhat0=model.guess, horizon=model.horizon, dt=model.dt,
        u_min=-limit, u_max=limit, fed="commanded", delay=here.delay(design), impulses=kicks(design, model), seed=int(design["seed"]),
        V=V, reference=drove.reference)


def _dies_down(run: Run) -> bool:
    """Whether the run went to its end and was smaller there than at its largest."""
    size = np.linalg.norm(run.x, axis=1)
    return run.diverged_at is None and float(size[-max(len(size) // 10, 1):].max()) <= DECAYED_SHARE * float(size.max())


def believed_right(truth: Plant, belief: Plant) -> bool:
    """Whether the observer copies the plant as it is."""
    return all(np.array_equal(getattr(truth, name), getattr(belief, name)) for name in "ABC")


def _formulas(K: np.ndarray, L: np.ndarray, right: bool, drove: Driven) -> tuple[Formula, ...]:
    below = r"0 & A-LC" if right else r"\Delta A-\Delta B\,K & \hat A-LC+\Delta B\,K"
    loop = (r"\frac{d}{dt}\begin{bmatrix} x \\ e \end{bmatrix} = \begin{bmatrix} A-BK & BK \\ " + below +
            r" \end{bmatrix} \begin{bmatrix} x \\ e \end{bmatrix}")
    return (
        Formula("loop", loop, NO_WORDS if right else text("ΔA = A − Â and ΔB = B − B̂: the part of the plant that the observer's model "
                                                          "lacks.")),
        Formula("K", gain_words("K", K)),
        Formula("L", gain_words(r"L^{\mathsf T}", L.T)),
        *_command_formulas(drove),
    )


def _command_formulas(drove: Driven) -> tuple[Formula, ...]:
    """How the input follows from the command, where there is one."""
    if drove.N is None:
        return ()
    u = r"u=-K\hat x+\bar N r" if not drove.integral else r"u=-K\hat x+\bar N r+K_I\,(x_I+T\hat x),\quad \dot x_I=r-z"
    return (Formula("command", u), Formula("N", gain_words(r"\bar N", drove.N)))


def _live(study: Study, meter: float, rate: float) -> Text:
    loop = study.loop
    one = text("The {count} poles of the loop are the union of both boards to about {union_error}.",
               count=len(loop.poles), union_error=tiny(loop.union_error))
    two = text("The {count} poles of the loop differ from the boards by {union_error:.1f} %.",
               count=len(loop.poles), union_error=100 * loop.union_error)
    union = study.left_out() if not study.whole else claim(one, loop.union_error, below=1e-6, otherwise=two)
    wall = claim(text("Separation meter: 0."), meter, below=1e-8, otherwise=text(
        "Separation meter: {meter:.2g}; the error dynamics are no longer autonomous.", meter=meter))
    first = claim(text("The loop is unstable."), rate, above=0.0)
    stable = claim(text("The compensator by itself is unstable."), float(np.max(loop.compensator_poles.real)), above=0.0)
    own = text("Integral action adds the pole {own:.3g}, and its copy in the observer adds {copy:.3g}.", own=study.driven.own[0],
               copy=study.driven.own[1])
    return joined(first, union, own if study.driven.integral else study.driven.refused, wall, stable)
