"""The lesson on a person's own record."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from observer_lab.course.lesson import Design, Lesson
from observer_lab.engine import EngineError, Plant
from observer_lab.engine.identification import Record, RecordFit, identify, resample
from observer_lab.engine.identification.conditioning import delayed
from observer_lab.text import text

from .data import Given
from .knobs import DATA, DELAY, OPENING_SHARE, ORDER, OWN
from .study import Study, compute, from_knobs

MAX_SHOWN = 20_000  # rows that the page fits and plays; a longer record gets a coarser step
LONGEST_NAME = 18


def with_record(lesson: Lesson[Study], record: Record, plant: Plant | None = None,
                progress: Callable[[float], object] | None = None) -> Lesson[Study]:
    """The lesson with that record as a further choice, which it opens with; with a plant, its filter on that record.

    progress: called with the share of the fit that is done. Raises EngineError where the record cannot be made regular.
    """
    regular = resample(record)
    factor = math.ceil(regular.rows / MAX_SHOWN)
    if factor > 1:
        regular = resample(regular, step=factor * regular.dt)
    plain = _plain(regular)
    late = replace(DELAY, default=min(delayed(plain, OPENING_SHARE, None)[1], int(DELAY.high)))
    opening = None if plant is not None else _opening(plain, late.default, progress)
    mine = Given(plain, own=True, plant=plant, opening=opening)

    def source(design: Design) -> Given:
        return mine if design["data"] == OWN else from_knobs(design)
    chosen = replace(DATA, options=(*DATA.options, (OWN, text("your own record"))), default=OWN)
    order = ORDER if opening is None else replace(ORDER, default=len(opening.subspace.A))
    own = {"data": chosen, "delay": late, "order": order}
    return replace(lesson, knobs=tuple(own.get(knob.name, knob) for knob in lesson.knobs), compute=partial(compute, source))


def _opening(record: Record, delay: int, progress: Callable[[float], object] | None) -> RecordFit | None:
    """The fit of the order that the singular values suggest; None where there is none, which the lesson then says."""
    try:
        found = identify(record, share=OPENING_SHARE, delay=delay, progress=progress)
    except EngineError:
        return None
    return found if ORDER.low <= len(found.subspace.A) <= ORDER.high else None


def _plain(record: Record) -> Record:
    """Names and units without signs that a page would take for its own."""
    def words(name: str) -> str:
        return re.sub(r"[^\w %/.·°²³-]", " ", name).strip()[:LONGEST_NAME] or "?"
    return replace(record, input_names=tuple(map(words, record.input_names)), output_names=tuple(map(words, record.output_names)),
                   units=tuple((words(name), words(unit)) for name, unit in record.units))
