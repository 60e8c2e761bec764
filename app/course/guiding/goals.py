"""Judge what a hand has done in a scene that asks for a direction or a condition."""

from __future__ import annotations

from ...text import NO_WORDS, Text, text
from ..design import Design
from ..design_differences import value_in_words
from ..knobs import Choice, Knob, Number, Poles, Switch
from ..lesson import Lesson
from ..scenes import Goal, Move

MIN_MOVE_SHARE = 0.03  # of a knob's range, or of a pole's distance from the axis: a shorter way shows nothing


def judge_move(lesson: Lesson, do: Move, entry: Design, design: Design) -> tuple[bool, Text]:
    """Whether a scene's goal is reached, and what to say where something else was done; nothing where nothing was.

    `entry` is the design with which the scene began.
    """
    knob = lesson.knob(do.knobs[0])
    if do.goal is None:
        return any(design[name] != entry[name] for name in do.knobs), NO_WORDS
    if design[knob.name] == entry[knob.name]:
        return False, NO_WORDS
    if isinstance(knob, (Choice, Switch)):
        reached = design[knob.name] == do.goal.value
        return reached, NO_WORDS if reached else text("This is another setting: *{name}* is {value} now.", name=knob.label,
                                                      value=value_in_words(knob, design[knob.name]))
    why = _judge_poles(do.goal, _slowest(entry[knob.name]), _slowest(design[knob.name])) if isinstance(knob, Poles) else _judge_number(
        knob, do.goal, float(entry[knob.name]), float(design[knob.name]))
    return not why.id, why


def _slowest(poles: tuple[complex, ...]) -> float:
    return max(complex(pole).real for pole in poles)


def _judge_poles(goal: Goal, before: float, now: float) -> Text:
    """Why the slowest pole is not where it should be, nothing where it is."""
    said = {"before": before, "now": now}
    if now >= 0:
        return text("Too far: with a pole at {now:.3g} the motion does not decay.", **said)
    if abs(now - before) < MIN_MOVE_SHARE * abs(before):
        return text("The slowest pole has hardly moved: its real part is {now:.3g}.", **said)
    if goal.way == "right" and now < before:
        return text("The slowest pole moved away from the imaginary axis: its real part went from {before:.3g} to {now:.3g}.", **said)
    if goal.way == "left" and now > before:
        return text("The slowest pole moved toward the imaginary axis: its real part went from {before:.3g} to {now:.3g}.", **said)
    if (goal.least is not None and now < goal.least) or (goal.most is not None and now > goal.most):
        return text("The real part of the slowest pole is {now:.3g} now.", **said)
    return NO_WORDS


def _judge_number(knob: Knob, goal: Goal, before: float, now: float) -> Text:
    """Why a number is not where it should be, nothing where it is."""
    unit = f" {knob.unit}" if knob.unit else ""
    said = {"name": knob.label, "before": before, "now": now, "unit": unit}
    if goal.way == "right" and now < before:
        return text("*{name}* went down, from {before:.3g} to {now:.3g}{unit}.", **said)
    if goal.way == "left" and now > before:
        return text("*{name}* went up, from {before:.3g} to {now:.3g}{unit}.", **said)
    if goal.least is not None and now < goal.least:
        return text("*{name}* is {now:.3g}{unit} now: that is too low.", **said)
    if goal.most is not None and now > goal.most:
        return text("*{name}* is {now:.3g}{unit} now: that is too high.", **said)
    if goal.way and isinstance(knob, Number) and knob.scale != "log" and abs(now - before) < MIN_MOVE_SHARE * (knob.high - knob.low):
        return text("*{name}* has hardly moved: it is {now:.3g}{unit} now.", **said)
    return NO_WORDS

