"""Show the list of keyboard shortcuts."""

from __future__ import annotations

import html

from ...session.commands.shortcuts import SHORTCUTS
from ..web.html_page import APP_NAME
from ..words import phrases
from ..words.version import version
from .dialog import Dialog


class HelpDialog(Dialog):
    """A dialog that opens and closes."""

    def toggle(self, language: str) -> None:
        """Open it in a language, or close it."""
        if self.close():
            return
        gui = self._client.gui
        rows = "".join(f"<tr><td><kbd>{html.escape(c.key)}</kbd></td><td>{html.escape(c.label(language))}</td></tr>"
                       for c in SHORTCUTS)
        with self.open(phrases.KEYS_TITLE(language)):
            gui.add_html(f'<table class="ol-table ol-keys">{rows}</table><p class="ol-note">{APP_NAME} {version()}</p>')
            self.closed_by(gui.add_button(phrases.CLOSE(language)))
        self._client.flush()
