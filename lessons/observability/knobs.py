"""Define the knobs of lesson 3: the deck's sensors, and one knob for each other case."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number, Switch
from observer_lab.text import Text, text

from .cases import PLANT_CASES
from .criteria import CRITERIA

DECK_CASE, NOTES, PAIR, MANY_MASSES = "deck", "notes", "pair", "many"


def _place(name: str, symbol: str, label: Text, default: float) -> Number:
    return Number(name, symbol, label, "m", low=-0.2, high=0.2, default=default, step=0.002,
                  when=(f"{name}_on", (True,)),
                  hint=text("Where along the deck this vertical sensor stands; 0 is above the centre of mass."))


def _on(name: str, label: Text, default: bool) -> Switch:
    return Switch(name, "", label, default=default, when=("plant", (DECK_CASE,)),
                  hint=text("On or off. A sensor that is off turns grey on the deck."))


def _rows(name: str, plants: tuple[str, ...], high: int) -> Number:
    return Number(name, "k", text("block rows of O"), low=1, high=high, default=1, scale="integer",
                  when=("plant", plants),
                  hint=text("One step adds the next row C Aᵏ, that is, one more derivative of y."))


KNOBS = (
    Choice("plant", "", text("case"), default=DECK_CASE, options=tuple((c.id, c.label) for c in PLANT_CASES.values()),
           hint=text("The platform's deck, the example of the notes, and two plants that are hard to judge.")),
    _on("left_on", text("left sensor, vertical"), True),
    _place("left", "p_1", text("place of the left sensor"), 0.0),
    _on("right_on", text("right sensor, vertical"), False),
    _place("right", "p_2", text("place of the right sensor"), 0.072),
    _on("across_on", text("horizontal sensor"), False),
    Number("angle", r"\varphi", text("sensor direction"), "°", low=-90.0, high=90.0, default=0.0, step=0.1,
           when=("plant", (NOTES,)), hint=text("C = [cos φ, sin φ]: at 0° it is the notes' [1 0].")),
    Number("gap", r"\varepsilon", text("gap between the modes"), low=1e-8, high=1.0, default=0.5, scale="log",
           when=("plant", (PAIR,)), hint=text("A = diag(−1, −1−ε), C = [1 1]: with ε = 0 the sensor cannot distinguish the modes.")),
    Number("count", "n", text("number of modes"), low=2, high=20, default=20, scale="integer",
           when=("plant", (MANY_MASSES,)), hint=text("A = diag(−1, …, −n), and one sensor that adds all states up.")),
    _rows("rows_deck", (DECK_CASE,), 6),
    _rows("rows_two", (NOTES, PAIR), 2),
    _rows("rows_many", (MANY_MASSES,), 20),
    Number("tolerance", r"\tau", text("tolerance of the rank"), low=1e-16, high=0.1, default=5e-15, scale="log",
           hint=text("Singular values of O at or below τ times the largest count as zero.")),
    Number("reading", r"\delta", text("error of each derivative"), low=1e-12, high=0.1, default=1e-3,
           scale="log", hint=text("Relative error with which y and its derivatives are read at t = 0.")),
    Number("noise", r"\nu", text("noise of the sensors"), low=1e-4, high=1.0, default=0.03, scale="log",
           hint=text("White noise over the run, as a share of a typical reading.")),
    Choice("criterion", "", text("criterion for “observable”"), default="det", options=CRITERIA,
           hint=text("One of these sentences is what the notes derive from C e^{At}, and it is no criterion.")),
    Choice("second", "", text("the second start differs in"), default="z", when=("plant", (DECK_CASE,)),
           options=(("z", text("height")), ("theta", text("pitch")), ("x", text("horizontal position"))),
           hint=text("The tab Two starts runs the deck from two starts that differ in this alone.")),
    Number("apart", r"\Delta", text("difference of the two starts"), low=0.0, high=2.0, default=1.0, step=0.05,
           hint=text("In typical sizes: 2 mm or 10 mrad on the deck. Elsewhere it is in the direction that the readings show least.")),
    Switch("twin", "", text("second deck on the stage"), default=False, when=("plant", (DECK_CASE,)),
           hint=text("The deck of the second start, translucent, in place of the ghost.")),
    Number("seed", r"s_0", text("noise seed"), low=0, high=9999, default=1, scale="integer", hidden=True),
)
