"""The lesson on a person's own record."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import partial

from observer_lab.course.lesson import Design, Lesson
from observer_lab.engine import Plant
from observer_lab.engine.identification import Record, resample
from observer_lab.engine.identification.conditioning import delayed
from observer_lab.text import text

from .data import Given
from .knobs import DATA, DELAY, OWN
from .study import Study, compute, from_knobs

MAX_SHOWN = 20_000  # rows that the page fits and plays; a longer record gets a coarser step
LONGEST_NAME = 18


def with_record(lesson: Lesson[Study], record: Record, plant: Plant | None = None) -> Lesson[Study]:
    """The lesson with that record as a further choice, which it opens with; with a plant, its filter on that record.

    Raises EngineError where the record cannot be made regular.
    """
    regular = resample(record)
    factor = math.ceil(regular.rows / MAX_SHOWN)
    if factor > 1:
        regular = resample(regular, step=factor * regular.dt)
    mine = Given(_plain(regular), own=True, plant=plant)

    def source(design: Design) -> Given:
        return mine if design["data"] == OWN else from_knobs(design)
    chosen = replace(DATA, options=(*DATA.options, (OWN, text("your own record"))), default=OWN)
    late = replace(DELAY, default=min(delayed(mine.record, 0.5, None)[1], int(DELAY.high)))
    own = {"data": chosen, "delay": late}
    return replace(lesson, knobs=tuple(own.get(knob.name, knob) for knob in lesson.knobs), compute=partial(compute, source))


def _plain(record: Record) -> Record:
    """Names and units without signs that a page would take for its own."""
    def words(name: str) -> str:
        return re.sub(r"[^\w %/.·°²³-]", " ", name).strip()[:LONGEST_NAME] or "?"
    return replace(record, input_names=tuple(map(words, record.input_names)), output_names=tuple(map(words, record.output_names)),
                   units=tuple((words(name), words(unit)) for name, unit in record.units))
