"""Compute a design of lesson 7: a clipped run, the same with known state, error check."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from math import degrees, radians

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Check, Design, Formula, Outcome, Stage
from observer_lab.engine import EngineError, Plant, Scenario, autonomous_error, simulate
from observer_lab.engine.simulation import Run, separation_meter, simulate_until
from observer_lab.engine.systems import sorted_poles
from observer_lab.plants.cart_pendulum import in_fog
from observer_lab.text import NO_WORDS, Text, format_number, joined, text

from ..toolkit.boards import pole_boards, stage
from ..toolkit.gains import gains
from ..toolkit.knobs import kicks
from ..toolkit.latex import matrix
from .ending import Ending, ending_of
from .knobs import APPLIED, HORIZON, MODEL

CART_PLANT, FOGGY_BODY = MODEL.plant, in_fog(MODEL.body)
DT = 0.02
ERROR_LAW_RTOL = 1e-9  # of the error's peak: how well ė = (A − LC)e must hold to count as exact
ANGLE = 1  # index of the angle in the state
RECOVERED_NORM = 0.05  # ‖x‖ at the horizon below which a start has come home (m, rad, m/s, rad/s)
LOST_NORM = 20.0  # ‖x‖ beyond which it has not, whatever comes
FALLEN = radians(45.0)  # where the linear pole counts as fallen
ENDS = (0.5, 1.0, 2.0, 4.0)  # s; a lost run is not followed past the first of them after the pole has fallen
RUN_SERIES = ("x", "xhat", "e", "u_asked", "u_applied", "y", "yhat", "w", "v")
START_GRID_DEG = np.linspace(-20.0, 20.0, 41)  # degrees: angle across, error of its estimate upwards
FALLEN_END = Ending(False, True, 0.0, False)  # of a pole that has passed 45°
NOT_COMPUTED, RECOVERED, NOT_RECOVERED, UNRECOVERABLE = -1, 0, 1, 2


@dataclass(frozen=True, eq=False)
class Starts:
    """Categories (n_error, n_angle) of the starts on START_GRID_DEG × START_GRID_DEG; of a rough map those of the nearest start."""

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

    def at(self, angle: float, error: float) -> int:
        """The category of the start nearest to an angle and an error in degrees."""
        return int(self.values[nearest(error), nearest(angle)])


@dataclass(frozen=True, eq=False)
class Study:
    """One run as it is drawn: `shown` has every instant of the horizon, held once the pole has fallen.

    `promised` is what ė = (A − LC)e says (n_t, n), `known` the states had x been known (n_t, n), `starts` the map; `end` and
    `known_end` say how both go on after the horizon.
    """

    shown: Run
    promised: np.ndarray
    known: np.ndarray
    stopped: float | None
    starts: Starts | None
    end: Ending = FALLEN_END
    known_end: Ending = FALLEN_END


def nearest(value: float) -> int:
    """Index of the grid line nearest to a value in degrees."""
    return int(np.argmin(np.abs(START_GRID_DEG - value)))


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


def scenario_of(design: Design, K: np.ndarray, L: np.ndarray, state_feedback: bool = False) -> Scenario:
    """The clipped loop from the design's own start."""
    x0, xhat0 = start_state(design["angle0"], design["error0"])
    return Scenario(CART_PLANT, K, L, x0=x0, xhat0=xhat0, horizon=HORIZON, dt=DT, u_min=-design["u_max"],
                    u_max=design["u_max"], fed=design["fed"], state_feedback=state_feedback,
                    impulses=kicks(design, MODEL, (DT, HORIZON)), seed=int(design["seed"]))


def compute(design: Design) -> Outcome[Study]:
    """One clipped run, the same start with a known state, and what the error was promised."""
    K, L = gains(design, CART_PLANT)
    run = march(scenario_of(design, K, L))
    shown, stopped = whole(run)
    ideal = march(scenario_of(design, K, L, state_feedback=True))
    known, known_fall = whole(ideal)
    end, known_end = (FALLEN_END if fall is not None else ending_of(each) for each, fall in ((run, stopped), (ideal, known_fall)))
    seen = until(run, stopped)
    poles = poles_of(CART_PLANT, K, L, design["fed"])
    metrics = limited(seen, design["u_max"], poles, end, known_end) | {
        "stopped_at": np.inf if stopped is None else stopped, "ceiling": ceiling(CART_PLANT, design["u_max"])}
    story = Study(shown, autonomous_error(shown), known.x, stopped, None, end, known_end)
    checks = checks_of(metrics, ERROR_LAW_RTOL, text("the compensator is stable while the force is clipped"),
                       float(np.linalg.norm(run.x[-1])))
    boards = pole_boards(MODEL, design, poles["controller"], poles["observer"])
    return Outcome(design, {"K": K, "L": L}, poles, metrics, checks, seen, boards, _stage(shown, design),
                   _formulas(design, K, L, metrics), _live(design, metrics, story, _unstable(poles)), story)


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


def checks_of(m: Mapping[str, float], law_rtol: float, windup: Text, left: float) -> tuple[Check, ...]:
    """Whether the error keeps to its law, the compensator does not wind up, and the start recovers, with what is `left` at the end."""
    return (
        Check("autonomous", text("the error dynamics are autonomous, ė = (A − LC)e"), m["separation_meter"] < law_rtol,
              m["separation_meter"], informative=True),
        Check("windup", windup, m["clipped_rate"] < 0, m["clipped_rate"], informative=True),
        Check("home", text("this start recovers"), m["comes_home"] > 0, left, informative=True))


def _stage(shown: Run, design: Design) -> Stage:
    """Cart and pole along the run, with the force applied and the force asked for; in fog a hand can take hold of the cart alone."""
    clear = replace(stage(MODEL, shown, design), u=np.hstack([shown.u_applied, shown.u_asked]))
    if not design["fog"]:
        return clear
    hidden = {part.name for part in FOGGY_BODY.parts if part.unseen}
    return replace(clear, body=FOGGY_BODY, held=tuple(each for each in clear.held if hidden.isdisjoint(each[0].parts)))


def slowest(outcome: Outcome[Study], name: str) -> float:
    return float(np.max(np.real(outcome.poles[name])))


def amount(value: float) -> str:
    """A number for a sentence; what has left every scale is only said to be large."""
    return "> 1000" if value > 1000 else format_number(value, ".3g") if value > 1e-9 else "0"


def _formulas(design: Design, K: np.ndarray, L: np.ndarray, metrics: Mapping[str, float]) -> tuple[Formula, ...]:
    told = design["fed"] == APPLIED
    rate = metrics["clipped_rate"]
    return (
        Formula("error", r"\dot e = (A-LC)\,e" if told else r"\dot e = (A-LC)\,e + B\,(\mathrm{sat}\,u - u)"),
        Formula("clipped", r"\dot{\hat x} = (A-LC)\,\hat x \pm B\,u_{\max} + L\,y" if told else
                r"\dot{\hat x} = (A-BK-LC)\,\hat x + L\,y",
                text("The compensator while the force is clipped: rightmost eigenvalue {rate:.3g}.", rate=rate)),
        Formula("K", rf"K = {matrix(K)}"),
        Formula("L", rf"L^{{\mathsf T}} = {matrix(L.T)}"),
    )


def _unstable(poles: Mapping[str, np.ndarray]) -> Text:
    """That a pole is on the right, said before all else."""
    if np.max(np.real(poles["controller"])) >= 0:
        return text("A controller pole is not in the left half plane: the loop is unstable.")
    return (text("An observer pole is not in the left half plane: the error does not decay.")
            if np.max(np.real(poles["observer"])) >= 0 else NO_WORDS)


def ends(story: Study) -> Text:
    """How the run on the screen ends, or goes on after it."""
    if story.stopped is not None:
        return text("The pole falls: past 45° at {stopped:.2f} s.", stopped=story.stopped)
    if story.end.home:
        return text("The pole recovers.")
    if story.end.decided:
        return text("The pole does not recover: after this run it does not come to rest.")
    return text("Whether the pole recovers is not decided within {long:.0f} s.", long=story.end.until)


def _live(design: Design, metrics: Mapping[str, float], story: Study, first: Text) -> Text:
    meter, clipped = metrics["separation_meter"], metrics["clipped_for"]
    limit = text("The force is clipped for {clipped:.2f} s.", clipped=clipped) if clipped > 0 else text("The force is never clipped.")
    obeys = (text("The error obeys A − LC all the same.") if clipped > 0 else
             text("So the error obeys A − LC, whichever input the observer gets."))
    wall = claim(obeys, meter, below=ERROR_LAW_RTOL, otherwise=text(
        "Separation meter {meter}: what the motor did not give drives the error.", meter=amount(meter)))
    return joined(first, ends(story), limit, wall)


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
