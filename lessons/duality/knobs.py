"""Define the knobs of lesson 5, on the block with a sensor that turns."""

from __future__ import annotations

from types import MappingProxyType

from observer_lab.course.knobs import Choice, Number, Poles, Switch
from observer_lab.plants import MODELS
from observer_lab.text import Text, text

from ..toolkit.boards import WEIGHTS_FOLDER
from ..toolkit.knobs import BY_POLES, BY_WEIGHTS, run_knobs

MODEL = MODELS["spring-damper"]
NOTHING, DUAL, BOTH, PAIR = "nothing", "dual", "both", "pair"  # beside the block
HINTS = MappingProxyType({
    "q": text("Q = α_Q I: how much a deviation of the state costs."),
    "r": text("R = α_R: how much the input costs."),
    "w": text("W = α_W I: how hard unknown forces shake the plant."),
    "v": text("V = α_V: how noisy the sensor is."),
})


def _weight(name: str, symbol: str, label: Text, default: float, tied: bool) -> Number:
    return Number(name, symbol, label, low=1e-3, high=1e3, default=default, scale="log", group=WEIGHTS_FOLDER,
                  when=None if tied else ("mirror", (False,)), hint=HINTS[name])


TERMINAL = Number("terminal", "s_f", text("terminal weight s_f"), low=0.0, high=4.0, default=0.0, step=0.1,
                  hint=text("The equations in time begin with S_f = s_f S and P₀ = s_f P. With 1 they are settled from the start."))
KNOBS = (
    Choice("method", "", text("gains by"), default=BY_POLES,
           options=((BY_POLES, text("dragging poles")), (BY_WEIGHTS, text("Q/R weights"))),
           hint=text("Drag one set of poles for both boards, or let the two Riccati equations choose.")),
    Poles("poles", "p", text("Poles of both boards"), "rad/s", default=MODEL.controller_poles,
          re_low=-5.0, re_high=1.5, im_high=3.0, role="plant", when=("method", (BY_POLES,)),
          hint=text("Drag a cross on either board: both boards hold the same poles.")),
    Number("sensor", r"\varphi", text("sensor turned by"), "°", low=0.0, high=90.0, default=0.0, step=1.0,
           hint=text("y = q cos φ + v sin φ: the position at 0°, the velocity at 90°.")),
    Number("window", "T", text("length T of the window"), "s", low=0.5, high=12.0, default=4.0, step=0.1,
           hint=text("How long the input acts, and how long the output is measured.")),
    TERMINAL,
    _weight("q", r"\alpha_Q", text("state weight α_Q"), 4.0, True),
    _weight("r", r"\alpha_R", text("input weight α_R"), 1.0, True),
    Switch("mirror", "", text("mirror the weights: W = Q, V = R"), default=True,
           hint=text("On: the filter gets the regulator's weights. Off: it has its own.")),
    _weight("w", r"\alpha_W", text("process intensity α_W"), 1.0, False),
    _weight("v", r"\alpha_V", text("sensor intensity α_V"), 1.0, False),
    Choice("tiles", "", text("shown beside the block"), default=NOTHING,
           options=((NOTHING, text("nothing")), (DUAL, text("the gain K_d, transposed")), (BOTH, text("the gains K and L")),
                    (PAIR, text("error and dual state"))),
           hint=text("Gains as tiles, or the sizes of the error and of the state of the dual loop as bars.")),
    Number("transposed", "", text("row turned into a column by"), "°", low=0.0, high=90.0, default=0.0, step=1.0,
           when=("tiles", (DUAL,)), hint=text("At 0° the row K_d, at 90° the column L, its transpose.")),
    *run_knobs(MODEL.horizon),
)
