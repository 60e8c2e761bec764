"""Lay named bars before a body, whose lengths the run gives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...text import Text, format_number
from .body import BENCH, DARK_GREY, Body, Box, ErrorMarks, Part, Pose, Rod, Vector, pose_between
from .gain_lanes import BEHIND, moved_back

LEFT, BEGIN, LONG = -2.25, -1.05, 3.2  # stage units: the left end of the trough, where bars begin, how long one of 1 is
FIRST_Y, PITCH, STEP, THICK = -0.28, 0.3, 0.2, 0.1  # y of the bar next to the body, to the next one and down to it, the radius of a bar
FLOOR, LEAST, PLINTH = 0.1, 0.004, 0.7  # height of the last step; the least share that is drawn; depth of a plinth
NAME_AT, GATE, SIZE_AT = (LEFT + BEGIN) / 2, 0.44, 0.12  # across: the names of bars, from a bar's end to its size; how high the gate is


@dataclass(frozen=True)
class Bar:
    """One bar: its name and its colour."""

    name: Text
    colour: str


def share_of_decades(value: np.ndarray | float, low: float, high: float) -> np.ndarray:
    """How far magnitudes are from 10^low to 10^high, 0 to 1."""
    sizes = np.maximum(np.abs(np.nan_to_num(np.asarray(value, dtype=float), posinf=10.0 ** high)), 10.0 ** low)
    return np.clip((np.log10(sizes) - low) / (high - low), 0.0, 1.0)


def decade_marks(low: int, high: int, step: int, name: str = "10") -> tuple[tuple[str, float], ...]:
    """Names of powers of ten with the shares at which they stand."""
    return tuple((_decade(k, name), (k - low) / (high - low)) for k in range(low, high + 1, step))


def _decade(k: int, name: str = "10") -> str:
    return "1" if k == 0 else name + str(k).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def size_words(share: float, low: int, high: int) -> str:
    """The magnitude of which a bar has this share of the decades from 10^low to 10^high."""
    if share <= 0.0:
        return f"≤ {_decade(low)}"
    return f"≥ {_decade(high)}" if share >= 1.0 else format_number(10.0 ** (low + share * (high - low)), ".2g")


def with_bars(body: Body, states: int, bars: Sequence[Bar], marks: Sequence[tuple[Text | str, float]],
              by: float = BEHIND, up: float = 0.0, gate: bool = False, decades: tuple[int, int] | None = None,
              full: float | None = None) -> Body:
    """The body, moved back `by` and `up` onto a plinth, behind a flight of steps, a bar on each.

    After its states comes the share of each bar, 0 to 1; `marks` stand below, each at a share. With a `gate` the end of the first
    bar is marked across the others. Where the shares are of `decades`, or of a `full` size, each bar has its size at its end.
    """
    count, end = len(bars), BEGIN + LONG + 0.12
    rows = [(FIRST_Y - PITCH * k, FLOOR + STEP * (count - 1 - k)) for k in range(count)]  # y of each bar, and how high its step is
    fixed = {f"bar step {k}": Pose(((LEFT + end) / 2, y, high / 2)) for k, (y, high) in enumerate(rows)}
    front = rows[-1][0] - PITCH / 2
    fixed |= {f"bar mark {k}": Pose((BEGIN + LONG * share, front, FLOOR / 2)) for k, (_, share) in enumerate(marks)}

    plinth = (Part("plinth", Box((end - LEFT, PLINTH, up)), BENCH),) if up else ()
    if up:
        fixed["plinth"] = Pose(((LEFT + end) / 2, FIRST_Y + (PITCH + PLINTH) / 2, up / 2))

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        behind = {name: replace(each, position=moved_back(each.position, by, up)) for name, each in body.pose(x[:states], gain).items()}
        drawn = {}
        for k, ((y, high), share) in enumerate(zip(rows, x[states:states + count], strict=True)):
            long, z = LONG * min(max(float(share), LEAST), 1.0), high + THICK
            drawn[f"bar {k}"] = pose_between((BEGIN, y, z), (BEGIN + long, y, z))
        if gate:
            (across, _, _), long = drawn["bar 0"].position, drawn["bar 0"].scale[2]
            drawn["gate"] = Pose((across + long, (FIRST_Y + front) / 2, FLOOR + GATE / 2))
        return {**behind, **fixed, **drawn}

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple(moved_back(place, by, up) for place in body.anchors(x[:states], gain))

    def said(share: float) -> str:
        if full is None:
            assert decades is not None
            return size_words(share, *decades)
        return ("→ " if share > 1.0 else "") + format_number(share * full, ".2g")

    def sizes(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        own = () if body.marks is None else body.marks(x[:states], xhat[:states], gain).words
        places = tuple((BEGIN + LONG * min(float(share), 1.0) + SIZE_AT, y - THICK, high + 1.3 * THICK)
                       for (y, high), share in zip(rows, x[states:states + count], strict=True))
        return ErrorMarks((), (*((said(float(share)), at, "center-left") for share, at in zip(x[states:], places, strict=False)),
                               *((words, moved_back(at, by, up), side) for words, at, side in own)))

    parts = (*body.parts, *plinth, *(Part(f"bar step {k}", Box((end - LEFT, PITCH, high)), BENCH) for k, (_, high) in enumerate(rows)),
             *(Part(f"bar mark {k}", Box((0.025, 0.03, FLOOR)), DARK_GREY) for k in range(len(marks))),
             *(Part(f"bar {k}", Rod(THICK), bar.colour) for k, bar in enumerate(bars)),
             *((Part("gate", Box((0.04, FIRST_Y - front - 0.02, GATE)), DARK_GREY),) if gate else ()))
    labels = (*((name, moved_back(place, by, up)) for name, place in body.labels),
              *((bar.name, (NAME_AT, y - THICK, high + 1.3 * THICK)) for bar, (y, high) in zip(bars, rows, strict=True)),
              *((name, (BEGIN + LONG * share, front - 0.08, 0.0)) for name, share in marks))
    return replace(
        body, parts=parts, pose=pose, anchors=anchors, labels=labels, marks=body.marks if decades is None and full is None else sizes,
        arrows=lambda x, u, gain: tuple(replace(arrow, tail=moved_back(arrow.tail, by, up), head=moved_back(arrow.head, by, up))
                                        for arrow in body.arrows(x[:states], u, gain)))
