"""Show the playback controls: play, kick, time slider, speed, undo, reset and clock."""

from __future__ import annotations

import html
import math
from collections.abc import Callable
from typing import Any

import viser

from ...session.commands.commands import ChangeSpeed, Command, Edit, Kick, Play, Redo, Reset, Rewind, Seek, Undo
from ...session.state.view import Picture
from ..charts.print_sizes import BAR, Sizes
from ..charts.style_sheet import clock, clock_decimals
from ..viser_private import viser_internals
from ..viser_private.widget_values import ReadBack
from ..words import phrases

CLOCK_PLACEHOLDERS = "\ue000", "\ue001"  # where a page that plays by itself writes the cursor's place and the time into the clock
WRITE_EVERY = 3  # poses between two updates of the time slider


def step_of(horizon: float) -> float:
    """The step of the time slider: a round number, at most a five-hundredth of the run."""
    finest = horizon / 500
    decade = 10.0 ** math.floor(math.log10(finest))
    return max(s * decade for s in (1, 2, 5) if s * decade <= finest * (1 + 1e-9))


def slider_value(t: float, step: float, horizon: float) -> float:
    """The place of the time slider at a time, in whole steps: a field of six digits that change cannot be read.

    Halfway between two steps it is the later one, as in the scripts of a page that plays by itself.
    """
    return min(round(math.floor(t / step + 0.5) * step, 9), horizon)


def end_of(horizon: float) -> float:
    """The end of the time slider: the length of the run, without the digits that rounding has left there and a field would show."""
    return round(horizon, 9) or 0.01


def _parts(picture: Picture) -> str:
    """The names of the parts of the lesson, for a phone, which shows one at a time."""
    lang, live = picture.state.language, picture.lesson.live is not None
    named = [("predict", phrases.LIVE if live else phrases.PREDICTION), ("knobs", phrases.KNOBS)]
    named += [("curves", phrases.CURVES)] if picture.seen else []
    named += [("why", phrases.NUMBERS)] if live else [("why", phrases.STEPS), ("tasks", phrases.TASKS)]
    buttons = "".join(f'<button type="button" data-part="{part}">{words(lang)}</button>' for part, words in named)
    return f'<nav class="ol-parts">{buttons}</nav>'


class PlaybackControls:
    """Play, kick, start, undo, redo, reset; the time slider and the speed."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Callable[[Edit], int]) -> None:
        lang = picture.state.language
        self._lang = lang
        self._count, self._rate, self._picture = 0, picture.rate, picture
        self._caption = self._words(picture)
        self._horizon = end_of(picture.horizon)
        panel = gui.add_panel()
        with panel.add_tab(phrases.TRANSPORT(lang)):
            commands: dict[str, Command] = {
                phrases.PLAY(lang): Play(), phrases.PAUSE(lang): Play(), phrases.KICK(lang): Kick(),
                phrases.REWIND(lang): Rewind(), phrases.SLOWER(lang): ChangeSpeed(-1),
                phrases.FASTER(lang): ChangeSpeed(+1), phrases.UNDO(lang): Undo(), phrases.REDO(lang): Redo(),
                phrases.RESET(lang): Reset()}
            gui.add_html(_parts(picture))
            self._row = gui.add_button_group("", self._options(picture))
            self._time = gui.add_slider(phrases.TIME(lang), 0.0, self._horizon, step_of(self._horizon), 0.0)
            self._back = ReadBack(self._time, lambda t: post(Seek(t)))
            self._clock = gui.add_html(clock(0.0, picture.horizon, picture.rate, self._caption))
            self._time.visible = self._clock.visible = picture.lesson.live is None  # a running plant has no other time than now
        panel.expand()  # a phone folds it otherwise
        self._panel, self._width = panel, Sizes(picture.state).run
        panel.float(x=BAR, y=-BAR, width=self._width)
        self._listen(commands, post)

    def _words(self, picture: Picture) -> str:
        """What stands on the stage; a knob may put another plant there."""
        stage = None if picture.guided else picture.outcome.stage
        return html.escape(stage.body.caption(self._lang)) if stage is not None else ""

    def _options(self, picture: Picture) -> tuple[str, ...]:
        words: list[Any] = []
        if picture.lesson.live is None:
            words += [phrases.PAUSE if picture.state.moving else phrases.PLAY, *([phrases.KICK] if picture.lesson.kick else [])]
            words += [phrases.REWIND, phrases.SLOWER, phrases.FASTER]
        if picture.guided:
            return tuple(w(self._lang) for w in words)
        words += [phrases.UNDO, phrases.REDO, phrases.RESET]
        return tuple(w(self._lang) for w in words)

    def _listen(self, commands: dict[str, Command], post: Callable[[Edit], int]) -> None:
        @self._row.on_click
        async def _(event: viser.GuiEvent) -> None:
            if event.target.value in commands:
                post(commands[event.target.value])

    def show(self, picture: Picture) -> None:
        """Play or pause on the first button, the speed, the length of the run, what is on the stage."""
        self._picture = picture
        width = Sizes(picture.state).run
        if width != self._width:  # the window has grown or shrunk
            self._width = width
            self._panel.set_width(width)
        options = self._options(picture)
        if self._row.options != options:
            self._row.options = options
        words, longest = self._words(picture), end_of(picture.horizon or self._horizon)
        if (self._rate, self._caption, self._horizon) != (picture.rate, words, longest):
            self._rate, self._caption = picture.rate, words
            self._clock.content = clock(picture.state.t, picture.horizon, self._rate, self._caption)
        if longest != self._horizon:
            self._horizon = self._time.max = longest
            self._time.step = step_of(longest)
        if picture.resting and not picture.state.moving:
            self._write(picture.state.t)

    @property
    def told(self) -> dict[str, object]:
        """What a page that plays by itself must know to write clock and slider as `pose` does."""
        horizon = self._picture.horizon
        return {
            "clock": viser_internals.node_id(self._clock),
            "words": clock(0.0, horizon, self._rate, self._caption, *CLOCK_PLACEHOLDERS),
            "digits": clock_decimals(horizon),
            "slider": viser_internals.node_id(self._time),
            "step": self._time.step,
            "horizon": horizon,
        }

    def forget(self) -> None:
        """Clock and slider stand on the page as it has written them itself: what comes next is sent whatever it is."""
        self._clock.content = ""
        self._back.forget()

    def pose(self, t: float, horizon: float) -> None:
        """The clock at every pose, the slider now and then."""
        self._clock.content = clock(t, horizon, self._rate, self._caption)
        self._count += 1
        if self._count % WRITE_EVERY == 0 or t >= horizon:
            self._write(t)

    def _write(self, t: float) -> None:
        self._back.show(slider_value(t, self._time.step, self._horizon), self._picture)
