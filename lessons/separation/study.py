"""What a design of lesson 4 leads to: gains on the believed plant, the loop of 2n poles on the true one, one run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from app.engine import Plant, Scenario, closed_loop, simulate
from app.engine.feedback import ClosedLoop
from app.engine.simulation import separation_meter
from app.lesson.lesson import Check, Design, Formula, Outcome
from app.plants import Model, platform
from app.text.words import Text

from ..toolkit.boards import pole_boards, stage
from ..toolkit.gains import gains
from ..toolkit.knobs import kicks
from ..toolkit.latex import gain_words, tiny
from .knobs import MODEL


@dataclass(frozen=True, eq=False)
class Setting:
    """The plant of the lesson: what really moves and what is believed of it, in a design; noise of a design.

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


@lru_cache(maxsize=64)
def believed(error_percent: float) -> Plant:
    """The deck as the designer believes it: every spring stiffer by the error."""
    p, factor = platform.Parameters(), 1 + error_percent / 100
    return platform.deck(replace(p, kz=p.kz * factor, kx=p.kx * factor))


DECK = Setting(
    MODEL, lambda design: MODEL.plant, lambda design: believed(design["stiffness_error"]),
    lambda design: design["delay"] / 1000,
    lambda design: None if design["noise"] == 0 else (design["noise"] / 1000) ** 2 * MODEL.dt,
    platform.deck_disturbance()[:, :1], MODEL.plant.C[:1],
    (Text("from ground height to velocity VL", "地面高度到速度 VL 的增益"), "|VL/zg| [1/s]"), np.geomspace(0.1, 30.0, 300))
EXACT = 1e-9  # union of spectra: agreement asked of them


def compute(here: Setting, design: Design) -> Outcome[ClosedLoop]:
    """Gains on the believed plant, the 2n-pole loop on the true one, one run."""
    model, truth, belief = here.model, here.truth(design), here.belief(design)
    K, L = gains(design, belief, model)
    loop = closed_loop(truth, K, L, model=belief)
    limit = design["u_max"] if design["limited"] else None
    run = simulate(Scenario(
        truth, K, L, model=belief, x0=model.x0, xhat0=model.guess, horizon=model.horizon, dt=model.dt,
        u_min=None if limit is None else -limit, u_max=limit, fed="commanded", delay=here.delay(design),
        impulses=kicks(design, model), seed=int(design["seed"]), V=here.noise(design)))
    meter = separation_meter(run)
    slow, fast = float(max(loop.controller_poles.real)), float(max(loop.observer_poles.real))
    metrics = {
        "union_error": loop.union_error, "separation_meter": meter, "slowest_controller": slow,
        "slowest_observer": fast, "largest_input": float(np.max(np.abs(run.u_asked))),
        "slowest_loop": float(max(loop.poles.real)),
    }
    same_union = loop.union_error <= EXACT or loop.polynomial_error <= EXACT
    checks = (
        Check("union", Text("the 2n poles are the union of both sets", "2n 个极点正是两组极点的并集"), same_union,
              loop.union_error),
        Check("compensator", Text("the compensator itself is stable", "补偿器自身稳定"), loop.compensator_stable,
              float(max(loop.compensator_poles.real))),
    )
    return Outcome(
        design, {"K": K, "L": L},
        {"controller": loop.controller_poles, "observer": loop.observer_poles, "loop": loop.poles,
         "compensator": loop.compensator_poles},
        metrics, checks, run, pole_boards(model, design, loop.controller_poles, loop.observer_poles,
                                          belief.A - L @ belief.C),
        stage(model, run), _formulas(K, L), _live(loop, meter), loop)


def _formulas(K: np.ndarray, L: np.ndarray) -> tuple[Formula, ...]:
    return (
        Formula("loop", r"\frac{d}{dt}\begin{bmatrix} x \\ e \end{bmatrix} = \begin{bmatrix} A-BK & BK \\ 0 & A-LC "
                        r"\end{bmatrix} \begin{bmatrix} x \\ e \end{bmatrix}"),
        Formula("K", gain_words("K", K)),
        Formula("L", gain_words(r"L^{\mathsf T}", L.T)),
    )


def _live(loop: ClosedLoop, meter: float) -> Text:
    union = (Text(f"The {len(loop.poles)} poles of the loop are the union of both boards to about {tiny(loop.union_error)}.",
                  f"闭环的 {len(loop.poles)} 个极点就是两块板上极点的并集，误差约 {tiny(loop.union_error)}。")
             if loop.union_error < 1e-6 else
             Text(f"The {len(loop.poles)} poles of the loop differ from the boards by {100 * loop.union_error:.1f} %.",
                  f"闭环的 {len(loop.poles)} 个极点与两块板上的极点相差 {100 * loop.union_error:.1f} %。"))
    wall = (Text(" Separation meter: 0.", " 分离度量：0。") if meter < 1e-8 else
            Text(f" Separation meter: {meter:.2g}; the error no longer lives by itself.",
                 f" 分离度量：{meter:.2g}；误差不再独自演化。"))
    stable = (Text("", "") if loop.compensator_stable else
              Text(" The compensator by itself is unstable.", " 补偿器自身是不稳定的。"))
    return Text(union.en + wall.en + stable.en, union.zh + wall.zh + stable.zh)
