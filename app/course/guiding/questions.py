"""Draw a question: its axes and what is known, what each option would give, and what the run gives.

A lesson gives a function for each of its questions. An option's curve follows from what that option says, never from the answer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any  # the values of knobs are of any kind, as `Any` says

import numpy as np

from ...text import NO_WORDS, Text, text
from ..figures.curves import UNDER, thin_samples
from ..figures.ranges import round_up_nicely
from ..figures.records import Curve, Dash, PlaneFigure, Point, finite
from ..knobs import KnobError
from ..lesson import Lesson, Outcome

YOU, RUN = text("you"), text("the run")
YOUR_DIAMONDS, CROSSES_OF_RUN = text("diamonds: you"), text("crosses: the run")
MAX_SAMPLES = 160  # of a curve in a question's figure
COLUMNS = 40  # at which a hand draws a curve
BAR_WIDTH, BAR_GAP = 26.0, 0.19  # px, the widest; between the bars of one place, in places
ALL_BARS = 88.0  # px that bars of one each place may take together, so that none touches the next
SAME = 0.01  # of the axis: curves this near lie on one another
ROOM, ENDS = 1.08, (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)  # of an axis over its largest value; where an axis may end
LEVEL_WIDTH, LEVEL_HALF = 4.0, 0.42  # px; half the length of a line across a place, in places
Part = Curve | Point


@dataclass(frozen=True, eq=False)
class Asked:
    """A question on a tab's design: the outcome on entry, and the one `after` the page has done what the question asks about."""

    lesson: Lesson
    entry: Outcome
    after: Outcome

    def at(self, **values: Any) -> Outcome:
        """The outcome at other values of some knobs than on entry: what an option supposes."""
        return self.lesson.compute(self.lesson.apply(self.entry.design, values))


@dataclass(frozen=True, eq=False)
class DrawnQuestion:
    """A figure without its answer, what each option adds to it in the order of the options, and what the run adds."""

    figure: PlaneFigure
    options: tuple[tuple[Part, ...], ...]
    run: tuple[Part, ...]
    columns: tuple[float, ...] = ()  # where along the figure a hand may draw a height; none where it may not
    bars: bool = False  # whether those are bars

    def drawn(self, chosen: int | None, answered: bool, sketch: tuple[float, ...] | None = None) -> PlaneFigure:
        """The figure with what the person has predicted, and once it is `answered` with what the run gives.

        `sketch` is a drawing by hand, which takes the place of the option: shares of the frame's height at the columns.
        """
        yours = self.options[chosen] if chosen is not None and chosen >= 0 else ()
        if sketch is not None and len(sketch) == len(self.columns):
            heights, places = self.heights_of(sketch), len(self.figure.names)
            yours = tuple(_bar(x, h, YOU, "reference", places, -1, "dash")
                          for x, h in zip(self.columns, heights, strict=True)) if self.bars else (
                Curve(YOU, np.array(heights), "reference", "dash", 2.4, np.array(self.columns)),)
        parts = (*yours, *(self.run if answered else ()))
        curves = (*self.figure.curves, *(p for p in parts if isinstance(p, Curve)))
        return replace(self.figure, curves=curves if self.bars else self._told_apart(curves),
                       points=(*self.figure.points, *(p for p in parts if isinstance(p, Point))))

    def _told_apart(self, curves: Sequence[Curve]) -> tuple[Curve, ...]:
        """The curves, each wider on which a later one lies, so that both are seen."""
        near = SAME * (self.figure.y_range[1] - self.figure.y_range[0])

        def covered(k: int) -> bool:
            one = curves[k]
            return len(one.y) > 2 and any(len(other.y) == len(one.y) and np.array_equal(other.xs, one.xs)
                                          and float(np.abs(finite(other.y) - finite(one.y)).max()) <= near for other in curves[k + 1:])
        return tuple(replace(curve, width=UNDER) if covered(k) else curve for k, curve in enumerate(curves))

    def heights_of(self, shares: Sequence[float]) -> tuple[float, ...]:
        """Heights in the figure's units from shares of its frame. Raises KnobError where they are not one finite number for each column."""
        if len(shares) != len(self.columns) or not np.all(np.isfinite(shares)):
            raise KnobError(text("The drawing could not be read; draw it again."))
        low, high = self.figure.y_range
        return tuple(low + float(np.clip(share, 0.0, 1.0)) * (high - low) for share in shares)

    def distance(self, sketch: Sequence[float], parts: tuple[Part, ...]) -> float:
        """How far a drawing lies from an option's or the run's: the mean over its columns, as a share of the figure's height.

        `sketch` as in `drawn`. Raises KnobError where it does not fit the columns.
        """
        low, high = self.figure.y_range
        drawn = (np.asarray(self.heights_of(sketch)) - low) / (high - low)
        return float(np.mean(np.abs(np.array(self.shares_of(parts)) - drawn)))

    def shares_of(self, parts: tuple[Part, ...]) -> tuple[float, ...]:
        """How high an option's or the run's drawing stands at each column, as shares of the figure's height."""
        curves = [part for part in parts if isinstance(part, Curve) and part.x is not None]
        if self.bars:
            heights = np.array([float(curve.y[-1]) for curve in curves])
        else:
            assert curves[0].x is not None
            heights = np.interp(self.columns, curves[0].x, curves[0].y)
        low, high = self.figure.y_range
        return tuple(((np.clip(heights, low, high) - low) / (high - low)).tolist())

    def nearest(self, sketch: Sequence[float]) -> int:
        """The option whose drawing is nearest to one that was made by hand."""
        return int(np.argmin([self.distance(sketch, option) for option in self.options]))


Draw = Callable[[Asked], DrawnQuestion]


def question_over_time(title: Text, t: np.ndarray, known: Sequence[Curve], options: Sequence[np.ndarray], run: Curve,
                       y_label: Text | str, x_label: Text | str = "t [s]", log_y: bool = False,
                       span: tuple[float, float] | None = None) -> DrawnQuestion:
    """Curves over a common axis: what is `known`, one curve for each option, and the run's.

    `t` (n_t,), each curve (n_t,); with `log_y` their magnitudes are drawn in decades. `span` is the range of the upright axis.
    """
    def shown(y: np.ndarray) -> np.ndarray:
        y = finite(y)
        return np.log10(np.maximum(np.abs(y), 10.0 ** low)) if log_y else y

    everything = [np.asarray(y, dtype=float) for y in (*(c.y for c in known), *options, run.y)]
    low, high = span or (_decades(everything) if log_y else _range(everything))

    def thin(curve: Curve) -> Curve:
        x, y = thin_samples(np.asarray(t, dtype=float), shown(curve.y), points=MAX_SAMPLES)
        return replace(curve, x=x, y=y)
    figure = PlaneFigure("question", title, tuple(map(thin, known)), (), x_label, y_label, (float(t[0]), float(t[-1])), (low, high),
                         powers="y" if log_y else "")
    yours = tuple((thin(Curve(YOU, np.asarray(y, dtype=float), "reference", "dash", 2.4)),) for y in options)
    return DrawnQuestion(figure, yours, (thin(replace(run, name=run.name if run.name.id else RUN, width=3.0)),),
                         tuple(np.linspace(t[0], t[-1], COLUMNS).tolist()))


def question_of_bars(title: Text, y_label: Text | str, known: Sequence[tuple[Text, float]], asked: Text, options: Sequence[float],
                     run: float, role: str = "plant") -> DrawnQuestion:
    """Bars: those that are `known`, and at the place that is `asked` about the option's and the run's."""
    return question_of_bar_groups(title, y_label, known, (asked,), [(value,) for value in options], (run,), role)


def question_of_bar_groups(title: Text, y_label: Text | str, known: Sequence[tuple[Text, float]], asked: Sequence[Text],
                           options: Sequence[Sequence[float]], run: Sequence[float], role: str = "plant",
                           level: tuple[Text, Sequence[float]] = (NO_WORDS, ()),
                           runs: Sequence[tuple[Text, str]] = ()) -> DrawnQuestion:
    """Bars at several places that are asked about: each option and the run give one height for each of them.

    `level` is a name and a height for each of these places that is known already, drawn as a line across it. `runs` are the names and
    colours of the run's bars where they differ from place to place.
    """
    low, high = _range([np.array([value for _, value in known] or [0.0]), np.array(level[1] or (0.0,)),
                        *(np.array(each, dtype=float) for each in options), np.array(run, dtype=float)])
    first = len(known)
    names = tuple((float(k), name) for k, name in enumerate([*(name for name, _ in known), *asked]))
    drawn = (*(_bar(k, value, NO_WORDS, "muted", len(names)) for k, (_, value) in enumerate(known)), *_levels(first, *level))
    figure = PlaneFigure("question", title, drawn, (), "", y_label, (-0.6, len(names) - 0.4), (low, high), names=names)

    def group(values: Sequence[float], side: float, looks: Sequence[tuple[Text, str]], dash: Dash = "solid") -> tuple[Curve, ...]:
        return tuple(_bar(first + k, value, name, role, len(names), side, dash)
                     for k, (value, (name, role)) in enumerate(zip(values, looks, strict=True)))
    yours, shown = ((YOU, "reference"),) * len(asked), tuple(runs) or ((RUN, role),) * len(asked)
    return DrawnQuestion(figure, tuple(group(each, -1, yours, "dash") for each in options), group(run, +1, shown),
                         tuple(float(first + k) for k in range(len(asked))), bars=True)


def _levels(first: int, name: Text, heights: Sequence[float]) -> Iterator[Curve]:
    """A line across each place, the first with the name of all."""
    for k, height in enumerate(heights):
        yield Curve(NO_WORDS if k else name, np.full(2, float(height)), "muted", "solid", LEVEL_WIDTH,
                    np.array([first + k - LEVEL_HALF, first + k + LEVEL_HALF]))


def bar_width(places: int) -> float:
    """How wide a bar is, in px, in a figure with so many places."""
    return min(BAR_WIDTH, round(ALL_BARS / places, 1))


def _bar(at: float, value: float, name: Text, role: str, places: int, side: float = 0.0, dash: Dash = "solid") -> Curve:
    """A bar from zero at one of the places, beside its middle where another one stands there too; with a `dash` its edge alone."""
    return Curve(name, np.array([0.0, float(value)]), role, dash, bar_width(places), np.full(2, at + side * BAR_GAP))


def question_of_poles(title: Text, known: Sequence[Point], options: Sequence[Sequence[complex]], run: Sequence[complex],
                      x_label: str = "Re s", y_label: str = "Im s", role: str = "estimate", disc: bool = False,
                      names: tuple[Text, Text] = (YOU, RUN)) -> DrawnQuestion:
    """A pole map: what is known, where an option puts the poles that are asked about, and where the run puts them.

    `names` are those of an option's marks and of the run's.
    """
    every = [complex(p.x, p.y) for p in known] + [complex(s) for each in options for s in each] + [complex(s) for s in run]
    left, right = min(s.real for s in every), max(s.real for s in every)
    tall = max([abs(s.imag) for s in every]) or 0.5 * (right - left) or 1.0
    wide = max(right - left, 0.4 * tall)
    figure = PlaneFigure("question", title, (), tuple(known), x_label, y_label, (left - 0.15 * wide, max(right, 0.0) + 0.15 * wide),
                         (-1.25 * tall, 1.25 * tall), unstable=not disc)

    def marks(poles: Sequence[complex], others: Sequence[complex], name: Text, mark: Any, role: str) -> tuple[Point, ...]:
        """The poles, of which the one farthest from all others has the name."""
        def apart(k: int) -> tuple[float, float]:
            return min((abs(complex(poles[k]) - other) for other in others), default=0.0), complex(poles[k]).imag
        named = max(range(len(poles)), key=apart, default=0)
        return tuple(Point(complex(s).real, complex(s).imag, role, mark, name if k == named else NO_WORDS) for k, s in enumerate(poles))
    before = [complex(p.x, p.y) for p in known]
    yours = tuple(marks(each, [*map(complex, run), *before], names[0], "hollow", "reference") for each in options)
    return DrawnQuestion(figure, yours, marks(run, before, names[1], "cross", role))


def _range(curves: Sequence[np.ndarray]) -> tuple[float, float]:
    """A range of round numbers that holds all values and zero."""
    values = np.concatenate([finite(y).ravel() for y in curves])
    low, high = min(0.0, float(values.min())), max(0.0, float(values.max()))
    low = -round_up_nicely(-low * ROOM, ENDS) if low < 0 else 0.0
    return low, round_up_nicely(high * ROOM, ENDS) if high > 0 else (0.0 if low < 0 else 1.0)


def _decades(curves: Sequence[np.ndarray]) -> tuple[float, float]:
    """The exponents of ten that hold all magnitudes, at most nine decades."""
    sizes = np.concatenate([np.abs(finite(y)).ravel() for y in curves])
    high = float(np.ceil(np.log10(max(float(sizes.max()), 1e-9)) - 1e-9))
    least = float(sizes[sizes > 10.0 ** (high - 9)].min(initial=10.0 ** high))
    return min(float(np.floor(np.log10(least))), high - 1.0), high

