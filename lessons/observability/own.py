"""Fit lesson 3 to the user's own plant: outputs on and off, states in typical sizes."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.knobs import Knob, KnobError, Number, Switch
from observer_lab.course.lesson import Design, Lesson, Outcome, Stage
from observer_lab.plants import Model
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import text

from ..toolkit.gains import sizes
from .bodies import body_of
from .cases import Case, sensed_by
from .criteria import criteria
from .derive import derived
from .initial_state import learn, rebuild
from .knobs import KNOBS
from .study import Study, checks_of, cloud_of, formulas_of, live_of, metrics_of
from .two_starts import two_starts

SWITCHES = 6  # outputs with a switch; what a plant has beyond these stays on
OBSERVED_INSTANTS, FEW_INSTANTS = 120, 50  # instants, for few states and for many
MAX_GROWTH_EXPONENT = 5.0  # how many times e a run may grow
SHARED = ("tolerance", "reading", "noise", "criterion", "apart", "seed")  # knobs taken from the lesson as they are


def case_of(model: Model) -> Case:
    """The plant before its sensors. Raises KnobError for a single state, which no ellipse can show."""
    plant, n = model.plant, model.plant.n
    if n < 2:
        raise KnobError(text("With a single state there is nothing to distinguish; this lesson needs two states at "
                             "least."))
    fastest = float(np.real(plant.poles).max())
    horizon = min(model.horizon, MAX_GROWTH_EXPONENT / fastest) if fastest > 0 else model.horizon
    scale = tuple(abs(v) or 1.0 for v in model.x0)
    start = tuple((0.75, -0.6, 0.5, -0.4, 0.7)[i % 5] for i in range(n))
    return Case(
        "own",
        model.label,
        plant.state_names,
        scale,
        start,
        horizon,
        OBSERVED_INSTANTS if n <= 12 else FEW_INSTANTS,
        (0, 2 if n > 2 else None, 1),
        (0, 1),
        tuple(plant.unit(name) for name in plant.state_names),
        labels=tuple(signal_name(plant, name) for name in plant.state_names),
    )


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """A switch for each output, rows of O, and what the lesson asks everywhere."""
    names = model.plant.output_names[:SWITCHES]
    return (
        *(Switch(f"on{i}", "", text("sensor {name}", name=signal_name(model.plant, name)), default=True,
                 hint=text("On or off.")) for i, name in enumerate(names)),
        Number("rows", "k", text("block rows of O"), low=1, high=model.plant.n, default=1, scale="integer",
               hint=text("One step adds the next row C Aᵏ, that is, one more derivative of y.")),
        *(knob for knob in KNOBS if knob.name in SHARED),
    )


def compute(model: Model, case: Case, design: Design) -> Outcome[Study]:
    """The same questions as to the lesson's plants, in typical sizes. Raises EngineError where powers of A overflow."""
    plant, n, seed = model.plant, model.plant.n, int(design["seed"])
    scale = np.array(case.scale)
    on = [i for i in range(plant.p) if i >= SWITCHES or design[f"on{i}"]]
    C = plant.C[on] * scale / sizes(model)[on][:, None] if on else np.zeros((1, n))
    s = sensed_by(case, n, np.ascontiguousarray(plant.A * scale / scale[:, None]).tobytes(), np.ascontiguousarray(C).tobytes())
    start = np.array(case.start)
    full = s.seen.matrix_rank(design["tolerance"]) if s.seen.singular_values[0] > 0 else 0
    found = Study(case, s, rebuild(s, start, int(design["rows"]), design["reading"], design["tolerance"], seed),
                  learn(s, start, design["noise"], seed), start, criteria(s, full),
                  min(s.seen.modes, key=lambda m: (m.visible, m.distance)),
                  full, None, two_starts(s, start, design))
    metrics = metrics_of(found)
    return Outcome(design, {}, {"plant": np.array([m.pole for m in s.seen.modes])}, metrics, checks_of(metrics),
                   stage=_stage(model, found), formulas=formulas_of(found), words=live_of(found, metrics), study=found)


def _stage(model: Model, found: Study) -> Stage:
    """Columns in typical sizes with the needle along the first sensor that is on, and the cloud of states."""
    s, n = found.sensed, found.sensed.plant.n
    row = s.plant.C[0] / max(float(np.linalg.norm(s.plant.C[0])), 1e-300)
    needle = [0.0 if i is None else float(row[i]) for i in found.case.drawn]
    tail = np.hstack([np.tile(needle, (len(s.t), 1)), cloud_of(found)])
    true = np.hstack([s.powers @ found.start, tail])
    guess = np.hstack([np.einsum("kij,kj->ki", s.powers, found.belief.mean), tail])
    return Stage(body_of("own", n), s.t, true, guess)


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant; the tasks turn sensors of the lesson's plants and stay with them."""
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, model, case_of(model)), tasks=(),
                   derived=partial(derived))
