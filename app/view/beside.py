"""Designs beside the present one, in the left column: those that are pinned, compared in a table, and every step that was taken."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from types import MappingProxyType

import viser

from ..lesson.comparing import DASHES, Pinned
from ..lesson.differences import difference, step
from ..lesson.lesson import Design, Lesson
from ..tab.commands import Edit
from ..tab.orders import GoToStep, OpenPin, PinDesign, Unpin
from ..tab.picture import Picture
from ..text import NO_WORDS, Text
from . import lettering, phrases, quirks
from .prose import with_minus
from .svg import draw

Post = Callable[[Edit], int]
DONE: Mapping[str, Callable[[str], Edit]] = MappingProxyType({"unpin": Unpin, "open": OpenPin, "step": GoToStep})


class Beside:
    """Two folders: pins with their table, and the steps of undo, any of them one press away."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Post) -> None:
        self._lang = picture.state.language
        self._hand = gui.add_button_group("", ("",), visible=False)  # what the buttons of our own HTML answer for
        with gui.add_folder(phrases.COMPARE(self._lang), expand_by_default=bool(picture.pinned)):
            name = gui.add_text(phrases.NAME(self._lang), "", hint=phrases.NAME_HINT(self._lang))
            pin = gui.add_button(phrases.PIN(self._lang))
            self._pins = gui.add_html("")
        with gui.add_folder(phrases.TIMELINE(self._lang), expand_by_default=False):
            self._steps = gui.add_html("")
        self._shown: tuple[tuple[Design, ...], int] | None = None

        @pin.on_click
        async def _(_: viser.GuiEvent) -> None:
            given = name.value
            if given:
                name.value = ""
            post(PinDesign(given))

        @self._hand.on_click
        async def _(event: viser.GuiEvent) -> None:
            what, _, place = str(event.target.value).partition(" ")
            if what in DONE and place.isdecimal() and len(place) < 6:
                post(DONE[what](place))

    def show(self, picture: Picture) -> None:
        """The pins as soon as one comes or goes, all numbers when the knobs rest."""
        if not picture.resting:
            return
        self._write(self._pins, self._told(picture))
        if self._shown != (picture.steps, picture.at):
            self._shown = picture.steps, picture.at
            self._write(self._steps, self._walked(picture))

    def _write(self, handle: viser.GuiHtmlHandle, content: str) -> None:
        if handle.content != content:
            handle.content = content

    def _told(self, picture: Picture) -> str:
        table = picture.compared
        if table is None or picture.state.predicted is None:  # its numbers would answer the prediction
            return f'<p class="ol-note">{phrases.NO_PINS(self._lang)}</p>' if table is None else self._rows(picture)
        return self._rows(picture) + f'<div class="ol-compared">{draw(replace(table, caption=NO_WORDS), self._lang)}</div>'

    def _rows(self, picture: Picture) -> str:
        return "".join(self._row(pinned, picture) for pinned in picture.pinned)

    def _row(self, pinned: Pinned, picture: Picture) -> str:
        said = with_minus(html.escape(difference(picture.lesson, pinned.name, pinned.pin.design, picture.design)(self._lang)))
        dash = lettering.DASHES[DASHES[pinned.place]]
        line = f'<svg width="34" height="8"><path d="M1 4H33" stroke="currentColor" stroke-width="2"{dash}/></svg>'
        return (f'<div class="ol-pin">{line}<span>{said}</span>{self._button("open", pinned.place, phrases.OPEN_PIN)}'
                f'{self._button("unpin", pinned.place, phrases.UNPIN)}</div>')

    def _button(self, what: str, place: int, words: Text, now: bool = False) -> str:
        return (f'<button type="button" class="ol-do" data-value="{what} {place}" data-to="{quirks.id_of(self._hand)}"'
                f'{" disabled aria-current=step" if now else ""}>{with_minus(html.escape(words(self._lang)))}</button>')

    def _walked(self, picture: Picture) -> str:
        """Every step by what it changed, the latest on top, the present one marked."""
        steps = picture.steps
        said = [phrases.FIRST_STEP, *(_step(picture.lesson, a, b) for a, b in pairwise(steps))]
        rows = [f"<li>{self._button('step', k, words, k == picture.at)}</li>" for k, words in enumerate(said)]
        return f'<ol class="ol-steps" reversed>{"".join(reversed(rows))}</ol>'


@lru_cache(maxsize=2048)
def _step(lesson: Lesson, before: Design, after: Design) -> Text:
    return step(lesson, before, after)
