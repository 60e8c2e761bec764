"""The columns beside the stage and how wide they are."""

from __future__ import annotations

import viser


class Columns:
    """Docked panels with their widths in pixels. A busy browser may hear a width before the column stands: say it twice."""

    def __init__(self) -> None:
        self._held: list[tuple[viser.MainPanelHandle | viser.PanelHandle, float]] = []

    def add(self, panel: viser.MainPanelHandle | viser.PanelHandle, width: float) -> None:
        """A docked panel takes its width."""
        self._held.append((panel, width))
        panel.set_width(width)

    def again(self) -> None:
        """Say all widths once more."""
        for panel, width in self._held:
            panel.set_width(width)
