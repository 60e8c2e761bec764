"""Compute a design of lesson 3, with ranks reported together with distances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from observer_lab.course.lesson import Check, Design, Formula, Outcome, Stage
from observer_lab.engine.structure import Mode
from observer_lab.text import Text, format_number, text

from ..toolkit.latex import matrix, number, pole_words
from .bodies import body_of
from .cases import PLANT_CASES, Case, Sensed, sensed
from .criteria import Criterion, criteria
from .initial_state import SIGMAS_FOR_95_PERCENT, Belief, Rebuilt, TwoStarts, learn, rebuild, two_starts
from .knob_sweep import Sweep, sweep
from .knobs import DECK_CASE, MANY_MASSES

NEARLY_HIDDEN_DISTANCE = 0.02  # a mode nearer than this to being hidden (in typical sizes) is called nearly hidden


@dataclass(frozen=True, eq=False)
class Setting:
    """A design on one of the lesson's plants or on a person's own: the plant, its sensors, block rows of O, the sweep of a knob."""

    case: Case
    sensed: Sensed
    rows: int
    sweep: Sweep | None = None


@dataclass(frozen=True, eq=False)
class Study:
    """All that a design leads to; `rank` is that of the whole O at the tolerance; no sweep where no knob moves a sensor."""

    case: Case
    sensed: Sensed
    rebuilt: Rebuilt
    belief: Belief
    start: np.ndarray
    criteria: tuple[Criterion, ...]
    weakest: Mode
    rank: int
    sweep: Sweep | None
    twins: TwoStarts


def judged(found: Study) -> str:
    """hidden, near, unresolved or clear."""
    if not found.sensed.seen.observable:
        return "hidden"
    if found.weakest.distance < NEARLY_HIDDEN_DISTANCE:
        return "near"
    return "clear" if found.belief.known == found.sensed.plant.n else "unresolved"


def cases_setting(design: Design) -> Setting:
    """The lesson's own plants."""
    case = PLANT_CASES[design["plant"]]
    name = {DECK_CASE: "rows_deck", MANY_MASSES: "rows_many"}.get(case.id, "rows_two")
    return Setting(case, sensed(design), int(design[name]), sweep(design))


def compute(setting_of: Callable[[Design], Setting], design: Design) -> Outcome[Study]:
    """O and its rank, every mode's distance, x(0) from derivatives, and x(0) from noisy y over a growing window."""
    here = setting_of(design)
    case, s, seed = here.case, here.sensed, int(design["seed"])
    start = np.array(case.start[:s.plant.n])
    built = rebuild(s, start, min(here.rows, s.plant.n), design["reading"], design["tolerance"], seed)
    belief = learn(s, start, design["noise"], seed)
    weakest = min(s.seen.modes, key=lambda m: (m.visible, m.distance))
    full = s.seen.matrix_rank(design["tolerance"]) if s.seen.singular_values[0] > 0 else 0
    found = Study(case, s, built, belief, start, criteria(s, full), weakest, full, here.sweep, two_starts(s, start, design))
    metrics = _metrics(found)
    return Outcome(design, {}, {"plant": np.array([m.pole for m in s.seen.modes])}, metrics, _checks(metrics),
                   stage=_stage(design, found), formulas=_formulas(found), words=_live(found, metrics), study=found)


def _cloud(found: Study) -> np.ndarray:
    """Middle, half axes, rotation and truth of the drawn 95 % ellipsoid over time (n_t, 13): right, away, up."""
    count = len(found.belief.mean)
    cov, mean = np.zeros((count, 3, 3)), np.zeros((count, 3))
    truth = np.zeros(3)
    places = [(axis, i) for axis, i in enumerate(found.case.drawn) if i is not None and i < len(found.start)]
    axes, states = [a for a, _ in places], [i for _, i in places]
    cov[:, np.array(axes)[:, None], axes] = found.belief.P[:, np.array(states)[:, None], states]
    mean[:, axes] = found.belief.mean[:, states]
    truth[axes] = found.start[states]
    values, vectors = np.linalg.eigh(cov)
    vectors = vectors * np.where(np.linalg.det(vectors) < 0, -1.0, 1.0)[:, None, None]
    turns = Rotation.from_matrix(vectors).as_quat()[:, [3, 0, 1, 2]]
    return np.hstack([mean, SIGMAS_FOR_95_PERCENT[len(axes) - 1] * np.sqrt(np.maximum(values, 0.0)), turns, np.tile(truth, (count, 1))])


def _stage(design: Design, found: Study) -> Stage:
    """The plant along its free motion, its ghost along the estimate from the data so far, sensors, and the cloud.

    The deck may have the one of the second start beside it, and then no ghost.
    """
    s, case = found.sensed, found.case
    n = s.plant.n
    if case.id == DECK_CASE:
        extra = [design["left"], design["right"], *(float(design[f"{k}_on"]) for k in ("left", "right", "across"))]
    else:
        row = s.plant.C[0] / max(float(np.linalg.norm(s.plant.C[0])), 1e-300)
        extra = [0.0 if i is None or i >= n else float(row[i]) for i in case.drawn]
    size = np.array(case.scale) if case.id == DECK_CASE else np.ones(n)  # columns stand in typical sizes
    tail = np.hstack([np.tile(extra, (len(s.t), 1)), _cloud(found)])
    true = np.hstack([s.powers @ found.start * size, tail])
    if case.id == DECK_CASE and design["twin"]:
        return Stage(body_of(case.id, n, two=True), s.t, np.hstack([true, found.twins.states[1] * size]))
    guess = np.hstack([np.einsum("kij,kj->ki", s.powers, found.belief.mean) * size, tail])
    return Stage(body_of(case.id, n), s.t, true, guess)


def _metrics(found: Study) -> dict[str, float]:
    s, n = found.sensed, found.sensed.plant.n
    return {
        "rank": float(found.rank), "states": float(n), "rows": float(found.rebuilt.rows), "rank_built": float(found.rebuilt.rank),
        "weakest": found.weakest.distance if found.weakest.visible else 0.0, "hidden": float(n - s.seen.rank),
        "known": float(found.belief.known), "longest": float(found.belief.halves[-1, 0]),
        "rebuild_error": float(np.linalg.norm(found.rebuilt.guess - found.start) / np.linalg.norm(found.start)),
        "least_energy": float(s.heard[-1, 0]), "reading_gap": found.twins.gap,
    }


def _checks(m: dict[str, float]) -> tuple[Check, ...]:
    return (
        Check("rank", text("rank(O) = n at this tolerance"), m["rank"] == m["states"], m["rank"], informative=True),
        Check("seen", text("every mode leaves a trace"), m["hidden"] == 0, m["weakest"], informative=True),
        Check("clear", text("no mode is nearly hidden"), m["weakest"] >= NEARLY_HIDDEN_DISTANCE, m["weakest"], informative=True),
        Check("known", text("every direction of x(0) known to a tenth"),
              m["known"] == m["states"], m["known"], informative=True),
    )


def _formulas(found: Study) -> tuple[Formula, ...]:
    s, built = found.sensed, found.rebuilt
    n, p, k = s.plant.n, s.plant.p, built.rows
    power = "" if k == 1 else "A" if k == 2 else rf"A^{{{k - 1}}}"
    last = built.matrix[-p:]
    whole = (Formula("O", rf"\mathcal O_{{{k}}} = {matrix(built.matrix)}") if n == 2 else
             Formula("O", rf"C{power} = {matrix(last)}") if n <= 6 else
             Formula("O", rf"\left\| C{power} \right\| = {number(float(np.linalg.norm(last)))}"))
    return (whole, Formula("solve", r"\mathcal O_k\, x(0) = \begin{bmatrix} y \\ \dot y \\ \vdots \end{bmatrix}_{t=0}"),
            Formula("rank", rf"\mathrm{{rank}}\,\mathcal O_{{{k}}} = {built.rank}, \quad n = {n}"),
            Formula("P", r"P(t) = \left( I + W(t)/v \right)^{-1}"))


def _live(found: Study, m: dict[str, float]) -> Text:
    n, rank, known = int(m["states"]), int(m["rank"]), int(m["known"])
    verdict, d = judged(found), format_number(m["weakest"], ".2g")
    if verdict == "hidden":
        poles = pole_words([p for p in found.sensed.seen.unobservable if p.imag >= 0])
        return text("Not observable: {poles} leave no trace in y. Known to a tenth: {known} of {n} directions.",
                    poles=poles, known=known, n=n)
    if verdict == "near":
        mode = pole_words([complex(found.weakest.pole.real, abs(found.weakest.pole.imag))])
        return text("Nearly unobservable: the mode {mode} is {d} away from being hidden, while rank(O) = {rank} "
                    "of {n}.",
                    mode=mode, d=d, rank=rank, n=n)
    if verdict == "unresolved":
        return text("No mode is hidden (nearest: {d}), yet this run fixes only {known} of {n} directions to a "
                    "tenth; rank(O) = {rank}.",
                    d=d, known=known, n=n, rank=rank)
    return text("Observable: the nearest mode is {d} from being hidden, and each of the {n} directions is known to a "
                "tenth.",
                d=d, n=n)
