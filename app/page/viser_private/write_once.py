"""Write the content of a widget where it differs from what stands there."""

from __future__ import annotations

import viser


def write_content(handle: viser.GuiHtmlHandle | viser.GuiMarkdownHandle, content: str) -> None:
    """Send only what changes."""
    if handle.content != content:
        handle.content = content
