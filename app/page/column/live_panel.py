"""Show what a running plant sends, with the buttons that record it and drive it."""

from __future__ import annotations

import html

import viser

from ...session.state.view import Picture
from ...text import text
from ..viser_private import viser_internals
from ..viser_private.write_once import write_content
from ..words.prose import with_minus

BEATS = 1000  # the page says the number of its picture times this, and counts below it
FOLDER = text("The running plant")
RECORD, END_RECORD = text("Record the lines"), text("End the record")
DRIVE, END_DRIVE = text("Drive the plant: send u"), text("Stop driving: u = 0")
DRIVEN_MARK = text("THIS PAGE DRIVES THE PLANT")


class LivePanel:
    """A folder of the lab column on a live page."""

    def __init__(self, client: viser.ClientHandle, picture: Picture) -> None:
        gui, self._lang, self._tab = client.gui, picture.state.language, client.client_id
        assert picture.lesson.live is not None
        desk = self._desk = picture.lesson.live
        with gui.add_folder(FOLDER(self._lang)):
            self._said = gui.add_html("")
            self._record = gui.add_button(RECORD(self._lang))
            self._drive = gui.add_button(DRIVE(self._lang), color="red") if desk.can_drive else None
            self._beat = gui.add_number("", -1.0, visible=False)
        viser_internals.run_script(client, "live", widget=viser_internals.node_id(self._beat))

        @self._record.on_click
        async def _(_: viser.GuiEvent) -> None:
            desk.toggle_record()

        @self._beat.on_update
        async def _(_: viser.GuiEvent) -> None:
            desk.hear(self._tab, int(self._beat.value) // BEATS)

        if self._drive is not None:
            @self._drive.on_click
            async def _(_: viser.GuiEvent) -> None:
                desk.toggle_drive(self._tab)

    def show(self, picture: Picture) -> None:
        """What is known now."""
        desk, lang = self._desk, self._lang
        mark = f'<p class="ol-driven" role="status"><b>{html.escape(DRIVEN_MARK(lang))}</b></p>' if desk.driving else ""
        said = "".join(f'<p class="ol-note">{with_minus(html.escape(words(lang)))}</p>' for words in desk.said(self._tab))
        write_content(self._said, f'<div class="ol-running" data-picture="{desk.number(self._tab)}">{mark}{said}</div>')
        self._name(self._record, (END_RECORD if desk.recording else RECORD)(lang))
        if self._drive is not None:
            self._name(self._drive, (END_DRIVE if desk.driving else DRIVE)(lang))

    @staticmethod
    def _name(button: viser.GuiButtonHandle, words: str) -> None:
        if button.label != words:
            button.label = words
