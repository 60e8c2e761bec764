"""Draw a link as a QR code."""

from __future__ import annotations

import segno

BORDER = 4  # modules of white around a code, as its standard asks for


def qr_code(link: str) -> str:
    """A link as a QR code, an SVG as wide as there is room."""
    found = segno.make(link, error="l", micro=False, boost_error=False)
    svg = found.svg_inline(border=BORDER, omitsize=True, light="white", svgclass="ol-code")
    return f'<div class="ol-code-frame">{svg}</div>'
