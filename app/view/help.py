"""The list of keys, made from the table that binds them."""

from __future__ import annotations

import html
from typing import Any

import viser

from ..tab.shortcuts import SHORTCUTS
from . import phrases, quirks
from .version import version


class Help:
    """A dialog that opens and closes."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._modal: Any = None

    def toggle(self, language: str) -> None:
        """Open it in a language, or close it."""
        if self._modal is not None:
            self._close()
            return
        gui = self._client.gui
        self._modal = gui.add_modal(phrases.KEYS_TITLE(language))
        rows = "".join(f"<tr><td><kbd>{html.escape(c.key)}</kbd></td><td>{html.escape(c.label(language))}</td></tr>"
                       for c in SHORTCUTS)
        with self._modal:
            gui.add_html(f'<table class="ol-table ol-keys">{rows}</table><p class="ol-note">{quirks.NAME} {version()}</p>')
            button = gui.add_button(phrases.CLOSE(language))

        @button.on_click
        async def _(_: viser.GuiEvent) -> None:
            self._close()
        self._client.flush()

    def _close(self) -> None:
        if self._modal is not None:
            self._modal.close()
            self._modal = None
            self._client.flush()
