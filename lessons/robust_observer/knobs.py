"""Define the knobs of lesson 15: poles, model error, weights of J, slips to find."""

from __future__ import annotations

from types import MappingProxyType

from observer_lab.course.knobs import Choice, Number, Poles, Switch
from observer_lab.engine.observers import Norm
from observer_lab.text import Text, same, text

EXAMPLE_ONE, EXAMPLE_TWO, EXAMPLE_THREE, EXAMPLE_FOUR = "1", "2", "3", "4"
NORMS: MappingProxyType[str, Norm] = MappingProxyType({"1": 1, "2": 2, "inf": "inf"})
REMARKS = MappingProxyType({
    "printed": "(F, ΛF, ΛL, ΛNΛ⁻¹, M)",
    "left": "(F, ΛT, ΛL, NΛ⁻¹, M)",
    "forward": "(ΛFΛ⁻¹, ΛT, ΛL, NΛ, M)",
    "similar": "(ΛFΛ⁻¹, ΛT, ΛL, NΛ⁻¹, M)",
})
SENSITIVITY_LINES = MappingProxyType({"TA": "TΔA", "LC": "LΔC", "MC": "MΔC", "N": "N"})
COLUMNS = MappingProxyType({"np": "n + p − r*", "nm": "n + m − r*", "mp": "m + p − r*"})
KEPT, UNREACHED, UNSEEN, STATIC, STATIC_FIT = "kept", "unreached", "unseen", "static", "static-fit"
ASSUMED = ((KEPT, text("controllable and observable")), (UNREACHED, text("the input does not reach the mode")),
           (UNSEEN, text("the sensor does not see the mode")), (STATIC, text("T = 0: the nearest output feedback")),
           (STATIC_FIT, text("T = 0, with K a multiple of C")))
RE_LOW, RE_HIGH, IM_HIGH = -12.0, 1.0, 6.0  # of the observer's board
SLIPS_GROUP = text("Find the slips")
ROWS_AND_J, ROWS_ALONE = "both", "rows"  # what stands before and beside the gauges
ERRORS_GROUP = text("The plant is not the model")
SEARCH = text("Criterion and region")
ASSUMED_GROUP = text("Assumptions")


def _delta(name: str, symbol: str, examples: tuple[str, ...], label: Text, high: float, default: float) -> Number:
    return Number(name, symbol, label, low=-high, high=high, default=default, step=high / 50, group=ERRORS_GROUP,
                  when=("example", examples),
                  hint=text("How far the true plant is from the model the observer was designed for; 0: no error."))


def _weight(name: str, symbol: str, what: str) -> Number:
    return Number(name, symbol, text("weight of {what}", what=what), low=0.0, high=3.0, default=1.0, step=0.1,
                  group=SEARCH, hint=text("How much {what} counts in J; all ones in the paper.", what=what))


def weight_knobs() -> tuple[Number, ...]:
    """The weights of the three sums in J."""
    return _weight("alpha", r"\alpha", "‖TAᵢ‖"), _weight("beta", r"\beta", "‖LCᵢ‖"), _weight("gamma", r"\gamma", "‖MCᵢ‖")


KNOBS = (
    Choice("example", "", text("example"), default=EXAMPLE_ONE,
           options=((EXAMPLE_ONE, text("Example 1: two states")), (EXAMPLE_TWO, text(
               "Example 2: three states")), (EXAMPLE_THREE, text("Example 1 with one observer state more")),
                    (EXAMPLE_FOUR, text("Two carts: two outputs"))),
           hint=text("The two plants of the paper, each with its gain K; the third choice leaves M′ free. The fourth plant is ours.")),
    Poles("pole", "s", text("Observer pole"), "rad/s", default=(-5 + 0j,), re_low=RE_LOW, re_high=RE_HIGH,
          im_high=IM_HIGH, role="estimate", when=("example", (EXAMPLE_ONE,)),
          hint=text("Drag s along its axis and watch J.")),
    Poles("pair", r"s_1, s_2", text("Observer poles"), "rad/s", default=(-4 + 0j, -2.5 + 0j), re_low=RE_LOW,
          re_high=RE_HIGH, im_high=IM_HIGH, role="estimate", when=("example", (EXAMPLE_TWO, EXAMPLE_THREE, EXAMPLE_FOUR)),
          hint=text("Drag s₁ and s₂; they must differ, and may be a pair.")),
    Number("free", "M'", text("free number M′"), low=-100.0, high=100.0, default=0.0, step=1.0, when=("example", (EXAMPLE_THREE,)),
           hint=text("The freedom that the conditions leave: M = M′, and N = (K − M′C)T⁻¹ follows.")),
    _delta("a1", r"\delta_a^1", (EXAMPLE_ONE, EXAMPLE_THREE), text("δ of a₂₁"), 0.5, 0.1),
    _delta("a2", r"\delta_a^2", (EXAMPLE_ONE, EXAMPLE_THREE), text("δ of a₂₂"), 0.5, -0.4),
    _delta("c", r"\delta_c", (EXAMPLE_ONE, EXAMPLE_THREE), text("δ of the sensor"), 0.1, 0.05),
    _delta("b1", r"\delta_a^1", (EXAMPLE_TWO,), text("δ of a₁"), 0.5, 0.01),
    _delta("b2", r"\delta_a^2", (EXAMPLE_TWO,), text("δ of a₂"), 0.5, 0.05),
    _delta("d", r"\delta_c", (EXAMPLE_TWO,), text("δ of the sensor"), 0.1, 0.03),
    _delta("stiff", r"\delta_a^1", (EXAMPLE_FOUR,), text("δ of the spring, N/m"), 1.0, 0.5),
    _delta("damp", r"\delta_a^2", (EXAMPLE_FOUR,), text("δ of the damping, N s/m"), 0.5, 0.2),
    _delta("tacho", r"\delta_c", (EXAMPLE_FOUR,), text("δ of the tachometer"), 0.1, 0.05),
    Number("input", r"\delta_b", text("δ of the input"), low=-0.5, high=0.5, default=0.0, step=0.01, group=ERRORS_GROUP,
           hint=text("By what share the input acts more strongly on the true plant than on the model. J does not include it, and no sign "
                     "pattern has it.")),
    Number("w12", r"w_{12}", text("coordinates W = [1 w; 0 1]"), low=-2.0, high=2.0, default=1.2,
           step=0.1, when=("example", (EXAMPLE_TWO,)),
           hint=text("The observer's coordinates: F = W diag(s₁, s₂) W⁻¹.")),
    Switch("carried", "", text("carry z(0) along with W"), when=("example", (EXAMPLE_TWO,)),
           hint=text("On: z(0) becomes W z(0). Off: the same numbers whatever W is, as in the paper.")),
    Choice("norm", "", text("norm in J"), default="2", group=SEARCH, when=("example", (EXAMPLE_TWO, EXAMPLE_THREE, EXAMPLE_FOUR)),
           options=tuple((name, same("∞" if name == "inf" else name)) for name in NORMS),
           hint=text("Column sum, spectral or row sum norm; in Example 1 all three agree.")),
    *weight_knobs(),
    Number("second", r"\alpha_2/\alpha_1", text("weight of the second direction of A"), low=0.0, high=3.0, default=1.0, step=0.1,
           group=SEARCH, hint=text("How much ‖TA₂‖ counts in J, over ‖TA₁‖: the paper has a weight for each direction.")),
    Number("region_low", "a", text("region for RLO, left end"), "rad/s", low=-12.0, high=-4.0, default=-10.0,
           step=0.5, group=SEARCH, hint=text("RLO keeps every pole right of this.")),
    Number("region_high", "b", text("region for RLO, right end"), "rad/s", low=-3.5, high=-0.2, default=-0.5,
           step=0.1, group=SEARCH, hint=text("RLO keeps every pole left of this.")),
    Number("region_tall", "d", text("region for RLO, largest |Im s|"), "rad/s", low=0.0, high=IM_HIGH, default=1.5, step=0.1, group=SEARCH,
           when=("example", (EXAMPLE_FOUR,)), hint=text("With both ends a and b, a rectangle for the poles. 0: real poles only.")),
    Choice("assumed", "", text("what is assumed of the plant"), default=KEPT, options=ASSUMED, group=ASSUMED_GROUP,
           hint=text("Example 1 with an unstable mode more, in the tab Assumptions: each choice takes one assumption away.")),
    Choice("shown", "", text("on the stage"), default=ROWS_AND_J, group=ERRORS_GROUP, hidden=True,
           options=((ROWS_AND_J, text("rows and J")), (ROWS_ALONE, text("rows"))),
           hint=text("With the slabs of J or without them.")),
    Choice("remark", "", text("remark 3 should read"), default="printed", group=SLIPS_GROUP, when=("example", (EXAMPLE_TWO,)),
           options=tuple((name, same(words)) for name, words in REMARKS.items()),
           hint=text("Five matrices that are to meet the observer conditions again; Λ is any regular matrix.")),
    Choice("line", "", text("line of example 2 with a wrong size"), default="TA", group=SLIPS_GROUP,
           when=("example", (EXAMPLE_TWO,)), options=tuple((name, same(words)) for name, words in SENSITIVITY_LINES.items()),
           hint=text("The table sets the printed size beside the size of the product.")),
    Choice("columns", "", text("columns of the free M′"), default="np", group=SLIPS_GROUP,
           when=("example", (EXAMPLE_TWO,)), options=tuple((name, same(words)) for name, words in COLUMNS.items()),
           hint=text("In the paper's letters: n states, m outputs, p observer states, r* the rank of [T; C].")),
)
