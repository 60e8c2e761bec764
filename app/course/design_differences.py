"""Describe in words how one design differs from another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..text import Text, joined, listed, same, text
from .design import Design
from .knobs import Choice, Knob, Number, Poles, Switch, Track
from .lesson import Lesson

NAMED = 3  # knobs that a sentence names; of more it gives the number
ON, OFF, DRAWN_BY_HAND = text("on"), text("off"), text("drawn by hand")


def changed(lesson: Lesson, before: Design, after: Design) -> tuple[Knob, ...]:
    """The knobs of a lesson that have other values in a second design, in the lesson's order."""
    was, now = dict(before.values), dict(after.values)
    return tuple(knob for knob in lesson.knobs if knob.name in was and knob.name in now and was[knob.name] != now[knob.name])


def describe_step(lesson: Lesson, before: Design, after: Design) -> Text:
    """What was done from one design to the next: "gain: 1 → 3", or that another plant was brought."""
    if before.plant != after.plant:
        return text("another plant")
    return _several(
        [
            text(
                "{label}: {before} → {after}",
                label=_name(knob),
                before=value_in_words(knob, before[knob.name], after[knob.name]),
                after=value_in_words(knob, after[knob.name], before[knob.name]),
            )
            for knob in changed(lesson, before, after)
        ]
    )


def describe_design(lesson: Lesson, design: Design) -> Text:
    """How a design differs from the lesson's start: one sentence."""
    knobs = changed(lesson, lesson.start(), design)
    if not knobs:
        return text("Every knob stands at its start.")
    return text("Knobs away from their start: {knobs}.", knobs=_values(knobs, design))


def describe_difference(lesson: Lesson, name: Text, other: Design, present: Design) -> Text:
    """What differs between a pinned design and the present one: one sentence."""
    if other.plant != present.plant:
        return text("{name} has another plant.", name=name)
    knobs = changed(lesson, other, present)
    if not knobs:
        return text("{name} is the present design.", name=name)
    said = [
        text(
            "{label} ({before} instead of {after})",
            label=_name(knob),
            before=value_in_words(knob, other[knob.name], present[knob.name]),
            after=value_in_words(knob, present[knob.name], other[knob.name]),
        )
        for knob in knobs
    ]
    return text("{name} differs from now in {changes}.", name=name, changes=_several(said))


def _values(knobs: Sequence[Knob], design: Design) -> Text:
    return listed(text("{label} {value}", label=_name(knob), value=value_in_words(knob, design[knob.name])) for knob in knobs)


def _several(said: Sequence[Text]) -> Text:
    """The first few in a row, and how many more there are."""
    if len(said) <= NAMED:
        return listed(said)
    return text("{some} and {count} more", some=listed(said[:NAMED]), count=len(said) - NAMED)


def _name(knob: Knob) -> Text:
    return joined(knob.label, same(f"[{knob.unit}]")) if knob.unit else knob.label


def value_in_words(knob: Knob, value: Any, beside: Any = None) -> Text:
    """A value as a person reads it, in as many digits as tell it apart from the one `beside` it."""
    match knob:
        case Number():
            return text("{value:.{digits}g}", value=value, digits=_digits(value, beside))
        case Choice():
            return dict(knob.options)[value]
        case Switch():
            return ON if value else OFF
        case Poles():
            return same(_poles(value, beside))
        case Track():
            return DRAWN_BY_HAND if value else same("0")
    return same(knob.show(value))


def _digits(value: float, beside: float | None) -> int:
    return next((d for d in range(3, 17) if beside is None or f"{value:.{d}g}" != f"{beside:.{d}g}"), 17)


def _poles(poles: Sequence[complex], beside: Sequence[complex] | None) -> str:
    """−3 ± 2j, −5: pairs as one, to three digits or as many as the two sets need."""
    for digits in range(3, 17):
        said, other = (_written(each, digits) for each in (poles, beside or ()))
        if said != other:
            return said
    return _written(poles, 17)


def _written(poles: Sequence[complex], digits: int) -> str:
    said = [f"{p.real:.{digits}g}" + (f" ± {p.imag:.{digits}g}j" if p.imag > 0 else "") for p in poles if p.imag >= 0]
    return ", ".join(said).replace("-", "−")
