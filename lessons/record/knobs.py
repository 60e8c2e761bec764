"""Define the knobs: the data, order and share of the fit, Q by likelihood or hand, the smoother."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number, Switch
from observer_lab.text import text

SPRING, TANKS, MASSES, FURNACE, OWN = "spring", "tanks", "masses", "furnace", "own"
FAULTY = "faulty"  # the spring, whose sensor is faulty in the rows that judge
NO_GATE, ONE_SENSOR, SLOW, LATE, NO_BIAS = "off", "none", "slow", "late", "none"
NOTHING, INNOVATIONS, ERROR, DEVIATION, VALUES = "nothing", "innovations", "error", "deviation", "values"
MAX_ORDER, OPENING_SHARE = 6, 0.5

DATA = Choice("data", "", text("record"), default=SPRING,
              options=((SPRING, text("spring and damper (simulated)")), (TANKS, text("two tanks (simulated)")),
                       (MASSES, text("two masses (simulated)")), (FAULTY, text("spring, faulty sensor (simulated)")),
                       (FURNACE, text("gas furnace (measured, 1970)"))),
              hint=text("The true plant behind a simulated record is known; behind a measured one nobody knows it."))
DELAY = Number("delay", "", text("dead time of the input (rows)"), low=0, high=60, default=0, scale="integer",
               hint=text("By how many rows the output answers later than in the next row. For your own record it is estimated."))
ORDER = Number("order", "n", text("order of the model"), low=1, high=MAX_ORDER, default=2, scale="integer",
               hint=text("How many states the fitted model has. The tab Order suggests a number."))
KNOBS = (
    DATA,
    ORDER,
    Number("share", "", text("share used for the fit"), "%", low=20, high=80, default=100 * OPENING_SHARE, step=5,
           hint=text("The first part of the record fits the model; the rest judges the filter.")),
    DELAY,
    Number("factor", "", text("Q by hand / Q by likelihood"), low=0.001, high=1000.0, default=1.0, scale="log",
           hint=text("1 keeps the most likely Q. Below 1 the filter trusts the model too much.")),
    Choice("gate", "", text("gate of the filter"), default=NO_GATE,
           options=((NO_GATE, text("off")), ("0.999", text("lets 99.9 % pass")), ("0.99", text("lets 99 % pass"))),
           hint=text("A reading farther from its prediction than this share of good ones is set aside and counts as missing.")),
    Choice("bias", "", text("bias of a sensor"), default=NO_BIAS,
           options=((NO_BIAS, text("not a state")), ("constant", text("a constant state")), ("drift", text("a drifting state")),
                    ("data", text("as the data say"))),
           hint=text("A further state for what one sensor reads too much: constant, or a random walk. The data decide by likelihood.")),
    Choice("second", "", text("second sensor"), default=ONE_SENSOR,
           options=((ONE_SENSOR, text("none")), (SLOW, text("exact, at every 10th row")), (LATE, text("the same, 5 rows late"))),
           hint=text("A second sensor of the first output, ten times as exact as the first. The figure of the standard deviation shows "
                     "what it gains.")),
    Switch("smoother", "", text("smoother"), default=False,
           hint=text("Estimate each moment from the whole record, not only from what came before.")),
    Choice("below", "", text("shown below the record"), default=NOTHING,
           options=((NOTHING, text("nothing")), (INNOVATIONS, text("innovations")), (ERROR, text("error of the estimate")),
                    (DEVIATION, text("σ of the estimate")), (VALUES, text("singular values"))),
           hint=text("The lower part of the panel on the stage shows it over the rows that the fit has not used.")),
    Number("seed", r"s_0", text("noise seed"), low=0, high=9999, default=1, scale="integer", hidden=True),
)
