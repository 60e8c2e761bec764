"""The list of keys, made from the table that binds them."""

from __future__ import annotations

import html

from ..tab.shortcuts import SHORTCUTS
from . import phrases
from .dialog import Dialog
from .shell import NAME
from .version import version


class Help(Dialog):
    """A dialog that opens and closes."""

    def toggle(self, language: str) -> None:
        """Open it in a language, or close it."""
        if self.close():
            return
        gui = self._client.gui
        rows = "".join(f"<tr><td><kbd>{html.escape(c.key)}</kbd></td><td>{html.escape(c.label(language))}</td></tr>"
                       for c in SHORTCUTS)
        with self.open(phrases.KEYS_TITLE(language)):
            gui.add_html(f'<table class="ol-table ol-keys">{rows}</table><p class="ol-note">{NAME} {version()}</p>')
            self.closed_by(gui.add_button(phrases.CLOSE(language)))
        self._client.flush()
