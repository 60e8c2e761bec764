"""Write the switch between guide, lab and present as HTML."""

from __future__ import annotations

import html

from ...course.scenes import Mode
from . import phrases

MODE_WORDS = (("guide", phrases.GUIDE), ("lab", phrases.LAB), ("present", phrases.PRESENT))


def mode_switch(now: Mode, language: str, hand: str) -> str:
    """A button for each view of a lesson; each says `mode:` and its name to the hidden widget `hand`."""
    modes = "".join(f'<button type="button" class="ol-mode" aria-pressed="{"true" if mode == now else "false"}" '
                    f'data-to="{hand}" data-value="mode:{mode}">{html.escape(words(language))}</button>' for mode, words in MODE_WORDS)
    return f'<span class="ol-modes" role="group">{modes}</span>'
