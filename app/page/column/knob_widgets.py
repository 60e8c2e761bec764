"""Make the widgets of knobs: post what a person sets, show what the session accepted."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol

import viser

from ...course.knobs import Choice, Knob, Number, Poles, Switch, Track
from ...engine.systems import move_pole
from ...session.state.view import Picture
from ...text import format_number
from ..viser_private import viser_internals
from ..viser_private.widget_values import ReadBack

TIED = str.maketrans({" ": "\N{NO-BREAK SPACE}", "/": "/\N{WORD JOINER}"})  # in a unit, where no line may end
Post = Callable[[str, Any], int]  # knob name, value → number of the edit


class Widget(Protocol):
    """A knob's widget."""

    @property
    def node(self) -> str:
        """The name by which the page knows what a hand moves."""

    def show(self, value: Any, visible: bool, picture: Picture) -> None:
        """Show the value that a picture accepts."""


def label_of(knob: Knob, language: str) -> str:
    """The knob's name with its unit, which stands in one line."""
    return knob.label(language) + (f" [{knob.unit.translate(TIED)}]" if knob.unit else "")


def marks(knob: Number, language: str) -> tuple[float | tuple[float, str], ...]:
    """The marks of a slider: its ends, with a true minus; of one that moves in decades what they are, not their logarithms, and one
    at every power of ten."""
    if knob.scale != "log":
        return tuple((float(end), format_number(end, "g", language)) for end in (knob.low, knob.high))
    low, high = (round(math.log10(v), 3) for v in (knob.low, knob.high))
    inside = [float(power) for power in range(math.ceil(low), math.floor(high) + 1) if low < power < high]
    return (low, format_number(knob.low, ".3g", language)), *inside, (high, format_number(knob.high, ".3g", language))


def slider_place(knob: Number, value: float) -> float:
    """The place of a value on the knob's slider. A slider that moves in decades holds the logarithm to three decimals."""
    return round(math.log10(value), 3) if knob.scale == "log" else float(value)


def slider_value(knob: Number, place: float) -> float:
    """The value at a place of the knob's slider; its ends are those of the knob, which three decimals of a logarithm may miss."""
    if knob.scale != "log":
        return place
    return {slider_place(knob, end): end for end in (knob.low, knob.high)}.get(place, 10.0 ** place)


class NumberWidget:
    """A slider with its number field; one that moves in decades holds the logarithm, its field shows the value (`fields.js`)."""

    def __init__(self, gui: viser.GuiApi, knob: Number, language: str, post: Post) -> None:
        self._knob = knob
        self._log = knob.scale == "log"
        low, high = slider_place(knob, knob.low), slider_place(knob, knob.high)
        step = 1.0 if knob.scale == "integer" else knob.step or 10 ** math.floor(math.log10((high - low) / 100))
        label = label_of(knob, language)
        self._handle = gui.add_slider(label, low, high, float(step), slider_place(knob, knob.default),
                                      hint=knob.hint(language) or None, marks=marks(knob, language))
        self.field = {viser_internals.node_id(self._handle): {"log": self._log, "unit": knob.unit, "step": float(step), "name": label}}
        self._back = ReadBack(self._handle, lambda value: post(knob.name, slider_value(knob, value)))

    @property
    def node(self) -> str:
        return viser_internals.node_id(self._handle)

    def show(self, value: Any, visible: bool, picture: Picture) -> None:
        if self._handle.visible != visible:
            self._handle.visible = visible
        self._back.show(slider_place(self._knob, value), picture)


class ChoiceWidget:
    """A dropdown; its words change with the language, its values do not."""

    def __init__(self, gui: viser.GuiApi, knob: Choice, language: str, post: Post) -> None:
        self._names = {name: label(language) for name, label in knob.options}
        keys = {label: name for name, label in self._names.items()}
        self._handle = gui.add_dropdown(label_of(knob, language), tuple(self._names.values()),
                                        initial_value=self._names[knob.default], hint=knob.hint(language) or None)
        self._back = ReadBack(self._handle, lambda value: post(knob.name, keys.get(value, value)))

    @property
    def node(self) -> str:
        return viser_internals.node_id(self._handle)

    def show(self, value: Any, visible: bool, picture: Picture) -> None:
        if self._handle.visible != visible:
            self._handle.visible = visible
        self._back.show(self._names[value], picture)


class SwitchWidget:
    """A checkbox."""

    def __init__(self, gui: viser.GuiApi, knob: Switch, language: str, post: Post) -> None:
        self._handle = gui.add_checkbox(label_of(knob, language), knob.default, hint=knob.hint(language) or None)
        self._back = ReadBack(self._handle, lambda value: post(knob.name, bool(value)))

    @property
    def node(self) -> str:
        return viser_internals.node_id(self._handle)

    def show(self, value: Any, visible: bool, picture: Picture) -> None:
        if self._handle.visible != visible:
            self._handle.visible = visible
        self._back.show(value, picture)


def pole_step(knob: Poles) -> float:
    """How far a press of an arrow moves a pole."""
    decade = math.floor(math.log10(knob.re_high - knob.re_low))
    return 0.1 if 0 <= decade <= 1 else 10.0 ** (decade - 2)


def typed_decimals(knob: Poles) -> int:
    """How many decimals of a pole a person may type; a press of an arrow moves it by a larger step."""
    return max(3, 4 - math.floor(math.log10(knob.re_high - knob.re_low)))


class PolesWidget:
    """A row (Re, Im) for every real pole and every conjugate pair; typing does what dragging does."""

    def __init__(self, gui: viser.GuiApi, knob: Poles, language: str, post: Post) -> None:
        self._knob, self._poles, self._post = knob, knob.default, post
        self._rows: list[tuple[viser.GuiVector2Handle, ReadBack]] = []
        self._digits, step = typed_decimals(knob) + 1, pole_step(knob)
        for i in range(len(knob.default)):
            row = gui.add_vector2(f"{knob.symbol}{i + 1}", (0.0, 0.0), min=(knob.re_low, -knob.im_high),
                                  max=(knob.re_high, knob.im_high), step=step, hint=label_of(knob, language))
            row.precision = typed_decimals(knob)
            self._rows.append((row, ReadBack(row, lambda value, i=i: self._typed(i, complex(*value)))))

    def _typed(self, index: int, to: complex) -> int:
        """Move the pole of a row; the next row typed into builds on it, answered or not."""
        heads = [i for i, p in enumerate(self._poles) if p.imag >= 0]
        if index >= len(heads):  # a row that is not seen
            return self._post(self._knob.name, self._poles)
        at = heads[index]
        asked = (*self._poles[:at], to, *self._poles[at + 1:])  # what is not finite is refused by the knob
        snap = 1e-6 * min(1.0, self._knob.im_high)
        if _finite(to):
            asked = self._poles = move_pole(self._poles, at, to, axis_snap=snap)
        return self._post(self._knob.name, asked)

    @property
    def node(self) -> str:
        return viser_internals.node_id(self._rows[0][0])

    def show(self, value: Any, visible: bool, picture: Picture) -> None:
        heads = [p for p in value if p.imag >= 0]
        write = all(back.may_write(picture) for _, back in self._rows)  # sorted anew, one row's change moves others
        if write:
            self._poles = value
        for i, (row, back) in enumerate(self._rows):
            seen = visible and i < len(heads)
            if row.visible != seen:
                row.visible = seen
            if seen and write:
                back.show((round(heads[i].real, self._digits), round(heads[i].imag, self._digits)), picture)


def _finite(value: complex) -> bool:
    return math.isfinite(value.real) and math.isfinite(value.imag)


class TrackWidget:
    """A slider whose movement is recorded from the present time of the run on."""

    def __init__(self, gui: viser.GuiApi, knob: Track, language: str, record: Post) -> None:
        self._handle = gui.add_slider(label_of(knob, language), knob.low, knob.high, (knob.high - knob.low) / 200,
                                      0.0, hint=knob.hint(language) or None)
        self._back = ReadBack(self._handle, lambda value: record(knob.name, value))

    @property
    def node(self) -> str:
        return viser_internals.node_id(self._handle)

    def show(self, value: Any, visible: bool, picture: Picture) -> None:
        if self._handle.visible != visible:
            self._handle.visible = visible
        if not value and picture.resting:
            self._back.show(0.0, picture)


def make_widget(gui: viser.GuiApi, knob: Knob, language: str, post: Post, record: Post) -> Widget:
    """The widget for a knob's kind."""
    if isinstance(knob, Number):
        return NumberWidget(gui, knob, language, post)
    if isinstance(knob, Choice):
        return ChoiceWidget(gui, knob, language, post)
    if isinstance(knob, Switch):
        return SwitchWidget(gui, knob, language, post)
    if isinstance(knob, Poles):
        return PolesWidget(gui, knob, language, post)
    if isinstance(knob, Track):
        return TrackWidget(gui, knob, language, record)
    raise TypeError(f"no widget for {type(knob).__name__}")
