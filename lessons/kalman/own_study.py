"""Compute lesson 9 on an own plant: records of it, and how they are shown."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.course.lazy import LazyValue
from observer_lab.course.lesson import Design, Formula, Stage
from observer_lab.engine import Belief
from observer_lab.engine.filters import FilterTrial, simulate_filter
from observer_lab.plants import Model
from observer_lab.plants.signal_names import signal_name, with_unit
from observer_lab.text import Text, symbol, text

from ..toolkit.gains import judged, noise_units
from ..toolkit.latex import gain_words, number
from .filters import Truth, Watcher
from .knobs import UPDATE
from .study import Look, Setting, Study

RUN_SAMPLES, UNTESTED_SAMPLES, GAIN_SAMPLES = 160, 40, 80
FLOOR = 1e-9  # share of each variance
MAX_TABLE_STATES, DRAWN_ENTRIES = 10, 3  # rows of the table of one step, entries of the gain over time


@dataclass(frozen=True, eq=False)
class OwnStudy(Study):
    """A record of a person's own plant, held by the filter that knows the truth."""

    found: FilterTrial


def studied(model: Model, design: Design, seed: int) -> OwnStudy:
    """The filter of a design on the record of a seed. Raises EngineError where there is no filter."""
    G, W, V = noise_units(model)
    kick = (design["kick"], np.array(model.kick)) if design["kick"] >= 0 else None
    found = simulate_filter(model.plant, G, design["w"] ** 2 * W, design["v"] ** 2 * V, model.horizon / RUN_SAMPLES, RUN_SAMPLES,
                            believed=(design["q"], design["r"]), seed=seed, kick=kick)
    run, schedule = found.run, found.track.schedule
    if len(run.t) < 2 * UNTESTED_SAMPLES:
        raise KnobError(text("The plant grows without bound before the filter can be judged."))
    start = Belief(np.zeros(model.plant.n), schedule.prior[0])
    watcher = Watcher(found.filter, found.steady, schedule, start, UNTESTED_SAMPLES, LazyValue(lambda: None), FLOOR)
    return OwnStudy(Truth(run.t, run.x, run.y, run.u_applied), watcher, found.track, found)


def own_setting(model: Model) -> Setting[OwnStudy]:
    """A person's own plant: no true noise is carried as a state, and no figure tells of the deck."""
    return Setting(
        lambda design, seed: studied(model, design, seed),
        lambda _, s: Stage(model.body, s.truth.t, s.truth.x, s.track.means, s.truth.u),
        lambda _, s: {"nis_expected": s.found.expected}, _formulas, _live, own_look(model))


def own_look(model: Model) -> Look:
    """Its own names and units; the largest entries of the gain."""
    plant, first = model.plant, model.plant.output_names[0]
    return Look(
        [with_unit(plant, name) for name in plant.state_names[:MAX_TABLE_STATES]], 1.0, ".4g", judged(model),
        [signal_name(plant, name) for name in plant.output_names], (signal_name(plant, first), plant.unit(first)),
        text("largest entries of the gain M"), _largest, GAIN_SAMPLES,
        (text("NIS of a sample"), text("NEES of the states")),
        {name: (0.05 * dof, 20.0 * dof) for name, dof in (("nis", plant.p), ("nees", plant.n))}, ".3g",
        lambda *_: text("Each test flags a right filter in a few records of a hundred."))


def _largest(goal: np.ndarray) -> list[tuple[int, int, str]]:
    places = (divmod(int(place), goal.shape[1]) for place in np.argsort(np.abs(goal).ravel())[::-1][:DRAWN_ENTRIES])
    return [(i, j, symbol(f"M{i + 1}{j + 1}")) for i, j in places]


def _formulas(design: Design, s: OwnStudy) -> tuple[Formula, ...]:
    k, schedule = int(design["k"]), s.track.schedule
    gain = Formula("M", gain_words(rf"M_{{{k}}}", schedule.gains[int(schedule.index[k])]))
    if design["phase"] != UPDATE:
        return (gain,)
    return (gain, Formula("nis", rf"\mathrm{{NIS}}_{{{k}}} = \nu^{{\mathsf T}} S^{{-1}} \nu = {number(float(s.nis[k]))}"))


def _live(s: OwnStudy) -> Text:
    return text("NIS {nis_mean:.3g} in this record, {expected:.3g} on average ({p} expected); NEES "
                "{nees_mean:.3g} ({n} expected).",
                nis_mean=s.test.nis.mean, expected=s.found.expected, p=s.truth.y.shape[1], nees_mean=s.settled.mean, n=s.truth.x.shape[1])
