"""Compare pinned designs with the present one: curves, poles and numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from ..text import NO_WORDS, Text, joined, same, text
from .design import Design
from .design_differences import describe_difference
from .figures.curves import SAME_CURVE_RTOL
from .figures.records import Figure, TableFigure
from .lesson import Board, Lesson, Outcome, Stage

MAX_PINS = 4  # designs that are pinned at once
MAX_WRITTEN_ENTRIES = 3  # entries of a gain that are written out; of a larger one stands its norm
BOUND = "\N{NO-BREAK SPACE}"
COMPARED = text("Designs side by side")
NOW = text("now")
MEASURES = MappingProxyType({  # the metrics that have one meaning in all lessons
    "separation_meter": text("separation meter"), "slowest_controller": text("slowest controller pole [1/s]"),
    "slowest_observer": text("slowest observer pole [1/s]"), "slowest_loop": text("slowest pole of the loop [1/s]"),
    "largest_input": text("largest input"), "largest_error": text("largest error"), "largest_gain": text("largest gain"),
    "settled_after": text("settled after [s]"), "known_after": text("known after [s]"), "final_error": text("error at the end"),
    "late_error": text("error at the end"), "rank": text("rank"), "nis_mean": text("mean NIS"), "nees_mean": text("mean NEES"),
    "J": text("cost J"), "disk_margin": text("disk margin"), "error_rate": text("slowest mode of the error [1/s]"),
    "state_rate": text("slowest mode of the state [1/s]"), "loop_radius": text("spectral radius of the loop"),
    "nees_kf": text("NEES of the linear filter"), "nees_ekf": text("NEES of the EKF"), "nees_ukf": text("NEES of the UKF"),
    "clipped_for": text("clipped for [s]"), "clipped_share": text("share of time clipped"), "delay": text("delay of the alarm [s]"),
})


@dataclass(frozen=True)
class Pin:
    """A design that is kept to be compared, under a name of a person's own or a letter."""

    name: str
    design: Design
    ghost: bool = False  # whether it walks on the stage


@dataclass(frozen=True, eq=False)
class Ghost:
    """What a pinned run believes at each time: a record of `states`, as the present body's pose takes them."""

    place: int
    name: str
    t: np.ndarray
    states: np.ndarray


@dataclass(frozen=True, eq=False)
class Pinned:
    """A pin with what its design leads to; `place` is its number among the pins, from 0."""

    pin: Pin
    place: int
    outcome: Outcome
    figures: Sequence[Figure]

    @property
    def name(self) -> Text:
        """Its name as words."""
        return same(self.pin.name)


def next_pin_letter(taken: Sequence[str]) -> str:
    """The first letter that no pin has."""
    return next(letter for letter in "ABCDEFGH" if letter not in taken)


# --- figures -----------------------------------------------------------------------------------------------------------
def figures_with_pins(figures: Sequence[Figure], pinned: Sequence[Pinned]) -> tuple[Figure, ...]:
    """The figures with thin curves and hollow marks of the pins, where these differ from what is drawn anyway."""
    return tuple(figure.with_pins([(pin.place, pin.name, other) for pin in pinned for other in pin.figures if other.id == figure.id])
                 for figure in figures)


# --- boards ------------------------------------------------------------------------------------------------------------
def boards_with_pins(boards: Sequence[Board], pinned: Sequence[Pinned]) -> tuple[Board, ...]:
    """The boards with the poles that the pins have on the boards of the same name and these have not, by the pin's place."""
    return tuple(
        replace(
            board,
            pinned=tuple(
                (
                    pin.place,
                    tuple(
                        pole for pole in other.poles if not any(abs(pole - own) <= SAME_CURVE_RTOL * (1 + abs(own)) for own in board.poles)
                    ),
                )
                for pin in pinned
                for other in pin.outcome.boards
                if other.id == board.id
            ),
        )
        for board in boards
    )


# --- stage -------------------------------------------------------------------------------------------------------------
def has_same_body(stage: Stage | None, pinned: Pinned) -> bool:
    """Whether a pin's run can walk on the present stage: another plant has other parts."""
    other = pinned.outcome.stage
    if stage is None or other is None or other.x.shape[1:] != stage.x.shape[1:]:
        return False
    return any(part.twin for part in stage.body.parts) and stage.body.parts == other.body.parts


def ghosts_of_pins(stage: Stage | None, pinned: Sequence[Pinned]) -> tuple[Ghost, ...]:
    """The ghosts of the pins that are wanted: the estimate, the plant itself where nothing is estimated."""
    return tuple(Ghost(pin.place, pin.pin.name, other.t, other.x if other.xhat is None else other.xhat)
                 for pin in pinned if pin.pin.ghost and has_same_body(stage, pin) and (other := pin.outcome.stage) is not None)


# --- numbers -----------------------------------------------------------------------------------------------------------
def comparison_table(lesson: Lesson, design: Design, outcome: Outcome, pinned: Sequence[Pinned]) -> TableFigure | None:
    """A table of gains, poles, metrics and checks, a column a design, with what differs below; None without pins."""
    if not pinned:
        return None
    told = [dict(_facts(each)) for each in (outcome, *(pin.outcome for pin in pinned))]
    rows = tuple((label, *(facts.get(label, "–") for facts in told)) for label in dict.fromkeys(key for facts in told for key in facts))
    said = joined(*(describe_difference(lesson, pin.name, pin.pin.design, design) for pin in pinned))
    return TableFigure("compared", COMPARED, (NO_WORDS, NOW, *(pin.name for pin in pinned)), rows, said, COMPARED)


def _facts(outcome: Outcome) -> Iterator[tuple[Text, Text | str]]:
    """What is told of one design, by what it is."""
    for name, gain in outcome.gains.items():
        entries = np.asarray(gain, dtype=float).ravel()
        if 0 < entries.size <= MAX_WRITTEN_ENTRIES:
            yield same(name), _numbers(entries)
        else:
            yield same(f"‖{name}‖"), text("{value:.4g}", value=float(np.linalg.norm(gain)))
    for board in outcome.boards:
        yield board.title, same(_poles((*board.poles, *board.fixed)))
    for key, words in MEASURES.items():
        if key in outcome.metrics:
            yield words, text("{value:.4g}", value=outcome.metrics[key])
    for check in outcome.checks:
        yield check.text, "✓" if check.holds else "✗"


def _numbers(values: np.ndarray) -> Text | str:
    return same(", ".join(f"{value:.3g}" for value in values).replace("-", "−"))


def _poles(poles: Sequence[complex]) -> str:
    """−3 ± 2j, −5, each on one line."""
    said = [f"{p.real:.3g}" + (f"{BOUND}±{BOUND}{p.imag:.3g}j" if p.imag > 0 else "") for p in poles if p.imag >= 0]
    return ", ".join(said).replace("-", "−")
