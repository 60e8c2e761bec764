"""Compute a design of lesson 7: a clipped run, the same with known state, error check."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees, radians

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Check, Design, Formula, Outcome, Stage
from observer_lab.engine import EngineError, Plant, Scenario, autonomous_error, simulate
from observer_lab.engine.simulation import Run, separation_meter, simulate_until
from observer_lab.engine.systems import sorted_poles
from observer_lab.plants import Model
from observer_lab.plants.cart_pendulum import in_fog
from observer_lab.text import NO_WORDS, Text, format_number, joined, text

from ..toolkit.boards import pole_boards, stage
from ..toolkit.gains import gains
from ..toolkit.knobs import kicks
from ..toolkit.latex import gain_words
from .ending import Ending, ending_of
from .knobs import APPLIED, MODEL

CART_PLANT, FOGGY_BODY = MODEL.plant, in_fog(MODEL.body)
ERROR_LAW_RTOL = 1e-9  # of the error's peak: how well ė = (A − LC)e must hold to count as exact
ANGLE = 1  # index of the angle in the state
RECOVERED_NORM = 0.05  # ‖x‖ at the horizon below which a start has come home (m, rad, m/s, rad/s)
LOST_NORM = 20.0  # ‖x‖ beyond which it has not, whatever comes
FALLEN = radians(45.0)  # where the linear pole counts as fallen
ENDS = (0.5, 1.0, 2.0, 4.0)  # s; a lost run is not followed past the first of them after the pole has fallen
RUN_SERIES = ("x", "xhat", "e", "u_asked", "u_applied", "y", "yhat", "w", "v")
MAP_STEP_S = 0.01  # s, grid of the map's runs
START_GRID_DEG = np.linspace(-20.0, 20.0, 41)  # degrees: angle across, error of its estimate upwards
FALLEN_END = Ending(False, True, 0.0, False)  # of a pole that has passed 45°
NOT_COMPUTED, RECOVERED, NOT_RECOVERED, UNRECOVERABLE = -1, 0, 1, 2


@dataclass(frozen=True)
class Sayings:
    """What is said of a plant: it recovers, it does not, that is open so far; of a clipped input; of an error that is driven.

    `windup`: that the compensator is stable while clipped; `hopeless`: that poles on the right leave no start that recovers.
    """

    home: Text
    lost: Text
    open: Callable[[float], Text]
    clipped: Callable[[float], Text]
    never: Text
    meter: Callable[[str], Text]
    windup: Text
    hopeless: Text


@dataclass(frozen=True, eq=False)
class Starts:
    """Categories (n_error, n_start) of the starts on grid × grid; of a rough map those of the nearest start."""

    values: np.ndarray
    rough: bool = False

    @property
    def done(self) -> float:
        """Share of the map that is known."""
        return float(np.mean(self.values != NOT_COMPUTED))

    @property
    def home(self) -> float:
        """Share of the whole map that recovers."""
        return float(np.mean(self.values == RECOVERED))


@dataclass(frozen=True, eq=False)
class Setting:
    """The cart, or a person's `own` plant: its start x(0) and x̂(0), its run, that as it is drawn and when it was stopped.

    `law_rtol`: how well ė = (A − LC)e must hold to count as exact, of the error's peak. `numbers`: further metrics of a design and of
    the time of the stop. The map: the knobs of its axes, its `grid` in them and as values of the first state of `turned`, the loop in
    the coordinates in which it is drawn, in runs of `map_step` s; sizes of x (recovered, lost); beyond `ceiling` no start recovers.
    """

    own: bool
    model: Model
    start: Callable[[Design], tuple[Sequence[float], Sequence[float]]]
    march: Callable[[Scenario], Run]
    whole: Callable[[Run], tuple[Run, float | None]]
    law_rtol: float
    numbers: Callable[[Design, float | None], dict[str, float]]
    stage: Callable[[Run, Design], Stage]
    sayings: Sayings
    axes: tuple[str, str]
    grid: np.ndarray
    places: np.ndarray
    state: int
    turned: Callable[[Scenario], Scenario]
    map_step: float
    sizes: tuple[float, float]
    ceiling: Callable[[Design], float] = lambda _: np.inf


@dataclass(frozen=True, eq=False)
class Study:
    """One run as it is drawn: `shown` has every instant of the horizon, held once the pole has fallen.

    `promised` is what ė = (A − LC)e says (n_t, n), `known` the states had x been known (n_t, n), `starts` the map; `end` and
    `known_end` say how both go on after the horizon.
    """

    here: Setting
    shown: Run
    promised: np.ndarray
    known: np.ndarray
    stopped: float | None
    starts: Starts | None
    end: Ending = FALLEN_END
    known_end: Ending = FALLEN_END


def nearest(value: float, grid: np.ndarray) -> int:
    """Index of the grid line nearest to a value."""
    return int(np.argmin(np.abs(grid - value)))


def start_state(angle: float, error: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """x(0) and x̂(0) of a resting cart whose pole leans by `angle` degrees and is believed at angle − error."""
    return (0.0, radians(angle), 0.0, 0.0), (0.0, radians(angle - error), 0.0, 0.0)


def ceiling(plant: Plant, u_max: float) -> float:
    """The angle in degrees from which no |u| ≤ u_max can bring the resting plant back: |q·B| u_max / (λ |q_θ|).

    q is the left eigenvector of the one unstable eigenvalue λ: d(q·x)/dt = λ q·x + q·B u cannot change sign beyond.
    """
    values, vectors = np.linalg.eig(plant.A.T)
    unstable = np.flatnonzero(np.real(values) > 1e-9)
    if len(unstable) != 1:
        raise EngineError("The ceiling needs one unstable eigenvalue; this plant has {count}.", count=len(unstable))
    q, rate = np.real(vectors[:, unstable[0]]), float(np.real(values[unstable[0]]))
    return degrees(abs(float(q @ plant.B[:, 0])) * u_max / (rate * abs(q[ANGLE])))


def depends(design: Design) -> tuple[Hashable, ...]:
    """The design values on which the map depends; the start is not among them."""
    return tuple(design[name] for name in ("fed", "u_max", "controller_poles", "observer_poles"))


def scenario_of(here: Setting, design: Design, K: np.ndarray, L: np.ndarray) -> Scenario:
    """The clipped loop from the design's own start."""
    model, (x0, xhat0) = here.model, here.start(design)
    return Scenario(model.plant, K, L, x0=x0, xhat0=xhat0, horizon=model.horizon, dt=model.dt, u_min=-design["u_max"],
                    u_max=design["u_max"], fed=design["fed"], impulses=kicks(design, model), seed=int(design["seed"]))


def compute(here: Setting, design: Design) -> Outcome[Study]:
    """One clipped run, the same start with a known state, and what the error was promised."""
    plant = here.model.plant
    K, L = gains(design, plant, here.model)
    scenario = scenario_of(here, design, K, L)
    run, ideal = (here.march(each) for each in (scenario, replace(scenario, state_feedback=True)))
    (shown, stopped), (known, known_fall) = here.whole(run), here.whole(ideal)
    end, known_end = (FALLEN_END if fall is not None else ending_of(each) for each, fall in ((run, stopped), (ideal, known_fall)))
    seen = until(run, stopped)
    poles = poles_of(plant, K, L, design["fed"])
    metrics = limited(seen, design["u_max"], poles, end, known_end) | here.numbers(design, stopped)
    story = Study(here, shown, autonomous_error(shown), known.x, stopped, None, end, known_end)
    checks = checks_of(here, metrics, metrics["comes_home"] if here.own else float(np.linalg.norm(run.x[-1])))
    boards = pole_boards(here.model, design, poles["controller"], poles["observer"], plant.A - L @ plant.C if here.own else None)
    return Outcome(design, {"K": K, "L": L}, poles, metrics, checks, seen, boards, here.stage(shown, design),
                   _formulas(here, design, K, L, metrics), _live(design, metrics, story, poles), story)


def poles_of(plant: Plant, K: np.ndarray, L: np.ndarray, fed: str) -> dict[str, np.ndarray]:
    """Of controller and observer, and of the compensator while every input stands at its limit."""
    A, B, C = plant.A, plant.B, plant.C
    inside = A - L @ C if fed == APPLIED else A - B @ K - L @ C + L @ plant.D @ K
    return {"controller": sorted_poles(A - B @ K), "observer": sorted_poles(A - L @ C), "clipped": sorted_poles(inside)}


def limited(run: Run, u_max: float, poles: Mapping[str, np.ndarray], end: Ending, known_end: Ending) -> dict[str, float]:
    """Effects of the limit in a run: how far the error left its law, how long an input was clipped, whether the start recovers."""
    clipped = np.any(np.abs(run.u_asked) > u_max * (1 + 1e-9), axis=1)
    return {
        "separation_meter": separation_meter(run), "comes_home": float(end.home), "known_comes_home": float(known_end.home),
        "clipped_rate": float(np.max(np.real(poles["clipped"]))), "clipped_for": run.scenario.dt * float(np.sum(clipped)),
        "largest_asked": float(np.max(np.abs(run.u_asked)))}


def checks_of(here: Setting, m: Mapping[str, float], left: float) -> tuple[Check, ...]:
    """Whether the error keeps to its law, the compensator does not wind up, and the start recovers, with what is `left` at the end."""
    return (
        Check("autonomous", text("the error dynamics are autonomous, ė = (A − LC)e"), m["separation_meter"] < here.law_rtol,
              m["separation_meter"], informative=True),
        Check("windup", here.sayings.windup, m["clipped_rate"] < 0, m["clipped_rate"], informative=True),
        Check("home", text("this start recovers"), m["comes_home"] > 0, left, informative=True))


def slowest(outcome: Outcome[Study], name: str) -> float:
    return float(np.max(np.real(outcome.poles[name])))


def amount(value: float) -> str:
    """A number for a sentence; what has left every scale is only said to be large."""
    return "> 1000" if value > 1000 else format_number(value, ".3g") if value > 1e-9 else "0"


def _formulas(here: Setting, design: Design, K: np.ndarray, L: np.ndarray, metrics: Mapping[str, float]) -> tuple[Formula, ...]:
    told = design["fed"] == APPLIED
    clipped = Formula("clipped", r"\dot{\hat x} = (A-LC)\,\hat x \pm B\,u_{\max} + L\,y" if told else
                      r"\dot{\hat x} = (A-BK-LC)\,\hat x + L\,y",
                      text("The compensator while the force is clipped: rightmost eigenvalue {rate:.3g}.", rate=metrics["clipped_rate"]))
    return (
        Formula("error", r"\dot e = (A-LC)\,e" if told else r"\dot e = (A-LC)\,e + B\,(\mathrm{sat}\,u - u)"),
        *(() if here.own else (clipped,)), Formula("K", gain_words("K", K)), Formula("L", gain_words(r"L^{\mathsf T}", L.T)))


def _unstable(story: Study, poles: Mapping[str, np.ndarray]) -> Text:
    """That a pole is on the right, said before all else."""
    if story.here.own:
        return text("The loop is unstable.") if story.end.unstable else NO_WORDS
    if np.max(np.real(poles["controller"])) >= 0:
        return text("A controller pole is not in the left half plane: the loop is unstable.")
    return (text("An observer pole is not in the left half plane: the error does not decay.")
            if np.max(np.real(poles["observer"])) >= 0 else NO_WORDS)


def ends(story: Study) -> Text:
    """How the run on the screen ends, or goes on after it."""
    if story.stopped is not None:
        return text("The pole falls: past 45° at {stopped:.2f} s.", stopped=story.stopped)
    said = story.here.sayings
    return said.home if story.end.home else said.lost if story.end.decided else said.open(story.end.until)


def _live(design: Design, metrics: Mapping[str, float], story: Study, poles: Mapping[str, np.ndarray]) -> Text:
    meter, clipped, said = metrics["separation_meter"], metrics["clipped_for"], story.here.sayings
    obeys = (text("The error obeys A − LC all the same.") if clipped > 0 else
             text("So the error obeys A − LC, whichever input the observer gets."))
    return joined(_unstable(story, poles), ends(story), said.clipped(clipped) if clipped > 0 else said.never,
                  claim(obeys, meter, below=story.here.law_rtol, otherwise=said.meter(amount(meter))))


# --- the cart --------------------------------------------------------------------------------------------------------
def march(scenario: Scenario) -> Run:
    """The run of a scenario, ending early with the part in which the pole falls."""
    return simulate_until(scenario, ENDS, lambda x: bool(np.abs(x[:, ANGLE]).max() > FALLEN))


def whole(run: Run) -> tuple[Run, float | None]:
    """The run over every instant of its grid, and when the pole fell, if it did.

    From the fall on everything is held. Where the estimate leaves all bounds before that, the force stays where it
    was, at its limit, and the plant goes on under it.
    """
    s, x = run.scenario, run.x
    count = s.n_t
    over = np.flatnonzero(np.abs(x[:, ANGLE]) > FALLEN)
    if run.diverged_at is not None and not len(over):
        now = float(run.t[-1])  # a hand that pulls goes on pulling
        rest = simulate(Scenario(s.plant, x0=x[-1], reference=run.u_applied[-1], dt=s.dt, horizon=s.dt * (count - len(x) + 1),
                                 impulses=tuple((t - now, jump) for t, jump in s.impulses if t > now + 1e-9)))
        x = np.vstack([x, rest.x[1:]])[:count]
        over = np.flatnonzero(np.abs(x[:, ANGLE]) > FALLEN)
    end = int(over[0]) if len(over) else count - 1
    index = np.minimum(np.arange(count), min(end, len(x) - 1))
    held = {name: getattr(run, name)[np.minimum(index, len(run.t) - 1)] for name in RUN_SERIES}
    held["x"] = x[index]
    held["e"] = held["x"] - held["xhat"]
    return replace(run, t=s.t, **held), float(s.t[end]) if len(over) else None


def until(run: Run, stopped: float | None) -> Run:
    """The part of a run before the fall: where the numbers about it are taken."""
    end = len(run.t) if stopped is None else max(int(np.searchsorted(run.t, stopped)), 2)
    return replace(run, t=run.t[:end], **{name: getattr(run, name)[:end] for name in RUN_SERIES})


def _stage(shown: Run, design: Design) -> Stage:
    """Cart and pole along the run, with the force applied and the force asked for; in fog a hand can take hold of the cart alone."""
    clear = replace(stage(MODEL, shown, design), u=np.hstack([shown.u_applied, shown.u_asked]))
    if not design["fog"]:
        return clear
    hidden = {part.name for part in FOGGY_BODY.parts if part.unseen}
    return replace(clear, body=FOGGY_BODY, held=tuple(each for each in clear.held if hidden.isdisjoint(each[0].parts)))


CART = Setting(
    False, MODEL, lambda design: start_state(design["angle0"], design["error0"]), march, whole, ERROR_LAW_RTOL,
    lambda design, stopped: {"stopped_at": np.inf if stopped is None else stopped, "ceiling": ceiling(CART_PLANT, design["u_max"])}, _stage,
    Sayings(
        text("The pole recovers."), text("The pole does not recover: after this run it does not come to rest."),
        lambda long: text("Whether the pole recovers is not decided within {long:.0f} s.", long=long),
        lambda clipped: text("The force is clipped for {clipped:.2f} s.", clipped=clipped), text("The force is never clipped."),
        lambda meter: text("Separation meter {meter}: what the motor did not give drives the error.", meter=meter),
        text("the compensator is stable while the force is clipped"),
        text("A pole is not in the left half plane, so no start recovers; drag it to the left first.")),
    ("angle0", "error0"), START_GRID_DEG, np.radians(START_GRID_DEG), ANGLE, lambda scenario: scenario, MAP_STEP_S,
    (RECOVERED_NORM, LOST_NORM), lambda design: ceiling(CART_PLANT, design["u_max"]))
