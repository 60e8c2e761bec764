"""Show the pinned designs, saved designs and steps of the history in the left column."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from types import MappingProxyType

import viser

from ...course.design_differences import describe_difference, describe_step
from ...course.figures.curves import PIN_DASHES
from ...course.lesson import Design, Lesson
from ...course.pinned_designs import Pinned, has_same_body
from ...session.commands.commands import Edit, RunOnTabThread
from ...session.commands.files import (
    ClearBrowser,
    DeleteSavedDesign,
    GoToStep,
    OpenPin,
    OpenSavedDesign,
    PinDesign,
    SaveDesign,
    ToggleGhost,
    Unpin,
)
from ...session.state.view import Picture
from ...text import NO_WORDS, Text
from ..charts import text_layout
from ..charts.svg import draw
from ..viser_private import viser_internals
from ..words import phrases
from ..words.prose import with_minus

Post = Callable[[Edit], int]
DONE: Mapping[str, Callable[[str], Edit]] = MappingProxyType({
    "unpin": Unpin, "open": OpenPin, "ghost": ToggleGhost, "step": GoToStep, "kept": OpenSavedDesign, "forget": DeleteSavedDesign})
NOW = " disabled aria-current=step"
MAX_BUTTON_CHARACTERS = 200  # characters of what a button of ours says


class ComparePanel:
    """Two folders: pins with their table, and the steps of undo, any of them one press away."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Post) -> None:
        self._lang = picture.state.language
        self._hand = gui.add_button_group("", ("",), visible=False)  # what the buttons of our own HTML answer for
        with gui.add_folder(phrases.COMPARE(self._lang), expand_by_default=bool(picture.pinned)):
            name = gui.add_text(phrases.NAME_FIELD(self._lang), "", hint=phrases.NAME_HINT(self._lang))
            pin = gui.add_button(phrases.PIN(self._lang))
            self._pins = gui.add_html("")
        with gui.add_folder(phrases.TIMELINE(self._lang), expand_by_default=False):
            self._steps = gui.add_html("")
        with gui.add_folder(phrases.MY_DESIGNS(self._lang), expand_by_default=False):
            under = gui.add_text(phrases.NAME_FIELD(self._lang), "")
            keep = gui.add_button(phrases.KEEP(self._lang))
            self._kept = gui.add_html("")
            wipe = gui.add_button(phrases.WIPE(self._lang), color="gray", hint=phrases.WIPE_HINT(self._lang))
        self._shown: tuple[tuple[Design, ...], int] | None = None

        def clear() -> None:
            if name.value:
                name.value = ""

        @pin.on_click
        async def _(_: viser.GuiEvent) -> None:
            post(PinDesign(name.value))
            post(RunOnTabThread(clear))

        @keep.on_click
        async def _(_: viser.GuiEvent) -> None:
            post(SaveDesign(under.value))

        @wipe.on_click
        async def _(_: viser.GuiEvent) -> None:
            post(ClearBrowser())

        @self._hand.on_click
        async def _(event: viser.GuiEvent) -> None:
            what, _, which = str(event.target.value)[:MAX_BUTTON_CHARACTERS].partition(" ")
            if what in DONE:
                post(DONE[what](which))

    def show(self, picture: Picture) -> None:
        """The pins as soon as one comes or goes, all numbers when the knobs rest."""
        if not picture.resting:
            return
        self._write(self._pins, self._told(picture))
        self._write(self._kept, self._named(picture))
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
        said = with_minus(html.escape(describe_difference(picture.lesson, pinned.name, pinned.pin.design, picture.design)(self._lang)))
        dash = text_layout.SVG_DASHES[PIN_DASHES[pinned.place]]
        line = f'<svg width="34" height="8"><path d="M1 4H33" stroke="currentColor" stroke-width="2"{dash}/></svg>'
        ghost = self._ghost_button(pinned) if has_same_body(picture.outcome.stage, pinned) else ""
        return (f'<div class="ol-pin">{line}<span>{said}</span>{ghost}{self._button("open", pinned.place, phrases.OPEN_PIN)}'
                f'{self._button("unpin", pinned.place, phrases.UNPIN)}</div>')

    def _ghost_button(self, pinned: Pinned) -> str:
        """The button that lets a pin's ghost walk, pressed while it does."""
        title, on = html.escape(phrases.GHOST_HINT(self._lang), quote=True), str(pinned.pin.ghost).lower()
        return self._button("ghost", pinned.place, phrases.GHOST, look=f' aria-pressed={on} title="{title}"')

    def _named(self, picture: Picture) -> str:
        """The designs that the browser keeps, those of this lesson first."""
        titles = {lesson.id: lesson.words[self._lang].title for lesson in picture.catalogue}
        shelf = sorted(picture.state.shelf, key=lambda kept: kept.lesson != picture.lesson.id)
        return "".join(f'<div class="ol-pin"><span><b>{html.escape(kept.name)}</b> · {html.escape(titles[kept.lesson])}</span>'
                       f'{self._button("kept", kept.name, phrases.OPEN_PIN)}{self._button("forget", kept.name, phrases.REMOVE)}</div>'
                       for kept in shelf) or f'<p class="ol-note">{phrases.NOTHING_KEPT(self._lang)}</p>'

    def _button(self, what: str, which: int | str, words: Text, look: str = "") -> str:
        value = html.escape(f"{what} {which}", quote=True)
        return (f'<button type="button" class="ol-do" data-value="{value}" data-to="{viser_internals.node_id(self._hand)}"'
                f'{look}>{with_minus(html.escape(words(self._lang)))}</button>')

    def _walked(self, picture: Picture) -> str:
        """Every step by what it changed, the latest on top, the present one marked."""
        steps = picture.steps
        said = [phrases.FIRST_STEP, *(_step(picture.lesson, a, b) for a, b in pairwise(steps))]
        rows = [f"<li>{self._button('step', k, words, NOW if k == picture.at else '')}</li>" for k, words in enumerate(said)]
        return f'<ol class="ol-steps" reversed>{"".join(reversed(rows))}</ol>'


@lru_cache(maxsize=2048)
def _step(lesson: Lesson, before: Design, after: Design) -> Text:
    return describe_step(lesson, before, after)
