"""Give every colour of page, charts, stage and exports by its role, by day and in the dark.

A role names what a colour means; whoever draws asks for the role. Charts and drawings are made for a light ground and turned over
by the page in the dark, with their hues kept; `DARK_COLOURS` is for what the page and the stage draw themselves.
"""

from __future__ import annotations

from functools import cache
from types import MappingProxyType

PLANT = "#0072B2"
ESTIMATE = "#D55E00"
SECOND = "#56B4E9"
PAPER = "#FFFFFF"
WORDS_SHARE = 0.66  # of a colour in words written in it; the rest is black
COLOURS = MappingProxyType({
    # what curves, marks and bodies mean, the same everywhere: Okabe–Ito
    "plant": PLANT,
    "estimate": ESTIMATE,
    "error": "#CC79A7",
    "force": "#009E73",
    "disturbance": "#E69F00",
    "reference": "#000000",
    "second": SECOND,
    "muted": "#8A8F98",
    "unstable": "#F6D9D9",
    # words, grounds and buttons of the page
    "ink": "#1C2430",
    "soft": "#3A404A",
    "dimmed": "#5A616C",
    "line": "#E4E7EC",
    "edge": "#8A929E",  # of a field
    "warm": "#FFF7E6",
    "near": "#EAF4FB",  # behind what is chosen or under the pointer
    "page": PAPER,
    "paper": PAPER,
    "press": PAPER,  # words on a button
    "accent": PLANT,
    "hover": "#005C91",  # an accent under the pointer
    "pressed": "#005C91",  # the plant's colour under the pointer, also in the dark
    "outline": "#0067A3",
    "right": "#009E73",
    "wrong": ESTIMATE,
    "alarm": "#8A2F00",
    "haze": "#FFFFFFB3",  # behind a curve's name
    "shade": "#1C243040",  # of an end beyond which a table goes on
    "shadow": "#1C243014",  # of the knobs
    "cast": "#00000033",  # of a menu
    # behind the stage: top, middle, foot
    "sky": "#D3DEEC",
    "mist": "#F4F7FB",
    "ground": PAPER,
    # the stage
    "label": "#000000",
    "floor": "#D6DCE5",
    "fog": "#A9B4C4",
    "horizon": "#EEF2F7",  # what a trail fades into
    "empty": "#E2E5EA",  # what of a map is not computed
    "glass": PAPER,
    "glass-unstable": "#F6D6D6",
    "glass-axis": "#282C34",
    "glass-grid": "#D6DCE5",
    "glass-arc": "#ACB8CA",
    "glass-leader": "#5A616C",  # from a name to its mark
    "light-above": PAPER,
    "light-below": "#C4CAD6",
    "light-key": "#FFF8EC",
    "light-fill": "#E2ECFF",
    # charts and drawings
    "chart-ink": "#333A44",
    "chart-grid": "#E8EBF0",
    "chart-frame": "#C9CED6",
    "bolt": "#282C34",
    # exported figures and sheets
    "print-ink": "#20242B",
    "print-rule": "#5B626D",
    "print-grid": "#E6E9EE",
    "print-line": "#B9C0CB",  # to write on
    "print-pale": "#E4EFF6",  # of a map: from here
    "print-light": "#A9CFE6",
    "print-dark": "#123A55",  # to here
    # what bodies are made of
    "metal": "#C9CED6",
    "steel": "#8A93A0",
    "coil": "#4B4440",  # of wire; orange is the ghost's alone
    "dark": "#3A404A",
    "bench": "#B4C0CF",  # on which bars and gauges stand
    "grey": "#9AA3AE",
    "tube": "#DCE8F2",
    "lit": "#FFF3C4",
    "unlit": "#5A616C",
    "lamp": "#FFD65A",
    "off": "#C4C9D1",
    "brass": "#B8A46A",  # contacts
    "laminate": "#7C8896",  # the board of a circuit
    "ceramic": "#D9D6CE",  # what a chip sits on
    "warm-steel": "#B2B4B6",  # hotter than steel; then hot, white-hot
    "hot": "#DCD6CA",
    "white-hot": "#FFF4DC",
})
DARK_COLOURS = MappingProxyType({
    **COLOURS,
    "ink": "#E9ECF1",
    "soft": "#C3C9D2",
    "dimmed": "#B4BBC6",
    "line": "#3D434C",
    "warm": "#3A2F18",
    "near": "#1C3140",
    "page": "#1D2127",
    "press": "#10151B",
    "accent": SECOND,
    "hover": "#7CC5F0",
    "outline": "#7CC5F0",
    "haze": "#1D2127B3",
    "shade": "#000000CC",
    "sky": "#141A22",
    "mist": "#232A33",
    "ground": "#1A1E24",
    "label": "#E9ECF1",
    "floor": "#3A424E",
    "horizon": "#262D36",
    "empty": "#343C47",
    "glass": "#262C35",
    "glass-unstable": "#54282C",
    "glass-axis": "#DEE3EA",
    "glass-grid": "#3E4652",
    "glass-arc": "#626E80",
    "glass-leader": "#96A0B0",
    "bench": "#667283",
})


def palette(dark: bool) -> MappingProxyType[str, str]:
    """All roles with their colours, by day or in the dark."""
    return DARK_COLOURS if dark else COLOURS


@cache
def rgb(colour: str) -> tuple[int, int, int]:
    """'#RRGGBB' as three bytes."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def for_words(colour: str) -> str:
    """The colour with a third of black in it, to read words in on a light ground; `names.js` mixes the names of curves likewise."""
    return "#" + "".join(f"{round(WORDS_SHARE * part):02X}" for part in rgb(colour))
