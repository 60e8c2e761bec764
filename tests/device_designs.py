"""Draw random designs of a lesson that a device can run."""

from __future__ import annotations

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.devices import DeviceError
from observer_lab.engine import EngineError

CHANGED = 3  # knobs of a random design


def random_value(knob, random: np.random.Generator) -> object:
    """A value between the knob's limits or one of its options, else its default."""
    low, high = getattr(knob, "low", None), getattr(knob, "high", None)
    if isinstance(low, int | float) and isinstance(high, int | float):
        value = low + (high - low) * random.random()
        return round(value) if getattr(knob, "scale", "") == "integer" else float(value)
    options = getattr(knob, "options", ())
    return options[int(random.integers(len(options)))][0] if options else knob.default


def random_design(lesson, random: np.random.Generator, device):
    """The outcome of a random design, None where the lesson or the device refuses it in one sentence."""
    try:
        design = lesson.start()
        for name in random.permutation(np.array([k.name for k in lesson.knobs]))[:CHANGED]:
            design = lesson.apply(design, {str(name): random_value(lesson.knob(str(name)), random)})
        outcome = lesson.compute(design)
        device(lesson, outcome)
    except (KnobError, EngineError, DeviceError) as problem:
        assert str(problem).endswith((".", "?")), str(problem)
        return None
    return outcome
