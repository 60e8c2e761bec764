"""Compute lesson 9 on an own plant: one filtered record and its tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Design, Formula, Outcome, Stage
from observer_lab.engine import innovation_test, nees, nis
from observer_lab.engine.filters import FilterTrial, InnovationTest, SquaredError, simulate_filter
from observer_lab.plants import Model
from observer_lab.text import Text, text

from ..toolkit.gains import noise_units
from ..toolkit.latex import gain_words, number
from .knobs import UPDATE
from .study import Trials, checks

RUN_SAMPLES, UNTESTED_SAMPLES, LAST_SAMPLE = 160, 40, 60


@dataclass(frozen=True, eq=False)
class Study:
    """One record through one filter, and what judges it, found when it is looked at."""

    found: FilterTrial
    trials: Trials | None = None

    @cached_property
    def test(self) -> InnovationTest:
        """Of the innovations once the filter has settled."""
        return innovation_test(self.found.track.innovations[UNTESTED_SAMPLES:], self.found.track.S[UNTESTED_SAMPLES:])

    @cached_property
    def nis(self) -> np.ndarray:
        """νᵀ S⁻¹ ν at every sample."""
        return nis(self.found.track.innovations, self.found.track.S).values

    @cached_property
    def settled(self) -> SquaredError:
        """NEES once the filter has settled."""
        return self._nees(slice(UNTESTED_SAMPLES, None))

    @cached_property
    def nees(self) -> np.ndarray:
        """eᵀ P⁻¹ e at every sample."""
        return np.concatenate([self._nees(slice(UNTESTED_SAMPLES)).values, self.settled.values])

    def _nees(self, part: slice) -> SquaredError:
        track = self.found.track
        return nees(self.found.run.x[part], track.means[part], _solid(track.covariances[part]))


def tried(model: Model, design: Design, seed: int) -> FilterTrial:
    """The filter of a design on the record of a seed. Raises EngineError where there is no filter."""
    G, W, V = noise_units(model)
    kick = (design["kick"], np.array(model.kick)) if design["kick"] >= 0 else None
    found = simulate_filter(model.plant, G, design["w"] ** 2 * W, design["v"] ** 2 * V, model.horizon / RUN_SAMPLES,
                            RUN_SAMPLES,
                         believed=(design["q"], design["r"]), seed=seed, kick=kick)
    if len(found.run.t) < 2 * UNTESTED_SAMPLES:
        raise KnobError(text("The plant grows without bound before the filter can be judged."))
    return found


def compute(model: Model, design: Design) -> Outcome[Study]:
    """The record filtered, and judged when that is looked at."""
    study = Study(tried(model, design, int(design["seed"])))
    found = study.found
    metrics = LazyMap(lambda: _metrics(study))
    stage = Stage(model.body, found.run.t, found.run.x, found.track.means, found.run.u_applied)
    poles = np.log(np.where(np.abs(found.steady.poles) > 1e-12, found.steady.poles, 1e-12)) * RUN_SAMPLES / model.horizon
    return Outcome(design, {"M": found.track.schedule.gains[-1], "M_riccati": found.steady.filter_gain}, {"filter": poles}, metrics,
                   LazySequence(lambda: checks(study.test, study.settled, metrics["gain_gap"])), None, (), stage,
                   LazySequence(lambda: _formulas(design, study)), LazyValue(lambda: _live(model, study, metrics)), study)


def _metrics(s: Study) -> dict[str, float]:
    return {"nis_mean": s.test.nis.mean, "nis_expected": s.found.expected, "nees_mean": s.settled.mean,
            "white_p": s.test.whiteness.p_value, "gain_gap": float(s.found.distance[-1]), "riccati_residual": s.found.steady.residual}


def _formulas(design: Design, s: Study) -> tuple[Formula, ...]:
    k, schedule = int(design["k"]), s.found.track.schedule
    gain = Formula("M", gain_words(rf"M_{{{k}}}", schedule.gains[int(schedule.index[k])]))
    if design["phase"] != UPDATE:
        return (gain,)
    return (gain, Formula("nis", rf"\mathrm{{NIS}}_{{{k}}} = \nu^{{\mathsf T}} S^{{-1}} \nu = {number(float(s.nis[k]))}"))


def _live(model: Model, s: Study, m: Mapping[str, float]) -> Text:
    return text("NIS {nis_mean:.3g} in this record, {expected:.3g} on average ({p} expected); NEES "
                "{nees_mean:.3g} ({n} expected).",
                nis_mean=m["nis_mean"], expected=s.found.expected, p=model.plant.p, nees_mean=m["nees_mean"], n=model.plant.n)


def _solid(P: np.ndarray) -> np.ndarray:
    """Covariances with a floor of 1e-9 of each variance: a state known exactly has no NEES."""
    spread = np.maximum(np.diagonal(P, axis1=1, axis2=2), 1e-300)
    return P + 1e-9 * spread[:, :, None] * np.eye(P.shape[1])
