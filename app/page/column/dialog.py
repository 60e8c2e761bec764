"""Open and close a dialog over the page on the tab's own thread."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import viser

from ...session.commands.commands import Edit, RunOnTabThread
from ..viser_private import viser_internals
from ..viser_private.hidden_input import hidden_input


class Dialog:
    """One of the page's dialogs, open or not; a page that is laid out anew has closed it."""

    def __init__(self, client: viser.ClientHandle, post: Callable[[Edit], int]) -> None:
        self._client, self._post = client, post
        self._modal: Any = None

    def open(self, title: str) -> Any:
        """The dialog, empty, under a title."""
        gui = self._client.gui
        self._modal = gui.add_modal(title)
        with self._modal:
            hand = hidden_input(gui, lambda _: self.close_later())
            gui.add_html(f'<button type="button" class="ol-close" data-to="{viser_internals.node_id(hand)}" data-value="close" '
                         f'aria-label="×">×</button>')
        return self._modal

    def close(self) -> bool:
        """Close it; whether it was open."""
        modal, self._modal = self._modal, None
        if modal is None or modal.closed:
            return False
        modal.close()
        self._client.flush()
        return True

    def closed_by(self, button: viser.GuiButtonHandle) -> None:
        """Let a button close it."""
        @button.on_click
        async def _(_: viser.GuiEvent) -> None:
            self.close_later()

    def close_later(self) -> None:
        """Close it, said from the server's loop."""
        self._post(RunOnTabThread(self.close))
