"""Define the knobs of lesson 12: mode shown, order, rank and units, geometry, LQG."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number, Switch
from observer_lab.text import Text, same, text

from .balanced_platform import STATE_COUNT, sigmas
from .body import NOMINAL
from .reduced_regulator import PAIRS, PRESSED, WEIGHT_OUTPUTS
from .study import MEASURES, RELATIVE

GEOMETRY, RANK_FOLDER, MODEL, LQG = text("Geometry"), text("Rank"), text("Model"), same("LQG")


def _size(name: str, symbol: str, label: Text, unit: str, low: float, high: float, hint: Text, step: float | None = None) -> Number:
    return Number(name, symbol, label, unit, low=low, high=high, default=getattr(NOMINAL, name),
                  scale="linear" if step else "log", step=step, group=GEOMETRY, hint=hint)


KNOBS = (
    Choice("pair", "", text("pair on the stage"), default="1", group=MODEL,
           options=tuple((str(k + 1), same(sigmas(k))) for k in range(PAIRS)),
           hint=text("Which motion is drawn, the strongest pair first.")),
    Number("order", "r", text("states kept"), low=1, high=STATE_COUNT, default=STATE_COUNT, scale="integer", group=MODEL,
           hint=text("Order of the balanced truncation. The ghost shows what that model can hold of the motion.")),
    Number("ground", "g", text("unit of the ground's motion"), "m", low=1e-4, high=1.0, default=1.0, scale="log", group=MODEL,
           hint=text("The unit of the ground's inputs; that of the coils is the newton. The plant stays the same.")),
    Number("clock", "T", text("unit of time"), "s", low=1e-3, high=1.0, default=1.0, scale="log", group=RANK_FOLDER,
           hint=text("Velocities and A are counted per this unit. The plant stays the same.")),
    Number("tolerance", r"\tau", text("tolerance"), low=1e-18, high=0.1, default=1e-9, scale="log", group=RANK_FOLDER,
           hint=text("Singular values at or below it count as zero.")),
    Choice("measure", "", text("singular values"), default=RELATIVE, options=MEASURES, group=RANK_FOLDER,
           hint=text("Measured against the largest, or taken as they are.")),
    Switch("columns", "", text("singular values on the stage"), default=False, group=RANK_FOLDER,
           hint=text("As columns before the deck, with the tolerance as a plate.")),
    Switch("rest", "", text("deck at rest"), default=False, group=MODEL, hidden=True, hint=text("The deck stands still.")),
    _size("s", "s", text("sensors off the centre"), "m", 0.06, 0.18,
          text("Half the distance of the two sensors."), 0.002),
    _size("h", "h", text("height of the centre of mass"), "m", 0.002, 0.06,
          text("How far the centre of mass lies above the deck plane."), 0.001),
    _size("a", "a", text("springs off the centre"), "m", 0.10, 0.21,
          text("Half the distance of the two vertical springs."), 0.002),
    _size("mu", r"\mu", text("test mass"), "kg", 0.01, 0.5,
          text("Mass inside each sensor.")),
    _size("kp", "k_p", text("servo stiffness"), "N/m", 300.0, 20000.0,
          text("Stiffness that holds each test mass.")),
    Number("v0", "V", text("measurement noise"), "m²/s", low=1e-12, high=1e-6, default=1e-9, scale="log", group=LQG,
           hint=text("Intensity V of the noise on each velocity reading.")),
    Choice("pressed", "", text("the cost presses on"), default=WEIGHT_OUTPUTS, options=PRESSED, group=LQG,
           hint=text("The report's Q = α CᵀW_yC, or the same heavy weight on every balanced state.")),
)
