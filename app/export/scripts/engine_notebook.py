"""Write a notebook on the engine: plant, structure, gains, observer, filter, checked run.

Its plant is the design's own. Where the lesson's run is a plain loop, the run is the page's, and its numbers are asserted.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...course.lesson import Lesson, Outcome
from ...engine.simulation import Run, Scenario, simulate
from ...text import Text, text
from .literals import array_text
from .script import AGREED, INSTANTS, ScriptError, notebook_of

__all__ = ["engine_notebook"]

INTRODUCTION = text("This notebook uses the lab's own engine: arrays in, frozen records out. Ten lines lead from a plant to everything; "
                    "change any of them and run it again. help(simulate) describes its arguments.")
GIVEN = text("What is given")
TEN = text("Ten lines to everything")
CHECKED = text("What came out")
OWN_RUN = text("The gains and the run are those of the page.")
ANY_RUN = text("The page shows a run of another kind; here the same plant runs under gains to begin with.")
PLANT_COMMENT = text("the plant")
STRUCTURE = text("what u moves, what y shows, and what neither does")
GAIN_COMMENT = text("u = r − K x̂")
OBSERVER_COMMENT = text("e = x − x̂, de/dt = (A − L C) e")
LOOP = text("poles, compensator, separation")
FILTER = text("the best estimate under noise")
RUN_COMMENT = text("plant, observer and controller")
FILTERED = text("the filter on the same readings")
DRAWN_COMMENT = text("true states, estimates, the filter's means")
VERIFIED = text("largest difference between e and the solution of de/dt = (A − L C) e")
HELD_COMMENT = text("later the page holds what has fallen or left every bound")
NO_PLANT = text("The plant of this design is not linear, and the notebook on the engine begins with A, B and C; take the other notebook.")


def engine_notebook(lesson: Lesson, outcome: Outcome, token: str, language: str = "en") -> str:
    """The notebook of a design, in the words of a language. Raises ScriptError where the lesson's plant is not linear."""
    words = lesson.words[language]
    run = outcome.run if lesson.code is None else None
    given = "\n".join(_of_the_run(run.scenario) if run is not None else _of_the_plant(lesson, outcome))
    note = OWN_RUN if run is not None else ANY_RUN
    cells = [("markdown", f"# {words.title}\n\n**{words.question}**\n\n{INTRODUCTION(language)} {note(language)}\n\n`{token}`"),
             ("markdown", f"## {GIVEN(language)}"), ("code", given),
             ("markdown", f"## {TEN(language)}"), ("code", "\n".join(_ten(run is not None, language))),
             ("markdown", f"## {CHECKED(language)}"), ("code", "\n".join(_proof(run, language)))]
    return notebook_of(cells)


def _ten(of_the_page: bool, language: str) -> Iterator[str]:
    """The ten lines."""
    lines: tuple[tuple[str, Text], ...] = (
        ("plant = Plant(A, B, C, D, dt=period)", PLANT_COMMENT),
        ("moved, seen = controllability(plant), observability(plant)", STRUCTURE),
        ("K = K_page" if of_the_page else "K = starting_feedback(plant).gain", GAIN_COMMENT),
        ("L = L_page" if of_the_page else "L = starting_observer(plant).gain", OBSERVER_COMMENT),
        ("loop = closed_loop(plant, K, L, model=model)" if of_the_page else "loop = closed_loop(plant, K, L)", LOOP),
        ("kf = KalmanFilter.from_plant(model or plant, W, V, dt=h, G=G)" if of_the_page else
         "kf = KalmanFilter.from_plant(plant, W, V, dt=h, G=G)", FILTER),
        ("run = simulate(Scenario(plant, K, L, dt=h, **setting))", RUN_COMMENT),
        ("track = kf.run(Belief(np.zeros(kf.n), np.eye(kf.n)), run.y, run.u_applied)", FILTERED),
        ('plt.plot(run.t, run.x, "-", run.t, run.xhat, "--", run.t, track.means, ":")', DRAWN_COMMENT),
        ("meter = separation_meter(run) if kf.n == plant.n else None", VERIFIED))
    wide = max(len(code) for code, _ in lines)
    for code, said in lines:
        yield f"{code:{wide}}  # {said(language)}"


def _imports() -> str:
    return ("import numpy as np\nfrom matplotlib import pyplot as plt\n\n"
            "from observer_lab.engine import Belief, KalmanFilter, Plant, Scenario, closed_loop, controllability, observability, simulate\n"
            "from observer_lab.engine.design import starting_feedback, starting_observer\n"
            "from observer_lab.engine.simulation import separation_meter\n")


def _of_the_run(s: Scenario) -> Iterator[str]:
    """The page's own scenario."""
    yield _imports()
    for name in "ABCD":
        yield array_text(name, getattr(s.plant, name))
    yield f"period, h = {float(s.plant.dt)!r}, {s.dt!r}  # s"
    yield "model = None"
    if s.model is not s.plant:
        for name in "ABCD":
            yield array_text(f"{name}m", getattr(s.model, name))
        yield "model = Plant(Am, Bm, Cm, Dm, dt=period)"
    yield array_text("K_page", s.K)
    yield array_text("L_page", s.L)
    for name in _noisy(s):
        yield array_text(f"{name}_page", getattr(s, name))
    chosen = {"W": "np.eye(B.shape[1])", "V": "np.eye(len(C))", "G": "B if model is None else Bm"}
    chosen |= {name: f"{name}_page" for name in _noisy(s)}
    yield "\n".join(f"{name} = {value}" for name, value in chosen.items())
    yield array_text("x0", s.x0)
    yield array_text("xhat0", s.xhat0)
    yield array_text("reference", s.reference) if s.reference is not None else "reference = None"
    yield f"u_min, u_max = np.array({_limits(s.u_min)}), np.array({_limits(s.u_max)})"
    kicks = ", ".join(f"({float(t)!r}, np.array({np.asarray(jump).tolist()}))" for t, jump in s.impulses)
    yield f"impulses = ({kicks}{',' if kicks else ''})"
    yield (f"setting = dict(model=model, x0=x0, xhat0=xhat0, horizon={s.horizon!r}, sampled={bool(s.sampled)}, reference=reference,\n"
           f"               state_feedback={bool(s.state_feedback)}, u_min=u_min, u_max=u_max, fed={s.fed!r}, delay={s.delay!r},\n"
           f"               seed={s.seed}, impulses=impulses{''.join(f', {one}={one}_page' for one in _noisy(s))})")


def _noisy(s: Scenario) -> list[str]:
    """Which of W, V and G the page has set; without noise of its own the filter gets units."""
    return [name for name in "WVG" if getattr(s, name) is not None and (name != "G" or s.W is not None)]


def _limits(limit: np.ndarray) -> str:
    return "[" + ", ".join(repr(float(v)) if np.isfinite(v) else f"{'-' if v < 0 else ''}np.inf" for v in limit) + "]"


def _of_the_plant(lesson: Lesson, outcome: Outcome) -> Iterator[str]:
    """The plant that the lesson's equations start from, and a run to begin with."""
    code = lesson.code(outcome) if lesson.code is not None else None
    stated = () if code is None else code.given
    known = {given.name: np.asarray(given.value, dtype=float) for given in stated if given.name in tuple("ABCD")}
    plant = None if outcome.run is None else outcome.run.scenario.plant
    if plant is not None:
        known, period = {name: np.asarray(getattr(plant, name)) for name in "ABCD"}, float(plant.dt)
    else:
        period = code.period if code is not None else 0.0
    if not {"A", "C"} <= set(known):
        raise ScriptError(NO_PLANT)
    A, C = known["A"], known["C"]
    B = known.get("B", np.zeros((len(A), 1)))
    yield _imports()
    for name, value in (("A", A), ("B", B), ("C", C), ("D", known.get("D", np.zeros((len(C), B.shape[1]))))):
        yield array_text(name, value)
    yield f"period = {period!r}  # s" if period else "period = 0.0"
    yield "rates = np.abs(np.linalg.eigvals(A))"
    yield "h = period or 0.02 / max(np.median(rates), 1e-3)"
    yield "W, V, G = np.eye(B.shape[1]), np.eye(len(C)), B"
    yield "setting = dict(x0=np.ones(len(A)), horizon=400 * h)"


def _alike(run: Run) -> int:
    """Grid points for which the page shows the engine's own run: a lesson may hold what has fallen or left every bound."""
    again = simulate(run.scenario)
    count = min(len(again.t), len(run.t))
    apart = np.abs(again.x[:count] - run.x[:count]).max(axis=1) + np.abs(again.xhat[:count] - run.xhat[:count]).max(axis=1)
    largest = max(float(np.abs(again.xhat).max()), float(np.abs(again.x).max()))
    return max(int(np.argmax(apart > 1e-9 * largest)) if np.any(apart > 1e-9 * largest) else count, 1)


def _proof(run: Run | None, language: str) -> Iterator[str]:
    yield 'print(f"{moved.rank} of {plant.n} states are moved, {seen.rank} are seen; poles of the loop:", np.round(loop.poles, 4))'
    if run is None:
        yield "assert meter < 1e-6, 'u reaches e'"
        yield "print('Observer Lab: e = x - xhat goes its own way, whatever the controller does.')"
        return
    count = _alike(run)
    at = np.unique(np.linspace(0, count - 1, INSTANTS).astype(int))
    yield f"at = {at.tolist()}" + (f"  # {HELD_COMMENT(language)}" if count < len(run.t) else "")
    for name in ("x", "xhat", "u_asked", "u_applied", "y"):
        values = getattr(run, name)[:count]
        yield array_text("page", values[at])
        yield f"assert np.abs(run.{name}[at] - page).max() <= {AGREED!r} * max({float(np.abs(values).max())!r}, 1e-12), {name!r}"
    yield f"print('Observer Lab: the run agrees with the page to {AGREED:g}.')"
