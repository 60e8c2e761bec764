"""Lay out the columns beside the stage and keep their widths."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import viser

from ...session.commands.commands import Edit, RunOnTabThread
from ..viser_private import viser_internals

DOUBLE_CLICKS = -2.0  # what the page says for the first one, and one less for each that follows
FORGOTTEN = (296.0, 312.0)  # px: as wide as viser makes a column of which it knows no width


class Columns:
    """Docked panels with their widths in pixels.

    A browser that is busy while one page follows another puts the new column beside the old one and forgets its width; so
    the page says, for some seconds after it was laid out, how wide the column on the right stands, and is told again.
    """

    def __init__(self) -> None:
        self._held: list[tuple[viser.MainPanelHandle | viser.PanelHandle, float]] = []

    def add(self, panel: viser.MainPanelHandle | viser.PanelHandle, width: float) -> None:
        """A docked panel takes its width."""
        self._held.append((panel, width))
        panel.set_width(width)

    def resize(self, *widths: float) -> None:
        """The panels take other widths, in the order in which they were added."""
        for k, ((panel, before), width) in enumerate(zip(self._held, widths, strict=True)):
            if width != before:
                self._held[k] = panel, width
                panel.set_width(width)

    def watch(self, client: viser.ClientHandle, post: Callable[[Edit], int], wide: float) -> None:
        """Hear how wide the column on the right stands, the first of these panels; a double click on its head turns `wide` on and off."""
        if len(self._held) < 2:
            return
        told = client.gui.add_number("", -1.0, visible=False)

        def tell_again() -> None:
            panel, width = self._held[0]
            with suppress(RuntimeError):  # the page has been laid out anew meanwhile
                panel.set_width(width)

        other = [wide]

        def turn() -> None:
            panel, width = self._held[0]
            self._held[0], other[0] = (panel, other[0]), width
            tell_again()

        @told.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.target.value <= DOUBLE_CLICKS:
                post(RunOnTabThread(turn))
            elif FORGOTTEN[0] <= event.target.value <= FORGOTTEN[1]:
                post(RunOnTabThread(tell_again))
        viser_internals.run_script(client, "columns", widget=viser_internals.node_id(told))
