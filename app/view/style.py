"""The page's own style: one sheet, variables for what changes."""

from __future__ import annotations

import math

SHEET = """
:root{--mantine-scale:%(scale)s}
.ol-caption{font-size:calc(.8rem*var(--mantine-scale));line-height:1.35;margin:.1rem .6rem .5rem;color:#3a404a}
.ol-question{font-size:calc(1.28rem*var(--mantine-scale));line-height:1.25;font-weight:700;margin:.2rem .6rem .3rem;color:#1c2430}

.ol-veil{font-size:calc(.85rem*var(--mantine-scale));margin:.4rem .6rem;padding:.4rem .6rem;
 border-left:4px solid #E69F00;background:#fff7e6}
.ol-note{font-size:calc(.85rem*var(--mantine-scale));margin:.2rem .6rem .4rem;color:#3a404a}
.ol-group{font-size:calc(.78rem*var(--mantine-scale));font-weight:600;letter-spacing:.02em;color:#1c2430;
 margin:.45rem .6rem 0;padding-top:.3rem;border-top:1px solid #e4e7ec}
.ol-right{border-left:4px solid #009E73;padding-left:.5rem}.ol-wrong{border-left:4px solid #D55E00;padding-left:.5rem}
.ol-formula{margin:.15rem .4rem;overflow-x:auto;font-size:calc(.95rem*var(--mantine-scale))}
.ol-formula:has(mtd:nth-child(5)){font-size:calc(.78rem*var(--mantine-scale))}
.ol-formula math{font-size:1.02em}
.ol-figure{margin:.2rem .4rem;border:1px solid #e4e7ec;border-radius:4px}
.ol-figure svg{width:100%%;height:auto;display:block}
.ol-table{width:100%%;border-collapse:collapse;font-size:calc(.8rem*var(--mantine-scale))}.ol-table caption{font-weight:600;padding:.3rem}
.ol-table td,.ol-table th{padding:.15rem .4rem;text-align:right;border-top:1px solid #e8ebf0}
[data-dock-tab]{padding-inline:.6em!important}
.ol-table th{word-break:keep-all}.ol-table tr>:last-child{padding-right:.7rem}
.ol-table:has(th:nth-child(5)){font-size:calc(.8rem*min(var(--mantine-scale),1.24))}
.ol-keys td{text-align:left}.ol-table td:first-child,.ol-table th:first-child{text-align:left}
.uplot .u-legend{font-size:.78em;margin-top:-.4em}
.uplot .u-legend .ol-x{display:none}
.uplot .u-legend .u-marker{width:20px;height:0!important;border-width:3px 0 0!important;background:none!important;
 margin-right:5px;vertical-align:middle}
.uplot .u-legend [class*="-dash"] .u-marker{border-top-style:dashed!important}
.uplot .u-legend [class*="-dot"] .u-marker{border-top-style:dotted!important}
.uplot:has([class*="ol-time"]) .u-over::after{content:"";position:absolute;top:0;bottom:0;width:2px;margin-left:-1px;
 background:#1c2430;opacity:.75;left:calc(var(--ol-t,0)*100%%)}
math mtable{--b:linear-gradient(currentColor,currentColor);padding:.15em .3em;border-left:1.4px solid;border-right:1.4px solid;
 background:var(--b) top left/.4em 1.4px no-repeat,var(--b) bottom left/.4em 1.4px no-repeat,
 var(--b) top right/.4em 1.4px no-repeat,var(--b) bottom right/.4em 1.4px no-repeat}
math mtd{padding:.16em .3em}
@media (max-width:36em){
 .mantine-Paper-root[style*="width: 20em"],.mantine-Paper-root[style*="width: 20em"] [style*="width: 20em"]{
  width:100vw!important;max-height:52vh}}
canvas[data-engine]{background:linear-gradient(#d3deec,#f4f7fb 45%%,#ffffff)}
%(veil)s
"""
VEIL = ".uplot canvas,.ol-figure svg{filter:blur(9px);opacity:.65}.ol-caption,.ol-live,.ol-table{visibility:hidden}"


def sheet(lecture: bool, veiled: bool) -> str:
    """The style element for the present state."""
    return "<style>" + SHEET % {"scale": "1.55" if lecture else "1", "veil": VEIL if veiled else ""} + "</style>"


def clock(t: float, horizon: float, speed: float, caption: str) -> str:
    """The cursor in all time plots and the clock beside the transport, in one element."""
    share = t / horizon if horizon > 0 else 0.0
    digits = 2 if horizon >= 2 or horizon <= 0 else 2 - math.floor(math.log10(horizon))
    return (f"<style>:root{{--ol-t:{share:.4f}}}</style>"
            f'<div class="ol-note">t = {t:.{digits}f} s '
            f'<span style="color:#8a8f98">/ {horizon:g} s · {speed:g}× &emsp;{caption}</span></div>')
