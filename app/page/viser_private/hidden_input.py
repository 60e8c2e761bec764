"""Make the unseen widget for which buttons of our own HTML answer."""

from __future__ import annotations

from collections.abc import Callable

import viser


def hidden_input(gui: viser.GuiApi, heard: Callable[[str], object]) -> viser.GuiButtonGroupHandle:
    """The unseen widget that buttons of our own HTML answer for."""
    group = gui.add_button_group("", ("",), visible=False)

    @group.on_click
    async def _(event: viser.GuiEvent) -> None:
        heard(str(event.target.value))
    return group
